"""The committed means in `tests/pictures.json`, and the tolerances of their comparison."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from oitbench.errors import UsageError
from tests.pictures.render import Means, Pictures
from tests.pictures.scenes import BLOCK, SIZE

FILE = Path(__file__).parents[1] / "pictures.json"
FORMAT = 1
SKIPPED = "skipped"
"""In place of means: the driver lacks a capability."""
_COUNT = 2 * 3 * (SIZE[0] // BLOCK) * (SIZE[1] // BLOCK)
_DIGITS = 7


@dataclass(frozen=True)
class Tolerance:
    """A mean may differ by `relative` of the larger one plus `absolute`."""

    relative: float
    absolute: float

    def excess(self, before: float, now: float) -> float:
        """Return the difference in units of what is allowed."""
        allowed = self.relative * max(abs(before), abs(now)) + self.absolute
        return abs(now - before) / allowed


SAME_RENDERER = Tolerance(1e-5, 1e-7)
"""For equal names of the renderer. llvmpipe repeats itself bit for bit, and with vectors of 128 and
of 256 bits its means agree to 5e-7, so this leaves room for the compiler alone."""
OTHER_RENDERER = Tolerance(0.1, 1e-2)
"""For another renderer: faults that everybody sees. Random changes of all positions and normals in
their last digit move means by up to 1e-4, but by 4e-3 where shadows are stochastic, and by 8e-2
where a method decides at random for each place in the scene."""


def write(found: Pictures, path: Path = FILE) -> None:
    """Write the means of all cells, one cell per line.

    Raises
    ------
    UsageError
        There is no cell, or a mean is not finite.
    """
    cells = [f"  {json.dumps(name)}: {_line(name, found.means[name])}" for name in found.means]
    if not any(found.means.values()):
        raise UsageError(f"{path}: there is no picture to write")
    head = f'{{\n "format": {FORMAT},\n "renderer": {json.dumps(found.renderer)},\n "cells": {{\n'
    path.write_text(head + ",\n".join(cells) + "\n }\n}\n", encoding="utf-8")


def _line(name: str, means: Means) -> str:
    if means is None:
        return json.dumps(SKIPPED)
    if not all(map(math.isfinite, means)):
        raise UsageError(f"{name}: its picture is not finite")
    return f"[{', '.join(f'{mean:.{_DIGITS}g}' for mean in means)}]"


def read(path: Path = FILE) -> Pictures:
    """Read committed means.

    Raises
    ------
    UsageError
        The file is damaged, has no picture, or holds anything but finite means.
    """
    try:
        content: Any = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise UsageError(f"{path} cannot be read ({error}); run python -m tests.guard") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise UsageError(f"{path} is not of format {FORMAT}; run python -m tests.guard")
    renderer, cells = content.get("renderer"), content.get("cells")
    if not isinstance(renderer, str) or not isinstance(cells, dict):
        raise UsageError(f"{path} lacks its renderer or its cells; run python -m tests.guard")
    means: dict[str, Means] = {}
    for name, values in cells.items():
        if values != SKIPPED and not _is_means(values):
            raise UsageError(f"{path}: {name} is damaged; run python -m tests.guard")
        means[name] = None if values == SKIPPED else tuple(values)
    if not any(means.values()):
        raise UsageError(f"{path} has no picture; run python -m tests.guard")
    return Pictures(renderer, means)


def _is_means(values: Any) -> bool:
    return (
        isinstance(values, list)
        and len(values) == _COUNT
        and all(type(value) in (int, float) and math.isfinite(value) for value in values)
    )


def differences(now: Pictures, before: Pictures) -> dict[str, str]:
    """Return one line for each cell that differs by more than its tolerance, by name."""
    same = now.renderer == before.renderer
    tolerance = SAME_RENDERER if same else OTHER_RENDERER
    found = {}
    for name in [*now.means, *(now_gone for now_gone in before.means if now_gone not in now.means)]:
        line = _difference(name, now.means, before.means, tolerance, same)
        if line:
            found[name] = line
    return found


def _difference(
    name: str,
    now: Mapping[str, Means],
    before: Mapping[str, Means],
    tolerance: Tolerance,
    same: bool,
) -> str:
    if name not in now:
        return "is no cell any more"
    if name not in before:
        return "is not committed; run python -m tests.guard"
    new, old = now[name], before[name]
    if new is None or old is None:
        return f"{_word(old)} before, {_word(new)} now" if same and new != old else ""
    excess = [tolerance.excess(a, b) for a, b in zip(old, new, strict=True)]
    worst = max(range(len(excess)), key=excess.__getitem__)
    beyond = sum(item > 1 for item in excess)
    if not beyond:
        return ""
    return (
        f"{beyond} of {len(excess)} means differ, the most by {excess[worst]:.3g} tolerances"
        f" ({old[worst]:.6g} -> {new[worst]:.6g})"
    )


def _word(means: Means) -> str:
    return SKIPPED if means is None else "drawn"
