"""The page: all reports of a results folder in one index.html that opens from disk, offline."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from oitbench.catalog.messages import Portrait
from oitbench.crops import Crop
from oitbench.report.artifacts import Note, writing_to
from oitbench.report.cells import effect_labels
from oitbench.report.context import ReportContext
from oitbench.report.sections import SECONDS, Section, build_sections
from oitbench.report.single_file import joined
from oitbench.report.templates import environment
from oitbench.report.times import disturbed_scenes
from oitbench.results.records import Results
from oitbench.results.schema import Record, RunFacts
from oitbench.results.times import SIGN

VIEWER = (
    "codec", "tone", "stack", "state", "paint", "panes", "screen", "legend", "list", "actions",
    "input", "viewer",
)  # fmt: skip
"""Scripts of the viewer in `viewer/`, in the order in which the page has them."""
_REMARKS = "Not drawn"
HEADING = "Order-independent transparency: accuracy and cost"


@dataclass(frozen=True)
class Edition:
    """The differences between the page of all results and one of chosen reports.

    Parameters
    ----------
    heading : str
    numbers : mapping of str to str
        Text before the title of each section, by the names of reports in their order.
    variants : mapping of str to str
        See `ReportContext`.
    remarks : mapping of str to str
        Lines of a last section by what they are about.
    """

    heading: str
    numbers: Mapping[str, str]
    variants: Mapping[str, str] = field(default_factory=dict)
    remarks: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Page:
    """What was written.

    Parameters
    ----------
    path : Path
        The page, `index.html`.
    missing : tuple of str
        Why sections are missing, one line for each.
    """

    path: Path
    missing: tuple[str, ...]


def write(
    results_folder: Path | str,
    out_folder: Path | str | None,
    reports: Mapping[str, Path],
    *,
    hdr: bool = False,
    single_file: bool = False,
    crops: Mapping[str, Mapping[str, Crop]] | None = None,
    portraits: Mapping[str, Portrait | str] | None = None,
    bibliographies: Sequence[Path] = (),
    timeout: float | None = SECONDS,
    edition: Edition | None = None,
) -> Page:
    """Build all reports, and write them as one page.

    A report that fails, crashes or hangs costs its own section.

    Parameters
    ----------
    results_folder : path
        Folder of a run.
    out_folder : path, optional
        Folder of the page. Default: `report` in the results folder.
    reports : mapping of str to Path
        Files of reports by name; each has `title`, `build`, and optionally a number `order`.
    hdr : bool
        Show HDR-FLIP instead of FLIP of the displayed image, and keep linear radiance in the
        viewer.
    single_file : bool
        Put all files that the page needs into it, however large it becomes.
    crops : mapping of str to mapping of str to Crop, optional
        Parts of pictures by the name of a scene.
    portraits : mapping of str to Portrait or str, optional
        Methods as their files describe them, by bare name; else the reason why they do not.
    bibliographies : sequence of path
        BibTeX files with the sources of methods and claims.
    timeout : float, optional
        Seconds that one section may take. None: no limit.
    edition : Edition, optional
        Default: the page of all results.

    Raises
    ------
    UsageError
        If there are no results, or the folder of the page cannot be written to.
    """
    results = Results.load(results_folder)
    out = folder_of(results, out_folder)
    context = ReportContext(
        results,
        out,
        hdr,
        crops or {},
        variants=edition.variants if edition else {},
        portraits=portraits or {},
        bibliographies=tuple(bibliographies),
        sections=frozenset(reports),
        single_file=single_file,
    )
    page = out / "index.html"
    with writing_to(out):
        sections = build_sections(context, reports, timeout)
        if edition is not None:
            sections = _edited(context, sections, edition)
        text = _render(context, sections, edition.heading if edition else HEADING)
        scripts = {name: path for section in sections for name, path in section.pixels.items()}
        # Texts may hold names of files that are not UTF-8.
        with page.open("w", encoding="utf-8", errors="backslashreplace", newline="") as file:
            file.writelines(joined(text, out, scripts) if single_file else [text])
    return Page(page, tuple(section.error for section in sections if section.error))


def folder_of(results: Results, out_folder: Path | str | None) -> Path:
    """Return the folder of the page; see `write`."""
    return Path(out_folder) if out_folder is not None else results.folder / "report"


def _edited(context: ReportContext, sections: Sequence[Section], edition: Edition) -> list[Section]:
    """Return the sections in the order of an edition and with its numbers, then its remarks."""
    found = {section.name: section for section in sections}
    edited = [
        replace(found[name], title=f"{number}: {found[name].title}")
        for name, number in edition.numbers.items()
        if name in found
    ]
    if edition.remarks:
        notes = [Note(f"{about}: {text}.") for about, text in edition.remarks.items()]
        template = environment(context).get_template("section.html")
        body = template.render(artifacts=notes, section="remarks", heading=_REMARKS)
        edited.append(Section("remarks", _REMARKS, body=body))
    return edited


def _render(context: ReportContext, sections: Sequence[Section], heading: str) -> str:
    results = context.results
    # "ok" comes first, the other statuses in order of first appearance.
    counts = Counter(ok=0)
    counts.update(record.status for record in results.records)
    return (
        environment(context)
        .get_template("index.html")
        .render(
            results=results,
            heading=heading,
            sections=sections,
            counts={status: count for status, count in counts.items() if count},
            troubled=[record for record in results.records if record.status != "ok"],
            incomplete=_incomplete(results.records),
            faults=list(dict.fromkeys(line for item in sections for line in item.faults)),
            facts=facts_of(results.facts),
            disturbed=disturbed_scenes(results.records),
            sign=SIGN,
            viewer=VIEWER,
        )
    )


def _incomplete(records: Sequence[Record]) -> dict[tuple[str, str], list[str]]:
    """Return the methods that cannot express effects, by scene and missing effects."""
    found: dict[tuple[str, str], list[str]] = {}
    for record in records:
        if record.missing_effects:
            place = record.seen, effect_labels(record.missing_effects)
            methods = found.setdefault(place, [])
            if record.method not in methods:
                methods.append(record.method)
    return found


def facts_of(facts: RunFacts) -> list[tuple[str, str]]:
    """Return the facts of the run as names and values; unknown facts are left out."""
    gl, cpu, git = facts.gl, facts.cpu, facts.git
    cores = f", {cpu.cores} cores" if cpu and cpu.cores else ""
    governor = f", governor {cpu.governor}" if cpu and cpu.governor else ""
    modified = " (modified)" if git and git.modified else ""
    rows = {
        "GL renderer": gl.renderer if gl else "",
        "GL version": gl.version if gl else "",
        "CPU": f"{cpu.model}{cores}{governor}" if cpu else "",
        "OS": facts.os,
        "Python": facts.python,
        "Packages": ", ".join(f"{name} {value}" for name, value in facts.packages.items() if value),
        "LLVM of the path tracer": facts.llvm or "",
        "Commit": f"{git.commit}{modified}" if git else "",
        "Command": " ".join(facts.argv),
        "Seed": "" if facts.seed is None else str(facts.seed),
        "Date": facts.date,
        "Wall time": ", ".join(f"{kind} {seconds:.0f} s" for kind, seconds in facts.wall.items()),
    }
    return [(name, value) for name, value in rows.items() if value]
