"""Data files of claims: their form, and that those of the suite name things that exist."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from oitbench.claims import ledger
from oitbench.claims.ledger import Claim
from oitbench.claims.observations import Identity, Untestable
from oitbench.claims.trial import Trial
from oitbench.errors import DeclarationError
from oitbench.papers.listing import figures_of, read_papers
from oitbench.parameters import parse
from oitbench.places import own_folder
from oitbench.stability import suite
from oitbench.views import MAIN
from tests.helpers import collection

DATA = own_folder() / "reports" / "claims"
SOURCES = ledger.read(DATA)
CLAIMS = [claim for source in SOURCES for claim in source.claim]
ENTRY = """
[[source]]
cite = "Me 2026"

[[source.claim]]
id = "{id}"
section = "1"
said = "It is so."
trials = [{{ kind = "value", quantity = "flip", of = ["calm"], bounds = {{ most = 1 }} }}]
"""


def trials() -> Iterator[tuple[Claim, Trial]]:
    for claim in CLAIMS:
        for trial in claim.trials:
            yield claim, trial


def test_files_are_read_in_the_order_of_their_names(tmp_path: Path) -> None:
    for name in ("b", "a"):
        (tmp_path / f"{name}.toml").write_text(ENTRY.format(id=f"claim-{name}"))
    found = ledger.read(tmp_path)
    assert [source.claim[0].id for source in found] == ["claim-a", "claim-b"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"flip"', '"flop"', "unknown quantity 'flop'"),
        ("most = 1", "", "give one of least"),
        ('kind = "value"', 'kind = "guess"', "guess"),
        ("said", "stated", "stated"),
        ('"mine"', '"Mine = 1"', "claim"),
        ("[[source]]", "[[", "a.toml"),
    ],
)
def test_a_wrong_file_is_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    (tmp_path / "a.toml").write_text(ENTRY.format(id="mine").replace(old, new))
    with pytest.raises(DeclarationError, match=r"a\.toml: .+") as caught:
        ledger.read(tmp_path)
    assert message in str(caught.value)


def test_ids_are_unique(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / f"{name}.toml").write_text(ENTRY.format(id="mine"))
    with pytest.raises(DeclarationError, match=r"b\.toml: .*a\.toml also has the id 'mine'"):
        ledger.read(tmp_path)


def test_labels_of_methods_are_canonical() -> None:
    found = collection()
    for claim, trial in trials():
        for subject in trial.subjects:
            (method,) = found.expand_methods([subject.method])
            assert method.label == subject.method, claim.id


def test_labels_of_scenes_are_canonical() -> None:
    found = collection()
    for claim, trial in trials():
        for scene in trial.scenes:
            label, _, view = scene.partition("@")
            assert found.expand_scenes([label]) == [label], claim.id
            if view:
                assert view in {MAIN, *found.build_scene(label).views}, claim.id


def test_checks_exist() -> None:
    known = {check.name for check in suite.checks()}
    for claim, trial in trials():
        if isinstance(trial, Identity):
            assert set(trial.checks) <= known, claim.id


def test_figures_are_sections_of_the_report() -> None:
    # The page of all results has no figures of papers.
    known = set(collection().reports) - figures_of(read_papers([own_folder()]).values())
    assert {claim.figure for claim in CLAIMS} <= known | {""}


def test_claims_that_results_can_test_name_a_figure() -> None:
    for claim, trial in trials():
        assert claim.figure or isinstance(trial, Untestable), claim.id


def test_what_no_trial_can_use_does_not_exist() -> None:
    found = collection()
    for claim, trial in trials():
        if isinstance(trial, Untestable):
            names = {*found.methods, *(parse(scene).name for scene in found.scenes)}
            assert not names & set(trial.absent), f"{claim.id} can be tested now"
            assert len(claim.trials) == 1, claim.id


def test_the_documented_claim_is_one(tmp_path: Path) -> None:
    text = (own_folder() / "CONTRIBUTING.md").read_text(encoding="utf-8")
    block = text.partition("```toml\n[[source]]")[2].partition("```")[0]
    (tmp_path / "a.toml").write_text(f"[[source]]{block}", encoding="utf-8")
    (source,) = ledger.read(tmp_path)
    assert source.claim[0].trials[0].sentence.startswith("ratio of FLIP against exact compositing")
