"""Formulas in plain text as they are set: Greek letters, indices, exponents and signs.

`alpha_i` becomes α with the index i, `sum_{i<k}` Σ with the index i<k, `z^2` z², `1e-5` 10⁻⁵, and
`>=` ≥. Single letters are variables; words are names of functions or plain words.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple


class Span(NamedTuple):
    """A piece of text.

    `kind` is `text`, `variable`, `code`, `source`, or `sub` and `sup`, which have no text but an
    `inner` formula.
    """

    kind: str
    text: str
    inner: tuple[Span, ...] = ()


_LETTERS = {
    "alpha": "α", "beta": "β", "delta": "δ", "eta": "η", "kappa": "κ", "lambda": "λ", "phi": "φ",
    "pi": "π", "tau": "τ", "xi": "ξ", "Omega": "Ω",
}  # fmt: skip
_OPERATORS = {"sum": "∑", "prod": "∏", "sqrt": "√"}
_SIGNS = {"<=": "≤", ">=": "≥", "!=": "≠", "<-": "←", "->": "→", "...": "…", "-": "−"}
_TOKEN = re.compile(
    r"(?P<power>\b\d+(?:\.\d+)?e[-+]?\d+\b)"
    r"|(?P<operator>(?:sum|prod|sqrt)\b|(?:sum|prod)(?=_))(?! (?:<-|\+|of ))"
    r"|(?P<word>[A-Za-z]+)"
    r"|`(?P<code>[^`]+)`"
    r"|(?P<mark>[_^])(?P<script>\{[^}]*\}|\([^)]*\)|-?[A-Za-z]+|-?\d+)"
    r"|(?P<sign><=|>=|!=|<-|->|\.\.\.|-)"
    r"|(?P<other>.)"
)
_GREEK = "|".join(_LETTERS)
_IN_TEXT = re.compile(
    rf"\b(?:{_GREEK}|(?:{_GREEK}|[A-Za-z])_[A-Za-z0-9]{{1,2}})\b"
    r"|\^(?:\([^)]*\)|-?\w+)|\b\d+(?:\.\d+)?e[-+]?\d+\b"
)
"""Parts of a sentence that can only be formulas."""
_CONSTANT = re.compile(r"(?<![A-Za-z0-9_.])([A-Za-z])(\d)\b")


def spans(line: str) -> Iterator[Span]:
    """Yield the pieces of a line of a formula."""
    # A letter with a digit has an index, such as C0, the background.
    marked = _CONSTANT.sub(r"\1_\2", line)
    for found in _TOKEN.finditer(marked):
        if found["power"]:
            yield from _power(found["power"])
        elif found["operator"]:
            yield Span("text", _OPERATORS[found["operator"]])
        elif found["word"]:
            # Before a colon stands a name, such as a value of a parameter.
            named = marked[found.end() :].startswith(":")
            letter = found["word"] if named else _LETTERS.get(found["word"], found["word"])
            yield Span("variable" if len(letter) == 1 else "text", letter)
        elif found["code"]:
            yield Span("code", found["code"])
        elif found["mark"]:
            # Braces, and parentheses around an exponent, only group.
            inner = found["script"].strip("{}" if found["mark"] == "_" else "{}()")
            yield Span("sub" if found["mark"] == "_" else "sup", "", tuple(spans(inner)))
        else:
            yield Span("text", _SIGNS.get(found[0], found[0]))


def spans_of_text(sentence: str) -> Iterator[Span]:
    """Yield the pieces of a sentence, in which only Greek letters, indices and powers are set."""
    end = 0
    for found in _IN_TEXT.finditer(sentence):
        yield Span("text", sentence[end : found.start()])
        yield from spans(found[0])
        end = found.end()
    yield Span("text", sentence[end:])


def _power(number: str) -> Iterator[Span]:
    """Yield a number such as 3e-2 as 3·10⁻²."""
    digits, _, exponent = number.partition("e")
    yield Span("text", "10" if digits == "1" else f"{digits}·10")
    yield Span("sup", "", (Span("text", str(int(exponent)).replace("-", "−")),))
