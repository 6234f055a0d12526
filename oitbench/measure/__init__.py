"""Measurements of frames: bytes, time and visibility; and the exact answer in float64."""
