"""A small matrix in processes of its own, and ways to harm it; for `drills.py`."""

from __future__ import annotations

import itertools
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import psutil

from oitbench.image import files, stored
from oitbench.results.store import IMAGES, Store
from tests.made_up import FACTS, changed, record

SCENES = ("layer_stack[count=3]", "glass_bars")
METHODS = ("alpha_blend", "a_buffer", "weighted_blended")
SETTINGS = ("--size", "16x16", "--ssaa", "1")
WORKERS = {"quick": "2", "guard": "1"}
SECONDS = 300.0
"""Time in which each run must end."""


def command(folder: Path, preset: str) -> list[str]:
    """Return the command line of a run of the small matrix."""
    chosen = [argument for scene in SCENES for argument in ("--scene", scene)]
    chosen += [argument for method in METHODS for argument in ("--method", method)]
    return [
        sys.executable,
        "-m",
        "oitbench",
        "run",
        "--preset",
        preset,
        *SETTINGS,
        *chosen,
        "--out",
        str(folder),
    ]


def start(folder: Path, cache: Path, preset: str) -> subprocess.Popen[str]:
    """Start a run, and return its process."""
    return subprocess.Popen(
        [*command(folder, preset), "--workers", WORKERS[preset]],
        env={**os.environ, "XDG_CACHE_HOME": str(cache), "COLUMNS": "200"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def run(folder: Path, cache: Path, preset: str) -> subprocess.CompletedProcess[str]:
    """Run the small matrix to its end."""
    process = start(folder, cache, preset)
    _, error = process.communicate(timeout=SECONDS)
    return subprocess.CompletedProcess([], process.returncode, "", error)


def write_until_killed(folder: Path, seconds: float) -> set[str]:
    """Let a forked process write cells and images, kill it, and return the cells it confirmed.

    Parameters
    ----------
    folder : Path
        A results folder.
    seconds : float
        Time after which the process is killed.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        with Store.open(folder) as store:
            for number in itertools.count(len(store.records())):
                picture = np.full((4, 4, 3), number, dtype=np.float32)
                image = stored.store(folder, f"{IMAGES}/color", files.image_channels(picture))
                store.append(changed(record(f"m{number}"), "outcome.images.color", image))
                os.write(writing, f"m{number}\n".encode())
                if number % 4 == 3:
                    store.compact()
                    store.write_run(FACTS)
    os.close(writing)
    time.sleep(seconds)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    with os.fdopen(reading) as lines:
        return set(lines.read().split())


def strike(process: subprocess.Popen[str], action: str, chance: random.Random) -> bool:
    """Kill, terminate or interrupt a process or one of its workers; return whether it still ran."""
    if action == "kill worker":
        try:
            workers = psutil.Process(process.pid).children()
        except psutil.Error:
            return False
        if not workers:
            return False
        chance.choice(workers).kill()
        return True
    if process.poll() is not None:
        return False
    numbers = {"kill": signal.SIGKILL, "terminate": signal.SIGTERM, "interrupt": signal.SIGINT}
    process.send_signal(numbers[action.partition(" ")[0]])
    return True


def is_worker_of(process: psutil.Process, pid: int) -> bool:
    """Return whether a process is a worker of a run that has ended."""
    try:
        return "oitbench.matrix.worker" in process.cmdline() and process.ppid() in (1, pid)
    except psutil.Error:
        return False


def damage(path: Path, chance: random.Random) -> str:
    """Damage a file in one of several ways; return the way."""
    whole = path.read_bytes()
    kind = chance.choice(("flip", "flip", "flip", "cut", "zeros", "garbage", "remove", "insert"))
    at = chance.randrange(len(whole))
    if kind == "flip":
        changed = bytearray(whole)
        changed[at] ^= 1 << chance.randrange(8)
    elif kind == "cut":
        changed = bytearray(whole[:at])
    elif kind == "zeros":
        changed = bytearray(whole)
        length = min(chance.randrange(1, 4096), len(whole) - at)
        changed[at : at + length] = bytes(length)
    elif kind == "garbage":
        changed = bytearray(chance.randbytes(len(whole)))
    elif kind == "insert":
        changed = bytearray(whole[:at] + chance.randbytes(3) + whole[at:])
    else:
        path.unlink()
        return kind
    path.write_bytes(changed)
    return f"{kind} at {at}" if changed != whole else "unchanged"


@contextmanager
def small_disk(folder: Path, size: int) -> Iterator[None]:
    """Mount a file system in memory of some KiB."""
    folder.mkdir(exist_ok=True)
    options = f"size={size}k"
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "drill", str(folder)], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True)
