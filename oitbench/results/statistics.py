"""Statistics of a scene in the record of a cell: every field, its type and its unit."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

Count = Annotated[int, Meta(ge=0)]


class _Typed(Struct, frozen=True, forbid_unknown_fields=True):
    """Base of all parts of a record."""


class DepthComplexity(_Typed, frozen=True):
    """Transparent fragments at a pixel, over the pixels of a frame.

    `mean` and `median` are those of covered pixels; null if there are none. `worst` is the largest
    number. `histogram` has pairs in ascending order: a number of fragments, 0 included, and the
    pixels that have it.
    """

    mean: float | None
    median: float | None
    worst: Count
    histogram: list[tuple[Count, Count]]


class SceneStatistics(_Typed, frozen=True):
    """What a scene asks of a renderer in one view, at one size.

    `draws` is the number of draw calls if each object is drawn by itself; each layer of fragment
    lists is one. `fragments` are transparent ones that no opaque surface hides, counted at the
    center of each pixel; `covered_pixels` have at least one. `transparent_objects` and
    `transparent_triangles` are parts of `objects` and `triangles`.
    """

    objects: Count
    transparent_objects: Count
    triangles: Count
    transparent_triangles: Count
    draws: Count
    fragments: Count
    covered_pixels: Count
    complexity: DepthComplexity
