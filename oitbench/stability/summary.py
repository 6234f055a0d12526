"""The results in words and counts, by method."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple

from oitbench.stability.result import BREAKS, HOLDS, CheckResult

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

Verdict = Literal["promise broken", "fault", "not promised", "hard case"]
FAILURES: tuple[Verdict, ...] = ("promise broken", "fault")
"""Verdicts that are no known limits of methods: they fail the command."""


class Row(NamedTuple):
    """A check that breaks, in words: the worst channel, or what is wrong with the picture."""

    method: str
    case: str
    expected: str
    measured: str
    allowed: str
    verdict: Verdict


def by_method(results: Iterable[CheckResult]) -> dict[str, list[CheckResult]]:
    """Return the results of each variant by its label, in order of first appearance."""
    found: dict[str, list[CheckResult]] = {}
    for result in results:
        found.setdefault(result.method, []).append(result)
    return found


def table(results: Iterable[CheckResult]) -> Table:
    """Return a table for the terminal with one row per variant.

    Each cell states how many checks hold, of those that apply.
    """
    from rich.table import Table
    from rich.text import Text

    headings = ("Method", "Promises kept", "Other identities held", "Hard cases held", "Faults")
    shown = Table(*headings, title="Stability")
    shown.columns[0].no_wrap = True
    for column in shown.columns[1:]:
        column.justify = "right"
    for method, own in by_method(results).items():
        identities = [result for result in own if result.identity]
        count = sum(result.failed for result in own)
        shown.add_row(
            Text(method),
            _held(result for result in identities if result.promised),
            _held(result for result in identities if not result.promised),
            _held(result for result in own if not result.identity),
            Text(str(count), style="bold red" if count else ""),
        )
    return shown


def _held(results: Iterable[CheckResult]) -> Text:
    from rich.text import Text

    relevant = [result for result in results if result.applies]
    if not relevant:
        return Text("–")
    held = sum(result.status == HOLDS for result in relevant)
    broken = any(result.promise_broken for result in relevant)
    return Text(f"{held} of {len(relevant)}", style="bold red" if broken else "")


def broken(results: Iterable[CheckResult]) -> list[Row]:
    """Return one row for each identity and each hard case that breaks, and each unstable picture.

    Checks without an image are left to `without_image`. Variants of a method that break the same
    are one row, that of the variant with the largest error relative to its bound. Promises and
    faults come first.
    """
    groups: dict[tuple[str, str, Verdict], list[CheckResult]] = {}
    for result in results:
        verdict = _verdict(result)
        if verdict is not None:
            groups.setdefault((result.name, result.check, verdict), []).append(result)
    rows = [_row(own, verdict) for (_, _, verdict), own in groups.items()]
    return sorted(rows, key=lambda row: row.verdict not in FAILURES)


def _verdict(result: CheckResult) -> Verdict | None:
    if result.unstable:
        return "fault"
    if result.status != BREAKS or result.reason:
        return None
    if result.promised:
        return "promise broken"
    return "not promised" if result.identity else "hard case"


def _row(own: Sequence[CheckResult], verdict: Verdict) -> Row:
    def excess(result: CheckResult) -> float:
        if result.error is None or not result.allowed:
            return math.inf
        return result.error / result.allowed

    worst = max(own, key=excess)
    more = f" +{len(own) - 1}" if len(own) > 1 else ""
    expected, found = _number(worst.expected), _number(worst.found)
    if verdict == "fault":
        expected, found = "", ", ".join(_instabilities(worst))
    elif worst.in_mean:
        found += " in the mean"
    allowed = "" if verdict == "fault" else _number(worst.allowed)
    return Row(worst.method + more, worst.check, expected, found, allowed, verdict)


def _number(value: float | None) -> str:
    return "not finite" if value is None else f"{value:.4g}"


def broken_table(rows: Sequence[Row]) -> Table:
    """Return the rows of `broken` as a table for the terminal."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    shown = Table(title="Identities and hard cases that break", box=box.SIMPLE)
    for heading in (
        "method (+ variants)",
        "case",
        "expected",
        "measured",
        "error allowed",
        "verdict",
    ):
        shown.add_column(heading, overflow="fold")
    for row in rows:
        style = "bold red" if row.verdict in FAILURES else ""
        shown.add_row(*map(Text, row), style=style)
    return shown


def idle(results: Iterable[CheckResult]) -> list[str]:
    """Return one line for each variant that did not run at all."""
    own = by_method(results)
    return [
        f"{method}: not run: {_reason(its)}"
        for method, its in own.items()
        if not any(result.applies for result in its)
    ]


def _reason(results: Sequence[CheckResult]) -> str:
    """Return why none of the checks applies: the most frequent reason, without the label."""
    reasons = [result.reason.removeprefix(f"{result.method}: ") for result in results]
    return max(reasons, key=reasons.count)


def without_image(results: Iterable[CheckResult]) -> list[str]:
    """Return one line for each variant and each reason why checks have no image."""
    own = by_method(results)
    return [f"{method}: {line}" for method, its in own.items() for line in _without_image(its)]


def faults(results: Sequence[CheckResult]) -> list[str]:
    """Return the faults of a variant in words.

    These are broken promises, checks without an image, invalid pixels, and images that change
    between two runs.
    """
    found = [
        f"breaks {result.check} ({_error(result)})"
        for result in results
        if result.promise_broken and not result.reason
    ]
    found += _without_image(results)
    for result in results:
        found += [f"{result.check}: {text}" for text in _instabilities(result)]
    return found


def _without_image(results: Iterable[CheckResult]) -> list[str]:
    """Return one line for each reason why checks of a variant have no image."""
    reasons: dict[str, list[str]] = {}
    for result in results:
        if result.applies and result.reason:
            reasons.setdefault(result.reason, []).append(result.check)
    return [
        f"no image for {names[0] if len(names) == 1 else f'{len(names)} checks'}: {reason}"
        for reason, names in reasons.items()
    ]


def _error(result: CheckResult) -> str:
    if result.error is None:
        return "the error is not finite"
    return f"error {result.error:.2g}, allowed {result.allowed:.2g}"


def _instabilities(result: CheckResult) -> Iterator[str]:
    counts = {
        "NaN": result.nonfinite.nan,
        "infinite": result.nonfinite.inf,
        "negative": 0 if result.may_be_negative else result.nonfinite.negative,
    }
    for kind, count in counts.items():
        if count:
            yield f"{count} {kind} pixel{'s' if count > 1 else ''}"
    if not result.repeatable:
        yield "the image changes between runs"
