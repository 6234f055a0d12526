"""What a trial is: cases, each of which holds or not, and the commands that produce them."""

from __future__ import annotations

import shlex
from abc import abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from msgspec import Struct

from oitbench.claims import quantities
from oitbench.claims.evidence import Evidence, Subject
from oitbench.method.ablation import REQUESTED
from oitbench.report.artifacts import decimal
from oitbench.truths import EXACT, TRUTHS

Subjects = list[str | Subject]
"""Methods by label, or with settings."""


@dataclass(frozen=True)
class Case:
    """One comparison.

    Parameters
    ----------
    place : str
        Scene, or check of `oitbench stability`.
    subject : str
        What is compared there.
    value : float
        The number that decides.
    text : str
        This number and those that it follows from, in words.
    holds : bool
    quantity : str
        What is compared, in words, if trials of one kind compare several.
    """

    place: str
    subject: str
    value: float
    text: str
    holds: bool
    quantity: str = ""


@dataclass(frozen=True)
class Tried:
    """The cases of a trial that results hold, and those that they lack, in words."""

    cases: list[Case] = field(default_factory=list)
    lacking: list[str] = field(default_factory=list)


class Bounds(Struct, frozen=True, forbid_unknown_fields=True):
    """An interval of numbers: `least` and `most` belong to it, `above` and `below` do not.

    `equal` is a single number. `tolerance` is the part of a bound by which a number may miss it.
    """

    least: float | None = None
    most: float | None = None
    above: float | None = None
    below: float | None = None
    equal: float | None = None
    tolerance: float = 0.0

    def __post_init__(self) -> None:
        if all(bound is None for bound in self._bounds):
            raise ValueError("give one of least, most, above, below, equal")

    @property
    def _bounds(self) -> tuple[float | None, ...]:
        return self.least, self.most, self.above, self.below, self.equal

    def admit(self, value: float) -> bool:
        """Return whether a number lies in the interval."""
        least = self.least if self.equal is None else self.equal
        most = self.most if self.equal is None else self.equal
        return (
            (least is None or value >= least - abs(least) * self.tolerance)
            and (most is None or value <= most + abs(most) * self.tolerance)
            and (self.above is None or value > self.above)
            and (self.below is None or value < self.below)
        )

    @property
    def words(self) -> str:
        """The interval for readers."""
        names = ("at least", "at most", "above", "below", "equal to")
        known = [
            f"{name} {bound:g}"
            for name, bound in zip(names, self._bounds, strict=True)
            if bound is not None
        ]
        within = f" (tolerance {self.tolerance:.0%})" if self.tolerance else ""
        return " and ".join(known) + within


class Trial(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"):
    """A test of a claim on stored results.

    Parameters
    ----------
    scenes : list of str
        Labels with their views. None: all scenes of the results.
    """

    scenes: list[str] = []

    @property
    @abstractmethod
    def sentence(self) -> str:
        """How the claim is tested, for readers."""

    @property
    @abstractmethod
    def subjects(self) -> list[Subject]:
        """All methods that are needed, with their settings."""

    @abstractmethod
    def tried(self, evidence: Evidence) -> Tried:
        """Return the cases that results hold."""

    @property
    def quantity_names(self) -> Sequence[str]:
        """The quantities of cells or of films that are compared."""
        return ()

    def commands(self, folder: Path, size: str) -> list[str]:
        """Return the commands that produce the evidence, in a results folder.

        Parameters
        ----------
        folder : Path
        size : str
            Of pictures, as in "64x64"; empty for the preset's.
        """
        if any(quantities.parse(name)[0] in quantities.FILMS for name in self.quantity_names):
            methods = option("--method", (subject.method for subject in self.subjects))
            return [
                line("oitbench motion", [scene, *methods, *_sized(size)], folder / "motion" / scene)
                for scene in self.scenes or ["SCENE"]
            ]
        groups: dict[tuple[str, str], list[str]] = {}
        for item in self.subjects:
            groups.setdefault((item.effects, item.shading), []).append(item.method)
        return [
            line("oitbench run", self._options(effects, shading, methods, size), folder)
            for (effects, shading), methods in groups.items()
        ]

    def _options(self, effects: str, shading: str, methods: Iterable[str], size: str) -> list[str]:
        options = [*option("--scene", self.scenes), *option("--method", methods), *_sized(size)]
        if effects != REQUESTED:
            options.append(f"--effects={effects}")
        if shading:
            options += ["--shading", shading]
        arguments = {self._truth(name) for name in self.quantity_names}
        return options if arguments - {EXACT, ""} else [*options, "--truth", EXACT]

    @staticmethod
    def _truth(quantity: str) -> str:
        """Return the argument of a quantity if it is a truth, or its default."""
        name, argument = quantities.parse(quantity)
        argument = argument or quantities.quantity(name).argument
        named = (*TRUTHS, quantities.RANKING, quantities.WHOLE)
        return argument if argument in named else ""


def option(name: str, values: Iterable[str]) -> list[str]:
    """Return a repeatable option of a command with each of the values once."""
    return [part for value in dict.fromkeys(values) for part in (name, value)]


def _sized(size: str) -> list[str]:
    return ["--size", size] if size else []


def line(command: str, options: Sequence[str], folder: Path) -> str:
    """Return a command that writes into a folder, quoted for a shell."""
    return f"{command} {shlex.join([*options, '--out', str(folder)])}"


def expand(items: Iterable[str | Subject]) -> list[Subject]:
    """Return subjects; a label alone has the default settings."""
    return [Subject(item) if isinstance(item, str) else item for item in items]


def places_text(scenes: Sequence[str]) -> str:
    """Return the scenes of a trial for readers."""
    return f"on {', '.join(scenes)}" if scenes else "on every scene of the results"


def names(subjects: Iterable[Subject]) -> str:
    """Return subjects for readers."""
    return ", ".join(subject.label for subject in subjects)


def number(value: float) -> str:
    """Return a number for readers."""
    return decimal(value) if abs(value) < 1e6 else f"{value:.3g}"
