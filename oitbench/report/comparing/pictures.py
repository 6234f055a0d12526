"""Pictures of cells that two runs have, where they differ: before, after, and both differences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from oitbench.filenames import file_name
from oitbench.image.files import Image
from oitbench.report import pixels, plates, previews
from oitbench.report.artifacts import decimal
from oitbench.report.pixels import Codes
from oitbench.report.stacks import FOLDER
from oitbench.results.pictures import PICTURE
from oitbench.results.records import Results
from oitbench.results.schema import Record

BEFORE, AFTER = "before", "after"
MAGNIFIED = 8
"""Factor of differences, as in the viewer."""
_MIDDLE = 128
_AFTER_COLOR = "#0072B2"


@dataclass(frozen=True)
class Pair:
    """The pictures of a cell before and after, as levels of the display from 0 to 255."""

    record: Record
    before: Codes
    after: Codes

    @property
    def steps(self) -> Any:
        """The differences of the levels, signed."""
        return self.after.astype(np.int16) - self.before

    @property
    def mean(self) -> float:
        """The mean of the absolute differences, in levels."""
        return float(np.abs(self.steps).mean())


@dataclass(frozen=True)
class Changed:
    """A cell whose picture changed, for the page and for the viewer.

    Parameters
    ----------
    name, title : str
    text : str
        How far it changed.
    tiles : tuple of (str, str, str)
        Caption, address of the preview, and address of the viewer's state.
    pixels : Path
        The script with all pixels.
    facts : mapping
        What the viewer knows before it is loaded, but for its address.
    """

    name: str
    title: str
    text: str
    tiles: tuple[tuple[str, str, str], ...]
    pixels: Path
    facts: Mapping[str, Any]


def pairs(
    before: Results, after: Results, common: Sequence[tuple[Record, Record]], notes: list[str]
) -> Iterator[Pair]:
    """Yield the pictures that differ in a level of the display.

    Parameters
    ----------
    before, after : Results
    common : sequence of (Record, Record)
        Cells that both have.
    notes : list of str
        Gets a line for each pair that cannot be compared.
    """
    for old, new in common:
        if old.outcome is None or new.outcome is None:
            continue
        former, latter = (outcome.images.get(PICTURE) for outcome in (old.outcome, new.outcome))
        if former is None or latter is None or former.sha256 == latter.sha256:
            continue
        one, other = before.image(old, PICTURE), after.image(new, PICTURE)
        if one is None or other is None:
            notes.append(before.fault(old, PICTURE) or after.fault(new, PICTURE))
            continue
        pair = Pair(new, _levels(one, old), _levels(other, new))
        if (pair.before != pair.after).any():
            yield pair


def _levels(image: Image, record: Record) -> Codes:
    return pixels.display_codes(plates.display(image, plates.exposure([record])))


def show(pair: Pair, number: int, title: str, out: Path, characters: int) -> Changed:
    """Return a pair for the page, after writing its pixels."""
    name = f"{number:03d}-{file_name(pair.record.seen)}"
    script = out / FOLDER / f"{name}.js"
    pixels.write(script, name, {BEFORE: pair.before, AFTER: pair.after})
    steps = pair.steps
    signed = np.clip(_MIDDLE + MAGNIFIED * steps, 0, 255) / 255
    absolute = np.clip(MAGNIFIED * np.abs(steps), 0, 255) / 255
    shown = (
        (BEFORE, pair.before / 255, f"truth={BEFORE}"),
        (AFTER, pair.after / 255, f"method={AFTER}"),
        (f"signed × {MAGNIFIED}", signed, f"method={AFTER}&map=signed"),
        (f"absolute × {MAGNIFIED}", absolute, f"method={AFTER}&map=absolute"),
    )
    changed = float((steps != 0).any(axis=-1).mean())
    return Changed(
        name,
        title,
        f"{decimal(100 * changed)} % of the pixels changed, by {decimal(pair.mean)} levels in the "
        f"mean of the picture and {int(np.abs(steps).max())} of 255 at most.",
        tuple(
            (caption, previews.preview(picture.astype(np.float32), characters), state)
            for caption, picture, state in shown
        ),
        script,
        _facts(name, title, pair),
    )


def _facts(name: str, title: str, pair: Pair) -> dict[str, Any]:
    height, width = pair.after.shape[:2]
    layer = {"note": "", "errors": {}, "maps": {}}
    return {
        "name": name,
        "title": title,
        "against": BEFORE,
        "metric": "change of levels",
        "radiance": False,
        "exposure": plates.exposure([pair.record]),
        "size": (width, height),
        "crops": {},
        "layers": [
            {**layer, "label": BEFORE, "truth": BEFORE, "color": "", "key": BEFORE},
            {
                **layer,
                "label": AFTER,
                "truth": "",
                "color": _AFTER_COLOR,
                "key": AFTER,
                "errors": {BEFORE: pair.mean},
            },
        ],
    }
