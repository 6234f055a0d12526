"""The outcome of a run, as Python and notebooks use it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from oitbench import parameters
from oitbench.api.gallery import Gallery, Tile
from oitbench.errors import OitbenchError, UsageError, unknown
from oitbench.image import files, metrics
from oitbench.image.files import Image
from oitbench.parameters import AnyParameter, natural
from oitbench.report.artifacts import decimal
from oitbench.results.records import Results
from oitbench.results.schema import TROUBLED, Record
from oitbench.results.table import PARAMETERS
from oitbench.truths import EXACT, TRUTHS

if TYPE_CHECKING:
    import pandas as pd

    from oitbench.matrix.run import Summary

_AXES = ("size", "ssaa", "effects", "shading")
"""What distinguishes cells of one scene and one method."""
_SCENE = PARAMETERS[0]


@dataclass(frozen=True)
class Outcome:
    """Cells with their numbers and pictures.

    Where a scene or a method has several cells, `size`, `ssaa`, `effects` and `shading` choose one.
    Labels are those of `scenes` and `methods`.

    Parameters
    ----------
    results : Results
        The cells that were asked for; all of the folder if it was opened.
    summary : Summary, optional
        How the run ended; None if the folder was opened.
    collections : tuple of path
        Folders of further collections.
    """

    results: Results
    summary: Summary | None = None
    collections: tuple[Path | str, ...] = ()

    @property
    def folder(self) -> Path:
        """The results folder."""
        return self.results.folder

    @property
    def records(self) -> tuple[Record, ...]:
        """All cells, as `oitbench.results.schema.Record` describes them."""
        return self.results.records

    @property
    def scenes(self) -> tuple[str, ...]:
        """Labels of scenes with their views, in order of first appearance."""
        return self.results.scenes

    @property
    def methods(self) -> tuple[str, ...]:
        """Labels of methods."""
        return self.results.methods

    @property
    def troubled(self) -> tuple[Record, ...]:
        """Cells that failed, timed out, are unstable or are suspect; `reason` says why."""
        return tuple(record for record in self.records if record.status in TROUBLED)

    @property
    def exit_code(self) -> int:
        """0 if all cells are well and all metrics have worked, else 1, as of `oitbench run`."""
        if self.summary is not None:
            return self.summary.exit_code
        outcomes = [record.outcome for record in self.records if record.outcome]
        faults = any(scores.faults for one in outcomes for scores in one.scores.values())
        return 1 if self.troubled or faults else 0

    def __repr__(self) -> str:
        return f"<Outcome of {self}>"

    def __str__(self) -> str:
        if self.summary is not None:
            return f"{self.folder}: {self.summary}"
        return f"{self.folder}: {len(self.records)} cells, {len(self.troubled)} of them troubled"

    def table(self) -> pd.DataFrame:
        """Return one row for each cell.

        `flip` is the error against `ranking_truth`, and `flip_exact`, `flip_matched` and
        `flip_full` those against all truths; other metrics likewise. Times are medians in
        milliseconds, and `method_ms_low` and `method_ms_high` are the ends of an interval that
        holds the true median with a probability of at least 95 %. `method.NAME` and `scene.NAME`
        are parameters. What a cell does not have is missing.
        """
        import pandas as pd

        frame = self.results.frame()
        for column in [name for name in frame.columns if name.startswith(_SCENE)]:
            texts: list[object] = frame[column].tolist()
            values = self._scene_values(column.removeprefix(_SCENE), texts)
            frame[column] = pd.Series(values, index=frame.index)
        return frame

    def _scene_values(self, name: str, texts: Sequence[object]) -> list[Any]:
        """Return the values of a parameter of scenes, of which labels leave out defaults."""
        known: dict[str, AnyParameter | None] = {}
        values: list[Any] = []
        for record, text in zip(self.records, texts, strict=True):
            scene = parameters.parse(record.scene).name
            if scene not in known:
                known[scene] = self._parameters(scene).get(name)
            found = known[scene]
            given = isinstance(text, str)
            if found is None:
                values.append(text if given else None)
            else:
                values.append(found.parse(scene, name, str(text)) if given else found.default)
        return values

    def _parameters(self, scene: str) -> dict[str, AnyParameter]:
        """Return the parameters of a scene; none if it is not known here."""
        from oitbench.catalog.catalog import Catalog

        try:
            with Catalog(self.collections) as catalog:
                return catalog.entry("scene", scene).parameters
        except OitbenchError:
            return {}

    def record(self, scene: str, method: str, **settings: Any) -> Record:
        """Return one cell.

        Parameters
        ----------
        scene, method : str
        **settings
            `size`, `ssaa`, `effects` or `shading`, where there are several.

        Raises
        ------
        UsageError
            There is no such cell, or there are several.
        """
        cells = self._cells(scene, settings)
        found = [record for record in cells if record.method == method]
        if not found:
            raise unknown(f"method in {scene}", method, {record.method for record in cells})
        if len(found) > 1:
            raise _ambiguous(f"{scene} {method}", found)
        return found[0]

    def image(self, scene: str, method: str, *, display: bool = False, **settings: Any) -> Image:
        """Return the picture of a cell, as it was scored.

        Parameters
        ----------
        scene, method : str
        display : bool
            At the scene's exposure, clipped and sRGB-encoded; magenta where it is not finite.
        **settings
            See `record`.

        Returns
        -------
        array, shape (h, w, 3), float32
            Linear Rec.709, top row first.

        Raises
        ------
        UsageError
            There is no such cell, it has no picture, or the picture is damaged.
        """
        record = self.record(scene, method, **settings)
        image = self.results.image(record, "color")
        if image is None:
            reason = self.results.fault(record, "color") or f"{record.status}: {record.reason}"
            raise UsageError(f"{scene} {method} has no picture; {reason}")
        return _displayed(image, record) if display else image

    def truth(
        self, scene: str, key: str = EXACT, *, display: bool = False, **settings: Any
    ) -> Image:
        """Return a truth of a scene.

        Parameters
        ----------
        scene : str
        key : str
            "exact", "matched" or "full".
        display, **settings
            See `image`.

        Returns
        -------
        array, shape (h, w, 3), float32
            Linear Rec.709, top row first.

        Raises
        ------
        UsageError
            There is no such truth, or the picture is damaged.
        """
        if key not in TRUTHS:
            raise unknown("truth", key, TRUTHS)
        cells = self._cells(scene, settings)
        having = {
            record.outcome.images[key].path: record
            for record in cells
            if record.outcome and key in record.outcome.images
        }
        if len(having) > 1:
            raise _ambiguous(f"{scene} {key}", [*having.values()])
        for record in having.values():
            image = self.results.image(record, key)
            if image is None:
                raise UsageError(self.results.fault(record, key))
            return _displayed(image, record) if display else image
        scores = [cell.outcome.scores.get(key) for cell in cells if cell.outcome]
        reasons = [*(one.reason for one in scores if one), *(cell.reason for cell in cells)]
        raise UsageError(f"{scene} has no truth '{key}': {next(filter(None, reasons), 'not made')}")

    def show(self, scene: str, truth: str = "", **settings: Any) -> Gallery:
        """Return all truths and methods of a scene side by side, with error maps.

        A notebook shows what is returned; elsewhere, `save` writes it.

        Parameters
        ----------
        scene : str
        truth : str
            The truth of the error maps. Default: the one that ranks the methods of the scene.
        **settings
            See `record`.

        Raises
        ------
        UsageError
            There is no such scene or truth, or a method has several cells.
        """
        cells = sorted(self._cells(scene, settings), key=lambda record: natural(record.method))
        methods = [record.method for record in cells]
        if len(set(methods)) < len(methods):
            double = max(methods, key=methods.count)
            same = [record for record in cells if record.method == double]
            raise _ambiguous(f"{scene} {double}", same)
        finished = [record for record in cells if record.finished]
        truth = truth or (finished[0].ranking_truth if finished else EXACT)
        if truth not in TRUTHS:
            raise unknown("truth", truth, TRUTHS)
        tiles = [*self._truth_tiles(scene, finished, settings)]
        tiles += [self._tile(record, truth) for record in cells]
        return Gallery(scene, tuple(tiles), f"{metrics.FLIP_LDR} against {TRUTHS[truth]}")

    def _truth_tiles(
        self, scene: str, finished: Sequence[Record], settings: dict[str, Any]
    ) -> Sequence[Tile]:
        keys = [
            key
            for key in TRUTHS
            if any(record.outcome and key in record.outcome.images for record in finished)
        ]
        return [
            Tile(
                TRUTHS[key], "", self.truth(scene, key, display=True, **settings), None, truth=True
            )
            for key in keys
        ]

    def _tile(self, record: Record, truth: str) -> Tile:
        image = self.results.image(record, "color")
        if image is None:
            note = self.results.fault(record, "color") or f"{record.status}: {record.reason}"
            return Tile(record.method, note, None, None)
        error = record.metric(truth, metrics.FLIP_LDR)
        parts = [] if error is None else [f"FLIP {error:.4f}"]
        parts += [f"{decimal(record.time.method_ms.median)} ms"] if record.time else []
        parts += [] if record.status == "ok" else [f"{record.status}: {record.reason}"]
        maps = self.results.flip_maps(record, truth)
        errors = None if maps is None else maps[0]
        return Tile(record.method, ", ".join(parts), _displayed(image, record), errors)

    def _cells(self, scene: str, settings: dict[str, Any]) -> list[Record]:
        for name in settings:
            if name not in _AXES:
                raise unknown("setting of cells", name, _AXES)
        if scene not in self.scenes:
            raise unknown("scene in these results", scene, self.scenes)
        found = [
            record
            for record in self.records
            if record.seen == scene
            and all(getattr(record, name) == value for name, value in settings.items())
        ]
        if not found:
            wanted = ", ".join(f"{name}={value!r}" for name, value in settings.items())
            raise UsageError(f"{scene} has no cell with {wanted}")
        return found


def _ambiguous(owner: str, cells: Sequence[Record]) -> UsageError:
    axes = {name: list(dict.fromkeys(getattr(cell, name) for cell in cells)) for name in _AXES}
    name, values = next((name, values) for name, values in axes.items() if len(values) > 1)
    return UsageError(
        f"{owner} has {len(cells)} cells; give {name}, one of {', '.join(map(repr, values))}"
    )


def _displayed(image: Image, record: Record) -> Image:
    stops = record.outcome.exposure if record.outcome else 0.0
    return np.asarray(files.mark_nonfinite(files.to_srgb(image, stops)))
