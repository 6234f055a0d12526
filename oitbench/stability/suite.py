"""Runs every check on every method, and judges what comes out."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from oitbench import parameters as selector
from oitbench.errors import CapabilityError, OitbenchError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import metrics
from oitbench.image.files import Image
from oitbench.method.declaration import Method
from oitbench.parameters import AnyParameter
from oitbench.plugins import Collection
from oitbench.stability.cases import cases
from oitbench.stability.check import Bound, Check, Comparison, Photo, Picture, Values
from oitbench.stability.finding import BREAKS, DOES_NOT_APPLY, HOLDS, Finding
from oitbench.stability.identities import identities
from oitbench.stability.tolerance import allowed

PRECISION_AXES = ("precision", "node", "count")
"""Parameters that choose number formats: all of their choices are run."""
_RANDOM_PIXELS = 1024
_SIGMAS = 4.0
_DISPLAY_STEP = 1 / 255


def checks() -> tuple[Check, ...]:
    """Return all identities, then all hard cases."""
    return (*identities(), *cases())


def variants(collection: Collection, names: Iterable[str]) -> list[Method]:
    """Return the variants of methods that the suite runs.

    These are all combinations of the parameters' grids, as in the larger presets, and every choice
    of a parameter of `PRECISION_AXES` with all else at its default.
    """
    texts = []
    for name in names:
        parameters = collection.methods[name].parameters
        grid = {key: item.grid for key, item in parameters.items() if item.grid}
        texts.append(_text(name, grid))
        for key in set(PRECISION_AXES) & set(parameters):
            texts.append(_text(name, {key: _choices(parameters[key])}))
    return collection.expand_methods(texts)


def run(
    device: Device,
    collection: Collection,
    methods: Sequence[Method],
    chosen: Sequence[Check] = (),
    report: Callable[[Finding], None] = lambda finding: None,
) -> list[Finding]:
    """Run checks on methods; all checks without `chosen`.

    Returns
    -------
    list of Finding
        By method in the order given, then by check.
    """
    found = []
    for check in chosen or checks():
        for finding in _run_check(device, collection, methods, check):
            found.append(finding)
            report(finding)
    order = {method.label: place for place, method in enumerate(methods)}
    return sorted(found, key=lambda finding: order[finding.method])


def _choices(parameter: AnyParameter) -> tuple[selector.Value, ...]:
    return parameter.choices or parameter.grid or (parameter.default,)


def _text(name: str, grid: dict[str, tuple[selector.Value, ...]]) -> str:
    axes = [f"{key}={','.join(map(selector.text, values))}" for key, values in grid.items()]
    return f"{name}[{','.join(axes)}]" if axes else name


def _run_check(
    device: Device, collection: Collection, methods: Sequence[Method], check: Check
) -> Iterator[Finding]:
    scenes = {id(picture.scene): picture.scene for picture in check.pictures}
    geometries = {key: UploadedScene(device, scene) for key, scene in scenes.items()}
    darkroom = _Darkroom(device, geometries)
    exact: list[Image | None] = [None] * len(check.pictures)
    if check.exact:
        exact = [taken[0].image for taken in darkroom.take(collection.truth(), check.pictures)]
    for method in methods:
        yield _examine(darkroom, method, check, exact)
    darkroom.release()


class _Darkroom:
    """Takes pictures of the scenes of one check; all methods share its geometries."""

    def __init__(self, device: Device, geometries: dict[int, UploadedScene]) -> None:
        self.device, self.geometries = device, geometries

    def take(
        self, method: Method, pictures: Sequence[Picture], times: int = 1
    ) -> Iterator[list[Photo]]:
        """Yield the photos of each picture, taken several times in a row."""
        frame: Frame | None = None
        shown: Picture | None = None
        try:
            for picture in pictures:
                copies = _copies(method, picture)
                if frame is None or shown is None or not shown.shares_frame(picture):
                    if frame is not None:
                        frame.release()
                    frame, shown = self._frame(method, picture, copies), picture
                photos = []
                for _ in range(times):
                    frame.render(picture.transmittance, picture.permutation)
                    opaque = frame.read("opaque_color")[..., :3]
                    photos.append(Photo(frame.image(), opaque, copies=copies))
                yield photos
        finally:
            if frame is not None:
                frame.release()

    def _frame(self, method: Method, picture: Picture, copies: int) -> Frame:
        width, height = picture.pixels
        effects = picture.scene.effects & method.shows
        geometry = self.geometries[id(picture.scene)]
        return Frame(geometry, method, (width * copies, height * copies), effects)

    def release(self) -> None:
        for geometry in self.geometries.values():
            geometry.release()


def _examine(
    darkroom: _Darkroom, method: Method, check: Check, exact: Sequence[Image | None]
) -> Finding:
    """Take a check's pictures with one method and judge them."""
    promised = check.identity and check.id in method.promised
    head = (method.label, method.name, check.id, check.sentence, check.identity)
    reason = check.reason_against(method)
    if reason:
        return Finding(*head, DOES_NOT_APPLY, promised, reason=reason)
    photos: list[Photo] = []
    bad: Counter[str] = Counter()
    repeatable = True
    try:
        series = darkroom.take(method, check.pictures, 2 if check.repeat else 1)
        for taken, truth in zip(series, exact, strict=True):
            first, again = taken[0], taken[-1]
            repeatable = repeatable and np.array_equal(first.image, again.image, equal_nan=True)
            bad.update(metrics.count_nonfinite(first.image))
            photos.append(replace(first, exact=truth))
    except CapabilityError as error:
        return Finding(*head, DOES_NOT_APPLY, promised, reason=str(error))
    except OitbenchError as error:
        return Finding(*head, BREAKS, promised, reason=str(error))
    verdicts = [_judge(method, comparison) for comparison in check.compare(photos)]
    worst = max(verdicts, key=lambda verdict: verdict.excess)
    return Finding(
        *head,
        HOLDS if all(verdict.holds for verdict in verdicts) else BREAKS,
        promised,
        any(verdict.in_mean for verdict in verdicts),
        _finite(worst.error),
        _finite(worst.allowed),
        nan=bad["nan"],
        inf=bad["inf"],
        negative=bad["negative"],
        signed=method.may_be_negative,
        repeatable=repeatable,
    )


def _copies(method: Method, picture: Picture) -> int:
    """Return how often each pixel of lists is repeated in a row and in a column."""
    if not method.noisy or picture.scene.lists is None:
        return 1
    width, height = picture.pixels
    return math.ceil(math.sqrt(_RANDOM_PIXELS / (width * height)))


@dataclass(frozen=True)
class _Verdict:
    error: float
    allowed: float
    in_mean: bool = False

    @property
    def holds(self) -> bool:
        # Written so that NaN breaks.
        return self.error <= self.allowed

    @property
    def excess(self) -> float:
        """How far beyond the bound, for finding the worst; NaN counts as worst of all."""
        ratio = self.error / self.allowed if self.allowed else self.error * math.inf
        return (
            ratio if self.error and not math.isnan(ratio) else (0.0 if not self.error else math.inf)
        )


def _judge(method: Method, comparison: Comparison) -> _Verdict:
    """Hold one comparison to its bound: in each pixel, or in the mean if the method is random."""
    bound = _bound(method, comparison) + comparison.slack
    residual = _residual(comparison)
    error = float(np.abs(residual).max())
    noise = _SIGMAS * comparison.noise
    if not method.noisy or error <= bound or not np.isfinite(residual).all():
        return _Verdict(error, bound + noise, noise > 0)
    flat = residual.reshape(-1, residual.shape[-1])
    if comparison.noise:
        return _Verdict(error, bound + noise, in_mean=True)
    mean, deviation = np.abs(flat.mean(axis=0)), flat.std(axis=0)
    limits = bound + _SIGMAS * deviation / math.sqrt(len(flat))
    channel = int(np.argmax(mean - limits))
    return _Verdict(float(mean[channel]), float(limits[channel]), in_mean=True)


def _bound(method: Method, comparison: Comparison) -> float:
    if comparison.bound is Bound.EQUAL:
        return 0.0
    if comparison.bound is Bound.DISPLAY:
        return _DISPLAY_STEP * comparison.magnitude
    return allowed(method, comparison.layers, comparison.magnitude)


def _residual(comparison: Comparison) -> Values:
    """Return found − expected, with `expected` repeated to the size of what was found."""
    found, expected = (np.asarray(a, np.float64) for a in (comparison.found, comparison.expected))
    for axis in (0, 1):
        expected = np.repeat(expected, found.shape[axis] // expected.shape[axis], axis=axis)
    return found - expected


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
