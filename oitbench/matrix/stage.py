"""A scene on the device with its truths."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from oitbench.errors import OitbenchError
from oitbench.gl.frame import Frame, Image
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files
from oitbench.image.stored import StoredImage
from oitbench.scene import Scene

if TYPE_CHECKING:
    from oitbench.path_traced.references.storage import Reference


@dataclass
class Stage:
    """What the cells of one scene and size share.

    Parameters
    ----------
    label : str
        The canonical label of the scene.
    size : (int, int)
        Width and height of the image in pixels.
    ssaa : int
        Side of the sub-pixel grid.
    shading : str
        See `Cell.shading`.
    uploaded : UploadedScene
    exact, exact_transmittance : array, shape (h, w, 3), float32
        The exact truth.
    images : dict of str to StoredImage
        The truths that are stored in the results folder.
    """

    label: str
    size: tuple[int, int]
    ssaa: int
    shading: str
    uploaded: UploadedScene
    exact: Image
    exact_transmittance: Image
    images: dict[str, StoredImage]
    _reference: tuple[Reference, str] | OitbenchError | None = field(default=None, init=False)

    @property
    def identity(self) -> tuple[str, tuple[int, int], int, str]:
        """The fields of a cell that have the same stage."""
        return self.label, self.size, self.ssaa, self.shading

    @property
    def scene(self) -> Scene:
        """The scene that is uploaded."""
        return self.uploaded.scene

    def reference(self, folders: Iterable[Path]) -> tuple[Reference, str]:
        """Return the path-traced truth and a message; the first call may take minutes.

        Parameters
        ----------
        folders : iterable of Path
            Folders of collections.

        Raises
        ------
        OitbenchError
            As `find_or_render` does, in every call.
        """
        from oitbench.path_traced.references.lookup import find_or_render

        if self._reference is None:
            try:
                place = self.label, self.size, self.ssaa
                self._reference = find_or_render(self.scene, *place, folders)
            except OitbenchError as error:
                self._reference = error
        if isinstance(self._reference, OitbenchError):
            raise self._reference
        return self._reference


def with_transmittance(frame: Frame, ssaa: int) -> tuple[Image, Image]:
    """Return the image and the transmittance alone, averaged over sub-pixels."""
    frame.render()
    image = files.box_downsample(frame.image(), ssaa)
    frame.render(transmittance=True)
    return image, files.box_downsample(frame.image(), ssaa)
