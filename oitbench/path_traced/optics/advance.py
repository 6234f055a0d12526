"""How rays advance beyond a surface that they have hit."""

from __future__ import annotations

STEP = 6e-7
"""Advance beyond a hit, relative to the magnitudes that are added there: five float32 roundings."""
NO_FACE = 0xFFFFFFFF
"""A number that no face has. The face that a ray has hit last is not hit again."""
