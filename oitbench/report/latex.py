"""Tables as LaTeX with the rules of the package booktabs; numbers are those of the page."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from oitbench.report.artifacts import (
    Artifact,
    Choices,
    Chosen,
    Column,
    HeatTable,
    Shade,
    Table,
    Value,
)

SUFFIX = ".tex"
_LAYOUT = {"number": "r", "rank": "r", "prose": "p{60mm}"}
"""Columns of other kinds are one line, at the left."""
_SPECIAL = {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "<": r"\textless{}", ">": r"\textgreater{}", "|": r"\textbar{}", "†": r"\dag{}",
    "≥": r"$\geq$", "≤": r"$\leq$", "≈": r"$\approx$", "−": r"$-$", "×": r"$\times$", "–": "--",
    "…": r"\dots{}", "✓": r"$\surd$", "∞": r"$\infty$", "“": "``", "”": "''",
    "·": r"$\cdot$", "α": r"$\alpha$", "τ": r"$\tau$", "Π": r"$\prod$", "₀": "$_0$", "²": "$^2$",
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
}  # fmt: skip
_ESCAPED = re.compile("|".join(map(re.escape, _SPECIAL)))


def escaped(text: str) -> str:
    """Return a text in one line, in which no sign has a meaning of its own in LaTeX."""
    return _ESCAPED.sub(lambda found: _SPECIAL[found[0]], " ".join(text.split()))


def path(artifact: Artifact) -> Path | None:
    """Return the file of a table; None for other artifacts."""
    if isinstance(artifact, Table):
        return artifact.tex
    if isinstance(artifact, Choices | HeatTable):
        return artifact.csv.with_suffix(SUFFIX)
    return None


def write_all(artifacts: Iterable[Artifact]) -> None:
    """Write the files of all tables, beside their CSV files."""
    for artifact in artifacts:
        place = path(artifact)
        if place is not None:
            content = text(artifact)
            place.write_text(content, encoding="utf-8", errors="backslashreplace", newline="")


def text(artifact: Artifact) -> str:
    """Return a table as LaTeX."""
    if isinstance(artifact, Table):
        return _table(artifact)
    if isinstance(artifact, HeatTable):
        rows = [
            (escaped(name), *map(_shade, shades), escaped(remark))
            for name, remark, shades in artifact.rows
        ]
        heading = ("", *map(escaped, artifact.columns), "")
        return _written(artifact, "l" + "r" * len(artifact.columns) + "l", heading, rows)
    if isinstance(artifact, Choices):
        heading = ("For", *(escaped(words) for words, _ in artifact.criteria))
        chosen = [(escaped(row.subject), *map(_chosen, row.chosen)) for row in artifact.rows]
        return _written(artifact, "l" * len(heading), heading, chosen)
    raise TypeError(f"{type(artifact).__name__} is no table")


def _table(it: Table) -> str:
    columns = [it.columns[place] for place in it.visible]
    layout = "".join(_LAYOUT.get(column.kind, "l") for column in columns)
    heading = [escaped(f"{column.title} {column.unit}".strip()) for column in columns]
    rows = [[_cell(it.columns[place], row[place]) for place in it.visible] for row in it.rows]
    return _written(it, layout, heading, rows)


def _cell(column: Column, value: Value) -> str:
    text = escaped(column.text(value))
    # A bracket at the start of a row would be an option of the row before.
    return f"{{{text}}}" if isinstance(value, str) and value else text


def _shade(shade: Shade) -> str:
    return rf"\textbf{{{escaped(shade.text)}}}" if shade.best else escaped(shade.text)


def _chosen(choice: Chosen | None) -> str:
    return "--" if choice is None else escaped(f"{choice.method}, {choice.numbers}")


def _written(
    it: Table | HeatTable | Choices,
    layout: str,
    heading: Sequence[str],
    rows: Iterable[Sequence[str]],
) -> str:
    lines = [
        rf"% Needs \usepackage{{booktabs}}. {escaped(it.title)}",
        rf"\begin{{tabular}}{{{layout}}}",
        r"\toprule",
        " & ".join(heading) + r" \\",
        r"\midrule",
        *(" & ".join(row) + r" \\" for row in rows),
        r"\bottomrule",
        r"\end{tabular}",
        "",
    ]
    return "\n".join(lines)
