"""Each figure of a paper is drawn from results of its cells, and says so if there are none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest

from oitbench.image import files, stored
from oitbench.measure.visibility import Curves
from oitbench.papers.listing import figures_of, read_papers
from oitbench.parameters import parse
from oitbench.places import own_folder
from oitbench.report import Figure, Note, Table
from oitbench.results.schema import COMPLEXITY, TRANSMITTANCE, Record
from oitbench.scene import FragmentLists
from tests.helpers import collection
from tests.papers.made_up import context, made
from tests.report.made_up import SIDE

FIGURES = sorted(figures_of(read_papers([own_folder()]).values()))
LAYERS = 7


def needed(folder: Path, name: str) -> list[Record]:
    """Return records of all cells that a figure needs, each with a map of its fragments."""
    found = []
    for number, need in enumerate(getattr(collection().reports[name], "needs", ())):
        record = made(folder, need, 0.02 * (number % 9))
        assert record.outcome is not None
        counts = np.full((SIDE, SIDE), LAYERS, np.int64)
        light = np.full((SIDE, SIDE, 3), 0.1, np.float32)
        images = {
            COMPLEXITY: stored.store(folder, f"images/{COMPLEXITY}", files.count_channels(counts)),
            TRANSMITTANCE: stored.store(
                folder, f"images/{TRANSMITTANCE}", files.image_channels(light)
            ),
        }
        values = dict.fromkeys(("nodes", "samples", "slices", "coefficients"), 8)
        statistics = msgspec.structs.replace(
            record.outcome.statistics, fragments=1000 * len(need.scene)
        )
        outcome = msgspec.structs.replace(
            record.outcome,
            images=record.outcome.images | images,
            parameters=values,
            statistics=statistics,
        )
        found.append(msgspec.structs.replace(record, outcome=outcome))
    return found


def measured(
    scene: str, pixel: tuple[int, int], methods: Sequence[str], size: tuple[int, int]
) -> Curves:
    """Return made-up curves: the exact one for all methods."""
    z = np.arange(1, LAYERS + 1, dtype=np.float32).reshape(-1, 1, 1)
    half = np.full_like(z, 0.5)
    fragments = FragmentLists(
        z, half, np.zeros((*z.shape, 3), np.float32), np.zeros((*z.shape, 3), np.float32)
    )
    exact = np.repeat(0.5 ** np.arange(LAYERS + 1.0)[:, None], 3, axis=1)
    names = {label: parse(label).name for label in methods}
    curves = dict.fromkeys(methods, exact)
    noise = dict.fromkeys(methods, np.zeros_like(exact))
    return Curves(scene, pixel, size, fragments, exact, curves, noise, names, {}, {})


@pytest.fixture(autouse=True)
def nothing_is_rendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace what figures draw or measure themselves."""
    srgb = np.full((SIDE, SIDE, 3), 0.5, np.float32)
    target = SimpleNamespace(picture=SimpleNamespace(srgb=srgb, text=""))
    monkeypatch.setattr("oitbench.matrix.targets.draw", lambda *names, **options: [target])
    monkeypatch.setattr("oitbench.papers.curves.measure", measured)


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_drawn_from_its_cells(name: str, tmp_path: Path) -> None:
    report = collection().reports[name]
    crops = {key: scene.crops for key, scene in collection().scenes.items()}
    shown = report.build(context(tmp_path, needed(tmp_path, name), crops))
    drawn = [item for item in shown if isinstance(item, Figure | Table)]
    assert drawn
    for item in drawn:
        assert "not in these results" not in item.caption
        assert "{" not in item.caption
        path = item.png if isinstance(item, Figure) else item.csv
        assert path.name.startswith(name) or path.parent.name == name
        assert path.stat().st_size > 100


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_says_that_results_lack_its_cells(name: str, tmp_path: Path) -> None:
    shown = collection().reports[name].build(context(tmp_path, []))
    text = " ".join(item.text if isinstance(item, Note) else item.caption for item in shown)
    assert "results" in text or "timed" in text
    assert "Reproduced" not in text
    assert "Not reproduced" not in text


@pytest.mark.parametrize(("noise", "word"), [(0.0, "Not reproduced"), (0.01, "Reproduced")])
def test_the_nearest_curve_is_that_of_least_error_with_noise(
    noise: float, word: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def noisy(*arguments: Any) -> Curves:
        found = measured(*arguments)
        shifts = dict(zip(found.methods, (0.05, 0.0, 0.2, 0.1), strict=True))
        values = {label: found.exact + shift for label, shift in shifts.items()}
        errors = found.noise | {arguments[2][1]: np.full_like(found.exact, noise)}
        return replace(found, methods=values, noise=errors)

    monkeypatch.setattr("oitbench.papers.curves.measure", noisy)
    crops = {key: scene.crops for key, scene in collection().scenes.items()}
    records = needed(tmp_path, "at_figure08")
    (figure,) = collection().reports["at_figure08"].build(context(tmp_path, records, crops))
    # The mean of 256 pixels has a sixteenth of the deviation of one.
    numbers = f"AT 0.0500, ST {16 * noise:.4f}, OSMT 0.2000, FOMT 0.1000"
    text = f"the curve of AT is nearest to the exact one (RMS error {numbers})"
    assert f"{word}: {text}." in figure.caption
