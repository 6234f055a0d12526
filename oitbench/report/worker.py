"""The far end of a report: builds sections of the page, each from the file of a report."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from msgspec import Struct

from oitbench.catalog.messages import Portrait
from oitbench.crops import Crop
from oitbench.errors import DeclarationError, OitbenchError, locate, printable
from oitbench.places import Places
from oitbench.plugins import Collection
from oitbench.report import latex
from oitbench.report.artifacts import Artifact, Figure, ImageGrid, Note, Stack, writing_to
from oitbench.report.context import ReportContext
from oitbench.report.templates import environment
from oitbench.results.records import Results
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve

LAST = 1000.0
"""Number `order` of reports that have none."""
_LOADING, _BUILDING = Step("loading the file"), Step("building the section")


class Settings(Struct, frozen=True):
    """The results folder, and the other fields of a context."""

    results: Path
    out: Path
    hdr: bool
    crops: dict[str, dict[str, Crop]]
    variants: dict[str, str]
    portraits: dict[str, Portrait | str]
    bibliographies: list[Path]
    sections: list[str]
    single_file: bool
    sheets: bool


class BuildSection(Struct, frozen=True, tag=True):
    """Asks for the section of the report `name`, whose file is `path`."""

    name: str
    path: Path


class SectionBuilt(Struct, frozen=True, tag=True):
    """The section: `body` is HTML, and sections are sorted by `order`.

    A section without a body has nothing to show, and `absent` says why.
    `faults` says in one line each which images could not be read so far, `pixels` are the scripts
    of its stacks by their names, and `figures` the PNG and the PDF file of each figure.
    """

    title: str
    doc: str
    order: float
    body: str
    faults: list[str]
    pixels: dict[str, Path]
    figures: list[Path]
    absent: str


def _begin(settings: Settings, on_step: OnStep) -> Callable[[BuildSection], SectionBuilt]:
    collection = Collection(Places())
    results = Results.load(settings.results)
    context = ReportContext(
        results,
        settings.out,
        settings.hdr,
        settings.crops,
        settings.variants,
        settings.portraits,
        tuple(settings.bibliographies),
        frozenset(settings.sections),
        settings.single_file,
        settings.sheets,
    )
    template = environment(context).get_template("section.html")

    def answer(request: BuildSection) -> SectionBuilt:
        on_step(_LOADING)
        path = request.path
        collection.places.reports.add(request.name, path)
        module = collection.reports[request.name]
        on_step(_BUILDING)
        try:
            with writing_to(context.out):
                artifacts = list(module.build(context))
                latex.write_all(artifacts)
                absent = _absent(artifacts)
                body = (
                    ""
                    if absent
                    else template.render(
                        artifacts=artifacts, section=request.name, heading=module.title
                    )
                )
            return SectionBuilt(
                printable(str(module.title)),
                printable(" ".join((module.__doc__ or "").split())),
                float(getattr(module, "order", LAST)),
                # A note may name a folder whose name is not UTF-8.
                body.encode(errors="backslashreplace").decode(),
                list(map(printable, results.faults)),
                {item.name: item.pixels for item in artifacts if isinstance(item, Stack)},
                list(_files(artifacts)),
                printable(absent),
            )
        except OitbenchError:
            raise
        except (Exception, SystemExit) as error:
            raise DeclarationError(locate(error, path)) from error

    return answer


def _files(artifacts: Iterable[Artifact]) -> Iterator[Path]:
    for item in artifacts:
        figure: object = item
        if isinstance(item, ImageGrid):
            figure = item.figure
        elif isinstance(item, Stack):
            figure = item.sheet
        if isinstance(figure, Figure):
            yield from (figure.png, figure.pdf)


def _absent(artifacts: Sequence[Artifact]) -> str:
    """Return why a section would be empty: it has no artifacts, or notes alone."""
    notes = [item.text for item in artifacts if isinstance(item, Note)]
    if len(notes) < len(artifacts):
        return ""
    return " ".join(dict.fromkeys(notes)) or "There is nothing to show yet."


def main() -> None:
    """Serve the page that started this process."""
    serve(Settings, BuildSection, _begin)
