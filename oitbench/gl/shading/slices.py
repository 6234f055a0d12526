"""Opacity slices of one beam: the light that reaches planes across its axis.

Surfaces are drawn as the light sees them, and each adds its optical depth to the slice of space
that it lies in (Kim and Neumann 2001, "Opacity Shadow Maps"). A sum over the slices before a plane
gives the light there. This is repeated for one ray after another through each texel, and the light
is averaged: cutouts smaller than a texel then darken as much as they cover.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import moderngl
import numpy as np

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Chain, Measurement
from oitbench.gl.draws.records import Lap, Term, no_lap
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.program.bindings import Bindings
from oitbench.gl.program.passes import LIGHT_VIEW, Blueprint
from oitbench.gl.view import Projection
from oitbench.method.passes import Gather, Resolve
from oitbench.method.storage import Buffer, Items, Target
from oitbench.shading import ShadingSettings

_UNIT = float(2**18)
"""Fixed-point optical depth of one; a slice holds 1,489 opaque layers before its sum overflows."""
_LABEL = "opacity slices"
_DEPTH = {"nothing": Target("depth32f")}
_MARGIN = 1e-3
"""Part of the casters' range by which the slices reach beyond it, on both sides."""
_LEAST = 1e-6
"""The same, as a part of their distance, for casters in one plane across the light."""
_WORD = 4


class OpacitySlices(Owner):
    """The slices of one beam.

    Parameters
    ----------
    device : Device
    geometry : Geometry
        At least one transparent object casts shadows.
    effects : Effect
    projection : Projection
        View of the scene from the beam.
    settings : ShadingSettings
    channels : int
        1 for gray light, or 3.

    Attributes
    ----------
    textures : dict of str to moderngl.Texture3D
        One per channel: "slices0" and so on.

    Raises
    ------
    CapabilityError
        The slices are larger than the driver allows.
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        effects: Effect,
        projection: Projection,
        settings: ShadingSettings,
        channels: int,
    ) -> None:
        super().__init__()
        self._device, self._channels = device, channels
        self._side, self._planes = settings.small_side, settings.slices
        self._first, self._thickness = _range(geometry, projection, settings.slices)
        self._rays = settings.rays**2
        bytes_ = _WORD * self._side**2 * self._planes
        owner = f"{self._planes} slices of {self._side}x{self._side} texels"
        device.within(owner, bytes_, "GL_MAX_SHADER_STORAGE_BLOCK_SIZE")
        device.within(owner, max(self._side, self._planes), "GL_MAX_3D_TEXTURE_SIZE")
        fields = [f"{kind}{k}" for kind in ("depth", "light") for k in range(channels)]
        types = {name: "uint" if name.startswith("depth") else "float" for name in fields}
        buffers = {"slices": Buffer(types, Items.PIXELS)}
        self._bindings = Bindings.of(buffers, counted=False)
        self._views = [
            _shifted(projection, shift).block((self._side, self._side), origin=geometry.origin)
            for shift in _shifts(settings.rays, self._side)
        ]
        with self.building():
            self._view = self.own(device.context.buffer(self._views[0]))
            self._fields = {
                name: self.own(device.context.buffer(reserve=bytes_)) for name in fields
            }
            self.textures = {f"slices{k}": self._texture() for k in range(channels)}
            sizes = {"nothing": (self._side, self._side)}
            self._chain = self.own(Chain(device, geometry, _DEPTH, sizes, self._view))
            self._compile(geometry, buffers, effects)

    def _texture(self) -> moderngl.Texture3D:
        size = (self._side, self._side, self._planes)
        texture = self.own(self._device.context.texture3d(size, 1, dtype="f2"))
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = texture.repeat_z = False
        return texture

    def _compile(self, geometry: Geometry, buffers: dict[str, Buffer], effects: Effect) -> None:
        blueprint = Blueprint(
            _LABEL, buffers=buffers, bindings=self._bindings, effects=effects & Effect.CAUSTICS
        )
        constants = {"UNIT": _UNIT, "LIGHT_PLANES": self._planes}
        constants |= {"GRAY": 1} if self._channels == 1 else {}
        draw = Gather(
            "slice_depths.glsl",
            buffers=("slices",),
            depth="nothing",
            depth_writes=False,
            clears=("nothing",),
            defines=constants | {LIGHT_VIEW: 1, "FIRST": self._first, "THICKNESS": self._thickness},
        )
        self._chain.add(draw, blueprint, _LABEL, geometry.casting)
        light = Resolve(
            "slice_light.glsl",
            buffers=("slices",),
            depth="nothing",
            defines=constants | {"SAMPLES": float(self._rays)},
        )
        self._chain.add(light, blueprint, _LABEL)

    def issue(self, lap: Lap = no_lap) -> None:
        """Draw all slices; `lap` ends "opacity slices"."""
        self._each_ray(lambda: self._chain.issue())
        lap(_LABEL)

    def measure(self, into: Measurement) -> None:
        """Draw all slices, and add their record to `into`."""
        before = into.records[_LABEL].fragments if _LABEL in into.records else 0
        self._each_ray(lambda: self._chain.measure(into))
        texels, rays = self._side**2 * self._planes, self._rays
        drawn = into.records[_LABEL].fragments - before - rays * self._side**2
        for name in self._fields:
            into.terms.append(Term(_LABEL, name, "clear", texels, _WORD))
            if name.startswith("depth"):
                into.terms.append(Term(_LABEL, name, "atomic", drawn + rays * texels, 2 * _WORD))
            else:
                # The last read is the copy to the texture.
                into.terms.append(Term(_LABEL, name, "read", (rays + 1) * texels, _WORD))
                into.terms.append(Term(_LABEL, name, "write", rays * texels, _WORD))
        for name in self.textures:
            into.terms.append(Term(_LABEL, name, "write", texels, _WORD // 2))

    def _each_ray(self, draw: Callable[[], None]) -> None:
        """Draw once for each ray of a texel, and store the mean light in the textures."""
        for name, buffer in self._fields.items():
            self._device.fill(buffer)
            buffer.bind_to_storage_buffer(self._bindings.fields["slices", name])
        for view in self._views:
            self._view.write(view)
            draw()
        self._device.context.memory_barrier()
        for k in range(self._channels):
            self._device.write_volume(self.textures[f"slices{k}"], self._fields[f"light{k}"])

    def memory(self) -> list[tuple[str, int]]:
        """Return (texture or buffer, bytes)."""
        texels = self._side**2 * self._planes
        return [
            *self._chain.memory(),
            *((name, _WORD * texels) for name in self._fields),
            *((name, _WORD // 2 * texels) for name in self.textures),
        ]

    def visibility(self, number: int) -> str:
        """Return the GLSL expression of the light of beam `number` that arrives, a vec3."""
        constants = f"{self._first:.9e}, {self._thickness:.9e}"
        place = f"slice_place({number}, receiver, {constants})"
        own = ["receiver.tau.r", "receiver.tau.g", "receiver.tau.b"]
        if self._channels == 1:
            own = ["dot(receiver.tau, vec3(1.0 / 3.0))"]
        reads = [
            f"slice_visibility({name}_map{number}, {place}, receiver.kind, {tau})"
            for name, tau in zip(self.textures, own, strict=True)
        ]
        return f"vec3({', '.join(reads)})"


def _range(geometry: Geometry, projection: Projection, planes: int) -> tuple[float, float]:
    """Return the distance of the first plane, and the distance between planes, in meters."""
    row = projection.distance_row
    casting = [item for item in geometry.scene.transparent if item.casts]
    distances = [item.mesh.used_positions @ row[:3] + row[3] for item in casting]
    near = max(min(float(one.min()) for one in distances), projection.near)
    far = max(max(float(one.max()) for one in distances), near)
    margin = _MARGIN * (far - near) + _LEAST * far
    return near - margin, (far - near + 2 * margin) / (planes - 1)


def _shifts(count: int, side: int) -> list[tuple[float, float]]:
    """Return the places of `count` x `count` rays in a texel, in clip space."""
    places = 2 * ((np.arange(count) + 0.5) / count - 0.5) / side
    return list(itertools.product(places.tolist(), repeat=2))


def _shifted(projection: Projection, shift: tuple[float, float]) -> Projection:
    """Return the projection that shows at the center of a texel a place beside it."""
    moved = np.eye(4)
    moved[:2, 3] = -np.asarray(shift)
    return replace(projection, to_clip=moved @ projection.to_clip)
