"""Shadow maps of one beam: a depth map of opaque surfaces, variance maps of transparent ones.

Transparent surfaces are drawn into one depth map per channel, where each texel keeps a fragment
with the probability that it absorbs the light of that channel; all channels are drawn at once. The
depths are converted to moments, and a tent of 15 texels filters them in two passes that keep every
fourth texel (McGuire & Mara 2017).
"""

from __future__ import annotations

import moderngl

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Chain, Measurement
from oitbench.gl.draws.records import Lap, no_lap
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.program.passes import Blueprint
from oitbench.gl.view import Projection
from oitbench.method.blending import MINIMUM, REPLACE
from oitbench.method.passes import Gather, Resolve
from oitbench.method.storage import Target

KEPT = 4
"""Downsampling factor of the filter per axis."""
_DEPTH, _MAP = Target("depth32f", clear=(1.0,)), Target("r32f", clear=(1.0,))
_MOMENTS = Target("rg32f")
_SHADER, _TAPS = "shadow_map.glsl", 15
_DRAWN, _FILTERED = "shadow maps", "variance maps"


class ShadowMaps(Owner):
    """The maps of one beam.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    effects : Effect
        Running effects, which determine the maps that exist.
    projection : Projection
        View of the scene from the beam.
    side : int
        Texels along each side of the depth maps; a multiple of `KEPT`.

    Attributes
    ----------
    opaque : bool
        Whether there is a map of opaque surfaces.
    channels : int
        Number of variance maps: 0, 1 for gray light, or 3.
    textures : dict of str to moderngl.Texture
        All maps by name.
    finished : dict of str to moderngl.Texture
        Maps that shading reads: "opaque", and the variance maps "filtered0" and so on.
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        effects: Effect,
        projection: Projection,
        side: int,
    ) -> None:
        super().__init__()
        translucent = bool(effects & Effect.TRANSLUCENT_SHADOWS) and len(geometry.casting) > 0
        self.opaque = bool(effects & Effect.SHADOWS)
        colored = bool(effects & Effect.COLORED_SHADOWS)
        self.channels = (3 if colored else 1) if translucent else 0
        self._geometry = geometry
        self._blueprint = Blueprint("shadow maps", effects=effects & Effect.CAUSTICS)
        sizes = self._sizes(side)
        kinds = {"opaque": _DEPTH, "map": _MAP}
        targets = {name: kinds.get(name.rstrip("012"), _MOMENTS) for name in sizes}
        with self.building():
            view = self.own(device.context.buffer(projection.block((side, side))))
            self._chain = self.own(Chain(device, geometry, targets, sizes, view))
            self._compile()
        self.textures = self._chain.textures
        names = [
            *(["opaque"] if self.opaque else []),
            *map("filtered{}".format, range(self.channels)),
        ]
        self.finished = {name: self.textures[name] for name in names}
        for name in names[int(self.opaque) :]:
            self.finished[name].filter = (moderngl.LINEAR, moderngl.LINEAR)

    def _sizes(self, side: int) -> dict[str, tuple[int, int]]:
        small = side // KEPT
        sizes = {"opaque": (side, side)} if self.opaque else {}
        if self.channels:
            sizes |= {f"map{k}": (side, side) for k in range(self.channels)}
            sizes |= {"moments": (side, side), "across": (small, side)}
            sizes |= {f"filtered{k}": (small, small) for k in range(self.channels)}
        return sizes

    def _compile(self) -> None:
        chain, blueprint, geometry = self._chain, self._blueprint, self._geometry
        if self.opaque:
            opaque = Gather("opaque_map.glsl", depth="opaque", clears=("opaque",))
            chain.add(opaque, blueprint, _DRAWN, geometry.opaque)
            if not self.channels:
                # Without translucent shadows, surfaces that absorb half the light cast hard ones.
                binary = Gather(_SHADER, depth="opaque", defines={"BINARY": 1, "GRAY": 1})
                chain.add(binary, blueprint, _DRAWN, geometry.casting)
        if self.channels:
            maps = tuple(f"map{k}" for k in range(self.channels))
            draw = Gather(
                _SHADER,
                writes=dict.fromkeys(maps, MINIMUM),
                depth="opaque" if self.opaque else None,
                depth_writes=False,
                clears=maps,
                defines={"GRAY": 1} if self.channels == 1 else {},
            )
            chain.add(draw, blueprint, _DRAWN, geometry.casting)
        for channel in range(self.channels):
            self._add_filters(channel)

    def _add_filters(self, channel: int) -> None:
        taps = {"map": 1, "opaque": 1} if self.opaque else {"map": 1}
        convert = Resolve(
            "shadow_moments.glsl",
            reads=tuple(taps),
            writes={"moments": REPLACE},
            defines={"OPAQUE": 1} if self.opaque else {},
        )
        names = {"map": f"map{channel}"}
        self._chain.add(convert, self._blueprint, _FILTERED, taps=taps, names=names)
        for source, result, defines in (
            ("moments", "across", {"ACROSS": 1}),
            ("across", f"filtered{channel}", {}),
        ):
            tent = Resolve(
                "shadow_tent.glsl",
                reads=("source",),
                writes={"filtered": REPLACE},
                defines=defines,
            )
            names = {"source": source, "filtered": result}
            taps = {"source": _TAPS}
            self._chain.add(tent, self._blueprint, _FILTERED, taps=taps, names=names)

    def issue(self, lap: Lap = no_lap) -> None:
        """Draw and filter all maps; `lap` ends "shadow maps" and "variance maps"."""
        self._chain.issue(lap=lap)

    def measure(self, into: Measurement) -> None:
        """Draw and filter all maps, and add "shadow maps" and "variance maps" to `into`."""
        self._chain.measure(into)

    def memory(self) -> list[tuple[str, int]]:
        """Return (map, bytes)."""
        return self._chain.memory()
