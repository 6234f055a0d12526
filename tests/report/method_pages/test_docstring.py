"""Docstrings of methods: title, paragraphs, formulas, failures and sources."""

from __future__ import annotations

import ast

import pytest

from oitbench.places import own_folder
from oitbench.report.method_pages import docstring
from oitbench.report.method_pages.docstring import Block
from oitbench.report.method_pages.formula import Span

DOC = """Mixes: all at once.

    C = sum L
      + C0

With `n` of
[Me2020].

Source: Me 2020 [Me2020].

Known failures: a front layer is lost. `half` stalls, and so on. Noise.
"""


def text(block: Block) -> list[str]:
    return ["".join(span.text for span in line) for line in block.lines]


def test_a_docstring_has_parts_in_their_order() -> None:
    assert docstring.title(DOC) == "Mixes: all at once."
    formula, paragraph, sources, failures = docstring.blocks(DOC)
    assert [b.kind for b in (formula, paragraph, sources)] == ["formula", "paragraph", "sources"]
    assert text(formula)[0] == "C = ∑ L"
    assert text(formula)[1].startswith("  + C")
    assert paragraph.lines == (
        (Span("text", "With "), Span("code", "n"), Span("text", " of "), Span("source", "Me2020"),
         Span("text", ".")),
    )  # fmt: skip
    assert failures.kind == "failures"
    assert text(failures) == ["A front layer is lost.", "half stalls, and so on.", "Noise."]


def test_a_title_alone_has_no_parts() -> None:
    assert docstring.title(" One. ") == "One."
    assert docstring.blocks(" One. ") == []
    assert docstring.blocks("") == []


@pytest.mark.parametrize("path", sorted((own_folder() / "methods").glob("*/method.py")), ids=str)
def test_no_word_of_a_method_is_lost(path: object) -> None:
    source = ast.parse(path.read_text(encoding="utf-8"))  # type: ignore[attr-defined]
    blocks = docstring.blocks(ast.get_docstring(source, clean=False) or "")
    kinds = [block.kind for block in blocks]
    assert kinds.count("failures") == kinds.count("sources") == 1
    assert "paragraph" in kinds
