"""Quantities of a cell or of a film that a claim is about, by the names that data files use.

`NAME:ARGUMENT` is a quantity with an argument: the truth of an error, or the pass of a cost.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from oitbench.errors import UsageError, unknown
from oitbench.image import metrics
from oitbench.image.ties import Errors
from oitbench.motion.record import Track
from oitbench.report.cells import listed_fragments
from oitbench.report.families import UNSEEN
from oitbench.results.schema import Outcome, Record, TrafficTerm
from oitbench.results.table import MEBIBYTE
from oitbench.results.times import PassTime
from oitbench.truths import EXACT, MATCHED, TRUTHS

RANKING, WHOLE = "ranking", "whole"
"""Truths that a cell chooses: see `Record.ranking_truth` and `Record.whole_truth`."""
_Source = TypeVar("_Source", Record, Track)


@dataclass(frozen=True)
class Measured:
    """A value, and what is known of its uncertainty.

    Parameters
    ----------
    value : float
    errors : Errors, optional
        Of an error against a truth that may have noise.
    rounds : sequence of float
        A time in each round of the run, in their order.
    disturbed : bool
        Whether other processes disturbed these times.
    """

    value: float
    errors: Errors | None = None
    rounds: Sequence[float] = ()
    disturbed: bool = False


@dataclass(frozen=True)
class Quantity(Generic[_Source]):
    """What is measured of a cell or of a track of a film.

    Parameters
    ----------
    words : str
        With its unit, for readers.
    measure : callable
        From a cell or track and the argument to the value; None if there is none.
    argument : str
        By default.
    least : float
        Smaller values count as this.
    """

    words: str
    measure: Callable[[_Source, str], Measured | float | None]
    argument: str = ""
    least: float = 0.0

    def of(self, source: _Source, argument: str) -> Measured | None:
        """Return the value of a cell or track."""
        found = self.measure(source, argument or self.argument)
        return Measured(float(found)) if isinstance(found, int | float) else found


def _truth(cell: Record, name: str) -> str:
    return {RANKING: cell.ranking_truth, WHOLE: cell.whole_truth}.get(name, name)


def _error(metric: str) -> Callable[[Record, str], float | None]:
    return lambda cell, truth: cell.metric(_truth(cell, truth), metric)


def _flip(cell: Record, truth: str) -> Measured | None:
    found = cell.errors(_truth(cell, truth), metrics.FLIP_LDR)
    return None if found is None else Measured(found.error, errors=found)


def _squared(cell: Record, truth: str) -> float | None:
    error = cell.metric(_truth(cell, truth), metrics.RMSE)
    return None if error is None else error**2


def _opaque_flip(cell: Record, truth: str) -> float | None:
    scores = cell.outcome.scores.get(_truth(cell, truth)) if cell.outcome else None
    return scores.opaque.get(metrics.FLIP_LDR) if scores else None


def _exact(metric: str) -> Callable[[Record, str], float | None]:
    return lambda cell, _: cell.metric(EXACT, metric)


def _milliseconds(cell: Record, name: str) -> Measured | None:
    """Return the time of a method, or of one of its passes."""
    if cell.time is None:
        return None
    ms = _of_pass(cell.time.passes, name) if name else cell.time.method_ms.samples
    disturbed = cell.time.block.disturbed
    return None if not ms else Measured(_median(ms), rounds=ms, disturbed=disturbed)


def _frame(cell: Record, _: str) -> Measured | None:
    if cell.time is None:
        return None
    ms = cell.time.frame_ms
    return Measured(ms.median, rounds=ms.samples, disturbed=cell.time.block.disturbed)


def _shading(cell: Record, stage: str) -> float | None:
    if cell.time is None:
        return None
    ms = _of_pass(cell.time.shading, stage) if stage else cell.time.shading_ms.samples
    return _median(ms) if ms else None


def _of_pass(passes: Sequence[PassTime], name: str) -> list[float]:
    """Return the samples of a pass; its name may go on with settings, as in "build terms=16"."""
    return next((item.ms.samples for item in passes if item.name.split()[0] == name), [])


def _median(samples: Sequence[float]) -> float:
    ordered, half = sorted(samples), len(samples) // 2
    return ordered[half] if len(samples) % 2 else (ordered[half - 1] + ordered[half]) / 2


def _traced(cell: Record, truth: str) -> float | None:
    """Return the time in which noise alone would have the cell's error, as it falls with √time."""
    scores = cell.outcome.scores.get(truth) if cell.outcome else None
    error, floor = cell.metric(truth, metrics.FLIP_LDR), cell.noise_floor(truth, metrics.FLIP_LDR)
    if scores is None or scores.reference is None or not error or not floor:
        return None
    return 1000 * scores.reference.seconds * (floor / error) ** 2


def _of_outcome(measure: Callable[[Outcome], float]) -> Callable[[Record, str], float | None]:
    return lambda cell, _: None if cell.outcome is None else measure(cell.outcome)


def _moved(
    terms: Callable[[Outcome], Sequence[TrafficTerm]],
) -> Callable[[Record, str], int | None]:
    def measure(cell: Record, name: str) -> int | None:
        if cell.outcome is None:
            return None
        return sum(
            term.bytes for term in terms(cell.outcome) if not name or term.pass_.split()[0] == name
        )

    return measure


def _captured(cell: Record, _: str) -> int | None:
    return None if cell.outcome is None else listed_fragments(cell.outcome)


CELLS: Mapping[str, Quantity[Record]] = {
    "flip": Quantity("FLIP", _flip, EXACT, UNSEEN),
    "rmse": Quantity("RMSE of radiance", _error(metrics.RMSE), EXACT, UNSEEN),
    "relmse": Quantity("relative MSE", _error(metrics.RELMSE), EXACT, UNSEEN**2),
    "mse": Quantity("MSE of radiance", _squared, EXACT, UNSEEN**2),
    "opaque_flip": Quantity("FLIP of opaque pixels", _opaque_flip, MATCHED, UNSEEN),
    "transmittance_error": Quantity("RMSE of transmittance", _exact(metrics.TRANSMITTANCE)),
    "order_spread": Quantity(
        "mean spread over orders", _exact(metrics.ORDER_SPREAD_MEAN), least=UNSEEN
    ),
    "ms": Quantity("method time, ms", _milliseconds),
    "frame_ms": Quantity("frame time, ms", _frame),
    "shading_ms": Quantity("time of shared shading, ms", _shading),
    "traced_ms": Quantity("time of a path tracer of equal error, ms", _traced, MATCHED),
    "bytes_per_pixel": Quantity(
        "bytes per pixel", _of_outcome(lambda outcome: outcome.memory.bits_per_pixel / 8)
    ),
    "mebibytes": Quantity("MiB", _of_outcome(lambda outcome: outcome.memory.bytes / MEBIBYTE)),
    "traffic": Quantity("bytes moved", _moved(lambda outcome: outcome.traffic.terms)),
    "shading_traffic": Quantity(
        "bytes moved by shared shading", _moved(lambda outcome: outcome.shading.traffic.terms)
    ),
    "captured": Quantity("captured fragments", _captured),
    "fragments": Quantity(
        "transparent fragments", _of_outcome(lambda outcome: outcome.statistics.fragments)
    ),
}
"""Quantities of cells by name."""
FILMS: Mapping[str, Quantity[Track]] = {
    "popping": Quantity(
        "excess jump that small steps leave",
        lambda track, _: max((pop.popping for pop in track.pops if pop.pops), default=0.0),
    ),
    "flicker": Quantity("mean excess change", lambda track, _: track.mean_flicker),
    "worst_flicker": Quantity("worst excess change", lambda track, _: track.worst_flicker),
}
"""Quantities of films by name."""


def parse(text: str) -> tuple[str, str]:
    """Return name and argument of a quantity.

    Raises
    ------
    UsageError
        There is no such quantity.
    """
    name, _, argument = text.partition(":")
    if name not in CELLS and name not in FILMS:
        raise unknown("quantity", name, [*CELLS, *FILMS])
    return name, argument


def check(texts: Iterable[str]) -> None:
    """Raise `ValueError`, as msgspec expects it, if one of the quantities does not exist."""
    try:
        for text in texts:
            parse(text)
    except UsageError as error:
        raise ValueError(str(error)) from error


def quantity(text: str) -> Quantity[Record] | Quantity[Track]:
    """Return the quantity of a text, which `parse` accepts."""
    name = parse(text)[0]
    return CELLS[name] if name in CELLS else FILMS[name]


def words(text: str) -> str:
    """Return a quantity for readers."""
    _, argument = parse(text)
    found = quantity(text)
    argument = argument or found.argument
    if not argument:
        return found.words
    against = {**TRUTHS, RANKING: "the ranking truth", WHOLE: "the truth with all effects"}
    if argument in against:
        return f"{found.words} against {against[argument]}"
    return f"{found.words}, {argument}"
