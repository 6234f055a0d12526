"""Following rays through a scene."""
