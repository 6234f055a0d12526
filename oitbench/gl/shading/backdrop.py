"""What lies behind all transparency: the opaque picture, its depth, and the copies passes need."""

from __future__ import annotations

from collections.abc import Iterable

import moderngl

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.geometry import Geometry
from oitbench.gl.shading.lighting import Lighting
from oitbench.gl.shading.occlusion import Occlusion
from oitbench.gl.shading.opaque import DEPTH, draw_opaque
from oitbench.method.declaration import Draws, Pass, Target


class Backdrop:
    """The opaque picture of one frame.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    size : (int, int)
        Width and height in pixels.
    color : Target
        Of the picture.
    samples : int
        Samples a pixel.
    passes : iterable of Pass
        Those that run before it: what they read decides which copies there are.
    single : bool
        Whether some of them write targets of one sample a pixel in a multisampled frame.

    Attributes
    ----------
    textures : dict of str to moderngl.Texture
        "opaque_color" and "opaque_depth"; perhaps "opaque_depth_copy" and "opaque_depth_single".
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        size: tuple[int, int],
        color: Target,
        samples: int,
        passes: Iterable[Pass],
        single: bool,
    ) -> None:
        self._device, self._geometry, self._size = device, geometry, size
        self._color, self._samples = color, samples
        self.textures = {
            "opaque_color": device.texture(size, color.texel, samples),
            "opaque_depth": device.texture(size, DEPTH.texel, samples),
        }
        if any(p.draws is Draws.FRAGMENTS and "opaque_depth" in p.reads for p in passes):
            # What a pass tests against it may not read as well: it gets a copy.
            self.textures["opaque_depth_copy"] = device.texture(size, DEPTH.texel, samples)
        if samples > 1 and single:
            self.textures["opaque_depth_single"] = device.texture(size, DEPTH.texel)

    def draw(
        self,
        view: moderngl.Buffer,
        transmittance: bool,
        lighting: Lighting | None,
        effects: Effect,
        occlusion: Occlusion | None,
    ) -> None:
        """Draw all of it, and fill the uniform block `View`.

        Parameters
        ----------
        view : moderngl.Buffer
        transmittance : bool
            Show a background of one instead of radiance.
        lighting, occlusion : optional
            What shades.
        effects : Effect
            Those that run.
        """
        color, depth = self.textures["opaque_color"], self.textures["opaque_depth"]
        draw_opaque(
            self._device, self._geometry, view, (color, depth), self._color,
            self._samples, transmittance, lighting, effects, occlusion,
        )  # fmt: skip
        if "opaque_depth_copy" in self.textures:
            copied = self.textures["opaque_depth_copy"]
            self._device.copy(depth, copied, self._size, self._samples)
        if "opaque_depth_single" in self.textures:
            self._draw_single(view, transmittance, effects)

    def _draw_single(self, view: moderngl.Buffer, transmittance: bool, effects: Effect) -> None:
        """Draw the depth at pixel centers, for targets of one sample a pixel."""
        color = self._device.texture(self._size, self._color.texel)
        behind = (color, self.textures["opaque_depth_single"])
        draw_opaque(
            self._device, self._geometry, view, behind, self._color, 1, transmittance,
            effects=effects,
        )  # fmt: skip
        color.release()

    def release(self) -> None:
        """Free the device's memory."""
        for texture in self.textures.values():
            texture.release()
