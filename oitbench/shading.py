"""Settings of the shading that all methods share.

A setting is a parameter like those of methods: `oitbench run --shading shadow_map=1024,4096` runs
both values. Settings do not depend on the scene, the method or the size of the frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from oitbench import parameters
from oitbench.errors import UsageError
from oitbench.parameters import AnyParameter, Parameter, Value

PUBLISHED, OCCLUDERS, SLICES = "published", "occluders", "slices"
"""Forms of translucent shadows; see "Shadow maps" in CONVENTIONS.md."""
_OWNER = "shading"


@dataclass(frozen=True)
class ShadingSettings:
    """Settings of shadow maps.

    Parameters
    ----------
    translucent : str
        Form of translucent shadows: "published", variance maps whose moments include the nearest
        opaque surface; "occluders", variance maps of transparent surfaces alone, with their weight;
        or "slices", the transmittance at planes across the light.
    shadow_map : int
        Texels along each side of a depth map.
    downsampling : int
        Factor per axis by which variance maps and slices are smaller than depth maps.
    slices : int
        Planes at which the form "slices" knows the transmittance.
    rays : int
        Side of the grid of rays through each texel that the form "slices" averages.

    Raises
    ------
    UsageError
        A value is not allowed.
    """

    translucent: str = SLICES
    shadow_map: int = 1024
    downsampling: int = 4
    slices: int = 64
    rays: int = 1

    def __post_init__(self) -> None:
        for name, value in self.values.items():
            PARAMETERS[name].check(_OWNER, name, value)
        if self.shadow_map % self.downsampling:
            raise UsageError(
                f"{_OWNER}: shadow_map is {self.shadow_map}; it must be a multiple of downsampling,"
                f" which is {self.downsampling}"
            )

    @property
    def values(self) -> dict[str, Value]:
        """All values by name."""
        return asdict(self)

    @property
    def label(self) -> str:
        """The settings that differ from their defaults, as in "shadow_map=4096"; "" for none."""
        return parameters.label("", self.values, PARAMETERS)[1:-1]

    @property
    def small_side(self) -> int:
        """Texels along each side of variance maps and slices."""
        return self.shadow_map // self.downsampling


PARAMETERS: Mapping[str, AnyParameter] = {
    "translucent": Parameter(
        ShadingSettings.translucent,
        choices=(PUBLISHED, OCCLUDERS, SLICES),
        help="form of translucent shadows",
    ),
    "shadow_map": Parameter(
        ShadingSettings.shadow_map, low=16, high=16384, help="texels along each side of depth maps"
    ),
    "downsampling": Parameter(
        ShadingSettings.downsampling,
        choices=(1, 2, 4, 8),
        help="factor per axis by which variance maps and slices are smaller",
    ),
    "slices": Parameter(
        ShadingSettings.slices, low=2, high=1024, help="planes of the form 'slices'"
    ),
    "rays": Parameter(
        ShadingSettings.rays,
        low=1,
        high=16,
        help="side of the grid of rays through each texel of slices",
    ),
}
"""The settings by name, in the order of their label."""


DEFAULT = ShadingSettings()


def read_shading(label: str) -> ShadingSettings:
    """Return the settings that a label names.

    Raises
    ------
    UsageError
        A name is unknown, a value is not allowed, or there are several.
    """
    found = parse_shading([label])
    if len(found) > 1:
        raise UsageError(f"{_OWNER}: '{label}' selects {len(found)} settings; give one of each")
    return found[0]


def parse_shading(texts: Sequence[str]) -> tuple[ShadingSettings, ...]:
    """Return all combinations of values that some texts `NAME=value,value` select.

    Raises
    ------
    UsageError
        A name is unknown, or a value is not allowed.
    """
    selected = parameters.parse(f"{_OWNER}[{','.join(texts)}]")
    combinations: Iterator[dict[str, Any]] = parameters.expand(selected, PARAMETERS)
    found = [ShadingSettings(**values) for values in combinations]
    return tuple(dict.fromkeys(found))
