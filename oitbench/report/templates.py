"""The templates of the page; all texts that they show are escaped."""

from __future__ import annotations

import os
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from oitbench.filenames import file_name
from oitbench.report import latex, stacks
from oitbench.report.artifacts import (
    Choices,
    Figure,
    HeatTable,
    ImageGrid,
    Note,
    Parts,
    References,
    Stack,
    Statement,
    Table,
)
from oitbench.report.context import ReportContext
from oitbench.report.palette import is_dark

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

_WIDE, _MIDDLE, _NARROW = (7, 6, 8, 5), (4, 5, 3), (2, 3)
"""Columns of a grid that screens of three widths have room for."""


def _code(text: str) -> Markup:
    """Return an escaped text whose parts between backticks are code."""
    from markupsafe import Markup, escape

    parts = str(text).split("`")
    if len(parts) % 2 == 0:
        return escape(text)
    marked = [
        Markup("<code>{}</code>").format(p) if k % 2 else escape(p) for k, p in enumerate(parts)
    ]
    return Markup("").join(marked)


def _across(count: int) -> str:
    """Return the columns of a grid of tiles, such that no tile is alone in the last row."""

    def columns(choices: tuple[int, ...]) -> int:
        def gaps(across: int) -> tuple[bool, int, int]:
            rows = -(-count // across)
            return rows > 1 and count % across == 1, rows, rows * across - count

        return min(choices, key=gaps) if count > 1 else choices[0]

    names = zip(("wide", "middle", "narrow"), (_WIDE, _MIDDLE, _NARROW), strict=True)
    across = {name: columns(choices) for name, choices in names}
    # Of 7 tiles, the first one, which is the truth, fills a row on a phone.
    lead = across["narrow"] if 1 < across["narrow"] < count and count % across["narrow"] == 1 else 1
    return ";".join(f"--{name}:{size}" for name, size in {**across, "lead": lead}.items())


def environment(context: ReportContext, folder: Path | None = None) -> Environment:
    """Return the templates of this area, for a page in `folder`; by default in `context.out`."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    place = context.out if folder is None else folder
    sources = resources.files("oitbench.report")
    made = Environment(
        loader=FunctionLoader(lambda name: (sources / name).read_text(encoding="utf-8")),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    kinds: dict[type, str] = {
        Figure: "figure", Table: "table", ImageGrid: "grid", Stack: "stack", Note: "note",
        Statement: "statement", Choices: "choices", HeatTable: "heat", Parts: "parts",
        References: "references",
    }  # fmt: skip
    made.filters["kind"] = lambda artifact: kinds[type(artifact)]

    def link(path: Path) -> str:
        return quote(os.fsencode(Path(os.path.relpath(path, place)).as_posix()))

    def address(label: str) -> str:
        """Return the address of the page of a method; empty if it has none."""
        name = context.names.get(label)
        if not context.pages or name is None:
            return ""
        return f"#{anchor(name)}" if context.single_file else link(context.page(name))

    made.filters["link"] = link
    made.filters["anchor"] = anchor
    made.filters["tex"] = latex.path
    made.globals["address"] = address
    made.filters["code"] = _code
    made.filters["across"] = _across
    made.globals["style"] = context.style
    made.globals["on_page"] = context.sections
    made.globals["is_dark"] = is_dark
    made.globals["citation"], made.globals["section"] = context.citation, ""
    made.globals["facts"] = lambda stack: stacks.facts(context, stack, link(stack.pixels))
    made.globals["color_maps"] = stacks.color_maps
    return made


def anchor(name: str) -> str:
    """Return the id of the part of the page that describes a method."""
    return f"method-{file_name(name)}".replace("%", "~")
