"""What a results folder holds that can confirm or refute a claim."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from msgspec import Struct

from oitbench.claims import quantities
from oitbench.claims.quantities import Measured
from oitbench.errors import UsageError
from oitbench.method.ablation import REQUESTED
from oitbench.motion import record as films
from oitbench.motion.record import PER_FRAME, MotionFile
from oitbench.results.records import Results
from oitbench.results.schema import Record
from oitbench.stability import files as stability
from oitbench.stability.result import CheckResult

Place = tuple[str, tuple[int, int], int]
"""A scene with its view, its size and its sub-pixels."""


class Subject(Struct, frozen=True, forbid_unknown_fields=True):
    """A method under settings of a run.

    Parameters
    ----------
    method : str
        Canonical label.
    effects, shading : str
        As in `CellKey`.
    """

    method: str
    effects: str = REQUESTED
    shading: str = ""

    @property
    def label(self) -> str:
        """The method, and the settings that are no defaults."""
        effects = "" if self.effects == REQUESTED else self.effects
        return ", ".join(filter(None, (self.method, effects, self.shading)))


@dataclass(frozen=True)
class Evidence:
    """Stored results of all verbs that claims are tested by.

    Parameters
    ----------
    results : Results
    checks : sequence of CheckResult
        Of `oitbench stability`.
    films : sequence of MotionFile
        Of `oitbench motion`.
    faults : sequence of str
        Why files could not be read, one line each.
    """

    results: Results
    checks: Sequence[CheckResult] = ()
    films: Sequence[MotionFile] = ()
    faults: Sequence[str] = ()

    @classmethod
    def load(cls, results: Results) -> Evidence:
        """Read what lies in a results folder beside its cells."""
        checks: list[CheckResult] = []
        found: list[MotionFile] = []
        faults: list[str] = []
        path = stability.find(results.folder)
        try:
            checks = [] if path is None else stability.read(path)
        except UsageError as error:
            faults.append(str(error))
        for folder in films.find(results.folder):
            try:
                found.append(films.read(folder / films.JSON))
            except UsageError as error:
                faults.append(str(error))
        return cls(results, checks, found, faults)

    def cells(self, subject: Subject, scenes: Sequence[str] = ()) -> dict[Place, Record]:
        """Return the finished cells of a subject; in all scenes if none are given."""
        cells = self._cells.get(subject, [])
        return {_place(cell): cell for cell in cells if not scenes or cell.seen in scenes}

    def measured(
        self, quantity: str, subject: Subject, scenes: Sequence[str] = ()
    ) -> dict[Place, Measured]:
        """Return a quantity of a subject where it is known; in all scenes if none are given."""
        name, argument = quantities.parse(quantity)
        found: dict[Place, Measured | None] = {}
        if name in quantities.CELLS:
            for place, cell in self.cells(subject, scenes).items():
                found[place] = quantities.CELLS[name].of(cell, argument)
        else:
            for film in self.films:
                for track in film.tracks:
                    known = track.method == subject.method and track.seeds != PER_FRAME
                    if known and (not scenes or film.title in scenes):
                        place = film.title, film.size, film.ssaa
                        found[place] = quantities.FILMS[name].of(track, argument)
        return {place: value for place, value in found.items() if value is not None}

    def title(self, place: Place) -> str:
        """Return a place for readers, with the settings in which places differ."""
        scene, (width, height), ssaa = place
        kinds = {(record.size, record.ssaa) for record in self.results.records}
        return scene if len(kinds) < 2 else f"{scene} ({width} × {height}, ssaa {ssaa})"

    @cached_property
    def _cells(self) -> dict[Subject, list[Record]]:
        found: dict[Subject, list[Record]] = {}
        for record in self.results.records:
            if record.finished:
                subject = Subject(record.method, record.effects, record.shading)
                found.setdefault(subject, []).append(record)
        return found


def _place(record: Record) -> Place:
    return record.seen, record.size, record.ssaa
