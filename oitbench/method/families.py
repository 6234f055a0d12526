"""Families of methods: the ways in which they order layers, or do without an order."""

from __future__ import annotations

from collections.abc import Mapping

BLENDING, SORTING, EXACT, LISTS, CURVES, RANDOM, OTHER = (
    "blending", "sorting", "exact", "lists", "curves", "random", "other",
)  # fmt: skip

FAMILIES: Mapping[str, str] = {
    BLENDING: "blending in any order",
    SORTING: "blending of sorted draws",
    EXACT: "all layers: lists or peeling",
    LISTS: "a bounded number of nodes per pixel",
    CURVES: "visibility as a curve over depth",
    RANDOM: "random coverage",
    OTHER: "another way",
}
"""Words by the name of a family, in the order of legends."""
