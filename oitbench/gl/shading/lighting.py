"""The lights of a scene on the device: the uniform block `Lights`, the environment, the shadows."""

from __future__ import annotations

import math

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.effects import SHADING, Effect
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Moved
from oitbench.gl.draws.steps import PassRecord
from oitbench.gl.geometry import Geometry
from oitbench.gl.program.prelude import LIGHTS_BINDING, MEDIUM_BINDING
from oitbench.gl.shading.medium import Fog
from oitbench.gl.shading.shadows import ShadowMaps
from oitbench.gl.view import Projection, light_projection
from oitbench.scene import PENUMBRA, DirectionalLight, EnvironmentLight, SpotLight, Texture

MAP_SIDE = 1024
"""Texels along each side of a light's depth maps; variance maps keep every fourth."""
Floats = npt.NDArray[np.float64]
_CASTING = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS
_NO_PROJECTION = Projection(np.eye(4), np.eye(4), 1.0, 2.0, 1.0, np.zeros(4))


class Lighting:
    """What shading needs to know of a scene's lights.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    effects : Effect
        Those that run.
    map_side : int
        Texels along each side of a depth map.

    Attributes
    ----------
    block : moderngl.Buffer
    fog : Fog
        The medium that scatters the light; only shaders that march through it read it.
    textures : dict of str to moderngl.Texture or moderngl.Texture3D
        Samplers by name.
    """

    def __init__(
        self, device: Device, geometry: Geometry, effects: Effect, map_side: int = MAP_SIDE
    ) -> None:
        scene = geometry.scene
        self.device = device
        self._beams = scene.beams
        self._drawn = False
        casters = tuple(item for item in scene.objects if item.casts)
        self._projections = [
            light_projection(light, casters, scene.objects) if effects & _CASTING else None
            for light in self._beams
        ]
        self.maps = [
            None
            if projection is None
            else ShadowMaps(device, geometry, effects, projection, map_side)
            for projection in self._projections
        ]
        self.textures: dict[str, moderngl.Texture | moderngl.Texture3D] = {}
        for number, maps in enumerate(self.maps):
            if maps is not None:
                self.textures |= {
                    f"{name}_map{number}": texture
                    for name, texture in maps.textures.items()
                    if name == "opaque" or name.startswith("filtered")
                }
        harmonics = np.zeros((9, 3))
        self._environment = scene.environment
        if self._environment is not None:
            texels = environment_texels(self._environment)
            harmonics = irradiance_harmonics(texels)
            self.textures["environment_texture"] = self._upload(texels)
        self.fog = Fog(device, scene.medium)
        if self.fog.density is not None:
            self.textures["density_texture"] = self.fog.density
        self.block = device.context.buffer(self._bytes(harmonics, map_side))

    def _upload(self, texels: Floats) -> moderngl.Texture:
        height, width = texels.shape[:2]
        data = np.ones((height, width, 4), dtype=np.float32)
        data[..., :3] = texels[::-1]
        texture = self.device.context.texture((width, height), 4, data.tobytes(), dtype="f4")
        texture.build_mipmaps()
        texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        texture.repeat_x, texture.repeat_y = True, False
        return texture

    def _bytes(self, harmonics: Floats, map_side: int) -> bytes:
        parts = []
        for light, projection in zip(self._beams, self._projections, strict=True):
            seen = projection or _NO_PROJECTION
            parts.append(
                np.concatenate([seen.world_to_clip.T.ravel(), *_beam(light, seen, map_side)])
            )
        parts.append(np.zeros(36))
        padded = np.concatenate([harmonics, np.zeros((9, 1))], axis=1)
        return np.concatenate([*parts, padded.ravel()]).astype(np.float32).tobytes()

    @property
    def blocks(self) -> dict[int, moderngl.Buffer]:
        """The uniform blocks by binding."""
        return {LIGHTS_BINDING: self.block, MEDIUM_BINDING: self.fog.block}

    @property
    def macros(self) -> str:
        """What shaders must know at compile time."""
        lines = [f"#define BEAMS {len(self._beams)}"]
        if self._environment is not None:
            lines.append("#define ENVIRONMENT 1")
        return "\n".join(lines)

    @property
    def visibility(self) -> str:
        """The samplers of all maps, and the function `beam_visibility` that reads them."""
        lines, cases = [], []
        for number, maps in enumerate(self.maps):
            if maps is None or not (maps.opaque or maps.channels):
                continue
            names = [name for name in self.textures if name.endswith(f"_map{number}")]
            lines += [f"uniform sampler2D {name};" for name in names]
            cases.append(f"    if (i == {number}) {{\n{_visibility(number, maps)}    }}")
        head = "vec3 beam_visibility(int i, vec3 position, vec3 side) {\n    vec3 lit = vec3(1.0);"
        return "\n".join([*lines, head, *cases, "    return lit;", "}"])

    def prepare(self) -> None:
        """Draw all shadow maps, unless they have been drawn: they do not depend on the camera."""
        if not self._drawn:
            self.issue()

    def issue(self) -> None:
        """Draw all shadow maps."""
        self._drawn = True
        for maps in self.maps:
            if maps is not None:
                maps.issue()

    def measure(self) -> tuple[list[PassRecord], list[Moved]]:
        """Draw all shadow maps; return what each stage did, and the bytes it moved."""
        records: dict[str, PassRecord] = {}
        moved = [entry for maps in self.maps if maps is not None for entry in maps.measure(records)]
        return list(records.values()), moved

    def memory(self) -> list[tuple[str, int]]:
        """Return (map, bytes) of all shadow maps."""
        return [
            (f"light {number} {name}", size)
            for number, maps in enumerate(self.maps)
            if maps is not None
            for name, size in maps.memory()
        ]

    def release(self) -> None:
        """Free the device's memory."""
        for maps in self.maps:
            if maps is not None:
                maps.release()
        if "environment_texture" in self.textures:
            self.textures["environment_texture"].release()
        self.fog.release()
        self.block.release()


def lighting_of(device: Device, geometry: Geometry, effects: Effect) -> Lighting | None:
    """Return the lighting that all frames of `geometry` under these effects share.

    None for a scene that is lit by emission alone, unless its medium is called for: that comes
    with the lights that it scatters, be there any or none. It is released with the geometry.
    """
    if not geometry.scene.lights and Effect.VOLUME not in effects:
        return None
    shading = effects & SHADING
    if shading not in geometry.lightings:
        geometry.lightings[shading] = Lighting(device, geometry, shading)
    return geometry.lightings[shading]


def _beam(light: DirectionalLight | SpotLight, seen: Projection, map_side: int) -> list[Floats]:
    """Return place, axis, color, distance and range of one beam, four numbers each."""
    texel = 2 / (seen.focal * map_side)
    if isinstance(light, DirectionalLight):
        direction = -np.asarray(light.direction, dtype=np.float64)
        place = np.array([*direction / np.linalg.norm(direction), 0.0])
        axis, color = np.zeros(4), light.irradiance
    else:
        ahead = np.subtract(light.target, light.position).astype(np.float64)
        place = np.array([*light.position, 1.0])
        axis = np.array([*ahead / np.linalg.norm(ahead), light.angle / 2])
        color = light.intensity
    bounds = np.array([seen.near, seen.far, PENUMBRA, 0.0])
    return [place, axis, np.array([*color, texel]), seen.distance_row, bounds]


def _visibility(number: int, maps: ShadowMaps) -> str:
    """Return the GLSL that finds what beam `number` loses on its way."""
    lines = [
        f"MapPlace at = place_in_map({number}, position);",
        "if (!at.inside) return lit;",
    ]
    if maps.channels:
        reads = [
            f"variance_visibility(filtered{k}_map{number}, at.uv, at.distance)"
            for k in range(maps.channels)
        ]
        lines.append(f"lit = vec3({', '.join(reads)});")
    if maps.opaque:
        lines += [
            f"at = place_in_map({number}, off_surface({number}, position, side));",
            f"lit = min(lit, vec3(opaque_visibility(opaque_map{number}, {number}, at)));",
        ]
    return "".join(f"        {line}\n" for line in lines)


def environment_texels(light: EnvironmentLight) -> Floats:
    """Return the map of latitude and longitude, (h, w, 3), first row up; small if constant."""
    if isinstance(light.radiance, Texture):
        return light.radiance.texels.astype(np.float64)
    return np.broadcast_to(np.asarray(light.radiance, dtype=np.float64), (2, 4, 3))


def irradiance_harmonics(texels: Floats) -> Floats:
    """Return the coefficients with which `surrounding_irradiance` (lighting.glsl) gives irradiance.

    Parameters
    ----------
    texels : array, shape (h, w, 3)
        Radiance by latitude (first row up, +y) and longitude (middle column −z, to the right +x).

    Returns
    -------
    array, shape (9, 3)
        For 1, y, z, x, xy, yz, 3z² − 1, xz, x² − y², normalization and cosine lobe included.

    References
    ----------
    Ramamoorthi & Hanrahan 2001, "An efficient representation for irradiance environment maps".
    """
    # Texels of a small map are cut into patches, over which the functions hardly change.
    cuts = max(1, math.ceil(256 / len(texels)))
    texels = texels.repeat(cuts, axis=0).repeat(cuts, axis=1)
    height, width = texels.shape[:2]
    edges = np.linspace(0, math.pi, height + 1)
    polar = (edges[:-1] + edges[1:]) / 2
    weight = (np.cos(edges[:-1]) - np.cos(edges[1:]))[:, None] * (2 * math.pi / width)
    longitude = ((np.arange(width) + 0.5) / width - 0.5) * 2 * math.pi
    x = np.sin(polar)[:, None] * np.sin(longitude)
    y = np.broadcast_to(np.cos(polar)[:, None], x.shape)
    z = -np.sin(polar)[:, None] * np.cos(longitude)
    functions = [np.ones_like(x), y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y]
    # Squares of the functions' normalization, times the cosine lobe's π, 2π/3, π/4 by band.
    norms = np.array([1 / (4 * math.pi), *[3 / (4 * math.pi)] * 3, *[15 / (4 * math.pi)] * 2,
                      5 / (16 * math.pi), 15 / (4 * math.pi), 15 / (16 * math.pi)])  # fmt: skip
    lobe = np.array([math.pi, *[2 * math.pi / 3] * 3, *[math.pi / 4] * 5])
    sums = [np.einsum("hw,hwc->c", weight * function, texels) for function in functions]
    return np.asarray(np.array(sums) * (norms * lobe)[:, None])
