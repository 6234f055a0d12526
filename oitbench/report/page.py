"""The page: all reports of a results folder in one index.html that opens from disk, offline."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from oitbench.errors import UsageError
from oitbench.report.artifacts import Artifact, Figure, ImageGrid, Note, Table
from oitbench.results import records as read
from oitbench.results.records import Results
from oitbench.results.store import Record

if TYPE_CHECKING:
    from jinja2 import Environment

_LAST = 1000


@dataclass(frozen=True)
class Section:
    """One report on the page."""

    name: str
    title: str
    doc: str
    artifacts: tuple[Artifact, ...]


def write(
    results_folder: Path | str,
    out_folder: Path | str | None,
    collection_reports: Mapping[str, ModuleType],
    *,
    hdr: bool = False,
) -> Path:
    """Build every report and compose them into a page.

    Parameters
    ----------
    results_folder : path
        Folder of a run.
    out_folder : path, optional
        Where the page goes; `report` inside the results folder without.
    collection_reports : mapping of str to module
        Report files by name; each has `title`, `build`, and optionally a number `order`.
    hdr : bool
        Show HDR-FLIP instead of FLIP of the displayed image.

    Returns
    -------
    Path
        The page, `index.html`.

    Raises
    ------
    UsageError
        If there are no results, or the place cannot be written to.
    """
    results = Results.load(results_folder, hdr=hdr)
    out = Path(out_folder) if out_folder is not None else results.folder / "report"
    try:
        out.mkdir(parents=True, exist_ok=True)
        sections = [
            _section(name, module, results, out)
            for name, module in sorted(collection_reports.items(), key=_order)
        ]
        page = out / "index.html"
        page.write_text(_render(results, sections, out), encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{out} cannot be written to ({error.strerror}); give -o DIR") from error
    return page


def _order(report: tuple[str, ModuleType]) -> tuple[float, str]:
    return float(getattr(report[1], "order", _LAST)), report[0]


def _section(name: str, module: ModuleType, results: Results, out: Path) -> Section:
    artifacts = tuple(module.build(results, out))
    # The first line of the docstring is what the section shows; the rest is how to read it.
    doc = " ".join((module.__doc__ or "").split())
    return Section(name, str(module.title), doc, artifacts)


def _render(results: Results, sections: list[Section], out: Path) -> str:
    template = _environment(results, out).get_template("index.html")
    troubled = [record for record in results.records if record["status"] != "ok"]
    return template.render(
        results=results,
        sections=sections,
        counts=_counts(results.records),
        troubled=troubled,
        incomplete=_incomplete(results.records),
        facts=list(_facts(results.facts)),
        statuses=read.FINISHED,
    )


def _environment(results: Results, out: Path) -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    folder = resources.files("oitbench.report")
    environment = Environment(
        loader=FunctionLoader(lambda name: (folder / name).read_text(encoding="utf-8")),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    kinds = {Figure: "figure", Table: "table", ImageGrid: "grid", Note: "note"}
    environment.filters["kind"] = lambda artifact: kinds[type(artifact)]
    environment.filters["link"] = lambda path: quote(Path(os.path.relpath(path, out)).as_posix())
    environment.globals["style"] = results.style
    return environment


def _counts(records: tuple[Record, ...]) -> dict[str, int]:
    """Return the number of cells by status, in order of first appearance, "ok" first."""
    statuses = ["ok", *(record["status"] for record in records)]
    counts = dict.fromkeys(dict.fromkeys(statuses), 0)
    for record in records:
        counts[record["status"]] += 1
    return {status: count for status, count in counts.items() if count}


def _incomplete(records: tuple[Record, ...]) -> dict[str, dict[str, list[str]]]:
    """Return scene → missing effects → methods that cannot express them."""
    found: dict[str, dict[str, list[str]]] = {}
    for record in records:
        missing = read.missing_effects(record)
        if missing:
            by_effects = found.setdefault(record["scene"], {})
            methods = by_effects.setdefault(", ".join(missing), [])
            if record["method"] not in methods:
                methods.append(record["method"])
    return found


def _facts(facts: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the facts of the run as rows of the environment box."""
    gl = facts.get("gl") or {}
    cpu = facts.get("cpu") or {}
    git = facts.get("git") or {}
    cores = f", {cpu['cores']} cores" if cpu.get("cores") else ""
    packages = facts.get("packages") or {}
    rows = {
        "GL renderer": gl.get("renderer"),
        "GL version": gl.get("version"),
        "CPU": f"{cpu['model']}{cores}" if cpu.get("model") else None,
        "OS": facts.get("os"),
        "Python": facts.get("python"),
        "Packages": ", ".join(f"{name} {packages[name]}" for name in packages if packages[name]),
        "LLVM of the path tracer": facts.get("llvm"),
        "Commit": (git.get("commit") or "") + (" (modified)" if git.get("modified") else ""),
        "Command": " ".join(map(str, facts.get("argv") or [])),
        "Seed": facts.get("seed"),
        "Date": facts.get("date"),
        "Wall time": _wall_time(facts.get("wall") or {}),
    }
    return [(name, str(value)) for name, value in rows.items() if value not in (None, "")]


def _wall_time(seconds: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:.0f} s" for name, value in seconds.items())
