"""The page of a method, as a file or as a part of the report's page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oitbench.report import latex
from oitbench.report.artifacts import Part, Table
from oitbench.report.bibliography import Source
from oitbench.report.context import ReportContext
from oitbench.report.method_pages.diagram import Diagram
from oitbench.report.method_pages.docstring import Block
from oitbench.report.templates import anchor, environment


@dataclass(frozen=True)
class Scene:
    """The pictures of a method in a scene, as addresses of previews; empty without a picture.

    Parameters
    ----------
    heading : str
    text : str
        The error, and the truth that it is against.
    view : str
        Address of the viewer, relative to the report's page.
    pictures : tuple of (str, str)
        Captions and addresses.
    """

    heading: str
    text: str
    view: str
    pictures: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class MethodPage:
    """All that the template shows.

    Parameters
    ----------
    name, title, family : str
    remarks : tuple of str
        What a reader must know of this page, such as that the method's file was not found.
    blocks : tuple of Block
        Of the docstring.
    facts : tuple of (str, str)
        Demands on a platform, and effects: names and values.
    diagram : Diagram, optional
        None if nothing is known of the method's passes.
    declared : str
        The origin of the diagram.
    promises, breaks, parameters, results : Table, optional
    scenes : tuple of Scene
        The best one and the worst one.
    sources : tuple of Source
    others : tuple of str
        Labels of other methods.
    label : str
        Of the variant that stands for the method.
    """

    name: str
    title: str
    family: str
    remarks: tuple[str, ...]
    blocks: tuple[Block, ...]
    facts: tuple[tuple[str, str], ...]
    diagram: Diagram | None
    declared: str
    parameters: Table | None
    promises: Table | None
    breaks: Table | None
    results: Table | None
    scenes: tuple[Scene, ...]
    sources: tuple[Source, ...]
    others: tuple[str, ...]
    label: str

    @property
    def keys(self) -> frozenset[str]:
        """The keys of its sources."""
        return frozenset(source.key for source in self.sources)

    @property
    def tables(self) -> tuple[Table, ...]:
        """Its tables."""
        found = (self.parameters, self.promises, self.breaks, self.results)
        return tuple(table for table in found if table is not None)


def write(context: ReportContext, pages: Sequence[MethodPage]) -> list[Part]:
    """Write pages as files, or return them as parts if the report is a single file."""
    if not context.pages:
        return []
    for page in pages:
        latex.write_all(page.tables)
    if context.single_file:
        body = environment(context).get_template("method_pages/body.html")
        return [
            Part(anchor(page.name), page.name, body.render(page=page, home="")) for page in pages
        ]
    for page in pages:
        path = context.page(page.name)
        template = environment(context, path.parent).get_template("method_pages/page.html")
        text = template.render(page=page, home=_home(path, context.out))
        path.write_text(text, encoding="utf-8", errors="backslashreplace", newline="")
    return []


def _home(path: Path, out: Path) -> str:
    """Return the address of the report's page from that of a method."""
    return "../" * len(path.parent.relative_to(out).parts) + "index.html"
