"""Passes over fragments and over pixels, and the ways to group and repeat them."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from oitbench.errors import DeclarationError
from oitbench.method.blending import Blend

OPAQUE_DEPTH, OPAQUE_COLOR = "opaque_depth", "opaque_color"
"""Targets of the engine that passes may read."""
BLUE_NOISE = "blue_noise"
"""The engine's mask of thresholds, which passes may read; it repeats over the frame."""


class Objects(enum.Enum):
    """The transparent objects that a pass draws."""

    ALL = "all"
    PARTICLES = "particles"
    OTHERS = "others"


class Order(enum.Enum):
    """The order in which geometry is submitted."""

    SUBMISSION = "submission"
    OBJECTS = "object"
    """Objects by view distance of their bounding box's center, far first."""
    TRIANGLES = "triangle"
    """Triangles by view distance of their centroid, far first, over all objects."""


def _name(shader: str, defines: Mapping[str, float]) -> str:
    """Return the shader's name without folder and ending, followed by its macros."""
    macros = [f"{key.lower()}={value}" for key, value in defines.items()]
    return " ".join([PurePosixPath(shader).stem, *macros])


@dataclass(frozen=True)
class Gather:
    """A pass that draws transparent geometry; its shader defines `void gather(Fragment fragment)`.

    Parameters
    ----------
    shader : str
        File of the method's folder or its collection's `glsl/`, or `KIT/FILE.glsl`.
    reads : tuple of str
        Targets that the shader reads with `read_NAME()`; also `opaque_color`, `opaque_depth` and
        `blue_noise` (see `oitbench.method.blue_noise`).
    writes : mapping of str to Blend
        Targets that the shader writes by name. `color` is the frame's image; it starts as the
        opaque picture.
    buffers : tuple of str
        Buffers that the shader may access.
    order : Order
    depth : str, optional
        Target of format depth32f that takes the place of the opaque depth: fragments that are
        nearer pass, and their `inverse_depth` is written: nearer is greater, so clear it to 0. The
        opaque depth itself is never written.
    depth_writes : bool
        Whether `depth` is written; if not, it is only tested.
    clears : tuple of str
        Targets that are cleared just before this pass, in addition to the start of the frame.
    defines : mapping of str to int or float
        Macros of this pass, so that one shader can serve several passes.
    objects : Objects
    masked_by_alpha : bool
        The alpha of the first target is also the part of the fragment's samples that the pass
        writes. The driver chooses them. Needs several samples per pixel.
    """

    shader: str
    reads: tuple[str, ...] = ()
    writes: Mapping[str, Blend] = field(default_factory=dict)
    buffers: tuple[str, ...] = ()
    order: Order = Order.SUBMISSION
    depth: str | None = None
    depth_writes: bool = True
    clears: tuple[str, ...] = ()
    defines: Mapping[str, float] = field(default_factory=dict)
    objects: Objects = Objects.ALL
    masked_by_alpha: bool = False

    @property
    def name(self) -> str:
        """The shader's name, followed by the macros of the pass."""
        return _name(self.shader, self.defines)


@dataclass(frozen=True)
class Resolve:
    """A pass over all pixels; its shader defines `void resolve()`.

    Parameters
    ----------
    shader, reads, writes, buffers, clears, defines
        As in `Gather`.
    depth : str, optional
        Target of format depth32f that stores the value the shader assigns to `gl_FragDepth`.
    """

    shader: str
    reads: tuple[str, ...] = ()
    writes: Mapping[str, Blend] = field(default_factory=dict)
    buffers: tuple[str, ...] = ()
    depth: str | None = None
    clears: tuple[str, ...] = ()
    defines: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The shader's name, followed by the macros of the pass."""
        return _name(self.shader, self.defines)


Pass = Gather | Resolve


@dataclass(frozen=True)
class Interleaved:
    """Gather passes that are all issued for one unit of geometry before the next unit.

    A unit is an object or, under `Order.TRIANGLES`, a triangle. All passes must draw the same
    objects in the same order.
    """

    passes: tuple[Gather, ...]

    def __post_init__(self) -> None:
        if len({(item.order, item.objects) for item in self.passes}) != 1:
            shaders = " and ".join(item.shader for item in self.passes)
            raise DeclarationError(
                f"{shaders}: interleaved passes must draw the same objects in the same order"
            )


@dataclass(frozen=True)
class Loop:
    """Passes that are issued repeatedly; shaders read the round as the uniform `iteration`.

    Parameters
    ----------
    passes : tuple of Gather or Resolve
    times : int, optional
        Largest number of rounds. Default: as many as `until_empty` or `within` takes.
    until_empty : str, optional
        Name of a pass: the loop ends after the first round in which no sample passes in it.
    swaps : tuple of (str, str)
        Pairs of targets of one format that trade places after each round, so that a pass can read
        the result of the previous round. They are back in place when the loop ends.
    within : str, optional
        Target that marks, by texels that are not zero, the parts of the frame in which the next
        round has work. It is read back after each round. The passes of the next one draw only the
        rectangle around all marks; their clears still clear the whole frame. The loop ends when
        nothing is marked.
    """

    passes: tuple[Pass, ...]
    times: int | None = None
    until_empty: str | None = None
    swaps: tuple[tuple[str, str], ...] = ()
    within: str | None = None

    def __post_init__(self) -> None:
        if self.times is None and self.until_empty is None and self.within is None:
            shaders = " and ".join(item.shader for item in self.passes)
            raise DeclarationError(
                f"{shaders}: the loop has no end; give times, until_empty or within"
            )


Step = Gather | Resolve | Interleaved | Loop
