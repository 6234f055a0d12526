"""The cells of a results folder as reports read them: grouped, with images and as a table."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import numpy.typing as npt

from oitbench.errors import UsageError
from oitbench.filenames import file_name
from oitbench.image import files, stored
from oitbench.image.files import Image
from oitbench.method.ablation import REQUESTED
from oitbench.parameters import natural
from oitbench.results.custom import CustomMetric
from oitbench.results.schema import (
    COMPLEXITY,
    CellKey,
    Record,
    Renderer,
    RunFacts,
    flip_image,
)
from oitbench.results.store import CELLS, RUN, read_cells, read_run
from oitbench.results.table import PARAMETERS, plain
from oitbench.truths import EXACT

if TYPE_CHECKING:
    import pandas as pd

_Place = tuple[str, tuple[int, int], int, str, str]


@dataclass(frozen=True)
class Ablation:
    """A cell with all effects that its scene requests, and the same cell with some left out.

    Parameters
    ----------
    complete, reduced : Record
    named : tuple of str
        Names of the effects that were requested to be left out.
    implied : tuple of str
        Names of the effects that were left out because they depend on those.
    """

    complete: Record
    reduced: Record
    named: tuple[str, ...]
    implied: tuple[str, ...]


@dataclass(frozen=True)
class Panel:
    """The cells that share an axis: one view of a scene at one size with one set of effects.

    A cell that leaves effects out of one of `cells` is one of `ablations`, and in no other panel.
    """

    scene: str
    size: tuple[int, int]
    title: str
    slug: str
    cells: tuple[Record, ...]
    ablations: tuple[Ablation, ...] = ()

    @property
    def finished(self) -> tuple[Record, ...]:
        """Cells that have an image and numbers."""
        return tuple(cell for cell in self.cells if cell.finished)

    @property
    def truth(self) -> str:
        """The truth that ranks these cells, which all request the same effects."""
        return self.finished[0].ranking_truth if self.finished else EXACT


@dataclass(frozen=True)
class Results:
    """A results folder, read once.

    Parameters
    ----------
    folder : Path
    records : tuple of Record
        The newest record of every cell.
    facts : RunFacts
        The content of `run.json`.
    """

    folder: Path
    records: tuple[Record, ...]
    facts: RunFacts
    _faults: dict[str, str] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def load(cls, folder: Path | str) -> Results:
        """Read a results folder.

        Raises
        ------
        UsageError
            There is no such folder, it holds no cells, or cells of another version of the suite.
        """
        folder = Path(folder)
        found = parts(folder)
        if found != [folder]:
            raise UsageError(
                f"{folder} holds results of several renderers; give one of"
                f" {', '.join(map(str, found))}"
            )
        records = tuple(read_cells(folder / CELLS).values())
        facts = read_run(folder / RUN) or RunFacts(gl=None, seed=None)
        return cls(folder, records, facts)

    @property
    def scenes(self) -> tuple[str, ...]:
        """Labels of scenes with their views, in order of first appearance."""
        return tuple(dict.fromkeys(record.seen for record in self.records))

    @property
    def methods(self) -> tuple[str, ...]:
        """Method labels, sorted so that 8 comes before 16."""
        return tuple(sorted({record.method for record in self.records}, key=natural))

    @property
    def custom(self) -> dict[str, CustomMetric]:
        """The metrics of users' files that cells have, by name."""
        outcomes = (record.outcome for record in self.records)
        return {name: facts for o in outcomes if o for name, facts in o.custom.items()}

    @property
    def renderer(self) -> str:
        """The name of the GL renderer, or "unknown renderer"."""
        return self._gl.renderer if self._gl else "unknown renderer"

    @property
    def software(self) -> bool:
        """Whether that renderer runs on the CPU."""
        return self._gl is not None and self._gl.software

    @property
    def _gl(self) -> Renderer | None:
        """The renderer of the cells; of the last run if no cell names one."""
        return next((record.gl for record in self.records if record.gl), self.facts.gl)

    def panels(self) -> tuple[Panel, ...]:
        """Return the cells by scene, size, sub-pixels and effects, methods in stable order."""
        groups: dict[_Place, list[Record]] = {}
        reduced: dict[_Place, list[Ablation]] = {}
        known = {record.key: record for record in self.records}
        for record in self.records:
            counterpart = _counterpart(record)
            complete = None if counterpart is None else known.get(counterpart)
            if complete is None:
                groups.setdefault(_place(record), []).append(record)
            else:
                reduced.setdefault(_place(complete), []).append(_ablation(complete, record))
        scenes = self.scenes
        ordered = sorted(groups, key=lambda place: (scenes.index(place[0]), *place[1:]))
        # A title shows the settings in which the panels differ.
        several = [len({place[k] for place in ordered}) > 1 for k in (1, 2, 3, 4)]
        return tuple(
            Panel(
                place[0],
                place[1],
                title=_title(place, several),
                slug=f"{number:02d}-{file_name(place[0])}",
                cells=tuple(sorted(groups[place], key=_by_method)),
                ablations=tuple(sorted(reduced.get(place, ()), key=_by_complete)),
            )
            for number, place in enumerate(ordered, start=1)
        )

    def image(self, record: Record, kind: str) -> Image | None:
        """Return an image of a cell, a key of `Outcome.images`; None if it has no intact one."""
        path = self._file(record, kind)
        return None if path is None else files.read_exr(path)

    def flip_maps(self, record: Record, truth: str) -> tuple[Image, Image] | None:
        """Return the stored FLIP maps of a cell against a truth; None if it has no intact ones.

        Returns
        -------
        ldr, hdr : array, shape (h, w), float32
            FLIP errors of the displayed image and of HDR-FLIP, in [0, 1].
        """
        path = self._file(record, flip_image(truth))
        return None if path is None else files.read_flip_maps(path)

    def complexity(self, record: Record) -> npt.NDArray[np.uint32] | None:
        """Return the transparent fragments at each pixel, (h, w); None without an intact map."""
        path = self._file(record, COMPLEXITY)
        return None if path is None else files.read_counts(path)

    def fault(self, record: Record, kind: str) -> str:
        """Return the reason why an image of a cell cannot be read; empty if it can, or has none."""
        image = record.outcome.images.get(kind) if record.outcome else None
        if image is None:
            return ""
        if image.path not in self._faults:
            try:
                stored.verify(self.folder, image)
                self._faults[image.path] = ""
            except UsageError as error:
                self._faults[image.path] = f"{error}; run again to render it"
        return self._faults[image.path]

    @property
    def faults(self) -> tuple[str, ...]:
        """The reasons why images that were asked for could not be read, one line each."""
        return tuple(filter(None, self._faults.values()))

    def _file(self, record: Record, kind: str) -> Path | None:
        """Return the file of an image of a cell, or None if there is no intact one."""
        image = record.outcome.images.get(kind) if record.outcome else None
        return self.folder / image.path if image and not self.fault(record, kind) else None

    def frame(self) -> pd.DataFrame:
        """Return one row per cell, as `plain` names it; numbers that do not exist are missing."""
        import pandas as pd

        rows = [plain(record) for record in self.records]
        names = dict.fromkeys(name for row in rows for name in row)
        # Rows of other methods have other parameters; all of them stand together.
        place = ([*names].index("reason") + 1) if names else 0
        settings = [name for name in names if name.startswith(PARAMETERS)]
        rest = [name for name in names if name not in settings]
        return pd.DataFrame(rows, columns=[*rest[:place], *sorted(settings), *rest[place:]])


def parts(folder: Path) -> list[Path]:
    """Return the folder of each renderer in merged results, or the folder of a run itself.

    Raises
    ------
    UsageError
        It holds no results.
    """
    if (folder / CELLS).is_file():
        return [folder]
    found = sorted(path.parent for path in folder.glob(f"*/{CELLS}"))
    if not found:
        raise UsageError(f"{folder} holds no {CELLS}; give the folder of a run")
    return found


def _place(record: Record) -> _Place:
    return record.seen, record.size, record.ssaa, record.effects, record.shading


def _by_method(record: Record) -> Any:
    return natural(record.method)


def _by_complete(ablation: Ablation) -> Any:
    return natural(ablation.complete.method)


def _left_out(record: Record) -> list[str]:
    """Return the names of the effects that a cell was requested to leave out."""
    text = record.effects.upper()
    return [part.strip().removeprefix("-") for part in text.split(",") if text.startswith("-")]


def _counterpart(record: Record) -> CellKey | None:
    """Return the cell with all effects that this one leaves some out of, or None."""
    return msgspec.structs.replace(record.key, effects=REQUESTED) if _left_out(record) else None


def _ablation(complete: Record, record: Record) -> Ablation:
    named = _left_out(record)
    kept = (*record.requested_effects, *named)
    # A cell that did not finish has no list of effects.
    implied = [e for e in complete.requested_effects if e not in kept] if record.finished else []
    return Ablation(complete, record, tuple(named), tuple(implied))


def _title(place: _Place, several: Iterable[bool]) -> str:
    scene, (width, height), ssaa, effects, shading = place
    settings = (
        f"{width} × {height}",
        f"ssaa {ssaa}",
        f"effects {effects}",
        f"shading {shading or 'default'}",
    )
    shown = [text for text, differs in zip(settings, several, strict=True) if differs]
    return " · ".join([scene, *shown])
