"""The version of the path tracer: nobody may change a picture and forget to raise it."""

from __future__ import annotations

import json
from pathlib import Path

from oitbench import path_traced
from oitbench.fingerprints.sources import sources_digest
from oitbench.path_traced.version import TRACER

STORED = Path(__file__).with_name("tracer.json")
"""The version, and the digest of the sources of that version."""


def current() -> dict[str, int | str]:
    """Return the version and the digest of this checkout; references are stored by other code."""
    folder = Path(path_traced.__file__).parent
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*.py")}
    drawing = {name: path for name, path in files.items() if not name.startswith("references/")}
    return {"tracer": TRACER, "sources": sources_digest(drawing)}


def test_the_version_belongs_to_these_sources() -> None:
    assert json.loads(STORED.read_text(encoding="utf-8")) == current(), (
        "the path tracer has changed: raise TRACER in oitbench/path_traced/version.py if a picture"
        " changes, and in any case run 'python -m tests.path_traced.test_version'"
    )


if __name__ == "__main__":
    STORED.write_text(json.dumps(current(), indent=1) + "\n", encoding="utf-8")
