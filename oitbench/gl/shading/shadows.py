"""Shadow maps of one beam: a depth map of opaque surfaces, and maps of transparent ones.

For variance maps, transparent surfaces are drawn into one depth map per channel, where each texel
keeps a fragment with the probability that it absorbs the light of that channel; all channels are
drawn at once. The depths are converted to moments, and a tent filters them in two passes that keep
one of several texels (McGuire & Mara 2017). The other form of translucent shadows is `slices`.
"""

from __future__ import annotations

import moderngl

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Chain, Measurement
from oitbench.gl.draws.records import Lap, no_lap
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.program.passes import LIGHT_VIEW, Blueprint
from oitbench.gl.program.shading_inputs import Sampled
from oitbench.gl.shading.slices import OpacitySlices
from oitbench.gl.view import Projection
from oitbench.method.blending import MAXIMUM, REPLACE
from oitbench.method.passes import Gather, Resolve
from oitbench.method.storage import Target
from oitbench.shading import OCCLUDERS, PUBLISHED, SLICES, ShadingSettings

_DEPTH, _MAP = Target("depth32f"), Target("r32f")
_MOMENTS = {PUBLISHED: Target("rg32f"), OCCLUDERS: Target("rgba32f")}
_SHADER = "shadow_map.glsl"
_LIGHT_VIEW = {LIGHT_VIEW: 1}
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
    settings : ShadingSettings

    Attributes
    ----------
    opaque : bool
        Whether there is a map of opaque surfaces.
    channels : int
        Number of maps of transparent surfaces: 0, 1 for gray light, or 3.
    textures : dict of str to moderngl.Texture
        All maps by name.
    finished : dict of str to texture
        Maps that shading reads: "opaque", and "filtered0" and so on, or "slices0" and so on.
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        effects: Effect,
        projection: Projection,
        settings: ShadingSettings,
    ) -> None:
        super().__init__()
        side = settings.shadow_map
        self._settings = settings
        translucent = bool(effects & Effect.TRANSLUCENT_SHADOWS) and len(geometry.casting) > 0
        self.opaque = bool(effects & Effect.SHADOWS)
        colored = bool(effects & Effect.COLORED_SHADOWS)
        self.channels = (3 if colored else 1) if translucent else 0
        self._geometry = geometry
        self._blueprint = Blueprint("shadow maps", effects=effects & Effect.CAUSTICS)
        self._slices: OpacitySlices | None = None
        sizes = self._sizes(side, settings.small_side)
        kinds = {"opaque": _DEPTH, "map": _MAP}
        moments = _MOMENTS.get(settings.translucent, _MAP)
        targets = {name: kinds.get(name.rstrip("012"), moments) for name in sizes}
        with self.building():
            block = projection.block((side, side), origin=geometry.origin)
            view = self.own(device.context.buffer(block))
            self._chain = self.own(Chain(device, geometry, targets, sizes, view))
            self._compile()
            if self.channels and settings.translucent == SLICES:
                self._slices = self.own(
                    OpacitySlices(device, geometry, effects, projection, settings, self.channels)
                )
        self.textures = self._chain.textures
        self.finished: dict[str, Sampled] = {}
        if self.opaque:
            self.finished["opaque"] = self.textures["opaque"]
        if self._slices is not None:
            self.finished |= self._slices.textures
        elif self.channels:
            for name in map("filtered{}".format, range(self.channels)):
                self.textures[name].filter = (moderngl.LINEAR, moderngl.LINEAR)
                self.finished[name] = self.textures[name]

    @property
    def _variance(self) -> bool:
        """Whether there are variance maps."""
        return self.channels > 0 and self._settings.translucent != SLICES

    def _sizes(self, side: int, small: int) -> dict[str, tuple[int, int]]:
        sizes = {"opaque": (side, side)} if self.opaque else {}
        if self._variance:
            sizes |= {f"map{k}": (side, side) for k in range(self.channels)}
            sizes |= {"moments": (side, side), "across": (small, side)}
            sizes |= {f"filtered{k}": (small, small) for k in range(self.channels)}
        return sizes

    def _compile(self) -> None:
        chain, blueprint, geometry = self._chain, self._blueprint, self._geometry
        if self.opaque:
            opaque = Gather(
                "opaque_map.glsl", depth="opaque", clears=("opaque",), defines=_LIGHT_VIEW
            )
            chain.add(opaque, blueprint, _DRAWN, geometry.opaque)
            if not self.channels:
                # Without translucent shadows, surfaces that absorb half the light cast hard ones.
                binary = Gather(
                    _SHADER, depth="opaque", defines={"BINARY": 1, "GRAY": 1} | _LIGHT_VIEW
                )
                chain.add(binary, blueprint, _DRAWN, geometry.casting)
        if self._variance:
            maps = tuple(f"map{k}" for k in range(self.channels))
            draw = Gather(
                _SHADER,
                writes=dict.fromkeys(maps, MAXIMUM),
                depth="opaque" if self.opaque else None,
                depth_writes=False,
                clears=maps,
                defines=_LIGHT_VIEW | ({"GRAY": 1} if self.channels == 1 else {}),
            )
            chain.add(draw, blueprint, _DRAWN, geometry.casting)
            for channel in range(self.channels):
                self._add_filters(channel)

    def _add_filters(self, channel: int) -> None:
        alone = self._settings.translucent == OCCLUDERS
        form = {"OCCLUDERS": 1} if alone else {}
        opaque = {"opaque": 1} if self.opaque and not alone else {}
        taps = {"map": 1} | opaque
        convert = Resolve(
            "shadow_moments.glsl",
            reads=tuple(taps),
            writes={"moments": REPLACE},
            defines=form | {name.upper(): 1 for name in opaque},
        )
        names = {"map": f"map{channel}"}
        self._chain.add(convert, self._blueprint, _FILTERED, taps=taps, names=names)
        factor = self._settings.downsampling
        for source, result, defines in (
            ("moments", "across", {"ACROSS": 1}),
            ("across", f"filtered{channel}", {}),
        ):
            tent = Resolve(
                "shadow_tent.glsl",
                reads=("source",),
                writes={"filtered": REPLACE},
                defines=defines | form | {"DOWNSAMPLING": factor},
            )
            names = {"source": source, "filtered": result}
            taps = {"source": 4 * factor - 1}
            self._chain.add(tent, self._blueprint, _FILTERED, taps=taps, names=names)

    def issue(self, lap: Lap = no_lap) -> None:
        """Draw and filter all maps; `lap` ends each stage."""
        self._chain.issue(lap=lap)
        if self._slices is not None:
            self._slices.issue(lap)

    def measure(self, into: Measurement) -> None:
        """Draw and filter all maps, and add the records of all stages to `into`."""
        self._chain.measure(into)
        if self._slices is not None:
            self._slices.measure(into)

    def memory(self) -> list[tuple[str, int]]:
        """Return (map, bytes)."""
        return [*self._chain.memory(), *(self._slices.memory() if self._slices else [])]

    def visibility(self, number: int) -> str:
        """Return the GLSL that computes the part of beam `number` that arrives."""
        lines = [
            f"MapPlace at = place_in_map({number}, receiver.position);",
            "if (!at.inside) return lit;",
        ]
        if self._slices is not None:
            lines.append(f"lit = {self._slices.visibility(number)};")
        elif self.channels:
            alone = self._settings.translucent == OCCLUDERS
            name, last = ("occluder", ", receiver.kind") if alone else ("published", "")
            reads = [
                f"{name}_visibility(filtered{k}_map{number}, at.uv, at.distance{last})"
                for k in range(self.channels)
            ]
            lines.append(f"lit = vec3({', '.join(reads)});")
        if self.opaque:
            lines += [
                f"at = place_in_map({number}, off_surface({number}, receiver, 2.0));",
                f"lit = min(lit, vec3(opaque_visibility(opaque_map{number}, {number}, at)));",
            ]
        return "".join(f"        {line}\n" for line in lines)
