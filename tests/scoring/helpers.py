"""Results folders with images that no renderer made, and files of metrics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from oitbench.image import files, metrics, stored
from oitbench.image.files import Image
from oitbench.results.schema import Record, RunFacts, Scores, flip_image
from oitbench.results.store import CELLS, IMAGES, read_cells
from oitbench.scoring.folder import score_folder
from oitbench.scoring.scorer import Findings, Scorer
from oitbench.truths import EXACT, MATCHED
from oitbench.workers import memory
from tests.made_up import FACTS, changed, record, write

EXPOSURE = 1.0
SHAPE = (16, 12, 3)
MAE = '''
"""Mean absolute error."""
import numpy as np

name = "mae_lin"
higher_is_better = False
tolerance = 1e-3
relative_tolerance = 0.5


def measure(reference, test, exposure):
    return np.abs(test - reference).mean()
'''
"""The file of a metric that works."""


def picture(seed: int) -> Image:
    """Return an image whose values no half float can represent."""
    return np.random.default_rng(seed).random(SHAPE).astype(np.float32)


def write_cell(folder: Path, method: str, image: Image, **fields: Any) -> Record:
    """Return the record of a cell whose images are stored, scored as a run does."""
    images, scores = {"color": _store(folder, "color", image)}, {}
    for kind, seed in ((EXACT, 1), (MATCHED, 2)):
        truth = picture(seed)
        images[kind] = _store(folder, kind, truth)
        found = metrics.compare(truth, image, EXPOSURE)
        if found.maps:
            maps = files.flip_channels(found.maps[metrics.FLIP_LDR], found.maps[metrics.FLIP_HDR])
            images[flip_image(kind)] = stored.store(folder, f"{IMAGES}/{flip_image(kind)}", maps)
        scores[kind] = Scores(
            {**found.values, metrics.TRANSMITTANCE: 0.25},
            noise_floor={metrics.FLIP_LDR: 0.125},
            jackknife={metrics.FLIP_LDR: [0.5] * 8},
            transparent={metrics.FLIP_LDR: 0.75},
        )
    made = changed(record(method, **fields), "outcome.images", images)
    made = changed(made, "outcome.exposure", EXPOSURE)
    found_record: Record = changed(made, "outcome.scores", scores)
    return found_record


def _store(folder: Path, kind: str, image: Image) -> stored.StoredImage:
    return stored.store(folder, f"{IMAGES}/{kind}", files.image_channels(image))


def write_results(
    folder: Path,
    methods: tuple[str, ...] = ("mean", "peel"),
    facts: RunFacts = FACTS,
    **fields: Any,
) -> Path:
    """Write a results folder with one cell for each method, and return it."""
    (folder / IMAGES).mkdir(parents=True)
    cells = [
        write_cell(folder, name, picture(seed), gl=facts.gl, **fields)
        for seed, name in enumerate(methods, start=3)
    ]
    return write(folder, cells, facts)


def read(folder: Path) -> list[Record]:
    """Return the cells of a folder."""
    return list(read_cells(folder / CELLS).values())


def write_metric(folder: Path, text: str = MAE, name: str = "metric.py") -> Path:
    """Write the file of a metric, and return its path."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def opened(*paths: Path, timeout: float | None = 60.0) -> Scorer:
    """Return a scorer with the metrics of some files."""
    return Scorer(paths, memory.share(1), timeout)


def score(folder: Path, *paths: Path, built_in: bool = False) -> Findings:
    """Score a folder with the metrics of some files."""
    with opened(*paths) as scorer:
        return score_folder(folder, scorer, built_in=built_in)
