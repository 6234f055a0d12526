"""The pictures of a figure as the results have them, all of one size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from msgspec.structs import replace

from oitbench.catalog.needs import Need
from oitbench.crops import Crop, of_view
from oitbench.errors import DeclarationError, unknown
from oitbench.image import metrics
from oitbench.image.files import Image, box_downsample
from oitbench.papers.picture import Picture
from oitbench.parameters import parse
from oitbench.report.context import ReportContext
from oitbench.report.plates import display, note, why_no_truth
from oitbench.results.pictures import PICTURE
from oitbench.results.schema import Outcome, Record

_Grid = tuple[tuple[int, int], int]
"""Size in pixels and side of the sub-pixel grid of a cell."""


@dataclass(frozen=True)
class Album:
    """The cells that a figure needs, at the size that most of them have.

    Parameters
    ----------
    context : ReportContext
    needs : sequence of Need
    """

    context: ReportContext
    needs: Sequence[Need]

    @cached_property
    def _records(self) -> Mapping[Need, Record]:
        """The records of the figure's size by their cell."""
        wanted = {self._stored(need) for need in self.needs}
        found: dict[_Grid, dict[Need, Record]] = {}
        for record in self.context.results.records:
            cell = Need(record.scene, record.method, record.view, record.effects, record.shading)
            if cell in wanted:
                found.setdefault((record.size, record.ssaa), {})[cell] = record

        def worth(grid: _Grid) -> tuple[int, int]:
            (width, height), ssaa = grid
            return sum(record.finished for record in found[grid].values()), width * height * ssaa

        return found[max(found, key=worth)] if found else {}

    def _stored(self, need: Need) -> Need:
        """Return the cell of a need; the page of a paper may use a variant of the method."""
        method = self.context.variants.get(need.method, need.method)
        return replace(need.cell, method=method)

    def record(self, picture: Picture) -> Record | None:
        """Return the finished cell of a picture, or None."""
        record = self._records.get(self._stored(picture.need))
        return record if record is not None and record.finished else None

    def outcome(self, picture: Picture) -> Outcome | None:
        """Return all that was measured of the cell of a picture, or None."""
        record = self.record(picture)
        return record.outcome if record else None

    def image(self, picture: Picture) -> Image | None:
        """Return what a picture shows, linear, (h, w, 3); None if the results lack it."""
        record = self.record(picture)
        kind = picture.truth or PICTURE
        image = self.context.results.image(record, kind) if record and not picture.target else None
        return None if image is None else self._part(image, picture)

    def shown(self, picture: Picture) -> Image | None:
        """Return what a picture shows at the exposure of its scene, sRGB-encoded, (h, w, 3)."""
        if picture.target:
            return self._target(picture)
        image = self.image(picture)
        return None if image is None else display(image, self.stops(picture))

    def stops(self, picture: Picture) -> float:
        """Return the exposure of a picture that the results have."""
        outcome = self.outcome(picture)
        return outcome.exposure if outcome else 0.0

    def why(self, picture: Picture) -> str:
        """Return why there is no picture, in one line."""
        record = self._records.get(self._stored(picture.need))
        if record is None:
            return "not in these results"
        if not record.finished:
            return note(record)
        if picture.truth:
            return why_no_truth(self.context, [record], picture.truth)
        return self.context.results.fault(record, PICTURE) or "no picture"

    def error(self, picture: Picture, truth: str) -> float | None:
        """Return mean FLIP of the whole picture of a cell against a truth, or None."""
        record = self.record(picture)
        return None if record is None else record.metric(truth, self.context.flip)

    def distance(self, picture: Picture, other: Picture) -> float | None:
        """Return mean FLIP of what one picture shows against another, or None.

        A larger picture is reduced to the size of the other one.
        """
        image, reference = self.image(picture), self.image(other)
        if image is None or reference is None:
            return None
        image = reduced(image, reference)
        if image.shape != reference.shape:
            return None
        measure = metrics.flip_hdr if self.context.hdr else metrics.flip_ldr
        return measure(reference, image, self.stops(other))

    def tone(self, picture: Picture) -> float | None:
        """Return the mean displayed value of what a picture shows, in [0, 1], or None."""
        shown = self.shown(picture)
        return None if shown is None else float(np.nanmean(shown))

    @property
    def lacking(self) -> list[Need]:
        """The cells that the results do not have, or that did not finish."""
        cells = self._records
        return [
            need
            for need in map(self._stored, self.needs)
            if need not in cells or not cells[need].finished
        ]

    def _part(self, image: Image, picture: Picture) -> Image:
        if not picture.crop:
            return image
        left, top, width, height = self.crop(picture, picture.crop)
        tall, wide = image.shape[:2]
        rows = slice(round(top * tall), max(round((top + height) * tall), round(top * tall) + 1))
        begin = round(left * wide)
        return image[rows, begin : max(round((left + width) * wide), begin + 1)]

    def crop(self, picture: Picture, name: str) -> Crop:
        """Return a named part of a picture.

        Raises
        ------
        DeclarationError
            The scene's file states no such part.
        """
        scene = parse(picture.scene).name
        known = of_view(self.context.crops.get(scene, {}), picture.view)
        if name not in known:
            raise DeclarationError(str(unknown(f"crop of {scene}", name, list(known))))
        return known[name]

    def _target(self, picture: Picture) -> Image | None:
        """Return a target of a method, drawn at the size of its cell, one sample per pixel."""
        from oitbench.matrix.targets import draw

        record = self.record(picture)
        if record is None:
            return None
        (drawn,) = draw(
            record.scene, record.method, [picture.target], record.size, 1, record.effects,
            shading=[record.shading] if record.shading else [], view=record.view,
        )  # fmt: skip
        return self._part(np.asarray(drawn.picture.srgb), picture)


def reduced(image: Image, other: Image) -> Image:
    """Return means of blocks of an image, so that it has the size of another one, if it can."""
    factor = len(image) // max(1, len(other))
    fits = image.shape[:2] == tuple(factor * side for side in other.shape[:2])
    return box_downsample(image, factor) if fits and factor > 1 else image
