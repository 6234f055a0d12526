"""Polygon files (Turk 1994), as text and binary."""
