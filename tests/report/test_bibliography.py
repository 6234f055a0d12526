"""The bibliography: what it holds, what it refuses, and that all who cite a source name it."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from oitbench.claims import ledger
from oitbench.errors import DeclarationError, UsageError
from oitbench.loading import load_module
from oitbench.places import own_folder
from oitbench.report import bibliography

REPORTS = own_folder() / "reports"
SOURCES = bibliography.read([REPORTS / bibliography.NAME])
METHODS = sorted((own_folder() / "methods").glob("*/method.py"))
ENTRY = "@misc{Me2020,\n  author = {Me, A. and You, B. and Them, C.},\n  title = {{GPU} Things},\n"
ENTRY += "  year = {2020},\n  eprint = {1},\n}"


def doc(path: Path) -> str:
    return ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")), clean=False) or ""


@pytest.mark.parametrize("path", METHODS, ids=lambda path: path.parent.name)
def test_each_method_names_known_sources_or_says_that_it_has_none(path: Path) -> None:
    keys = bibliography.keys(doc(path))
    assert keys or bibliography.sources_text(doc(path)).startswith(bibliography.OWN)
    assert set(keys) <= SOURCES.keys()


def test_each_source_of_claims_is_known() -> None:
    keys = [source.key for source in ledger.read(REPORTS / "claims")]
    assert keys
    assert set(keys) <= SOURCES.keys()


def test_each_entry_is_cited() -> None:
    metrics = load_module(REPORTS / "references.py").METRICS
    cited = {key for path in METHODS for key in bibliography.keys(doc(path))}
    cited |= {source.key for source in ledger.read(REPORTS / "claims")}
    assert SOURCES.keys() == cited | {key for key, _ in metrics}


def test_entries_have_what_their_kind_needs() -> None:
    for source in SOURCES.values():
        assert source.title, source.key
        assert source.venue, source.key
        assert source.bibtex.startswith("@"), source.key
        assert source.year or source.key == "Antimatter15"


def test_an_entry_is_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "a.bib"
    path.write_text(ENTRY)
    (source,) = bibliography.read([path]).values()
    assert source.text == "Me et al. 2020, “GPU Things”, arXiv:1"
    assert source.bibtex == ENTRY
    assert bibliography.text([source]) == ENTRY + "\n"


def test_two_authors_are_both_named(tmp_path: Path) -> None:
    path = tmp_path / "a.bib"
    path.write_text("@misc{A2000, author = {Me, A. and You, B.}, title = {T}, note = {N}}")
    assert bibliography.read([path])["A2000"].authors == "Me and You"


def test_wrong_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.bib"
    with pytest.raises(UsageError, match=r"a.bib cannot be read"):
        bibliography.read([path])
    path.write_text("@misc{A2000, title = {T\n")
    with pytest.raises(DeclarationError, match=r"a.bib:1: no entry of BibTeX"):
        bibliography.read([path])
    path.write_bytes(b"@misc{A2000, title = {\xff}}")
    with pytest.raises(DeclarationError, match=r"a.bib: 'utf-8'"):
        bibliography.read([path])


def test_a_key_has_one_entry(tmp_path: Path) -> None:
    paths = [tmp_path / "a.bib", tmp_path / "b.bib"]
    for path in paths:
        path.write_text(ENTRY)
    with pytest.raises(DeclarationError, match=r"b.bib: a second entry is named 'Me2020'"):
        bibliography.read(paths)


def test_keys_stand_in_the_paragraph_of_sources_alone() -> None:
    text = """Title.

    With [n=2], and [Other2001] here.

    Sources: Me 2020 [Me2020],
    You 2021 [You2021], Me again [Me2020].
    """
    assert bibliography.keys(text) == ["Me2020", "You2021"]
    assert bibliography.keys("Title.\n\nSource: folklore.") == []
