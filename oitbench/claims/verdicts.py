"""Verdicts on claims; they follow from the cases of their trials and from nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from oitbench.claims.evidence import Evidence
from oitbench.claims.ledger import Claim
from oitbench.claims.observations import Untestable
from oitbench.claims.trial import Case

REPRODUCED: Final = "reproduced"
REFUTED: Final = "refuted"
CONDITIONAL: Final = "conditional"
NOT_TESTABLE: Final = "not testable here"
NO_EVIDENCE: Final = "no evidence in these results"
WORDS = (REPRODUCED, CONDITIONAL, REFUTED, NOT_TESTABLE, NO_EVIDENCE)
_SHOWN = 4


@dataclass(frozen=True)
class Verdict:
    """What results say about a claim.

    Parameters
    ----------
    claim : Claim
    word : str
        One of `WORDS`.
    reason : str
        The condition, or why there is no verdict.
    cases : sequence of Case
    lacking : sequence of str
        Cases that the results do not hold.
    commands : sequence of str
        That repeat the trials.
    """

    claim: Claim
    word: str
    reason: str
    cases: Sequence[Case]
    lacking: Sequence[str]
    commands: Sequence[str]

    @property
    def numbers(self) -> str:
        """The numbers of some cases in words, those first that decide the verdict."""
        decisive = self.word == REPRODUCED
        shown = sorted(self.cases, key=lambda case: case.holds != decisive)[:_SHOWN]
        # Half of them hold, if only some do.
        if self.word == CONDITIONAL:
            by_kind = [[c for c in self.cases if c.holds is kind] for kind in (True, False)]
            shown = [case for kind in by_kind for case in kind[: _SHOWN // 2]]
        parts = [f"{case.place}, {case.subject}: {case.text}" for case in shown]
        rest = len(self.cases) - len(shown)
        return "; ".join([*parts, *([f"and {rest} more"] if rest else [])])

    @property
    def counts(self) -> str:
        """How many cases hold, and how many are lacking."""
        held = f"{sum(case.holds for case in self.cases)} of {len(self.cases)}"
        known = [held] if self.cases else []
        lost = [f"{len(self.lacking)} lacking"] if self.lacking else []
        return ", ".join(known + lost)


def judge(claim: Claim, evidence: Evidence) -> Verdict:
    """Return what results say about a claim.

    It is reproduced if all cases hold, and refuted if none does. If some do, it is conditional, or
    reproduced if one case anywhere is enough: then, the lack of any case leaves it open. Each trial
    needs at least one case.
    """
    untestable = [trial.reason for trial in claim.trials if isinstance(trial, Untestable)]
    commands = _commands(claim, evidence)
    if untestable:
        return Verdict(claim, NOT_TESTABLE, "; ".join(untestable), (), (), commands)
    if claim.gpu and evidence.results.software:
        reason = f"needs a GPU; these results are of {evidence.results.renderer}"
        return Verdict(claim, NOT_TESTABLE, reason, (), (), commands)
    tried = [trial.tried(evidence) for trial in claim.trials]
    cases = [case for one in tried for case in one.cases]
    lacking = [text for one in tried for text in one.lacking]
    nowhere = claim.anywhere and lacking and not any(case.holds for case in cases)
    if nowhere or not all(one.cases for one in tried):
        return Verdict(claim, NO_EVIDENCE, "", cases, lacking, commands)
    word, reason = _decide(claim, cases)
    return Verdict(claim, word, reason, cases, lacking, commands)


def _decide(claim: Claim, cases: Sequence[Case]) -> tuple[str, str]:
    held = [case for case in cases if case.holds]
    if not held:
        return REFUTED, ""
    if len(held) == len(cases) or claim.anywhere:
        return REPRODUCED, ""
    return CONDITIONAL, _condition(cases)


def _condition(cases: Sequence[Case]) -> str:
    """Return where a claim holds and where not, by scene if that decides it."""
    # The first description that separates what holds from what does not.
    for describe in (_place, _subject, _quantity, _both, _all):
        held = list(dict.fromkeys(describe(case) for case in cases if case.holds))
        lost = list(dict.fromkeys(describe(case) for case in cases if not case.holds))
        if not set(held) & set(lost):
            break
    return f"holds: {_listed(held)}; does not: {_listed(lost)}"


def _place(case: Case) -> str:
    return case.place


def _subject(case: Case) -> str:
    return case.subject


def _quantity(case: Case) -> str:
    return case.quantity


def _both(case: Case) -> str:
    return f"{case.place}, {case.subject}"


def _all(case: Case) -> str:
    return f"{case.place}, {case.subject}, {case.quantity}"


def _listed(texts: Sequence[str]) -> str:
    rest = len(texts) - 2 * _SHOWN
    shown = [*texts[: 2 * _SHOWN], *([f"{rest} more"] if rest > 0 else [])]
    return " · ".join(shown)


def _commands(claim: Claim, evidence: Evidence) -> list[str]:
    sizes = {record.size for record in evidence.results.records}
    size = "{}x{}".format(*sizes.pop()) if len(sizes) == 1 else ""
    folder = evidence.results.folder
    lines = [line for trial in claim.trials for line in trial.commands(folder, size)]
    return list(dict.fromkeys(lines))
