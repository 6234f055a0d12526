"""Renders the shots of a check with a method."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.ownership import Owner
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.method.declaration import Method
from oitbench.stability.check import Rendering, Shot

_RANDOM_PIXELS = 1024
"""Smallest number of pixels to which the images of a method with random pixels are enlarged."""


class UploadedScenes(Owner):
    """The scenes of some shots on the device, which all methods share.

    Parameters
    ----------
    device : Device
    shots : sequence of Shot
    """

    def __init__(self, device: Device, shots: Sequence[Shot]) -> None:
        super().__init__()
        self.device = device
        scenes = {id(shot.scene): shot.scene for shot in shots}
        with self.building():
            self._uploaded = {
                key: self.own(UploadedScene(device, scene)) for key, scene in scenes.items()
            }

    def render(
        self, method: Method, shots: Sequence[Shot], times: int = 1
    ) -> list[list[Rendering]]:
        """Render each shot `times` times in a row.

        Images of fragment lists are enlarged for methods with random pixels: each pixel is repeated
        in a square, so that there is a mean to compare.

        Raises
        ------
        CapabilityError
            The driver lacks a capability that the method requires.
        DeclarationError
            The declaration is inconsistent or a shader does not compile.
        """
        renderings = []
        for _, group in groupby(shots, key=lambda shot: (id(shot.scene), shot.pixels)):
            alike = list(group)
            with self._frame(method, alike[0]) as frame:
                renderings += [[_render(frame, shot) for _ in range(times)] for shot in alike]
        return renderings

    def _frame(self, method: Method, shot: Shot) -> Frame:
        width, height = shot.pixels
        copies = 1
        if method.noisy and shot.scene.lists is not None:
            copies = math.ceil(math.sqrt(_RANDOM_PIXELS / (width * height)))
        effects = shot.scene.effects & method.shows
        scene = self._uploaded[id(shot.scene)]
        return Frame(scene, method, (width * copies, height * copies), effects)


def _render(frame: Frame, shot: Shot) -> Rendering:
    frame.render(shot.transmittance, shot.permutation)
    return Rendering(
        frame.read("color"),
        frame.read("opaque_color"),
        in_order_of_arrival=frame.plan.in_order_of_arrival and not frame.device.software,
    )
