"""The opaque picture of a frame, and the copies of its depth that passes need."""

from __future__ import annotations

import moderngl

from oitbench.gl.device import Device
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.plan import FramePlan
from oitbench.gl.program.passes import DEPTH_AT_CENTERS, DEPTH_COPY
from oitbench.gl.program.shading_inputs import ShadingInputs
from oitbench.gl.shading.opaque import DEPTH, OpaquePicture
from oitbench.method.passes import OPAQUE_COLOR, OPAQUE_DEPTH


class Backdrop(Owner):
    """The opaque picture of one frame.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    plan : FramePlan
    view : moderngl.Buffer
        The uniform block `View` of the frame.
    shading : ShadingInputs

    Attributes
    ----------
    textures : dict of str to moderngl.Texture
        `OPAQUE_COLOR` and `OPAQUE_DEPTH`, and where the plan needs them `DEPTH_COPY` and
        `DEPTH_AT_CENTERS`.
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        plan: FramePlan,
        view: moderngl.Buffer,
        shading: ShadingInputs,
    ) -> None:
        super().__init__()
        self._device, self._plan = device, plan
        target, size, samples = plan.color, plan.size, plan.samples
        with self.building():
            color = self.own(device.texture(size, target.texel, samples))
            depth = self.own(device.texture(size, DEPTH.texel, samples))
            self.textures = {OPAQUE_COLOR: color, OPAQUE_DEPTH: depth}
            picture = OpaquePicture(
                device, geometry, color, depth, target, view, samples, plan.effects, shading
            )
            self._picture = self.own(picture)
            self._centers: OpaquePicture | None = None
            if plan.copies_depth:
                copied = self.own(device.texture(size, DEPTH.texel, samples))
                self.textures[DEPTH_COPY] = copied
            if plan.needs_depth_at_centers:
                self._add_centers(geometry, view)

    def _add_centers(self, geometry: Geometry, view: moderngl.Buffer) -> None:
        """Add the depth at pixel centers, for targets of one sample per pixel."""
        target, size = self._plan.color, self._plan.size
        depth = self.own(self._device.texture(size, DEPTH.texel))
        color = self.own(self._device.texture(size, target.texel))  # drawn, but never seen
        picture = OpaquePicture(
            self._device, geometry, color, depth, target, view, effects=self._plan.effects
        )
        self._centers = self.own(picture)
        self.textures[DEPTH_AT_CENTERS] = depth

    def draw(self, transmittance: bool) -> None:
        """Draw the picture; `transmittance` shows a background of one instead of radiance."""
        self._picture.draw(transmittance)

    def derive(self) -> None:
        """Draw and copy the further depths that passes of this plan need."""
        if self._centers is not None:
            self._centers.draw()
        if DEPTH_COPY in self.textures:
            self._device.copy(
                self.textures[OPAQUE_DEPTH], self.textures[DEPTH_COPY], self._plan.size,
                self._plan.samples,
            )  # fmt: skip
