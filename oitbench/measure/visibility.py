"""Visibility curves: the fraction of the light at each depth of a pixel that a method shows.

The measurement works for any method. It renders a row of pixels that all hold the fragments of one
pixel. In the i-th pixel only the i-th fragment shines, with radiance 1/α, and the background is
black. The rendered value is therefore the method's weight of that fragment. For the over operator
it is the visibility Π(1 − o) of all nearer fragments; for any method whose image is linear in
radiance it is the method's visibility curve. Two properties of the scene are lost: methods that
sort objects sort single fragments here, and random methods use the random numbers of other pixels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oitbench.errors import CapabilityError, UsageError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.limits import check_size
from oitbench.gl.probe import probe
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure.oracle import composite, transmittances
from oitbench.method.declaration import Method
from oitbench.scene import Camera, Floats, FragmentLists, Scene

STEP_SECONDS = 600.0
"""Time in which the scene must be built, and each method must be measured, by default."""
_RANDOM_ROWS = 256


@dataclass(frozen=True, eq=False)
class Curves:
    """Visibility of the fragments at one pixel, from near to far, and of the background.

    Parameters
    ----------
    scene : str
    pixel : (int, int)
        Column from the left, row from the top.
    size : (int, int)
        Width and height of the frame in pixels.
    fragments : FragmentLists
        Of the pixel, (n, 1, 1).
    exact : array, shape (n + 1, 3), float64
        NaN where a fragment's coverage is zero. The last entry is the total transmittance.
    methods : dict of str to array, shape (n + 1, 3), float64
        By label.
    noise : dict of str to array, shape (n + 1, 3), float64
        Standard error of each value; zero for methods that are not random.
    names : dict of str to str
        From a label to the method's bare name.
    families : dict of str to str
        From a bare name to its family; see `oitbench.method.families`.
    reasons : dict of str to str
        Why a method has no curve.
    """

    scene: str
    pixel: tuple[int, int]
    size: tuple[int, int]
    fragments: FragmentLists
    exact: Floats
    methods: dict[str, Floats]
    noise: dict[str, Floats]
    names: dict[str, str]
    families: dict[str, str]
    reasons: dict[str, str]

    def spread(self, label: str) -> Floats:
        """Return the standard deviation of each value of a method at a single pixel, (n + 1, 3)."""
        return np.asarray(self.noise[label] * np.sqrt(_RANDOM_ROWS))


def instrument(fragments: FragmentLists, rows: int = 1) -> FragmentLists:
    """Return lists in which pixel i holds all `fragments` of one pixel, but only the i-th shines.

    Parameters
    ----------
    fragments : FragmentLists
        One pixel, (n, 1, 1).
    rows : int
        Rows that repeat the measurement.

    Returns
    -------
    FragmentLists
        (n, rows, n); a fragment with α = 0 does not shine.
    """
    count = len(fragments.z)
    shape = (count, rows, count)
    coverage = fragments.coverage[:, 0, 0].astype(np.float64)
    shining = np.divide(1.0, coverage, out=np.zeros(count), where=coverage > 0)
    radiance = np.broadcast_to(np.diag(shining)[:, None, :, None], (*shape, 3))
    return FragmentLists(
        np.broadcast_to(fragments.z, shape).copy(),
        np.broadcast_to(fragments.coverage, shape).copy(),
        radiance.astype(np.float32),
        np.broadcast_to(fragments.transmission, (*shape, 3)).copy(),
    )


def curve_of(image: npt.NDArray[np.float32], count: int) -> tuple[Floats, Floats]:
    """Return the mean and its standard error, each (count, 3), of a picture of the instrument.

    The image may be larger than the row of pixels by an integer factor.
    """
    height, width = image.shape[:2]
    samples = image.astype(np.float64).reshape(height, count, width // count, 3)
    values = samples.transpose(1, 0, 2, 3).reshape(count, -1, 3)
    return values.mean(axis=1), values.std(axis=1) / np.sqrt(values.shape[1])


def exact_curve(fragments: FragmentLists) -> Floats:
    """Return the visibility of each fragment of one pixel and of the background, (n + 1, 3)."""
    total = transmittances(fragments).prod(axis=0)[0]
    return np.concatenate([_with_gaps(composite(instrument(fragments), 0.0)[0], fragments), total])


def method_curve(
    device: Device, method: Method, fragments: FragmentLists, camera: Camera
) -> tuple[Floats, Floats]:
    """Return a method's visibility of each fragment and of the background, and its error.

    Parameters
    ----------
    device : Device
    method : Method
    fragments : FragmentLists
        One pixel, (n, 1, 1).
    camera : Camera
        Its clip distances give window depths.

    Returns
    -------
    (array, array), each of shape (n + 1, 3)
        Values, and standard errors.

    Raises
    ------
    CapabilityError
        If the method cannot render so many fragments here.
    """
    rows = _RANDOM_ROWS if method.noisy else 1
    straight = replace(camera, position=(0, 0, 0), target=(0, 0, -1), up=(0, 1, 0))
    scene = Scene("visibility", straight, lists=instrument(fragments, rows))
    effects = scene.effects & method.shows
    with (
        UploadedScene(device, scene) as uploaded,
        Frame(uploaded, method, (len(fragments.z), rows), effects) as frame,
    ):
        frame.render()
        values, noise = curve_of(frame.image(), len(fragments.z))
        frame.render(transmittance=True)
        total, total_noise = curve_of(frame.image(), 1)
    curve = np.concatenate([_with_gaps(values, fragments), total])
    return curve, np.concatenate([noise, total_noise])


def measure(
    device: Device,
    described: Scene,
    pixel: tuple[int, int],
    size: tuple[int, int],
    chosen: Sequence[Method],
    on_method: Callable[[str], None] = lambda label: None,
) -> Curves:
    """Measure the visibility curves of methods at one pixel of a scene.

    Parameters
    ----------
    device : Device
    described : Scene
    pixel : (int, int)
        Column from the left, row from the top.
    size : (int, int)
        Width and height of the frame in pixels.
    chosen : sequence of Method
    on_method : callable
        Called with the label of each method before it is rendered.

    Raises
    ------
    UsageError
        The pixel lies outside the frame, or nothing transparent is there.
    """
    place, frame = f"{pixel[0]},{pixel[1]}", f"{size[0]}x{size[1]}"
    if not (0 <= pixel[0] < size[0] and 0 <= pixel[1] < size[1]):
        raise UsageError(f"pixel {place} lies outside a frame of {frame}")
    check_size(device, size)
    with UploadedScene(device, described, rows=size[1]) as uploaded:
        found = probe(uploaded, size, pixel)
    if not len(found.z):
        raise UsageError(
            f"{described.name}: nothing transparent is at pixel {place} of {frame}; choose another"
        )
    order = np.argsort(found.z[:, 0, 0], kind="stable")
    places = np.append(order, len(order))
    curves: dict[str, Floats] = {}
    noise: dict[str, Floats] = {}
    reasons: dict[str, str] = {}
    for method in chosen:
        on_method(method.label)
        try:
            values, error = method_curve(device, method, found, described.camera)
        except CapabilityError as problem:
            reasons[method.label] = str(problem)
            continue
        curves[method.label], noise[method.label] = values[places], error[places]
    parts = (found.z, found.coverage, found.radiance, found.transmission)
    return Curves(
        described.name,
        pixel,
        size,
        FragmentLists(*(part[order] for part in parts)),
        exact_curve(found)[places],
        curves,
        noise,
        {method.label: method.name for method in chosen},
        {method.name: method.family for method in chosen},
        reasons,
    )


def _with_gaps(values: Floats, fragments: FragmentLists) -> Floats:
    return np.where(fragments.coverage[:, 0, 0, None] > 0, values, np.nan)
