"""The OpenGL renderer: everything that talks to moderngl lives here."""
