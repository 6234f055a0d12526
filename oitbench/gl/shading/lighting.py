"""The lights of a scene on the device: uniform block `Lights`, environment and shadow maps."""

from __future__ import annotations

import moderngl
import numpy as np

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Measurement
from oitbench.gl.draws.records import Lap, no_lap
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.program.bindings import LIGHTS_BINDING, MEDIUM_BINDING
from oitbench.gl.program.shading_inputs import Sampled, ShadingInputs
from oitbench.gl.shading.environment import (
    irradiance_harmonics,
    upload_environment,
)
from oitbench.gl.shading.medium import UploadedMedium
from oitbench.gl.shading.shadows import ShadowMaps
from oitbench.gl.view import Projection, light_projection
from oitbench.scene import PENUMBRA, DirectionalLight, Floats, SpotLight, unit
from oitbench.scene.checks import single_precision
from oitbench.shading import DEFAULT, ShadingSettings

_BEAM_BYTES, _HARMONICS_BYTES = 144, 144
_CASTING = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS
_NO_PROJECTION = Projection(np.eye(4), np.eye(4), 1.0, 2.0, 1.0, np.zeros(4))


class Lighting(Owner):
    """Lights, environment, medium and shadow maps of a scene; all methods share them.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    effects : Effect
        Running effects of shading.
    settings : ShadingSettings

    Attributes
    ----------
    block : moderngl.Buffer
        The uniform block `Lights`.
    medium : UploadedMedium
    maps : list of ShadowMaps or None
        One entry per beam; None for a beam without casters.

    Raises
    ------
    CapabilityError
        There are more lights, or larger maps, than the driver allows.
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        effects: Effect,
        settings: ShadingSettings = DEFAULT,
    ) -> None:
        super().__init__()
        scene = geometry.scene
        self._beams = scene.beams
        self._drawn, self._settings = False, settings
        owner = f"a scene of {len(self._beams)} directional and spot lights"
        size = (len(self._beams) + 1) * _BEAM_BYTES + _HARMONICS_BYTES
        device.within(owner, size, "GL_MAX_UNIFORM_BLOCK_SIZE")
        casters = tuple(item for item in scene.objects if item.casts)
        self._projections = [
            light_projection(light, casters, scene.objects) if effects & _CASTING else None
            for light in self._beams
        ]
        harmonics = np.zeros((9, 3))
        self._environment: moderngl.Texture | None = None
        with self.building():
            self.maps = [
                None
                if projection is None
                else self.own(ShadowMaps(device, geometry, effects, projection, settings))
                for projection in self._projections
            ]
            if scene.environment is not None:
                texels = scene.environment.texels
                self._environment = self.own(upload_environment(device, texels))
                harmonics = irradiance_harmonics(texels)
            self.medium = self.own(UploadedMedium(device, scene.medium))
            self.block = self.own(
                device.context.buffer(self._bytes(harmonics, settings.shadow_map))
            )

    def _bytes(self, harmonics: Floats, map_side: int) -> bytes:
        parts = []
        for light, projection in zip(self._beams, self._projections, strict=True):
            seen = projection or _NO_PROJECTION
            parts.append(
                np.concatenate([seen.world_to_clip.T.ravel(), *_beam(light, seen, map_side)])
            )
        parts.append(np.zeros(36))
        padded = np.concatenate([harmonics, np.zeros((9, 1))], axis=1)
        numbers = np.concatenate([*parts, padded.ravel()])
        return single_precision("the lights of the scene", numbers).tobytes()

    def inputs(self, effects: Effect) -> ShadingInputs:
        """Return the inputs of shaders under all running `effects`."""
        lines = [f"#define BEAMS {len(self._beams)}"]
        if any(self.maps):
            lines.append(f"#define DOWNSAMPLING {self._settings.downsampling}")
        if self._environment is not None:
            lines.append("#define ENVIRONMENT 1")
        return ShadingInputs(
            lit=True,
            lights="\n".join(lines),
            shadows=self._shadows(),
            medium=self.medium.macros if Effect.VOLUME in effects else "",
            samplers=self._samplers(),
            blocks={LIGHTS_BINDING: self.block, MEDIUM_BINDING: self.medium.block},
        )

    def _samplers(self) -> dict[str, Sampled]:
        found: dict[str, Sampled] = {}
        for number, maps in enumerate(self.maps):
            if maps is not None:
                found |= {f"{name}_map{number}": texture for name, texture in maps.finished.items()}
        if self._environment is not None:
            found["environment_texture"] = self._environment
        if self.medium.density is not None:
            found["density_texture"] = self.medium.density
        return found

    def _shadows(self) -> str:
        """Return the samplers of all maps, and the function `beam_visibility` that reads them."""
        lines, cases = [], []
        for number, maps in enumerate(self.maps):
            if maps is None or not maps.finished:
                continue
            lines += [
                f"uniform {'sampler3D' if isinstance(texture, moderngl.Texture3D) else 'sampler2D'}"
                f" {name}_map{number};"
                for name, texture in maps.finished.items()
            ]
            cases.append(f"    if (i == {number}) {{\n{maps.visibility(number)}    }}")
        head = "vec3 beam_visibility(int i, Receiver receiver) {"
        return "\n".join(
            [*lines, head, "    vec3 lit = vec3(1.0);", *cases, "    return lit;", "}"]
        )

    def prepare(self) -> None:
        """Draw all shadow maps unless they are drawn: they do not depend on the camera."""
        if not self._drawn:
            self.issue()

    def issue(self, lap: Lap = no_lap) -> None:
        """Draw all shadow maps; `lap` ends each part."""
        self._drawn = True
        for maps in self.maps:
            if maps is not None:
                maps.issue(lap)

    def measure(self, into: Measurement) -> None:
        """Draw all shadow maps, and add one record per stage to `into`."""
        self._drawn = True
        for maps in self.maps:
            if maps is not None:
                maps.measure(into)

    def memory(self) -> list[tuple[str, int]]:
        """Return (map, bytes) of all shadow maps."""
        return [
            (f"light {number} {name}", size)
            for number, maps in enumerate(self.maps)
            if maps is not None
            for name, size in maps.memory()
        ]


def _beam(light: DirectionalLight | SpotLight, seen: Projection, map_side: int) -> list[Floats]:
    """Return place, axis, color, distance and range of one beam, four numbers each."""
    texel = 2 / (seen.focal * map_side)
    if isinstance(light, DirectionalLight):
        place = np.array([*-unit(np.asarray(light.direction, dtype=np.float64)), 0.0])
        axis, color = np.zeros(4), light.irradiance
    else:
        ahead = unit(np.subtract(light.target, light.position, dtype=np.float64))
        place = np.array([*light.position, 1.0])
        axis = np.array([*ahead, light.angle / 2])
        color = light.intensity
    bounds = np.array([seen.near, seen.far, PENUMBRA, 0.0])
    return [place, axis, np.array([*color, texel]), seen.distance_row, bounds]
