"""Joining the results of several machines, with a folder of its own for each renderer.

Times of different renderers share no axis, and no rank. A software renderer is another one on
another processor. If there is only one renderer, the merged folder is an ordinary results folder;
else it holds one for each, and every command takes those.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from oitbench.atomic import writing
from oitbench.errors import UsageError
from oitbench.filenames import file_name
from oitbench.image import stored
from oitbench.results.records import Results, parts
from oitbench.results.schema import CellKey, Record
from oitbench.results.store import CELLS, CONFIG, IMAGES, RUN, Store

_MERGED = {CELLS, CONFIG, IMAGES, RUN, "report"}
"""What need not be copied as it is: reports are written from results."""
_SIGNS = re.compile(r"[^A-Za-z0-9._]+")
_LONGEST = 80


@dataclass
class Merged:
    """What was written.

    Parameters
    ----------
    folders : dict of str to Path
        The results folder of each renderer.
    cells : int
    notes : list of str
        What a user should know of the inputs, one line each.
    """

    folders: dict[str, Path] = field(default_factory=dict)
    cells: int = 0
    notes: list[str] = field(default_factory=list)


def merge(folders: Sequence[Path], out: Path) -> Merged:
    """Join results folders; they stay as they are.

    Of a cell that the same renderer has in several folders, the one of the newest run is kept; one
    that is finished goes before one that is not.

    Parameters
    ----------
    folders : sequence of Path
        Results folders, also merged ones.
    out : Path
        A folder that does not exist, or is empty. It appears when it is complete.

    Raises
    ------
    UsageError
        A folder holds no results, or those of another version of the suite; `out` is not empty, or
        inside of one of the folders.
    StorageError
        `out` cannot be written.
    """
    _check_out(out, folders)
    sources = [Results.load(part) for folder in folders for part in parts(folder)]
    _check_engines(sources)
    merged = Merged(notes=[*_different_scenes(sources), *_left_out(sources)])
    groups: dict[str, list[Results]] = {}
    for source in sources:
        groups.setdefault(_device(source), []).append(source)
    names = _folder_names(groups)
    target = out.resolve()
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    with writing(out):
        try:
            for device, group in groups.items():
                place = names[device] if len(groups) > 1 else ""
                merged.cells += _write(partial / place, group, merged.notes)
                merged.folders[device] = out / place
            os.replace(partial, target)
        finally:
            shutil.rmtree(partial, ignore_errors=True)
    return merged


def _folder_names(devices: Collection[str]) -> dict[str, str]:
    """Return a short name for the folder of each device."""
    short = {device: _SIGNS.sub("-", device).strip("-.")[:_LONGEST] for device in devices}
    unique = len(set(short.values())) == len(short) and all(short.values())
    return short if unique else {device: file_name(device) for device in devices}


def _check_out(out: Path, folders: Iterable[Path]) -> None:
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError(f"{out} is not empty; give a new folder")
    for folder in folders:
        if out.resolve().is_relative_to(folder.resolve()):
            raise UsageError(
                f"{out} is inside of {folder}, which must not change; give another one"
            )


def _check_engines(sources: Sequence[Results]) -> None:
    """Raise `UsageError` if the suite's code that measured the cells is not the same."""
    for part in ("engine", "metrics"):
        known: dict[str, Path] = {}
        for source in sources:
            for record in source.records:
                if record.fingerprints is not None:
                    known.setdefault(getattr(record.fingerprints, part), source.folder)
        if len(known) > 1:
            first, second, *_ = known.values()
            where = f"{first} and {second} hold" if first != second else f"{first} holds"
            raise UsageError(
                f"{where} cells of different versions of the {part}; run all with one version"
            )


def _different_scenes(sources: Sequence[Results]) -> list[str]:
    known: dict[str, dict[str, Path]] = {}
    for source in sources:
        for record in source.records:
            if record.fingerprints is not None:
                known.setdefault(record.seen, {})[record.fingerprints.scene] = source.folder
    return [
        f"{scene} is not the same in {' and '.join(map(str, dict.fromkeys(found.values())))};"
        " compare its errors with care"
        for scene, found in known.items()
        if len(found) > 1
    ]


def _left_out(sources: Sequence[Results]) -> list[str]:
    found = (
        path
        for source in sources
        for path in sorted(source.folder.iterdir())
        if path.name not in _MERGED and not path.name.startswith(".") and path.is_dir()
    )
    return [f"{path} is not merged; it stays there" for path in found]


def _device(source: Results) -> str:
    """Return the name of the renderer, and of the processor that it runs on if it is software."""
    names = {record.gl.renderer for record in source.records if record.gl is not None}
    if len(names) > 1:
        raise UsageError(
            f"{source.folder} holds cells of {' and '.join(sorted(names))}; merge folders of runs"
        )
    cpu = source.facts.cpu
    return f"{source.renderer}, {cpu.model}" if source.software and cpu else source.renderer


def _write(folder: Path, group: Sequence[Results], notes: list[str]) -> int:
    """Write the results of one renderer; return the number of cells."""
    ordered = sorted(group, key=lambda source: source.facts.date)
    cells: dict[CellKey, tuple[Record, Results]] = {}
    double = 0
    for source in ordered:
        for record in source.records:
            known = cells.get(record.key)
            double += known is not None
            if known is None or record.finished or not known[0].finished:
                cells[record.key] = record, source
    if double:
        notes.append(f"{double} cells are in several folders; those of the newest run are kept")
    notes += _timed_apart(cells.values())
    facts = ordered[-1].facts
    methods = dict.fromkeys(name for source in ordered for name in source.facts.methods)
    with Store.open(folder) as store:
        store.write_run(msgspec.structs.replace(facts, methods=list(methods)))
        notes += _copy_images(cells.values(), folder)
        for record, _ in cells.values():
            store.append(record)
    return len(cells)


def _timed_apart(cells: Iterable[tuple[Record, Results]]) -> list[str]:
    """Return one line for each scene whose cells were not timed in the same rounds."""
    sources: dict[tuple[str, tuple[int, int]], dict[Path, None]] = {}
    for record, source in cells:
        if record.time is not None:
            sources.setdefault((record.seen, record.size), {})[source.folder] = None
    return [
        f"{scene} at {size[0]}x{size[1]} was timed in {' and in '.join(map(str, found))}, not in"
        " the same rounds; small differences of these times mean nothing"
        for (scene, size), found in sources.items()
        if len(found) > 1
    ]


def _copy_images(cells: Iterable[tuple[Record, Results]], folder: Path) -> list[str]:
    """Copy the images of cells; return one line for each that no folder has intact."""
    copied: set[str] = set()
    faults: dict[str, str] = {}
    for record, source in cells:
        for image in record.outcome.images.values() if record.outcome else ():
            if image.path in copied:
                continue
            try:
                path = stored.verify(source.folder, image)
            except UsageError as error:
                faults[image.path] = f"{error}; it is not copied"
                continue
            shutil.copyfile(path, folder / image.path)
            copied.add(image.path)
    return [fault for path, fault in faults.items() if path not in copied]
