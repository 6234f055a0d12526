"""Methods in motion: a camera moves along a path, and pictures are compared from frame to frame."""
