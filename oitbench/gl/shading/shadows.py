"""The shadow maps of one beam: one of what is opaque, and variance maps of what lets light through.

The chain: draw what transmits light into one depth map a channel, each texel with the probability
that its light is kept back, all channels at once; turn depths into moments; filter them by a tent
of 15 texels in two passes that keep every fourth texel (McGuire & Mara 2017).
"""

from __future__ import annotations

from collections.abc import Mapping

import moderngl

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Chain, Moved
from oitbench.gl.draws.steps import PassRecord
from oitbench.gl.geometry import Batch, Geometry
from oitbench.gl.program.passes import Blueprint
from oitbench.gl.program.prelude import bind
from oitbench.gl.view import Projection
from oitbench.method.declaration import MINIMUM, REPLACE, Draws, Method, Pass, Target

KEPT = 4
"""Every which texel the filter keeps, along each axis."""
_DEPTH, _MAP = Target("depth32f", clear=(1.0,)), Target("r32f", clear=(1.0,))
_MOMENTS = Target("rg32f")
_OPAQUE = Pass("opaque_map.glsl", Draws.FRAGMENTS, depth="opaque")
_SHADER, _TAPS = "shadow_map.glsl", 15


class ShadowMaps:
    """The maps of one beam.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    effects : Effect
        Those that run: they decide which maps there are.
    projection : Projection
        How the beam sees the scene.
    side : int
        Texels along each side of the depth maps; a multiple of `KEPT`.

    Attributes
    ----------
    opaque : bool
        Whether there is a map of opaque surfaces.
    channels : int
        Variance maps: none, one for grey light, or three.
    textures : dict of str to moderngl.Texture
        "opaque", and "filtered0" and so on: the finished variance maps.
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        effects: Effect,
        projection: Projection,
        side: int,
    ) -> None:
        self._device, self._geometry, self._effects = device, geometry, effects
        translucent = bool(effects & Effect.TRANSLUCENT_SHADOWS) and len(geometry.casting.triangles)
        self.opaque = bool(effects & Effect.SHADOWS)
        colored = bool(effects & Effect.COLORED_SHADOWS)
        self.channels = (3 if colored else 1) if translucent else 0
        sizes = self._sizes(side)
        kinds = {"opaque": _DEPTH, "map": _MAP}
        self._declared = {name: kinds.get(name.rstrip("012"), _MOMENTS) for name in sizes}
        view = device.context.buffer(projection.block((side, side)))
        self._chain = Chain(device, self._declared, sizes, view)
        self.textures = self._chain.textures
        for channel in range(self.channels):
            self.textures[f"filtered{channel}"].filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._compile()

    # -- preparation ---------------------------------------------------------------------------

    def _sizes(self, side: int) -> dict[str, tuple[int, int]]:
        small = side // KEPT
        sizes = {"opaque": (side, side)} if self.opaque else {}
        if self.channels:
            sizes |= {f"map{k}": (side, side) for k in range(self.channels)}
            sizes |= {"moments": (side, side), "across": (small, side)}
            sizes |= {f"filtered{k}": (small, small) for k in range(self.channels)}
        return sizes

    def _compile(self) -> None:
        if self.opaque:
            self._add(_OPAQUE, self._geometry.opaque, ("opaque",), clears=True)
            if not self.channels:
                # Without translucent shadows what keeps back half of the light hides all of it.
                defines = {"BINARY": 1, "GREY": 1}
                binary = Pass(_SHADER, Draws.FRAGMENTS, depth="opaque", defines=defines)
                self._add(binary, self._geometry.casting, ("opaque",))
        if self.channels:
            maps = tuple(f"map{k}" for k in range(self.channels))
            draw = Pass(
                _SHADER,
                Draws.FRAGMENTS,
                writes=dict.fromkeys(maps, MINIMUM),
                tests="opaque" if self.opaque else None,
                defines={"GREY": 1} if self.channels == 1 else {},
            )
            self._add(draw, self._geometry.casting, maps, clears=True)
        for channel in range(self.channels):
            self._add_filters(channel)

    def _add_filters(self, channel: int) -> None:
        reads = ("map", "opaque") if self.opaque else ("map",)
        convert = Pass(
            "shadow_moments.glsl",
            Draws.PIXELS,
            reads=reads,
            writes={"moments": REPLACE},
            defines={"OPAQUE": 1} if self.opaque else {},
        )
        taken = {f"map{channel}" if name == "map" else name: 1 for name in reads}
        names = {"map": f"map{channel}"}
        self._add(convert, None, ("moments",), reads=taken, names=names)
        for source, result, defines in (
            ("moments", "across", {"ACROSS": 1}),
            ("across", f"filtered{channel}", {}),
        ):
            tent = Pass(
                "shadow_tent.glsl",
                Draws.PIXELS,
                reads=("source",),
                writes={"filtered": REPLACE},
                defines=defines,
            )
            names = {"source": source, "filtered": result}
            self._add(tent, None, (result,), reads={source: _TAPS}, names=names)

    def _add(
        self,
        step: Pass,
        batch: Batch | None,
        writes: tuple[str, ...],
        reads: Mapping[str, int] | None = None,
        clears: bool = False,
        names: Mapping[str, str] | None = None,
    ) -> None:
        named = {name: name for name in self.textures} | dict(names or {})
        textures = {name: self.textures[actual] for name, actual in named.items()}
        blueprint = Blueprint(
            self._device, self._geometry, Method(), None, self._effects & Effect.CAUSTICS,
            {name: self._declared[actual] for name, actual in named.items()}, {}, bind({}, False),
        )  # fmt: skip
        label = "variance maps" if batch is None else "shadow maps"
        self._chain.add(label, blueprint, step, writes, reads, batch, clears, textures)

    # -- rendering -----------------------------------------------------------------------------

    def issue(self) -> None:
        """Draw and filter all maps."""
        self._chain.issue()

    def measure(self, records: dict[str, PassRecord]) -> list[Moved]:
        """Do the same, waiting for every draw; return what was moved.

        Parameters
        ----------
        records : dict of str to PassRecord
            Gains or adds to "shadow maps" and "variance maps".
        """
        return self._chain.measure(records)

    def memory(self) -> list[tuple[str, int]]:
        """Return (map, bytes)."""
        return self._chain.memory()

    def release(self) -> None:
        """Free the device's memory."""
        self._chain.release()
