"""Choosing a method under the constraints of a platform, from stored results alone."""
