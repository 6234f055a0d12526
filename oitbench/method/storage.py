"""Textures and buffers that a method allocates."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass

from oitbench.errors import DeclarationError
from oitbench.method.formats import GLSL_BYTES, Format, find


@dataclass(frozen=True)
class Target:
    """A texture of the frame's size that passes write and read.

    Parameters
    ----------
    format : str
        A name of `oitbench.method.formats.FORMATS`.
    clear : tuple of float
        Value at the start of each frame: one for all components, or one per component.
    single : bool
        The target keeps one sample per pixel in a multisampled frame. A pass that writes such a
        target writes no others, and rasterizes pixel centers.
    subsample : int
        Downsampling factor per axis; partial edge blocks get a texel. A pass that writes such a
        target writes no others, and its block `View` holds the size of the target.
    """

    format: str
    clear: tuple[float, ...] = (0.0,)
    single: bool = False
    subsample: int = 1

    def __post_init__(self) -> None:
        if self.subsample < 1:
            raise DeclarationError(f"target: subsample is {self.subsample}; it must be at least 1")
        components = self.texel.components
        if len(self.clear) not in (1, components):
            raise DeclarationError(
                f"target: clear has {len(self.clear)} values; give one, or one for each of the"
                f" {components} components of {self.format}"
            )

    def size(self, frame: tuple[int, int]) -> tuple[int, int]:
        """Return (width, height) of the target in a frame of that many pixels."""
        width, height = (math.ceil(side / self.subsample) for side in frame)
        return width, height

    @property
    def texel(self) -> Format:
        """The format's entry in the table."""
        return find(self.format)


class Items(enum.Enum):
    """The unit that a buffer holds one record of; its size scales with their number."""

    PIXELS = "pixel"
    FRAGMENTS = "fragment"


@dataclass(frozen=True)
class Buffer:
    """Records that shaders read and write at any place.

    Each field is a separate storage block, so that a driver's limit on one block (128 MiB on
    some) applies to a field and not to a record. The prelude defines `NAME_FIELD(i)` and
    `set_NAME_FIELD(i, v)`, and for uint fields also `exchange_`, `add_`, `min_` and
    `max_NAME_FIELD(i, v)`. A buffer of fragments also defines `allocate_NAME()`, which returns the
    index of a fresh record, or NONE when memory has run out, and `allocate_NAME(n)`, for the first
    of n records that follow each other. The engine then repeats the frame with enough memory.

    Parameters
    ----------
    fields : mapping of str to str
        GLSL type of each field.
    items : Items
    clear : int, optional
        Value of each 32-bit word at the start of a frame. Default: the content stays.
    """

    fields: Mapping[str, str]
    items: Items
    clear: int | None = None

    @property
    def record_bytes(self) -> int:
        """Bytes of one record."""
        return sum(GLSL_BYTES[kind] for kind in self.fields.values())
