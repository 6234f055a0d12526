"""Runs the checks on methods and judges the images."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from oitbench.errors import CapabilityError, OitbenchError
from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner
from oitbench.image import metrics
from oitbench.image.files import Image
from oitbench.method.declaration import Method
from oitbench.parameters import AnyParameter, grids, selector
from oitbench.plugins import Collection
from oitbench.results.schema import Nonfinite
from oitbench.stability.cases import cases
from oitbench.stability.check import Check, Rendering, Shot
from oitbench.stability.identities import identities
from oitbench.stability.judge import judge
from oitbench.stability.render import UploadedScenes
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY, HOLDS, CheckResult
from oitbench.stability.tolerance import rounding

PRECISION_AXES = ("precision", "node", "count")
"""Parameters that choose number formats."""
AXES = (*PRECISION_AXES, "msaa")
"""Parameters of which all choices are run: formats, and samples per pixel."""


def checks() -> tuple[Check, ...]:
    """Return all identities, then all hard cases."""
    return (*identities(), *cases())


def variants(name: str, parameters: Mapping[str, AnyParameter]) -> list[str]:
    """Return the selectors of all variants of a method that the suite runs.

    These are all combinations of the grids of a method's parameters, as in the larger presets of
    `oitbench run`, and every choice of each parameter in `AXES` with the defaults of all other
    parameters.

    Parameters
    ----------
    name : str
        Bare name of the method.
    parameters : mapping of str to Parameter
    """
    texts = [selector(name, grids(parameters))]
    for key in AXES:
        if key in parameters:
            item = parameters[key]
            choices = item.choices or item.grid or (item.default,)
            texts.append(selector(name, {key: choices}))
    return texts


def run(
    methods: Sequence[str],
    examine: Callable[[Check, str], CheckResult],
    chosen: Sequence[Check] = (),
    report: Callable[[CheckResult], None] = lambda result: None,
) -> list[CheckResult]:
    """Run checks on methods.

    Parameters
    ----------
    methods : sequence of str
        Labels.
    examine : callable
        Runs one check on the method of a label.
    chosen : sequence of Check
        Default: all checks.
    report : callable
        Receives each result as soon as it exists.

    Returns
    -------
    list of CheckResult
        By method in the given order, then by check.
    """
    results = []
    # All methods share the scenes of a check.
    for check in chosen or checks():
        for method in methods:
            results.append(examine(check, method))
            report(results[-1])
    order = {label: place for place, label in enumerate(methods)}
    return sorted(results, key=lambda result: order[result.method])


class Examiner(Owner):
    """Runs single checks; the scenes of the last check stay on the device.

    Parameters
    ----------
    device : Device
    collection : Collection
        Provides the exact method.
    """

    def __init__(self, device: Device, collection: Collection) -> None:
        super().__init__()
        self._device, self._collection = device, collection
        self._check: Check | None = None
        self._scenes: UploadedScenes
        self._exact: Sequence[Image | None] = ()

    def examine(self, check: Check, method: Method) -> CheckResult:
        """Render the shots of a check with one method and judge the images."""
        if check is not self._check:
            self._prepare(check)
        return _examine(self._scenes, method, check, self._exact)

    def _prepare(self, check: Check) -> None:
        """Upload the scenes of a check, and render the exact images if it needs them."""
        self._check = None
        self.release()
        with self.building():
            self._scenes = self.own(UploadedScenes(self._device, check.shots))
            self._exact = [None] * len(check.shots)
            if check.exact:
                truth = self._scenes.render(self._collection.truth(), check.shots)
                self._exact = [one.image for (one,) in truth]
        self._check = check


def _examine(
    scenes: UploadedScenes, method: Method, check: Check, exact: Sequence[Image | None]
) -> CheckResult:
    """Render the shots of a check with one method and judge the images."""
    result = partial(
        CheckResult,
        method.label,
        method.name,
        check.name,
        check.sentence,
        check.identity,
        check.identity and check.name in method.promised,
    )
    reason = check.reason_to_skip(method)
    if reason:
        return result(DOES_NOT_APPLY, reason=reason)
    try:
        renderings = scenes.render(method, check.shots, times=2 if check.repeat else 1)
    except CapabilityError as error:
        return result(DOES_NOT_APPLY, reason=str(error))
    except OitbenchError as error:
        return result(BREAKS, reason=str(error))
    first = [replace(one, exact=right) for (one, *_), right in zip(renderings, exact, strict=True)]
    deviations = [judge(method, expectation) for expectation in check.expect(first)]
    worst = max(deviations, key=lambda deviation: deviation.excess)
    return result(
        HOLDS if all(deviation.holds for deviation in deviations) else BREAKS,
        error=_finite(worst.error),
        allowed=_finite(worst.allowed),
        expected=_finite(worst.expected),
        found=_finite(worst.found),
        in_mean=any(deviation.in_mean for deviation in deviations),
        nonfinite=_nonfinite(first),
        may_be_negative=method.may_be_negative,
        repeatable=all(
            _repeats(taken, _freedom(scenes.device, method, shot, taken[0]))
            for shot, taken in zip(check.shots, renderings, strict=True)
        ),
    )


def _nonfinite(renderings: Sequence[Rendering]) -> Nonfinite:
    """Return the number of invalid pixels of all images."""
    counts = [metrics.count_nonfinite(rendering.image) for rendering in renderings]
    return Nonfinite(**{key: sum(count[key] for count in counts) for key in counts[0]})


def _repeats(taken: Sequence[Rendering], allowed: float) -> bool:
    """Return whether all images of one shot are equal, with differences up to `allowed`."""
    first, *others = (rendering.image for rendering in taken)
    return allowed == math.inf or all(
        np.allclose(first, other, rtol=0, atol=allowed, equal_nan=True) for other in others
    )


def _freedom(device: Device, method: Method, shot: Shot, rendering: Rendering) -> float:
    """Return how far two images of one shot may differ.

    Software renderers keep the order of the draws. Where a GPU takes the fragments of a pixel in
    any order, an image differs by rounding if the method promises independence of the order, and
    else by any amount.
    """
    if device.software:
        return 0.0
    if rendering.in_order_of_arrival and "order_independent" not in method.promised:
        return math.inf
    lists, objects = shot.scene.lists, shot.scene.transparent
    layers = 2 * len(objects) if lists is None else len(lists.z)
    finite = rendering.image[np.isfinite(rendering.image)]
    return rounding(method, layers, max(1.0, float(np.abs(finite).max(initial=0.0))))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
