"""What the rows of other engines found: `engines/engines.json` of a results folder."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final, Literal

import msgspec
from msgspec import Struct

from oitbench.atomic import replacing, writing
from oitbench.image.stored import StoredImage
from oitbench.results.documents import read_document
from oitbench.results.times import Interval
from oitbench.views import MAIN, seen

VERSION: Final = 1
FOLDER, JSON = "engines", "engines.json"
PEER: Final = "peer"
"""Key of the scores of a row against the picture of its peer."""
Scores = dict[str, dict[str, float | None]]
"""Metrics by what a picture is compared with: a truth, or `PEER`."""


class _Typed(Struct, frozen=True, forbid_unknown_fields=True):
    """Base of all parts of the file."""


class Place(_Typed, frozen=True):
    """A view of a scene at one size, with all effects and the default shading; see `Cell`."""

    scene: str
    view: str = MAIN
    size: tuple[int, int] = (256, 256)
    ssaa: int = 1

    @property
    def seen(self) -> str:
        """The label of the scene with its view, unless that is the main one."""
        return seen(self.scene, self.view)


class Picture(_Typed, frozen=True):
    """A picture below the results folder, and its metrics against the truths of its scene."""

    image: StoredImage
    scores: Scores


class EngineRow(_Typed, frozen=True):
    """One algorithm of an engine in one place, beside the method of the suite that is its peer.

    `algorithm` is empty if the adapter could not tell any. `remark` says where the two differ.
    `ratio` is the time of a whole frame over that of the peer, without a unit, of frames drawn in
    turns; null if it was not timed. `renderer` draws the row and `peer_renderer` its peer: only if
    they are equal does the ratio compare algorithms alone.
    """

    place: Place
    engine: str
    algorithm: str
    peer: str
    status: Literal["ok", "skipped", "failed", "timeout"]
    reason: str = ""
    remark: str = ""
    version: str = ""
    renderer: str = ""
    peer_renderer: str = ""
    drawn: Picture | None = None
    peer_drawn: Picture | None = None
    ratio: Interval | None = None

    @property
    def label(self) -> str:
        """The row as tables name it, `ENGINE:ALGORITHM`."""
        return f"{self.engine}:{self.algorithm}" if self.algorithm else self.engine

    @property
    def key(self) -> tuple[Place, str]:
        """What distinguishes one row from another."""
        return self.place, self.label

    @property
    def same_renderer(self) -> bool:
        """Whether the row and its peer were drawn by the same renderer."""
        return bool(self.renderer) and self.renderer == self.peer_renderer


class EnginesFile(_Typed, frozen=True):
    """All rows of a results folder."""

    rows: list[EngineRow]
    schema: Literal[1] = VERSION


def read(folder: Path) -> list[EngineRow]:
    """Return the rows of a results folder; none if no engine was run there.

    Raises
    ------
    UsageError
        The file cannot be read, holds something else, or another version of the suite wrote it.
    """
    path = folder / FOLDER / JSON
    return read_document(path, EnginesFile, VERSION, "run --engine").rows if path.exists() else []


def write(folder: Path, rows: Iterable[EngineRow]) -> None:
    """Write the rows of a results folder, and remove pictures that they do not name.

    Raises
    ------
    StorageError
        The folder cannot be written to.
    """
    found = EnginesFile(list(rows))
    with replacing(folder / FOLDER / JSON) as partial:
        partial.write_bytes(msgspec.json.format(msgspec.json.encode(found), indent=1) + b"\n")
    pictures = [one for row in found.rows for one in (row.drawn, row.peer_drawn) if one]
    named = {picture.image.path for picture in pictures}
    with writing(folder / FOLDER):
        for path in (folder / FOLDER).glob("*.exr"):
            if f"{FOLDER}/{path.name}" not in named:
                path.unlink(missing_ok=True)
