"""The suite's own methods, drawn beside other engines: whole frames at the size of a picture."""

from __future__ import annotations

from oitbench.engines.adapter import Drawing
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.limits import check_size
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image.files import Image
from oitbench.plugins import Collection
from oitbench.scene import Scene


class OwnFrame(Drawing):
    """A frame of a method, with the opaque picture that it is composited over.

    Parameters
    ----------
    device : Device
    collection : Collection
    scene : Scene
    method : str
        `NAME[param=v]`.
    size : (int, int)
        Width and height in pixels.
    """

    def __init__(
        self,
        device: Device,
        collection: Collection,
        scene: Scene,
        method: str,
        size: tuple[int, int],
    ) -> None:
        check_size(device, size)
        (chosen,) = collection.expand_methods([method])
        self._device, self._scene = device, UploadedScene(device, scene, rows=size[1])
        self._frame = Frame(self._scene, chosen, size, scene.effects & chosen.shows)
        self._frame.render()

    def draw(self) -> None:
        """Draw the opaque picture and the method, and wait until OpenGL has finished."""
        frame = self._frame
        frame.draw_backdrop()
        frame.restore()
        if frame.orders.sorts:
            frame.orders.sort()
        frame.composite()
        self._device.finish()

    def image(self) -> Image:
        """Return the picture."""
        return self._frame.image()

    def release(self) -> None:
        """Free the frame and the scene."""
        self._frame.release()
        self._scene.release()
