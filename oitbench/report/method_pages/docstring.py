"""The docstring of a method as paragraphs, formulas and lists of failures.

Blocks that are indented are formulas. Backticks enclose code, and brackets the keys of sources.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass

from oitbench.report.bibliography import KEY
from oitbench.report.method_pages.formula import Span, spans, spans_of_text

FAILURES, SOURCES = "Known failures: ", ("Source: ", "Sources: ")
_INLINE = re.compile(rf"`([^`]+)`|{KEY.pattern}")


@dataclass(frozen=True)
class Block:
    """A part of a docstring.

    Parameters
    ----------
    kind : str
        `paragraph`, `formula`, `failures` or `sources`.
    lines : tuple of tuple of Span
        A formula has one for each line, failures one for each sentence, and others one.
    """

    kind: str
    lines: tuple[tuple[Span, ...], ...]


def title(doc: str) -> str:
    """Return the first line."""
    return doc.strip().partition("\n")[0].strip()


def blocks(doc: str) -> list[Block]:
    """Return the parts of a docstring after its title, in their order."""
    _, _, rest = doc.strip().partition("\n")
    return [_block(part) for part in re.split(r"\n[ \t]*\n", rest.strip("\n")) if part.strip()]


def _block(part: str) -> Block:
    if all(line.startswith((" ", "\t")) for line in part.splitlines()):
        lines = textwrap.dedent(part).splitlines()
        return Block("formula", tuple(tuple(spans(line)) for line in lines))
    words = " ".join(part.split())
    if words.startswith(FAILURES):
        failures = words.removeprefix(FAILURES)
        # The first sentence begins after a colon; single letters but "a" are variables.
        if re.match(r"a |[a-z]{2}", failures):
            failures = failures[0].upper() + failures[1:]
        sentences = re.split(r"(?<=[.!?]) (?=[A-Z`])", failures)
        return Block("failures", tuple(tuple(_inline(sentence)) for sentence in sentences))
    kind = "sources" if words.startswith(SOURCES) else "paragraph"
    return Block(kind, (tuple(_inline(words)),))


def _inline(words: str) -> Iterator[Span]:
    """Yield the parts of a paragraph: text, `code`, and keys of sources."""
    end = 0
    for found in _INLINE.finditer(words):
        yield from spans_of_text(words[end : found.start()])
        yield Span("code", found[1]) if found[1] else Span("source", found[2])
        end = found.end()
    yield from spans_of_text(words[end:])
