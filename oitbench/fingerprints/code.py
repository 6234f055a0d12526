"""Fingerprints of the code that determines a result, by the text of its sources."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from oitbench.fingerprints.sources import sources_digest
from oitbench.method.declaration import Method

_PACKAGE = Path(__file__).resolve().parents[1]
_ENGINE = (
    "effects.py", "gl", "image/files.py", "matrix/bench.py", "matrix/cell.py",
    "matrix/plain_frames.py", "matrix/scoring.py", "matrix/stage.py", "measure", "method",
    "parameters.py", "scene", "shading.py", "truths.py",
)  # fmt: skip
"""Sources that can change a pixel or a count. What scenes are built with is not among them, because
a scene's fingerprint covers the result."""
_TIMING = (
    "matrix/timed_cells.py", "measure/agreement.py", "measure/clock.py", "measure/disturbance.py",
    "measure/intervals.py", "measure/rounds.py", "measure/timing.py",
)  # fmt: skip
"""Further sources, which can change times alone."""
_METRICS = ("image/metrics.py", "image/ties.py")
_METRIC_PACKAGES = ("flip-evaluator", "scikit-image")
PACKAGES = (
    "oitbench",
    "mitsuba",
    "drjit",
    "moderngl",
    "numpy",
    "scikit-image",
    "flip-evaluator",
    "OpenEXR",
)
"""Packages whose versions can change a result."""
_SOURCES = (".py", ".glsl")
_PROSE = (".md", ".rst")


def method_fingerprint(method: Method) -> str:
    """Return a digest of a method's parameters and of all sources in its folders."""
    files = {
        f"{number}/{path.relative_to(folder).as_posix()}": path
        for number, folder in enumerate(method.folders)
        for path in _method_files(folder)
    }
    values = json.dumps(method.values, sort_keys=True)
    return _combined(method.name, values, sources_digest(files))


@cache
def engine_fingerprint() -> str:
    """Return a digest of the suite's own sources that can change a picture or a count."""
    times = _own_files(_TIMING)
    files = _own_files(_ENGINE)
    return sources_digest({name: path for name, path in files.items() if name not in times})


@cache
def timing_fingerprint() -> str:
    """Return a digest of the suite's own sources that can change times, but no picture."""
    return sources_digest(_own_files(_TIMING))


@cache
def metrics_fingerprint() -> str:
    """Return a digest of the sources of the metrics, and of the packages that compute them."""
    versions = [f"{name} {package_version(name)}" for name in _METRIC_PACKAGES]
    return _combined(sources_digest(_own_files(_METRICS)), *versions)


def package_version(name: str) -> str | None:
    """Return the version of an installed package, or None."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _method_files(folder: Path) -> Iterator[Path]:
    """Yield sources at any depth, and all other files beside `method.py`, such as tables.

    Results that a user keeps in a folder below are not part of the method.
    """
    for path in folder.rglob("*"):
        parts = path.relative_to(folder).parts
        if any(part.startswith((".", "__pycache__")) for part in parts) or not path.is_file():
            continue
        if path.suffix in _SOURCES or (len(parts) == 1 and path.suffix not in _PROSE):
            yield path


def _own_files(names: tuple[str, ...]) -> dict[str, Path]:
    found: list[Path] = []
    for name in names:
        path = _PACKAGE / name
        found += [path] if path.is_file() else [p for p in path.rglob("*") if p.suffix in _SOURCES]
    return {path.relative_to(_PACKAGE).as_posix(): path for path in found}


def _combined(*parts: str) -> str:
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:32]
