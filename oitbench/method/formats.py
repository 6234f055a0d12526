"""The one table of texture formats: their cost, and their names in OpenGL and GLSL."""

from __future__ import annotations

from dataclasses import dataclass

from oitbench.errors import DeclarationError, unknown


@dataclass(frozen=True)
class Format:
    """A texture format.

    Parameters
    ----------
    name : str
        Name used in declarations, such as "rgba16f".
    components : int
    dtype : str
        Element type of moderngl ("f1" is normalized 8 bit).
    bytes : int
        Size of one texel, unpadded.
    step : float
        Largest distance of adjacent values in [0, 1].
    internal : int, optional
        Enumerant of OpenGL, where moderngl cannot derive it.
    """

    name: str
    components: int
    dtype: str
    bytes: int
    step: float
    internal: int | None = None

    @property
    def integer(self) -> bool:
        """Whether texels are unsigned integers, which cannot be blended."""
        return self.dtype == "u4"

    @property
    def signed(self) -> bool:
        """Whether texels are signed fractions of bytes."""
        return self.name.endswith("_snorm")

    @property
    def half(self) -> bool:
        """Whether texels are half floats."""
        return self.dtype == "f2"

    @property
    def depth(self) -> bool:
        """Whether this is a depth format."""
        return self.name.startswith("depth")

    @property
    def glsl(self) -> str:
        """The GLSL type of a texel."""
        if self.components == 1:
            return "uint" if self.integer else "float"
        return f"{'u' if self.integer else ''}vec{self.components}"


LARGEST_HALF = 65504.0
"""The greatest half float. Beyond it, sums are infinite on GPUs and stay at it on llvmpipe."""
_HALF = 2.0**-11
_FULL = 2.0**-24
FORMATS: dict[str, Format] = {
    entry.name: entry
    for entry in (
        Format("r8", 1, "f1", 1, 1 / 255),
        Format("rgb8", 3, "f1", 3, 1 / 255),
        Format("rgba8", 4, "f1", 4, 1 / 255),
        Format("rg8_snorm", 2, "f1", 2, 1 / 127, internal=0x8F95),
        Format("r16f", 1, "f2", 2, _HALF),
        Format("rg16f", 2, "f2", 4, _HALF),
        Format("rgba16f", 4, "f2", 8, _HALF),
        Format("r32f", 1, "f4", 4, _FULL),
        Format("rg32f", 2, "f4", 8, _FULL),
        Format("rgba32f", 4, "f4", 16, _FULL),
        Format("r32ui", 1, "u4", 4, 1.0),
        Format("rg32ui", 2, "u4", 8, 1.0),
        Format("rgba32ui", 4, "u4", 16, 1.0),
        Format("depth32f", 1, "f4", 4, _FULL),
    )
}
_BITS = {"half": "16f", "float": "32f"}


def find(name: str) -> Format:
    """Return the format called `name`; raise `DeclarationError` with near names otherwise."""
    if name not in FORMATS:
        raise DeclarationError(str(unknown("texture format", name, FORMATS)))
    return FORMATS[name]


def float_format(channels: str, precision: str) -> str:
    """Return a floating-point format by precision: `("rgba", "half")` gives "rgba16f".

    Parameters
    ----------
    channels : str
        "r", "rg" or "rgba".
    precision : str
        "half" or "float".
    """
    return channels + _BITS[precision]


GLSL_BYTES = {"float": 4, "uint": 4, "int": 4, "vec2": 8, "uvec2": 8, "vec4": 16, "uvec4": 16}
"""Size in bytes of a buffer field, by its GLSL type (std430, one field per buffer)."""
