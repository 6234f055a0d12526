"""Scores against truths: parts, pixels with and without layers, and truths that disagree."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files, metrics
from oitbench.image.files import Image
from oitbench.image.stored import StoredImage
from oitbench.image.ties import means_without
from oitbench.matrix import scoring
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell
from oitbench.matrix.stage import Stage, Truth
from oitbench.path_traced.references import lookup
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.path_traced.references.wanted import Wanted
from oitbench.plugins import Collection
from oitbench.results.pictures import PICTURE, REDUCED, REDUCED_EXACT, compared
from oitbench.results.schema import WHOLE, Outcome, Record
from oitbench.scoring.scorer import Findings, Scorer
from oitbench.truths import EXACT, FULL, MATCHED
from oitbench.workers import memory

SIZE = (16, 16)
STORED = StoredImage("images/a.exr", "0" * 64, 1)
GRAY = np.full((16, 16, 3), 0.5, dtype=np.float32)


def truth(image: Image, floor: float = 0.0) -> Truth:
    return Truth(image, STORED, noise_floor={metrics.FLIP_LDR: floor})


def test_means_over_some_pixels() -> None:
    errors = np.array([[0.0, 0.2], [0.4, 0.6]], dtype=np.float32)
    left = np.array([[True, False], [True, False]])
    found = [scoring.means_where({"flip": errors}, pixels)["flip"] for pixels in (left, ~left)]
    assert found == pytest.approx([0.2, 0.4])
    assert scoring.means_where({"flip": errors}, left & ~left) == {"flip": None}


def test_truths_that_disagree_are_suspect_only_if_every_effect_is_expressed() -> None:
    bright = GRAY * np.float32(1.2)
    flip = metrics.flip_ldr(GRAY, bright, 0.0)
    assert flip is not None
    assert 0.06 < flip < 0.2

    def reason(effects: Effect, floor: float = 0.0) -> str:
        return scoring.disagreement(effects, truth(bright), truth(GRAY, floor), 0.0)

    assert f"{flip:.3f}" in reason(Effect.COVERAGE)
    assert "every effect is expressed" in reason(Effect.COVERAGE | Effect.SHADOWS)
    for beyond in (Effect.REFRACTION, Effect.DIFFUSION, Effect.VOLUME):
        assert reason(Effect.COVERAGE | beyond) == ""
    assert reason(Effect.COVERAGE, floor=flip) == ""
    assert scoring.disagreement(Effect.COVERAGE, truth(GRAY), truth(GRAY), 0.0) == ""


def test_shared_shading_may_differ_by_its_approximations() -> None:
    open_, shadowed, occluded = (
        scoring.largest_disagreement(Effect.COVERAGE | effects)
        for effects in (Effect.NONE, Effect.COLORED_SHADOWS, Effect.AMBIENT_OCCLUSION)
    )
    assert open_ < shadowed < occluded <= 0.1


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Made-up references instead of rendered ones; the list names those that were asked for."""
    keys: list[str] = []

    def find_or_render(wanted: Wanted, *_: Any) -> tuple[Reference, str]:
        keys.append(wanted.key)
        parts = 8 if wanted.truth == MATCHED else 1
        random = np.random.default_rng(len(wanted.left_out))
        kind: Literal["matched", "full"] = "matched" if parts > 1 else "full"
        how = Rendering(
            wanted.label, kind, [], wanted.left_out, wanted.size, wanted.grid, 3, parts, 1, 1, "3",
            "f",
        )  # fmt: skip
        images = (random.random((16, 16, 3)).astype(np.float32) for _ in range(parts))
        return Reference(how, {metrics.FLIP_LDR: 0.02}, 4.5, tuple(images)), "made up"

    monkeypatch.setattr(lookup, "find_or_render", find_or_render)
    monkeypatch.setattr(lookup, "truth_fingerprint", lambda wanted, folders: wanted.key)
    return keys


def run(folder: Path, *cells: Cell) -> list[Record]:
    with Bench(Collection.load(), folder) as bench:
        return [bench.run(cell) for cell in cells]


def outcome_of(record: Record) -> Outcome:
    assert record.outcome is not None, record.reason
    return record.outcome


def test_a_cell_is_scored_against_all_parts_and_both_kinds_of_pixels(
    asked: list[str], tmp_path: Path
) -> None:
    (record,) = run(tmp_path, Cell("glass_bars", "alpha_blend", SIZE, permutations=0))
    outcome = outcome_of(record)
    assert asked == ["glass_bars@16x16.matched", "glass_bars@16x16.full"]
    matched = outcome.scores[MATCHED]
    assert matched.reference is not None
    facts = matched.reference
    assert (facts.ssaa, facts.spp, facts.parts, facts.random, facts.seconds) == (2, 3, 8, True, 4.5)
    assert (matched.noise_floor, matched.message) == ({metrics.FLIP_LDR: 0.02}, "made up")
    image = files.read_exr(tmp_path / outcome.images["color"].path)
    reference, _ = lookup.find_or_render(
        Wanted(Collection.load().build_scene("glass_bars"), "glass_bars", SIZE, 2), []
    )
    expected = [metrics.flip_ldr(mean, image, 0.0) for mean in means_without(reference.parts)]
    assert matched.jackknife[metrics.FLIP_LDR] == pytest.approx(expected, abs=1e-4)
    assert outcome.scores[FULL].jackknife == {}
    share = outcome.transparent_pixels / (SIZE[0] * SIZE[1])
    assert 0 < share < 1
    for truth_key in (EXACT, MATCHED, FULL):
        scores = outcome.scores[truth_key]
        for name in (metrics.FLIP_LDR, metrics.FLIP_HDR):
            transparent, opaque = scores.transparent[name], scores.opaque[name]
            assert transparent is not None
            assert opaque is not None
            whole = share * transparent + (1 - share) * opaque
            assert scores.metrics[name] == pytest.approx(whole, rel=1e-4)
    # The made-up truth is nothing like exact compositing, and the scene asks for nothing else.
    assert record.status == "suspect"
    assert "exact compositing and matched tracing differ" in record.reason
    assert record.ranking_truth == EXACT


def test_transparent_pixels_are_those_that_do_not_pass_all_light() -> None:
    with Device() as device:
        collection = Collection.load()
        scene = collection.build_scene("bottles")
        with UploadedScene(device, scene) as uploaded:
            stage = Stage(
                "b", (24, 16), 2, "", "main", uploaded, collection.truth(), lambda *_: STORED
            )
            exact = stage.exact(~Effect.NONE, (24, 16))
    absorbing = exact.transmittance.min(axis=-1) < 1
    # The scene is not symmetric, so that no axis is swapped.
    assert not np.array_equal(absorbing, absorbing[::-1])
    np.testing.assert_array_equal(exact.transparent, absorbing)


def test_a_cell_without_an_effect_has_its_own_truths_and_the_whole_one(
    asked: list[str], tmp_path: Path
) -> None:
    settings = {"permutations": 0, "truths": (EXACT, MATCHED)}
    cells = [
        Cell("tumblers", "sorted_over", SIZE, effects=effects, **settings)  # type: ignore[arg-type]
        for effects in ("requested", "-refraction")
    ]
    complete, reduced = run(tmp_path, *cells)
    prefix = "tumblers@16x16.matched"
    assert asked == [prefix, f"{prefix}-refraction"]
    assert (complete.ranking_truth, reduced.ranking_truth) == (MATCHED, EXACT)
    assert WHOLE not in outcome_of(complete).scores
    whole = outcome_of(reduced)
    assert whole.images[WHOLE] == outcome_of(complete).images[MATCHED]
    assert whole.images[MATCHED] != whole.images[WHOLE]
    assert whole.scores[WHOLE].metrics != whole.scores[MATCHED].metrics
    assert whole.scores[WHOLE].reference == outcome_of(complete).scores[MATCHED].reference
    assert reduced.fingerprints is not None
    assert reduced.fingerprints.truths[WHOLE] == prefix
    assert complete.status == "ok"
    assert outcome_of(complete).scores[FULL].reason == "left out of this run"


def test_exact_compositing_leaves_out_the_effects_of_the_cell(
    asked: list[str], tmp_path: Path
) -> None:
    scene, settings = "shadow_trio[detail=0.05]", {"permutations": 0, "truths": (EXACT,)}
    cells = [
        Cell(scene, "a_buffer", (24, 24), effects=effects, **settings)  # type: ignore[arg-type]
        for effects in ("requested", "-shadows")
    ]
    complete, reduced = run(tmp_path, *cells)
    for record in (complete, reduced):
        error = record.metric(EXACT, metrics.FLIP_LDR)
        assert error == pytest.approx(0, abs=1e-4)
    assert msgspec.structs.asdict(outcome_of(complete).images[EXACT]) != msgspec.structs.asdict(
        outcome_of(reduced).images[EXACT]
    )
    assert asked == []


@pytest.mark.parametrize("method", ["sorted_over", "hashed_alpha", "moments"])
def test_traced_truths_of_another_size_score_the_picture_of_that_size(
    method: str, asked: list[str], tmp_path: Path
) -> None:
    settings: dict[str, Any] = {"permutations": 0, "effects": "-refraction"}
    large = Cell("tumblers", method, (32, 32), reduced=True, **settings)
    found, small = map(outcome_of, run(tmp_path, large, Cell("tumblers", method, SIZE, **settings)))
    assert {key.partition("@")[2].partition(".")[0] for key in asked} == {"16x16"}
    for truth in (MATCHED, FULL, WHOLE):
        assert found.scores[truth] == small.scores[truth]
        assert found.images[truth] == small.images[truth]
        one, other = (it.images[compared(it, truth)] for it in (found, small))
        assert one.sha256 == other.sha256
    own, same = (it.scores[EXACT].metrics for it in (found, small))
    assert own != same
    assert own[metrics.TRANSMITTANCE] == same[metrics.TRANSMITTANCE]
    assert found.images[REDUCED_EXACT].sha256 == small.images[EXACT].sha256
    sizes = [files.read_exr(tmp_path / found.images[key].path).shape for key in ("color", EXACT)]
    assert sizes == [(32, 32, 3)] * 2
    assert [compared(found, truth) for truth in (EXACT, FULL)] == [PICTURE, REDUCED]


def test_a_reduced_cell_is_scored_again_with_the_same_pictures(
    asked: list[str], tmp_path: Path
) -> None:
    (record,) = run(
        tmp_path, Cell("glass_bars", "alpha_blend", (32, 32), permutations=0, reduced=True)
    )
    with Scorer([], memory.share(1)) as scorer:
        again = scorer.score(record, tmp_path, Findings(), built_in=True)
    assert again == record
