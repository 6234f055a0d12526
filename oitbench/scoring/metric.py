"""A user's metric: a file with a name, a direction and a function.

    \"\"\"Mean absolute error of linear radiance.\"\"\"
    import numpy as np

    name = "mae_lin"
    higher_is_better = False
    tolerance = 1e-3

    def measure(reference, test, exposure):
        return np.abs(test - reference).mean()

`measure` gets two linear images, (h, w, 3) of float32 and finite, and the scene's exposure in
stops; it returns a number. `oitbench compare` ignores changes up to `tolerance`, in the unit of the
metric, plus `relative_tolerance` times the value; the defaults are 0.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from oitbench.errors import DeclarationError, locate
from oitbench.fingerprints.sources import sources_digest
from oitbench.image import metrics
from oitbench.image.files import Image
from oitbench.loading import load_module
from oitbench.results.custom import CustomMetric

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*([@(][A-Za-z0-9_@()=.,+-]*)?")
"""A dot may only be in parameters: `TRUTH.NAME` is a column of tables."""
_TAKEN = (
    *metrics.NAMES,
    metrics.TRANSMITTANCE,
    metrics.ORDER_SPREAD_MAX,
    metrics.ORDER_SPREAD_MEAN,
)


@dataclass(frozen=True)
class Metric:
    """A metric that was loaded from a file.

    Parameters
    ----------
    path : Path
    name : str
    facts : CustomMetric
    function : callable
        From the reference, the test image and the exposure to a number.
    """

    path: Path
    name: str
    facts: CustomMetric
    function: Callable[[Image, Image, float], Any]

    def value(self, reference: Image, test: Image, exposure: float) -> float | None:
        """Return the metric; None if it is not finite.

        Raises
        ------
        DeclarationError
            The file's code fails, or returns no number. The message names file and line.
        """
        try:
            found = self.function(reference, test, exposure)
        except (Exception, SystemExit) as error:
            raise DeclarationError(locate(error, self.path)) from error
        try:
            number = float(found)
        except (TypeError, ValueError):
            line = self.function.__code__.co_firstlineno
            raise DeclarationError(
                f"{self.path}:{line}: measure returns {type(found).__name__}; return a number"
            ) from None
        return number if math.isfinite(number) else None


def load_metric(path: Path) -> Metric:
    """Load the metric of a file into this process.

    Raises
    ------
    DeclarationError
        The file cannot be loaded, or lacks or misstates a part of a metric.
    """
    if not path.is_file():
        raise DeclarationError(f"{path}: there is no such file; give the file of a metric")
    digest = sources_digest({path.name: path})
    module = load_module(path)
    facts = CustomMetric(
        higher_is_better=_member(
            path, module, "higher_is_better", _is_truth_value, "True or False"
        ),
        tolerance=_tolerance(path, module, "tolerance"),
        relative_tolerance=_tolerance(path, module, "relative_tolerance"),
        digest=digest,
    )
    name = _member(path, module, "name", _is_name, 'a word such as "mae_lin" or "psnr(peak=1.5)"')
    if name in _TAKEN:
        raise DeclarationError(f"{path}: the suite has a metric '{name}'; choose another name")
    function = _member(path, module, "measure", _is_function, "a function")
    return Metric(path, name, facts, function)


def _member(
    path: Path, module: object, name: str, is_valid: Callable[[Any], bool], wanted: str
) -> Any:
    if not hasattr(module, name):
        raise DeclarationError(f"{path}: defines no '{name}'; every metric needs one")
    value = getattr(module, name)
    if not is_valid(value):
        raise DeclarationError(f"{path}: {name} is {value!r:.80}; give {wanted}")
    return value


def _tolerance(path: Path, module: object, name: str) -> float:
    if not hasattr(module, name):
        return 0.0
    return float(_member(path, module, name, _is_tolerance, "a number of at least 0"))


def _is_truth_value(value: Any) -> bool:
    return isinstance(value, bool)


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and _NAME.fullmatch(value) is not None


def _is_function(value: Any) -> bool:
    return callable(value) and hasattr(value, "__code__")


def _is_tolerance(value: Any) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and 0 <= value < math.inf
