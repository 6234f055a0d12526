"""A scene on the device with its truths."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.errors import OitbenchError
from oitbench.gl.frame import Frame, Image
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files, ties
from oitbench.image.files import Channels
from oitbench.image.stored import StoredImage
from oitbench.measure import scene_statistics
from oitbench.method.declaration import Method
from oitbench.results.schema import COMPLEXITY, TRANSMITTANCE, ReferenceFacts
from oitbench.results.statistics import SceneStatistics
from oitbench.scene import Scene
from oitbench.truths import EXACT

if TYPE_CHECKING:
    from oitbench.path_traced.references.storage import Reference

Store = Callable[[str, Channels], StoredImage]
"""Writes an image of a kind into the results folder."""


@dataclass(frozen=True, eq=False)
class Truth:
    """A truth of a scene.

    Parameters
    ----------
    image : array, shape (h, w, 3), float32
    stored : StoredImage
        The image in the results folder.
    without : sequence of array, shape (h, w, 3), float32
        Means of all parts but each one; empty if there is no noise, or a single part.
    noise_floor : mapping of str to float or None
        By metric.
    facts : ReferenceFacts, optional
        Of a traced truth.
    message : str
        A remark for readers.
    """

    image: Image
    stored: StoredImage
    without: tuple[Image, ...] = ()
    noise_floor: Mapping[str, float | None] = field(default_factory=dict)
    facts: ReferenceFacts | None = None
    message: str = ""


@dataclass(frozen=True, eq=False)
class Exact:
    """Exact compositing: the truth, its total transmittance, and where anything is transparent.

    Parameters
    ----------
    truth : Truth
    transmittance : array, shape (h, w, 3), float32
    stored : StoredImage
        The transmittance in the results folder.
    transparent : array, shape (h, w), bool
        Pixels with a transparent fragment.
    """

    truth: Truth
    transmittance: Image
    stored: StoredImage
    transparent: npt.NDArray[np.bool_]


@dataclass
class Stage:
    """What the cells of one view and size share; each truth is made when it is first asked for.

    Parameters
    ----------
    label : str
        The canonical label of the scene.
    size : (int, int)
        Width and height of the image in pixels.
    ssaa : int
        Side of the sub-pixel grid.
    shading, view : str
        See `Cell`.
    uploaded : UploadedScene
        For frames with sub-pixels.
    method : Method
        Exact compositing.
    store : Store

    Attributes
    ----------
    disagreements : dict of Effect to str
        Why truths contradict each other, or "", by the effects that run.
    """

    label: str
    size: tuple[int, int]
    ssaa: int
    shading: str
    view: str
    uploaded: UploadedScene
    method: Method
    store: Store
    disagreements: dict[Effect, str] = field(default_factory=dict, init=False)
    _others: dict[int, UploadedScene] = field(default_factory=dict, init=False)
    _exact: dict[tuple[Effect, tuple[int, int]], Exact] = field(default_factory=dict, init=False)
    _traced: dict[str, Truth | OitbenchError] = field(default_factory=dict, init=False)

    @property
    def identity(self) -> tuple[str, tuple[int, int], int, str, str]:
        """The fields of a cell that have the same stage."""
        return self.label, self.size, self.ssaa, self.shading, self.view

    @property
    def coarse(self) -> UploadedScene:
        """The scene for frames without sub-pixels."""
        return self.at(self.size[1])

    def at(self, rows: int) -> UploadedScene:
        """Return the scene for frames of some rows of pixels, sub-pixels included."""
        if rows == self.size[1] * self.ssaa or not self.scene.by_pixel:
            return self.uploaded
        if rows not in self._others:
            known = self.uploaded
            self._others[rows] = UploadedScene(known.device, known.scene, known.settings, rows)
        return self._others[rows]

    def release(self) -> None:
        """Free the scene on the device."""
        self.uploaded.release()
        for other in self._others.values():
            other.release()

    @property
    def scene(self) -> Scene:
        """The scene that is uploaded."""
        return self.uploaded.scene

    def statistics(self, effects: Effect) -> SceneStatistics:
        """Return the statistics of the scene in frames without sub-pixels under running effects."""
        return scene_statistics.measure(self.coarse, self.size, effects)

    def complexity(self, effects: Effect) -> StoredImage:
        """Return the map of depth complexity that belongs to `statistics`."""
        counts = self.coarse.fragment_counts(self.size, effects)[::-1]
        return self.store(COMPLEXITY, files.count_channels(counts))

    def exact(self, chosen: Effect, size: tuple[int, int]) -> Exact:
        """Return exact compositing of the scene, without the effects that are not chosen.

        Parameters
        ----------
        chosen : Effect
        size : (int, int)
            Width and height of the picture in pixels.
        """
        effects = self.scene.effects & chosen & self.method.shows
        if (effects, size) not in self._exact:
            width, height = size
            fine = (width * self.ssaa, height * self.ssaa)
            with Frame(self.at(fine[1]), self.method, fine, effects) as frame:
                image = averaged(frame, self.ssaa)
                transmittance = averaged(frame, self.ssaa, transmittance=True)
                blocks = frame.complexity[::-1].reshape(height, self.ssaa, width, self.ssaa)
            truth = Truth(image, self.store(EXACT, files.image_channels(image)))
            transparent = blocks.max(axis=(1, 3)) > 0
            stored = self.store(TRANSMITTANCE, files.image_channels(transmittance))
            self._exact[effects, size] = Exact(truth, transmittance, stored, transparent)
        return self._exact[effects, size]

    def traced(
        self,
        kind: str,
        chosen: Effect,
        size: tuple[int, int],
        folders: Iterable[Path],
        progress: Callable[[int, int], None],
    ) -> Truth:
        """Return a traced truth; the first call may take minutes.

        Parameters
        ----------
        kind : str
            MATCHED or FULL.
        chosen : Effect
            Effects that are not left out.
        size : (int, int)
            Width and height of the picture in pixels.
        folders : iterable of Path
            Folders of collections.
        progress : callable
            As in `render_reference`.

        Raises
        ------
        OitbenchError
            As `find_or_render` does, in every call.
        """
        from oitbench.path_traced.references.lookup import find_or_render
        from oitbench.path_traced.references.wanted import Wanted

        wanted = Wanted(self.scene, self.label, size, self.ssaa, kind, chosen, self.view)
        if wanted.key not in self._traced:
            try:
                self._traced[wanted.key] = self._truth(
                    kind, *find_or_render(wanted, folders, progress)
                )
            except OitbenchError as error:
                self._traced[wanted.key] = error
        found = self._traced[wanted.key]
        if isinstance(found, OitbenchError):
            raise found
        return found

    def _truth(self, kind: str, reference: Reference, message: str) -> Truth:
        how, image = reference.rendering, reference.mean
        facts = ReferenceFacts(how.ssaa, how.spp, how.parts, reference.random, reference.seconds)
        return Truth(
            image,
            self.store(kind, files.image_channels(image)),
            tuple(ties.means_without(reference.parts)),
            reference.noise_floor,
            facts,
            message,
        )


def averaged(frame: Frame, ssaa: int, transmittance: bool = False) -> Image:
    """Render a frame, or its transmittance alone; return the picture, averaged over sub-pixels."""
    frame.render(transmittance=transmittance)
    return files.box_downsample(frame.image(), ssaa)
