"""Made-up evidence, in which a test changes one number."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from oitbench.claims.evidence import Evidence
from oitbench.claims.ledger import AnyTrial, Claim
from oitbench.claims.trial import Tried
from oitbench.image import metrics
from oitbench.results.records import Results
from oitbench.results.schema import Record, Renderer, RunFacts, Scores
from oitbench.truths import EXACT
from tests.made_up import changed, record, timed

SOFTWARE = RunFacts(gl=Renderer("llvmpipe (test)", software=True), seed=1)


def trial(**fields: Any) -> AnyTrial:
    """Return a trial as a data file gives it."""
    made: AnyTrial = msgspec.convert(fields, AnyTrial)
    return made


def claim(*trials: dict[str, Any], **fields: Any) -> Claim:
    """Return a claim with these trials."""
    given = {"id": "mine", "section": "1", "said": "It is so.", "trials": list(trials), **fields}
    return msgspec.convert(given, Claim)


def cell(
    method: str, scene: str = "fog", flip: float = 0.1, ms: float = 2.0, **replaced: Any
) -> Record:
    """Return a finished cell; keys of `replaced` are paths as of `changed`, with `__` for dots."""
    scores = {EXACT: Scores({metrics.FLIP_LDR: flip, metrics.RMSE: flip, metrics.RELMSE: flip})}
    made: Record = record(method, scene, time=timed(ms), gl=SOFTWARE.gl)
    values = {"outcome.scores": scores, **replaced}
    for path, value in values.items():
        made = changed(made, path.replace("__", "."), value)
    finished: Record = made
    return finished


def evidence(*cells: Record, **fields: Any) -> Evidence:
    """Return evidence of cells, and of `checks` or `films`."""
    return Evidence(Results(Path("results"), cells, SOFTWARE), **fields)


def held(tried: Tried) -> Sequence[bool]:
    """Return whether each case holds."""
    return [case.holds for case in tried.cases]
