"""Helpers for writing scenes: meshes, solids, baked light, patterns and props."""
