"""A scene on the device through which a camera moves, and what methods show of it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files
from oitbench.image import metrics as errors
from oitbench.image.files import Image
from oitbench.image.stored import StoredImage
from oitbench.method.declaration import Method
from oitbench.motion import metrics
from oitbench.motion.path import middle
from oitbench.motion.record import FIXED, PER_FRAME, Pop, Seeds, Track
from oitbench.scene import Camera, Scene
from oitbench.shading import ShadingSettings

HALVINGS = 6
"""Times that the step of a path is halved around a visible jump: it is then a 64th."""
SEED = "seed"
"""The parameter by which methods take the seed of their random numbers."""
Keep = Callable[[int, Image], StoredImage]
"""Stores the linear picture of a frame."""


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame of exact compositing.

    Parameters
    ----------
    linear, shown : array, shape (h, w, 3), float32
        Radiance, and the displayed picture.
    transparent : array, shape (h, w), bool
        Pixels with a transparent fragment.
    """

    linear: Image
    shown: Image
    transparent: npt.NDArray[np.bool_]


class Set:
    """A scene that stands ready to be filmed; a context manager.

    The geometry is uploaded once, unless it depends on the camera.

    Parameters
    ----------
    device : Device
    scene : Scene
    size : (int, int)
        Width and height of a picture.
    ssaa : int
        Side of the grid of sub-pixels.
    settings : ShadingSettings
        Of shared shading.
    truth : Method
        Exact compositing.
    """

    def __init__(
        self,
        device: Device,
        scene: Scene,
        size: tuple[int, int],
        ssaa: int,
        settings: ShadingSettings,
        truth: Method,
    ) -> None:
        self.scene, self.size, self._ssaa = scene, size, ssaa
        self._device, self._settings, self._truth = device, settings, truth
        self._fine = (size[0] * ssaa, size[1] * ssaa)
        self._uploaded: UploadedScene | None = None
        self._frames: dict[str, Frame] = {}

    def __enter__(self) -> Set:
        return self

    def __exit__(self, *error: object) -> None:
        self._clear()

    def _clear(self) -> None:
        with ExitStack() as stack:
            if self._uploaded is not None:
                stack.callback(self._uploaded.release)
            for label in list(self._frames):
                stack.callback(self._frames.pop(label).release)
            self._uploaded = None

    def _look(self, camera: Camera) -> UploadedScene:
        """Return the scene as seen from a camera."""
        uploaded = self._uploaded
        if uploaded is not None and uploaded.scene.camera is camera:
            return uploaded
        if uploaded is not None and uploaded.movable:
            uploaded.move(camera)
            return uploaded
        self._clear()
        self._uploaded = UploadedScene(
            self._device, replace(self.scene, camera=camera), self._settings, self._fine[1]
        )
        return self._uploaded

    def _render(self, method: Method, camera: Camera) -> tuple[Frame, Image]:
        uploaded = self._look(camera)
        frame = self._frames.get(method.label)
        if frame is None:
            effects = self.scene.effects & method.shows
            frame = Frame(uploaded, method, self._fine, effects)
            self._frames[method.label] = frame
        frame.render()
        return frame, files.box_downsample(frame.image(), self._ssaa)

    def picture(self, method: Method, camera: Camera) -> Image:
        """Return the linear picture of a method."""
        return self._render(method, camera)[1]

    def forget(self, method: Method) -> None:
        """Free what is kept for further pictures of a method."""
        frame = self._frames.pop(method.label, None)
        if frame is not None:
            frame.release()

    def exact(self, camera: Camera) -> Shot:
        """Return exact compositing from a camera."""
        frame, image = self._render(self._truth, camera)
        height, width = self.size[1], self.size[0]
        fine = frame.complexity[::-1].reshape(height, self._ssaa, width, self._ssaa)
        return Shot(image, self.shown(image), fine.max(axis=(1, 3)) > 0)

    def shown(self, image: Image) -> Image:
        """Return a picture as it is displayed; values that are not a number are black."""
        return np.nan_to_num(files.to_srgb(image, self.scene.exposure))


def exact_changes(shots: Sequence[Shot]) -> list[float]:
    """Return the mean change of exact compositing in each transition."""
    changes = []
    for before, after in itertools.pairwise(shots):
        change = after.shown - before.shown
        pixels = before.transparent | after.transparent
        changes.append(metrics.flicker(change, pixels).mean)
    return changes


def film(
    stage: Set,
    method: Method,
    cameras: Sequence[Camera],
    shots: Sequence[Shot],
    keep: Keep,
    *,
    per_frame: bool = False,
) -> Track:
    """Film one method along a path.

    Parameters
    ----------
    stage : Set
    method : Method
    cameras : sequence of Camera
    shots : sequence of Shot
        Exact compositing from these cameras.
    keep : callable
    per_frame : bool
        Whether random numbers are others in each frame; the method must have a seed.
    """
    exposure = stage.scene.exposure
    kept: list[StoredImage] = []
    flips: list[float | None] = []
    found: list[metrics.Flicker] = []
    jumps: list[metrics.Floats] = []
    before: Image | None = None
    for number, (camera, shot) in enumerate(zip(cameras, shots, strict=True)):
        used = reseeded(method, number) if per_frame else method
        image = stage.picture(used, camera)
        if per_frame:
            stage.forget(used)
        kept.append(keep(number, image))
        flips.append(errors.flip_ldr(shot.linear, image, exposure))
        error = stage.shown(image) - shot.shown
        if before is not None:
            last = shots[number - 1]
            pixels = last.transparent | shot.transparent
            found.append(metrics.flicker(error - before, pixels))
            jumps.append(metrics.jumps(error - before))
        before = error
    pops = [] if per_frame else _pops(stage, method, cameras, jumps)
    rest = _at_rest(stage, method, cameras, shots) if per_frame else None
    stage.forget(method)
    seeds: Seeds = "" if SEED not in method.parameters else PER_FRAME if per_frame else FIXED
    return Track(
        method.label,
        method.name,
        seeds,
        kept,
        flips,
        [item.mean for item in found],
        [item.worst for item in found],
        [item.largest for item in found],
        [float(jump.max()) for jump in jumps],
        pops,
        rest,
        method.family,
    )


def _at_rest(stage: Set, method: Method, cameras: Sequence[Camera], shots: Sequence[Shot]) -> float:
    """Return the mean change of transparent pixels when only the seed changes, at some cameras."""
    changes = []
    for place in sorted({0, len(cameras) // 2, len(cameras) - 1}):
        pictures = []
        for number in range(2):
            used = reseeded(method, number)
            pictures.append(stage.shown(stage.picture(used, cameras[place])))
            stage.forget(used)
        change = pictures[1] - pictures[0]
        changes.append(metrics.flicker(change, shots[place].transparent).mean)
    return metrics.mean(changes)


def reseeded(method: Method, number: int) -> Method:
    """Return the method with other random numbers for each frame."""
    seed = method.parameters[SEED]
    high = 65535 if seed.high is None else int(seed.high)
    low = 0 if seed.low is None else int(seed.low)
    value = low + (int(method.values[SEED]) - low + number) % (high - low + 1)
    return type(method)(**{**method.values, SEED: value})


def _pops(
    stage: Set, method: Method, cameras: Sequence[Camera], jumps: Sequence[metrics.Floats]
) -> list[Pop]:
    """Return what is left of the most isolated jumps when the step gets smaller."""
    return [
        _closely(stage, method, cameras[place], cameras[place + 1], place, block)
        for place, block in metrics.isolated(jumps)
    ]


def _closely(
    stage: Set, method: Method, one: Camera, other: Camera, transition: int, block: tuple[int, int]
) -> Pop:
    """Halve the step between two cameras, and follow the half in which the block jumps farther."""

    def look(camera: Camera) -> tuple[Image, Image]:
        exact = metrics.in_block(stage.exact(camera).shown, block)
        shown = metrics.in_block(stage.shown(stage.picture(method, camera)), block)
        return shown - exact, exact

    (first, first_exact), (last, last_exact) = look(one), look(other)
    for _ in range(HALVINGS):
        if metrics.jump(last - first) <= metrics.VISIBLE:
            break  # what is left is no pop
        between = middle(one, other)
        error, exact = look(between)
        if metrics.jump(error - first) >= metrics.jump(last - error):
            other, last, last_exact = between, error, exact
        else:
            one, first, first_exact = between, error, exact
    change = float(np.abs((last_exact - first_exact).mean(axis=(0, 1), dtype=np.float64)).max())
    return Pop(transition, block, metrics.jump(last - first), change)
