"""How to cite and to repeat a figure."""

from __future__ import annotations

from pathlib import Path

import msgspec

from oitbench.places import own_folder
from oitbench.report.citing import citation, fingerprint
from oitbench.results.records import Results
from tests.made_up import FACTS, changed, record

RECORDS = (record("mean"), record("peel[layers=8]"))


def results(*records: object, argv: tuple[str, ...] = ()) -> Results:
    facts = msgspec.structs.replace(FACTS, argv=list(argv), packages={"oitbench": "9.8"})
    return Results(Path("r"), tuple(records), facts)  # type: ignore[arg-type]


def test_a_figure_is_repeated_by_the_command_of_the_run() -> None:
    found = citation(results(*RECORDS, argv=("/home/me/oitbench", "run", "--method", "a[x=1,2]")))
    assert found.repeat("pareto") == (
        "oitbench run --method 'a[x=1,2]'",
        "oitbench report RESULTS --section pareto",
    )
    assert citation(results()).repeat("") == ("oitbench report RESULTS",)


def test_the_entry_is_that_of_the_citation_file() -> None:
    entry = citation(results(*RECORDS)).entry("Errors & times_1 {")
    text = (own_folder() / "CITATION.cff").read_text(encoding="utf-8")
    title = "oitbench: a benchmark of order-independent transparency"
    assert f'title: "{title}"' in text
    assert f"  title = {{{title}}},\n" in entry
    assert "  author = {{oitbench contributors}},\n" in entry
    assert "  version = {9.8},\n" in entry
    assert f"Errors \\& times\\_1 \\{{; results {fingerprint(results(*RECORDS))}" in entry


def test_the_fingerprint_is_that_of_the_cells_in_any_order() -> None:
    first = fingerprint(results(*RECORDS))
    assert len(first) == 16
    assert fingerprint(results(*RECORDS[::-1])) == first
    other = changed(RECORDS[0], "outcome.memory.bytes", 961)
    assert fingerprint(results(other, RECORDS[1])) != first
    assert fingerprint(results(RECORDS[0])) != first
