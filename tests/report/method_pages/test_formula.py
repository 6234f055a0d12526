"""Formulas: from plain text to letters, indices, exponents and signs."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from oitbench.report.method_pages.formula import Span, spans, spans_of_text


def shown(pieces: Iterable[Span]) -> str:
    """Return pieces as text, with marks for variables, indices and exponents."""
    marks = {"variable": "*{}*", "sub": "_[{}]", "sup": "^[{}]", "text": "{}", "code": "`{}`"}
    return "".join(marks[kind].format(text or shown(inner)) for kind, text, inner in pieces)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("alpha_i L_i", "*α*_[*i*] *L*_[*i*]"),
        ("C0 - k1", "*C*_[0] − *k*_[1]"),
        ("sum_{z_i < z} tau_i", "∑_[*z*_[*i*] < *z*] *τ*_[*i*]"),
        ("prod (1 - o)", "∏ (1 − *o*)"),
        ("sum <- sum + T", "sum ← sum + *T*"),
        ("A = sum of w", "*A* = sum of *w*"),
        ("(z/5)^2 + 2^(rank + 1)", "(*z*/5)^[2] + 2^[rank + 1]"),
        ("1e-5 and 3e3", "10^[−5] and 3·10^[3]"),
        ("T >= 0, x -> y ...", "*T* ≥ 0, *x* → *y* …"),
        ("max(log2 s, exp(-a))", "max(log2 *s*, exp(−*a*))"),
        ("alpha: by `alpha`", "alpha: by `alpha`"),
        ("b* and <b>", "*b** and <*b*>"),
    ],
)
def test_a_line_of_a_formula(text: str, expected: str) -> None:
    assert shown(spans(text)) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("the sum of o - 1 at a layer", "the sum of o - 1 at a layer"),
        (
            "beta rounds to 1e-5, z_B grows as w^2",
            "*β* rounds to 10^[−5], *z*_[*B*] grows as w^[2]",
        ),
        ("light_steps and k_buffer stay", "light_steps and k_buffer stay"),
        ("a betatron", "a betatron"),
    ],
)
def test_a_sentence_keeps_its_words(text: str, expected: str) -> None:
    assert shown(spans_of_text(text)) == expected
