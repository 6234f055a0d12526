"""Reading JSON that anybody may have written: deep nesting and numbers that are not finite."""

from __future__ import annotations

import json
import math
from typing import Any


def loads(text: bytes | str) -> Any:
    """Return the content of a JSON text.

    Raises
    ------
    ValueError
        It is no JSON, is nested too deeply, or holds a number that is not finite.
    """
    try:
        return json.loads(text, parse_constant=_refuse, parse_float=_finite)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _finite(text: str) -> float:
    value = float(text)
    return value if math.isfinite(value) else _refuse(text)


def _refuse(text: str) -> float:
    raise ValueError(f"{text} is not a finite number")
