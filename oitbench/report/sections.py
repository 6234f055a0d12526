"""The sections of the page; workers build them, so that a faulty report costs only its own."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue

from oitbench.errors import OitbenchError
from oitbench.report.context import ReportContext
from oitbench.report.worker import LAST, BuildSection, SectionBuilt, Settings
from oitbench.workers import memory
from oitbench.workers.cores import usable_cores
from oitbench.workers.process import Process

SECONDS = 600.0
"""Time in which each section must be built by default."""
_MOST_WORKERS = 8
"""Each worker reads all results, so that more of them gain little."""


@dataclass(frozen=True)
class Section:
    """A report on the page.

    Parameters
    ----------
    name, title, doc : str
    order : float
    body : str
        HTML.
    faults : tuple of str
        Images that could not be read, one line each.
    pixels : mapping of str to Path
        Scripts with the pixels of its stacks, by their names.
    figures : tuple of Path
        Files of its figures: PNG, then PDF, of each.
    absent : str
        Why these results have nothing to show; then it has no body.
    error : str
        Why the section could not be built, in one line; then it has no body.
    """

    name: str
    title: str
    doc: str = ""
    order: float = LAST
    body: str = ""
    faults: tuple[str, ...] = ()
    pixels: Mapping[str, Path] = field(default_factory=dict)
    figures: tuple[Path, ...] = ()
    absent: str = ""
    error: str = ""


def build_sections(
    context: ReportContext,
    reports: Mapping[str, Path],
    timeout: float | None = SECONDS,
    memory_limit: int | None = None,
) -> list[Section]:
    """Build all sections in their order.

    Parameters
    ----------
    context : ReportContext
    reports : mapping of str to Path
        Files of reports by name.
    timeout : float, optional
        Seconds that one section may take. None: no limit.
    memory_limit : int, optional
        Bytes that each worker may use. Default: its share of the machine's.
    """
    crops = {scene: dict(found) for scene, found in context.crops.items()}
    settings = Settings(
        context.results.folder,
        context.out,
        context.hdr,
        crops,
        dict(context.variants),
        dict(context.portraits),
        list(context.bibliographies),
        sorted(context.sections),
        context.single_file,
        context.sheets,
    )
    count = max(1, min(len(usable_cores()), len(reports), _MOST_WORKERS))
    limit = memory.share(count) if memory_limit is None else memory_limit
    free: SimpleQueue[Process] = SimpleQueue()

    def build(name: str) -> Section:
        worker = free.get()
        try:
            return _build(worker, name, reports[name], timeout)
        finally:
            free.put(worker)

    # Stopped workers end the threads that wait for them, so they are stopped first.
    with ThreadPoolExecutor(count) as threads, ExitStack() as workers:
        for _ in range(count):
            worker = Process("oitbench.report.worker", settings, SectionBuilt, limit, threads=1)
            free.put(workers.enter_context(worker))
        sections = list(threads.map(build, reports))
    return sorted(sections, key=lambda section: (section.order, section.name))


def _build(worker: Process, name: str, path: Path, timeout: float | None) -> Section:
    try:
        built = worker.ask(BuildSection(name, path), SectionBuilt, timeout)
    except OitbenchError as error:
        text = str(error)
        return Section(name, name, error=text if str(path) in text else f"{path}: {text}")
    faults = tuple(built.faults)
    return Section(
        name, built.title, built.doc, built.order, built.body, faults, built.pixels,
        tuple(built.figures), built.absent,
    )  # fmt: skip
