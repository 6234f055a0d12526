"""Made-up cells and results folders, for tests of reports."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from oitbench.image import files, metrics, stored
from oitbench.image.files import Image
from oitbench.image.stored import StoredImage
from oitbench.report import ReportContext
from oitbench.results.records import Results
from oitbench.results.schema import (
    WHOLE,
    EffectNames,
    Memory,
    MemoryTerm,
    Nonfinite,
    Record,
    ReferenceFacts,
    Renderer,
    RunFacts,
    Scores,
    SharedShading,
    Status,
    Traffic,
    TrafficTerm,
    flip_image,
)
from oitbench.results.store import IMAGES
from oitbench.truths import EXACT, FULL, MATCHED
from tests.made_up import failed, outcome_of, record, timed, write

SIDE = 16
"""Width and height of all pictures, in pixels."""
FLOOR = 0.01
"""Noise floor of FLIP and RMSE."""
FACTS = RunFacts(
    gl=Renderer("llvmpipe (test)", version="4.5", software=True), seed=1, methods=["glow", "murk"]
)
EFFECTS = ("COVERAGE", "DIFFUSION", "SHADOWS", "TRANSLUCENT_SHADOWS", "COLORED_SHADOWS")


def unfinished(
    scene: str, method: str, status: Status = "failed", reason: str = "no", **fields: Any
) -> Record:
    """Return a record without numbers; `fields` are further fields of `Record`."""
    return failed(
        method,
        reason,
        scene=scene,
        status=status,
        **({"size": (SIDE, SIDE), "gl": FACTS.gl} | fields),
    )


def finished(
    folder: Path,
    scene: str,
    method: str,
    error: float,
    *,
    traced: bool = True,
    outcome: Mapping[str, Any] | None = None,
    **fields: Any,
) -> Record:
    """Return a record, and write its pictures, which differ from both truths by a factor.

    Parameters
    ----------
    folder : Path
        The results folder.
    scene, method : str
    error : float
        One minus the factor.
    traced : bool
        Whether there are traced truths.
    outcome : mapping
        Fields of `Outcome` that replace the made-up ones.
    **fields
        Fields of `Record` that replace the made-up ones.
    """
    median = 2 - error
    values: dict[str, Any] = {"time": timed(median), "size": (SIDE, SIDE), "gl": FACTS.gl}
    made = record(method, scene, **(values | fields))
    truth, picture = _pictures(error)
    evaluation = _compare(error)
    kinds = ["color", EXACT, flip_image(EXACT)]
    none = Scores(reason="no geometry")
    scores = {EXACT: Scores(evaluation.values), MATCHED: none, FULL: none}
    if traced:
        wanted = [MATCHED, FULL, *([WHOLE] if made.effects.startswith("-") else [])]
        for kind in wanted:
            kinds += [kind, flip_image(kind)]
            scores[kind] = _noisy(evaluation.values)
    images: dict[str, StoredImage] = {}
    for kind in kinds:
        if kind.startswith("flip_"):
            maps = evaluation.maps[metrics.FLIP_LDR], evaluation.maps[metrics.FLIP_HDR]
            channels = files.flip_channels(*maps)
        else:
            channels = files.image_channels(picture if kind == "color" else truth)
        images[kind] = stored.store(folder, f"{IMAGES}/{kind}", channels)
    made_up = msgspec.structs.replace(
        outcome_of(scores, images),
        memory=Memory(3072, 96, [MemoryTerm("a", 2048), MemoryTerm("b", 1024)]),
        traffic=Traffic(400, [TrafficTerm("gather", "a", "write", 100, 4, 400)]),
    )
    replaced = msgspec.structs.replace(made_up, **(outcome or {}))
    return msgspec.structs.replace(made, outcome=replaced)


def _noisy(values: dict[str, float | None]) -> Scores:
    """Return scores against a reference of eight parts."""
    floor: dict[str, float | None] = {metrics.FLIP_LDR: FLOOR, metrics.RMSE: FLOOR}
    flips = {name: values[name] or 0.0 for name in (metrics.FLIP_LDR, metrics.FLIP_HDR)}
    return Scores(
        values,
        floor,
        {name: [flip * (1 + 0.002 * (k - 3.5)) for k in range(8)] for name, flip in flips.items()},
        {name: 1.5 * flip for name, flip in flips.items()},
        {name: 0.5 * flip for name, flip in flips.items()},
        ReferenceFacts(8, 4, 8, True, 12.5),
    )


def unstable(folder: Path, scene: str, method: str) -> Record:
    """Return a record whose picture has a NaN, and therefore neither metrics nor maps."""
    made = finished(folder, scene, method, 0.2)
    assert made.outcome is not None
    outcome = made.outcome
    picture = files.read_exr(folder / outcome.images["color"].path)
    picture[3, 3] = np.nan
    images = {kind: path for kind, path in outcome.images.items() if not kind.startswith("flip_")}
    images["color"] = stored.store(folder, f"{IMAGES}/color", files.image_channels(picture))
    nothing = Scores(dict.fromkeys(metrics.NAMES))
    changed = msgspec.structs.replace(
        outcome,
        nonfinite=Nonfinite(**metrics.count_nonfinite(picture)),
        scores={EXACT: nothing, MATCHED: nothing, FULL: nothing},
        images=images,
    )
    return msgspec.structs.replace(made, status="unstable", reason="1 NaN pixel", outcome=changed)


def with_effects(
    folder: Path,
    method: str,
    error: float,
    *,
    effects: str = "requested",
    gone: Iterable[str] = (),
    missing: Iterable[str] = (),
    ms: float = 10.0,
    shadow_maps: int = 2**20,
) -> Record:
    """Return a record of a scene that requests `EFFECTS`.

    Parameters
    ----------
    folder, method, error
        As in `finished`.
    effects : str
        Setting of the cell.
    gone, missing : iterable of str
        Effects that the setting leaves out, and effects that the method cannot express.
    ms : float
        Method time.
    shadow_maps : int
        Bytes of shared shading.
    """
    requested = [name for name in EFFECTS if name not in set(gone)]
    outcome = {
        "effects": EffectNames(requested, requested, list(missing)),
        "shading": shading(shadow_maps),
    }
    # Opposite swings give the difference of two cells an interval.
    time = timed(ms, -0.1 if effects.startswith("-") else 0.1)
    return finished(folder, "panes", method, error, effects=effects, time=time, outcome=outcome)


def shading(count: int) -> SharedShading:
    """Return accounts of shadow maps with that many bytes of memory."""
    return SharedShading(Memory(count, 0.0, [MemoryTerm("shadow maps", count)]), Traffic(0, []))


def store(folder: Path, *records: Record) -> Path:
    """Write a results folder with facts, and return it."""
    return write(folder, records, FACTS)


def context(folder: Path, records: Iterable[Record], out: Path) -> ReportContext:
    """Return the context of a report of those records, whose pictures are in `folder`."""
    return ReportContext(Results(folder, tuple(records), FACTS), out)


@cache
def _pictures(error: float) -> tuple[Image, Image]:
    truth = np.random.default_rng(5).random((SIDE, SIDE, 3), dtype=np.float32)
    return truth, truth * np.float32(1 - error)


@cache
def _compare(error: float) -> metrics.Evaluation:
    truth, picture = _pictures(error)
    return metrics.compare(truth, picture, 0.0)


def words(pdf: Path) -> list[str]:
    """Return the words of a PDF file of one page."""
    from pypdfium2 import PdfDocument

    with PdfDocument(pdf) as document:
        text: str = document[0].get_textpage().get_text_range()
    return text.split()
