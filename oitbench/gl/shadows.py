"""The shadow maps of one beam: one of what is opaque, and variance maps of what lets light through.

The chain: draw what transmits light into one depth map a channel, each texel with the probability
that its light is kept back, all channels at once; turn depths into moments; filter them by a tent
of 15 texels in two passes that keep every fourth texel (McGuire & Mara 2017).
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import moderngl
import numpy as np

from oitbench.declare import MINIMUM, REPLACE, Draws, Method, Order, Pass, Target
from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.geometry import Batch, Geometry
from oitbench.gl.passes import Blueprint, CompiledPass, attach, compile_pass
from oitbench.gl.prelude import bind
from oitbench.gl.steps import PassRecord
from oitbench.gl.view import Projection

KEPT = 4
"""Every which texel the filter keeps, along each axis."""
_DEPTH, _MAP, _MOMENTS = Target("depth32f"), Target("r32f"), Target("rg32f")
_OPAQUE = Pass("opaque_map.glsl", Draws.FRAGMENTS, depth="opaque")
_SHADER, _TAPS = "shadow_map.glsl", 15
Moved = tuple[str, str, str, int, int]
"""Pass, resource, kind, items, bytes of each: what `oitbench.accounting` makes a term of."""


@dataclass(frozen=True)
class _Draw:
    """One compiled pass with what it draws: a batch's indices, or the screen.

    `writes` names the maps that it fills; `reads` tells how many texels of a map one output needs.
    """

    compiled: CompiledPass
    view: moderngl.Buffer
    indices: moderngl.Buffer | None
    clears: bool
    writes: tuple[str, ...]
    reads: Mapping[str, int]

    @property
    def label(self) -> str:
        return "variance maps" if self.indices is None else "shadow maps"


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
        self.device, self.side, self.projection = device, side, projection
        self._geometry, self._effects = geometry, effects
        translucent = bool(effects & Effect.TRANSLUCENT_SHADOWS) and len(geometry.casting.triangles)
        self.opaque = bool(effects & Effect.SHADOWS)
        colored = bool(effects & Effect.COLORED_SHADOWS)
        self.channels = (3 if colored else 1) if translucent else 0
        self.textures: dict[str, moderngl.Texture] = {}
        self._declared: dict[str, Target] = {}
        self._framebuffers: dict[str, moderngl.Framebuffer] = {}
        self._draws: list[_Draw] = []
        self._views: list[moderngl.Buffer] = []
        self._indices: list[moderngl.Buffer] = []
        self._create()
        self._compile()

    # -- preparation ---------------------------------------------------------------------------

    def _create(self) -> None:
        side, small = self.side, self.side // KEPT
        sizes = {"opaque": (side, side)} if self.opaque else {}
        if self.channels:
            sizes |= {f"map{k}": (side, side) for k in range(self.channels)}
            sizes |= {"moments": (side, side), "across": (small, side)}
            sizes |= {f"filtered{k}": (small, small) for k in range(self.channels)}
        for name, size in sizes.items():
            kinds = {"opaque": _DEPTH, "map": _MAP}
            declared = kinds.get(name.rstrip("012"), _MOMENTS)
            self._declared[name] = declared
            self.textures[name] = self.device.texture(size, declared.texel)
            self._framebuffers[name] = attach(self.device, self.textures[name], declared.texel)
            if name.startswith("filtered"):
                self.textures[name].filter = (moderngl.LINEAR, moderngl.LINEAR)

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
        declared = {name: self._declared[actual] for name, actual in named.items()}
        indices = None
        if batch is not None:
            triangles = batch.arrange(Order.SUBMISSION)[0]
            if not len(triangles) and not clears:
                return
            if not len(triangles):
                # What is read must have been cleared: a triangle without area draws nothing.
                triangles = np.zeros((1, 3), dtype=np.uint32)
            indices = self.device.context.buffer(triangles.tobytes())
            self._indices.append(indices)
        blueprint = Blueprint(
            self.device, self._geometry, Method(), None, self._effects & Effect.CAUSTICS, declared,
            {}, bind({}, False),
        )  # fmt: skip
        compiled = compile_pass(blueprint, step, textures)
        view = self.device.context.buffer(self.projection.block((self.side, self.side)))
        self._views.append(view)
        self._draws.append(_Draw(compiled, view, indices, clears, writes, reads or {}))

    # -- rendering -----------------------------------------------------------------------------

    def issue(self) -> None:
        """Draw and filter all maps."""
        for draw in self._draws:
            self._begin(draw)
            self._draw(draw)

    def measure(self, records: dict[str, PassRecord]) -> list[Moved]:
        """Do the same, waiting for every draw; return what was moved.

        Parameters
        ----------
        records : dict of str to PassRecord
            Gains or adds to "shadow maps" and "variance maps".
        """
        moved: list[Moved] = []
        for draw in self._draws:
            start = time.perf_counter()
            query = self.device.context.query(samples=True)
            self._begin(draw)
            with query:
                self._draw(draw)
            self.device.finish()
            items = int(query.samples)
            record = records.setdefault(draw.label, PassRecord(draw.label))
            record.runs += 1
            record.fragments += items
            record.milliseconds += 1e3 * (time.perf_counter() - start)
            moved += self._moved(draw, items)
        return moved

    def _moved(self, draw: _Draw, items: int) -> list[Moved]:
        moved: list[Moved] = []
        for name, texels in draw.reads.items():
            size = self._declared[name].texel.bytes
            moved.append((draw.label, name, "read", texels * items, size))
        for name in draw.writes:
            size = self._declared[name].texel.bytes
            if draw.clears:
                moved.append((draw.label, name, "clear", self.side**2, size))
            if draw.indices is not None:
                moved.append((draw.label, name, "blend", items, size))
            moved.append((draw.label, name, "write", items, size))
        return moved

    def _begin(self, draw: _Draw) -> None:
        area = (0, 0, self.side, self.side)
        for name in draw.writes if draw.clears else ():
            self._framebuffers[name].use()
            self._framebuffers[name].scissor = area
            self.device.clear(0, self._declared[name].texel, (1.0,))
        draw.compiled.begin(draw.view, area)

    @staticmethod
    def _draw(draw: _Draw) -> None:
        if draw.indices is None:
            draw.compiled.draw_screen()
        else:
            draw.compiled.draw(draw.indices, 0, draw.indices.size // 12)

    def memory(self) -> list[tuple[str, int]]:
        """Return (map, bytes)."""
        return [
            (name, texture.width * texture.height * self._declared[name].texel.bytes)
            for name, texture in self.textures.items()
        ]

    def release(self) -> None:
        """Free the device's memory."""
        for draw in self._draws:
            draw.compiled.release()
        for framebuffer in self._framebuffers.values():
            framebuffer.release()
        for texture in self.textures.values():
            texture.release()
        for buffer in (*self._views, *self._indices):
            buffer.release()
