"""Wavefront files: meshes (.obj) and their materials (.mtl)."""
