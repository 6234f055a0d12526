"""The ladder of truths: parts of squared errors, and what is said of them."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.image import files, metrics, stored
from oitbench.report import ladder_words
from oitbench.report.artifacts import Figure, Table
from oitbench.report.ladder import COMPOSITING, CROSS, EFFECTS, SHADING, Ladder, split
from oitbench.results.pictures import PICTURE, REDUCED, REDUCED_EXACT
from oitbench.results.schema import EffectNames, Record
from oitbench.results.store import IMAGES
from oitbench.truths import EXACT, FULL, MATCHED
from reports import ladder as report
from tests.report import made_up
from tests.report.made_up import SIDE, context, finished

SHAPE = (SIDE, SIDE, 3)


def cell(
    folder: Path, method: str, levels: dict[str, float], floor: float = 0.0, expressed: str = ""
) -> Record:
    """Return a cell whose pictures, by their kinds, have one level each."""
    made = finished(folder, "panes", method, 0.3)
    assert made.outcome is not None
    images = {kind: image for kind, image in made.outcome.images.items() if kind == "complexity"}
    for kind, level in levels.items():
        channels = files.image_channels(np.full(SHAPE, level, np.float32))
        images[kind] = stored.store(folder, f"{IMAGES}/{kind}", channels)
    scores = {
        truth: msgspec.structs.replace(known, noise_floor={metrics.RMSE: floor})
        for truth, known in made.outcome.scores.items()
    }
    same = levels.get(PICTURE) == levels.get(EXACT)
    compared = scores[EXACT].metrics | {metrics.RMSE: 0.0 if same else 0.1}
    scores[EXACT] = msgspec.structs.replace(scores[EXACT], metrics=compared)
    names = EffectNames(["COVERAGE"], ["COVERAGE", *filter(None, [expressed])], [])
    outcome = msgspec.structs.replace(made.outcome, images=images, scores=scores, effects=names)
    return msgspec.structs.replace(made, outcome=outcome)


def ladder(folder: Path, *cells: Record) -> Ladder:
    found = context(folder, cells, folder)
    (panel,) = found.results.panels()
    return Ladder(found, panel)


def words(found: Ladder) -> str:
    return ladder_words.words(found).replace("\N{NO-BREAK SPACE}", " ")


LEVELS = {PICTURE: 0.1, EXACT: 0.2, MATCHED: 0.4, FULL: 0.8}


@pytest.mark.parametrize("count", [3, 4])
def test_the_parts_of_random_pictures_add_up(count: int) -> None:
    random = np.random.default_rng(7)
    pictures = [random.random((33, 17, 3)) for _ in range(count)]
    found = split(pictures, [0.0] * count)
    assert found.total == pytest.approx(((pictures[0] - pictures[-1]) ** 2).mean(), rel=1e-14)
    assert sum(found.parts.values()) == pytest.approx(found.total, rel=1e-13)
    assert found.parts[COMPOSITING] == ((pictures[0] - pictures[1]) ** 2).mean()
    assert abs(found.parts[CROSS]) > 0.01


def test_noise_is_subtracted_from_each_part() -> None:
    """Parts of noisy truths are those of the truths without noise, on average."""
    random = np.random.default_rng(11)
    clean = [random.random((400, 300, 3)) for _ in range(4)]
    deviations = (0.0, 0.0, 0.2, 0.3)
    noisy = [
        p + d * random.standard_normal(p.shape) for p, d in zip(clean, deviations, strict=True)
    ]
    expected, found = split(clean, [0.0] * 4), split(noisy, [d**2 for d in deviations])
    assert sum(found.parts.values()) == pytest.approx(found.total, abs=1e-12)
    for name, part in expected.parts.items():
        assert found.parts[name] == pytest.approx(part, abs=3e-3)
    assert found.noise == pytest.approx(0.13)


def test_a_cell_is_split_at_its_stored_pictures(tmp_path: Path) -> None:
    found = ladder(tmp_path, cell(tmp_path, "murk", LEVELS)).splits["murk"]
    assert found.total == pytest.approx(0.49, rel=1e-6)
    expected = {COMPOSITING: 0.01, EFFECTS: 0.04, SHADING: 0.16, CROSS: 0.28}
    assert found.parts == pytest.approx(expected, rel=1e-5)
    assert found.shares[SHADING] == pytest.approx(0.16 / 0.49, rel=1e-5)


def test_without_full_tracing_the_ladder_ends_at_matched(tmp_path: Path) -> None:
    made = cell(tmp_path, "murk", {k: v for k, v in LEVELS.items() if k != FULL})
    found = ladder(tmp_path, made)
    split_ = found.splits["murk"]
    assert (found.last, split_.parts[SHADING]) == (MATCHED, 0.0)
    assert split_.total == pytest.approx(0.09, rel=1e-5)
    assert "shading" not in ladder_words.words(found)


def test_reduced_pictures_are_compared_with_each_other(tmp_path: Path) -> None:
    """The picture and exact compositing are split at the size of the traced truths."""
    levels = LEVELS | {PICTURE: 0.9, EXACT: 0.95, REDUCED: 0.15}
    murk = cell(tmp_path, "murk", levels)
    assert not ladder(tmp_path, murk).splits
    murk = cell(tmp_path, "murk", levels | {REDUCED_EXACT: 0.25})
    found = ladder(tmp_path, murk).splits["murk"]
    assert found.parts[COMPOSITING] == pytest.approx(0.01, rel=1e-5)
    assert found.parts[EFFECTS] == pytest.approx(0.15**2, rel=1e-5)


def test_noise_and_small_errors_have_no_shares(tmp_path: Path) -> None:
    noisy = ladder(tmp_path, cell(tmp_path, "murk", LEVELS, floor=0.6)).splits["murk"]
    assert noisy.shares == {}
    small = split([np.full(SHAPE, level) for level in (0.5, 0.501, 0.5015)], [0.0] * 3)
    assert small.shares == {}


def test_words_say_what_an_error_consists_of(tmp_path: Path) -> None:
    found = words(ladder(tmp_path, cell(tmp_path, "murk", LEVELS)))
    assert found == (
        "Of the squared error of murk to full path tracing, 2 % is compositing, 8 % approximation "
        "of effects, 33 % shading model, and 57 % cross terms of errors that add up."
    )
    cancelling = LEVELS | {PICTURE: 0.6}
    drawn = cell(tmp_path, "murk", cancelling, expressed="REFRACTION")
    text = words(ladder(tmp_path, drawn))
    assert "cross terms take 800 % off, where errors cancel" in text
    assert "draws effects that exact compositing lacks" in text
    undrawn = ladder_words.words(ladder(tmp_path, cell(tmp_path, "murk", cancelling)))
    assert "lacks" not in undrawn


def test_the_section_draws_all_scenes_and_lists_all_parts(tmp_path: Path) -> None:
    cells = [cell(tmp_path, method, LEVELS) for method in ("murk", "glow")]
    words, figure, table = report.build(context(tmp_path, cells, tmp_path))
    assert isinstance(words, Table)
    assert isinstance(table, Table)
    assert isinstance(figure, Figure)
    assert "panes" in figure.title
    # A sign of percent at each number would touch the next number.
    drawn = made_up.words(figure.pdf)
    assert {"0", "100"} <= set(drawn)
    assert drawn.count("%") == 1
    assert len(table.rows) == 2
    heading = [column.key for column in table.columns]
    (row, _) = table.rows
    assert row[heading.index("cross_percent")] == pytest.approx(100 * 0.28 / 0.49, rel=1e-5)


def test_results_without_traced_truths_have_no_section(tmp_path: Path) -> None:
    made = finished(tmp_path, "panes", "murk", 0.3, traced=False)
    assert report.build(context(tmp_path, [made], tmp_path)) == []
