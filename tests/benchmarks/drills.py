"""Kill runs, damage files, fill disks; nothing may get lost and nothing wrong be believed.

    python -m tests.benchmarks.drills FOLDER [--kills N] [--writers N] [--damages N] [--pairs N]
        [--disks N] [--seed N] [--preset quick|guard]

FOLDER is created; a drill needs some megabytes. Without options, all drills run with their
default numbers, which takes about an hour. Full disks are small file systems in memory, which
only root can mount. The exit code is 1 if a drill finds a fault; each is printed as one line.
"""

from __future__ import annotations

import argparse
import json
import logging
import random
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
import psutil

from oitbench.errors import OitbenchError
from oitbench.image import stored
from oitbench.path_traced.references import storage
from oitbench.results import baseline
from oitbench.results.records import Results
from oitbench.results.schema import CellKey, Outcome, Record
from oitbench.results.store import CELLS, IMAGES, RUN, read_cells, read_run
from oitbench.truths import FULL
from tests.benchmarks.harm import (
    METHODS,
    SCENES,
    SECONDS,
    damage,
    is_worker_of,
    run,
    small_disk,
    start,
    strike,
    write_until_killed,
)

T = TypeVar("T")
MANY = 200
"""Cells with which a folder of the writers begins anew."""
STARTING = 2.0
"""Seconds in which Python itself may still be starting, which answers signals in its own way."""
ACTIONS = ("kill main", "kill worker", "terminate main", "interrupt main")


def main() -> None:
    """Run the drills that were asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path)
    numbers = {"kills": 200, "writers": 200, "damages": 100, "pairs": 10, "disks": 10}
    for name in numbers:
        parser.add_argument(f"--{name}", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--preset", default="quick", choices=("quick", "guard"))
    given = parser.parse_args()
    chosen = {name: getattr(given, name) for name in numbers}
    if all(number is None for number in chosen.values()):
        chosen = dict(numbers)
    logging.disable(logging.WARNING)  # One warning for each damaged file is expected.
    drill = Drill(given.folder, given.seed, given.preset)
    for name, number in chosen.items():
        if number:
            getattr(drill, name)(number)
    print(f"{len(drill.faults)} faults")
    sys.exit(1 if drill.faults else 0)


class Drill:
    """All drills; they share a finished run, whose records are right.

    Parameters
    ----------
    folder : Path
    seed : int
        Seed of everything that happens at random.
    preset : str
        "quick", or "guard", whose runs neither need references nor measure times.
    """

    def __init__(self, folder: Path, seed: int, preset: str) -> None:
        self.preset = preset
        self.folder, self.random = folder, random.Random(seed)
        self.faults: list[str] = []
        self.right = folder / "right"
        self.cache = folder / "cache"
        folder.mkdir(parents=True, exist_ok=True)
        for _ in range(2):  # The first run renders the references.
            shutil.rmtree(self.right, ignore_errors=True)
            begin = time.monotonic()
            done = run(self.right, self.cache, self.preset)
            self.seconds = time.monotonic() - begin
            assert done.returncode == 0, done.stderr
        self.expected = {key: content(r) for key, r in read_cells(self.right / CELLS).items()}
        assert len(self.expected) == len(SCENES) * len(METHODS)
        print(f"a whole run takes {self.seconds:.1f} s")

    def fault(self, text: str) -> None:
        """Note a fault."""
        self.faults.append(text)
        print(f"FAULT {text}", flush=True)

    def check_folder(self, folder: Path, owner: str) -> set[CellKey]:
        """Check that whatever is believed in a folder is right; return the finished cells."""
        finished = {key: r for key, r in read_cells(folder / CELLS).items() if r.finished}
        for key, record in finished.items():
            if content(record) != self.expected[key]:
                self.fault(f"{owner}: {key} is believed and wrong")
            for image in record.outcome.images.values() if record.outcome else ():
                try:
                    stored.verify(folder, image)
                except OitbenchError as error:
                    self.fault(f"{owner}: {error}")
        return set(finished)

    def complete(self, folder: Path, owner: str) -> None:
        """Run a folder to its end, and check that it equals the right one."""
        done = run(folder, self.cache, self.preset)
        if done.returncode != 0:
            self.fault(f"{owner}: the next run ends with {done.returncode}: {done.stderr[-300:]}")
        if self.check_folder(folder, owner) != self.expected.keys():
            self.fault(f"{owner}: cells are lost")
        named = {
            image.path
            for record in read_cells(folder / CELLS).values()
            for image in (record.outcome.images.values() if record.outcome else ())
        }
        found = {f"{IMAGES}/{path.name}" for path in (folder / IMAGES).iterdir()}
        if found != named or {path.name for path in folder.iterdir()} != {CELLS, RUN, IMAGES}:
            self.fault(f"{owner}: files are left over")

    def kills(self, count: int) -> None:
        """Kill the main process or a worker at random moments, and go on with the same folder."""
        folder = self.folder / "killed"
        done: Counter[str] = Counter()
        rounds = 0
        shutil.rmtree(folder, ignore_errors=True)
        before: set[CellKey] = set()
        while done.total() < count:
            action = self.random.choice(ACTIONS)
            delay = self.random.uniform(0.0, self.seconds)
            owner = f"kill {done.total() + 1} ({action} after {delay:.2f} s)"
            process = start(folder, self.cache, self.preset)
            time.sleep(delay)
            hit = strike(process, action, self.random)
            try:
                _, error = process.communicate(timeout=SECONDS)
            except subprocess.TimeoutExpired:
                self.fault(f"{owner}: the run does not end")
                process.kill()
                continue
            if hit:
                done[action] += 1
                if done.total() % 10 == 0:
                    print(f"kills: {dict(done)}", flush=True)
            if "Traceback" in error and delay > STARTING:
                self.fault(f"{owner}: {error[-300:]}")
            codes = {"kill main": {-9}, "terminate main": {143, -15}, "interrupt main": {130, -2}}
            if hit and process.returncode not in codes.get(action, {0, 1}) | {0, 1}:
                self.fault(f"{owner}: exit code {process.returncode}: {error[-300:]}")
            self.check_orphans(process.pid, owner)
            after = self.check_folder(folder, owner)
            if not before <= after:
                self.fault(f"{owner}: {len(before - after)} finished cells are lost")
            before = after
            if len(after) == len(self.expected) and process.returncode == 0:
                self.complete(folder, owner)
                shutil.rmtree(folder)
                before, rounds = set(), rounds + 1
        self.complete(folder, "after all kills")
        print(f"kills: {dict(done)}; {rounds + 1} folders completed", flush=True)

    def writers(self, count: int) -> None:
        """Kill a process that writes nothing but cells, images and run facts, at random moments."""
        folder = self.folder / "written"
        shutil.rmtree(folder, ignore_errors=True)
        confirmed: set[str] = set()
        for number in range(count):
            confirmed |= write_until_killed(folder, self.random.uniform(0.0, 0.3))
            cells = read_cells(folder / CELLS)
            if lost := confirmed - {record.method for record in cells.values()}:
                self.fault(f"writer {number}: {len(lost)} confirmed cells are lost")
            for record in cells.values():
                for image in record.outcome.images.values() if record.outcome else ():
                    stored.verify(folder, image)
            if len(cells) > MANY:
                shutil.rmtree(folder)
                confirmed = set()
        print(f"writers: {count} kills", flush=True)

    def check_orphans(self, pid: int, owner: str) -> None:
        """Check that no process of a run is left some seconds after its end."""
        deadline = time.monotonic() + 5
        while left := [p.pid for p in psutil.process_iter() if is_worker_of(p, pid)]:
            if time.monotonic() > deadline:
                self.fault(f"{owner}: processes are left: {left}")
                return
            time.sleep(0.05)

    def damages(self, count: int) -> None:
        """Damage each kind of file; damage must be noticed, or not change what is read."""
        for kind, check in (
            ("cells.jsonl", self._damage_cells),
            ("run.json", self._damage_run),
            ("image", self._damage_image),
            ("reference", self._damage_reference),
            ("manifest", self._damage_manifest),
            ("baseline", self._damage_baseline),
        ):
            results = Counter(check() for _ in range(count))
            print(f"damage: {kind}: {dict(results)}", flush=True)
        for number in range(max(1, count // 10)):
            folder = self._copy()
            paths = [folder / CELLS, folder / RUN, *sorted((folder / IMAGES).iterdir())]
            path = self.random.choice(paths)
            how = damage(path, self.random)
            self.complete(folder, f"damage {number}: {path.name} {how}")
        print(f"damage: {max(1, count // 10)} folders repaired by the next run", flush=True)

    def _copy(self) -> Path:
        folder = self.folder / "damaged"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.right, folder)
        return folder

    def _damage_cells(self) -> str:
        folder = self._copy()
        how = damage(folder / CELLS, self.random)
        found, error = attempt(lambda: Results.load(folder).records)
        records = {} if found is None else {record.key: content(record) for record in found}
        for key, value in records.items():
            if self.expected.get(key) != value:
                self.fault(f"cells.jsonl {how}: {key} is believed and wrong")
        return error or ("unchanged" if records == self.expected else "noticed")

    def _damage_run(self) -> str:
        folder = self._copy()
        right = read_run(folder / RUN)
        how = damage(folder / RUN, self.random)
        facts, error = attempt(lambda: read_run(folder / RUN))
        if facts not in (right, None):
            self.fault(f"run.json {how}: believed and wrong")
        if Results.load(folder).renderer != (right.renderer if right else ""):
            self.fault(f"run.json {how}: the renderer is lost")
        return error or ("unchanged" if facts == right else "noticed")

    def _damage_image(self) -> str:
        folder = self._copy()
        path = self.random.choice(sorted((folder / IMAGES).iterdir()))
        whole = path.read_bytes()
        how = damage(path, self.random)
        loaded = Results.load(folder)
        for record in loaded.records:
            for kind, image in (record.outcome.images if record.outcome else {}).items():
                fault = loaded.fault(record, kind)
                is_damaged = folder / image.path == path and how != "unchanged"
                if bool(fault) != is_damaged or "\n" in fault:
                    self.fault(f"{path.name} {how}: {kind} of {record.key}: '{fault}'")
        return "unchanged" if path.is_file() and path.read_bytes() == whole else "noticed"

    def _reference(self) -> Path:
        folder = self.folder / "references"
        shutil.rmtree(folder, ignore_errors=True)
        (manifest,) = list(self.cache.rglob("glass_bars@*.full.mean-*.exr"))[:1]
        shutil.copytree(manifest.parent, folder)
        return folder

    def _check_reference(self, folder: Path, path: Path) -> str:
        key = storage.reference_key("glass_bars", (16, 16), FULL)
        right = storage.read(folder, key)
        how = damage(path, self.random)
        found, error = attempt(lambda: storage.read(folder, key))
        if found is not None and right is not None:
            same = np.array_equal(found.mean, right.mean) and found.noise_floor == right.noise_floor
            if not same or found.rendering != right.rendering:
                self.fault(f"{path.name} {how}: believed and wrong")
        return error or ("noticed" if found is None else "unchanged")

    def _damage_reference(self) -> str:
        folder = self._reference()
        return self._check_reference(folder, self.random.choice(sorted(folder.glob("*.exr"))))

    def _damage_manifest(self) -> str:
        folder = self._reference()
        return self._check_reference(folder, folder / storage.MANIFEST)

    def _damage_baseline(self) -> str:
        path = self.folder / "baseline.json"
        right = baseline.save(self.right, path)
        how = damage(path, self.random)
        found, error = attempt(lambda: baseline.read(path))
        if found is not None and dict(found.rows) != json.loads(json.dumps(dict(right.rows))):
            self.fault(f"baseline {how}: believed and wrong")
        return error or "unchanged"

    def pairs(self, count: int) -> None:
        """Start two runs in one folder at once: one is refused in one line, the other is whole."""
        codes: Counter[str] = Counter()
        for number in range(count):
            folder = self.folder / "shared"
            shutil.rmtree(folder, ignore_errors=True)
            two = [start(folder, self.cache, self.preset)]
            time.sleep(self.random.uniform(0.0, 0.8 * self.seconds))
            two.append(start(folder, self.cache, self.preset))
            errors = [process.communicate(timeout=SECONDS)[1] for process in two]
            ended = sorted(
                (process.returncode, error) for process, error in zip(two, errors, strict=True)
            )
            codes[f"exit codes {ended[0][0]} and {ended[1][0]}"] += 1
            if [code for code, _ in ended] not in ([0, 0], [0, 2]):
                self.fault(f"pair {number}: {ended}")
            elif ended[1][0] == 2 and (
                ended[1][1].count("\n") != 1 or "is in use by process" not in ended[1][1]
            ):
                self.fault(f"pair {number}: the refusal is {ended[1][1]!r}")
            self.complete(folder, f"pair {number}")
        print(f"pairs: {dict(codes)}", flush=True)

    def disks(self, count: int) -> None:
        """Run on file systems of different sizes, each too small, and then make it large."""
        folder = self.folder / "disk"
        needed = sum(-(-p.stat().st_size // 4096) * 4 for p in self.right.rglob("*") if p.is_file())
        ends: Counter[str] = Counter()
        for number in range(count):
            # The largest one is only too small for the last file, which needs its place twice.
            size = max(4, round(needed * (number + 1) / count))
            with small_disk(folder, size):
                cache = self.cache if number % 2 else folder / "cache"
                done = run(folder / "out", cache, self.preset)
                errors = done.stderr.splitlines()
                ends[f"exit code {done.returncode}"] += 1
                if done.returncode == 2 and (
                    len(errors) != 1 or "free some space" not in errors[0]
                ):
                    self.fault(f"disk of {size} KiB: {done.stderr[-500:]!r}")
                elif done.returncode not in (0, 2):
                    self.fault(f"disk of {size} KiB: {done.returncode}: {done.stderr[-500:]}")
                if (folder / "out").is_dir():
                    self.check_folder(folder / "out", f"disk of {size} KiB")
                subprocess.run(["mount", "-o", "remount,size=64m", str(folder)], check=True)
                self.complete(folder / "out", f"disk of {size} KiB")
        print(f"disks: {dict(ends)}, of {needed} KiB", flush=True)


def content(record: Record) -> tuple[str, Outcome | None]:
    """Return what two runs of one cell have in common."""
    return record.status, record.outcome


def attempt(read: Callable[[], T]) -> tuple[T | None, str]:
    """Return what a function reads, or that it refuses in one line."""
    try:
        return read(), ""
    except OitbenchError as error:
        return None, "refused" if "\n" not in str(error) else "refused in several lines"


if __name__ == "__main__":
    main()
