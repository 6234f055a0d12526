"""Tables, pictures and galleries of results that were made up."""

from __future__ import annotations

import base64
import io
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as Picture

import oitbench
from oitbench.api.outcome import Outcome
from oitbench.errors import UsageError
from oitbench.image.files import to_srgb
from oitbench.results.schema import Scores
from oitbench.results.store import Store
from oitbench.truths import EXACT, MATCHED
from tests.damage import flip_bit
from tests.helpers import collection
from tests.made_up import changed, failed, record
from tests.scoring.helpers import EXPOSURE, picture, read, write_results

SCENE = "glass[count=4]"


@pytest.fixture
def outcome(tmp_path: Path) -> Outcome:
    """Two cells with pictures in one scene."""
    return oitbench.open(write_results(tmp_path / "results"))


def add(outcome: Outcome, cell: Any) -> Outcome:
    """Return the outcome with one more cell."""
    with Store.open(outcome.folder) as store:
        store.append(cell)
    return oitbench.open(outcome.folder)


def decode(source: str) -> Any:
    """Return the levels of the PNG pictures in HTML."""
    found = re.findall(r'src="data:image/png;base64,([^"]+)"', source)
    return [np.asarray(Picture.open(io.BytesIO(base64.b64decode(text)))) for text in found]


def levels(image: Any) -> Any:
    return np.rint(to_srgb(image, EXPOSURE) * 255).astype(np.uint8)


def test_an_opened_folder_has_its_cells(outcome: Outcome) -> None:
    assert outcome.records == tuple(read(outcome.folder))
    assert (outcome.scenes, outcome.methods) == ((SCENE,), ("mean", "peel"))
    assert (outcome.summary, outcome.exit_code, outcome.troubled) == (None, 0, ())
    assert str(outcome) == f"{outcome.folder}: 2 cells, 0 of them troubled"
    lost = add(outcome, failed("lost"))
    assert (lost.exit_code, [cell.method for cell in lost.troubled]) == (1, ["lost"])
    cell = changed(outcome.records[0], "outcome.scores", {EXACT: Scores(faults={"mae": "no"})})
    assert add(outcome, cell).exit_code == 1
    with pytest.raises(UsageError, match=r"holds no cells\.jsonl"):
        oitbench.open(outcome.folder / "images")


def test_a_table_has_plain_names(outcome: Outcome) -> None:
    many = add(outcome, record("sweep[n=2]", scene="glass", outcome=outcome.records[0].outcome))
    many = add(many, changed(many.records[2], "outcome.parameters", {"n": 2}))
    table = add(many, failed("lost")).table()
    assert len(table) == 4
    first = table.iloc[0]
    cell = outcome.records[0]
    assert cell.time is not None
    ends = (cell.time.method_ms.median, cell.time.method_ms.low, cell.time.method_ms.high)
    assert (first.method_ms, first.method_ms_low, first.method_ms_high) == ends
    exact = cell.metric(EXACT, "flip_ldr@67ppd")
    assert (first.flip, first.flip_exact, first.ranking_truth) == (exact, exact, EXACT)
    assert first.flip_matched == cell.metric(MATCHED, "flip_ldr@67ppd") != exact
    assert first.relmse_matched == cell.metric(MATCHED, "relmse_lin(eps=1e-2)")
    assert first.flip_transparent_exact == 0.75
    assert table["method.n"].tolist()[2] == 2
    assert table["method.n"].notna().sum() == 1
    # This scene is not known here, so its value is the text of the label.
    assert table["scene.count"].tolist()[:2] == ["4", "4"]
    assert table["scene.count"].notna().tolist() == [True, True, False, True]
    columns = list(table.columns)
    assert columns.index("scene.count") == columns.index("reason") + 2
    assert table["flip"].notna().tolist() == [True, True, True, False]
    assert not [name for name in columns if "@" in name]


def test_parameters_of_known_scenes_have_their_defaults(outcome: Outcome) -> None:
    more = add(outcome, record(scene="layer_stack[count=4]"))
    table = add(more, record(scene="layer_stack")).table()
    found = table[table.scene.str.startswith("layer_stack")]
    default = collection().scenes["layer_stack"].parameters["count"].default
    assert default != 4
    assert found["scene.count"].tolist() == [4, default]


def test_an_image_is_the_one_that_was_scored(outcome: Outcome) -> None:
    np.testing.assert_array_equal(outcome.image(SCENE, "peel"), picture(4))
    np.testing.assert_array_equal(outcome.truth(SCENE), picture(1))
    np.testing.assert_array_equal(outcome.truth(SCENE, MATCHED), picture(2))
    shown = outcome.image(SCENE, "peel", display=True)
    np.testing.assert_array_equal(shown, to_srgb(picture(4), EXPOSURE))
    shown = outcome.truth(SCENE, display=True)
    np.testing.assert_array_equal(shown, to_srgb(picture(1), EXPOSURE))


def test_what_is_not_there_is_refused(outcome: Outcome) -> None:
    lost = add(outcome, failed("lost"))
    for call, message in (
        (lambda: outcome.image("glas", "peel"), "unknown scene in these results 'glas'; known: gl"),
        (lambda: outcome.image(SCENE, "peal"), "unknown method in .* 'peal'; did you mean peel"),
        (lambda: outcome.truth(SCENE, "fell"), "unknown truth 'fell'; did you mean full"),
        (lambda: outcome.show(SCENE, "fell"), "unknown truth 'fell'"),
        (lambda: outcome.truth(SCENE, "full"), "has no truth 'full'"),
        (lambda: outcome.image(SCENE, "peel", size=(1, 1)), r"no cell with size=\(1, 1\)"),
        (lambda: outcome.image(SCENE, "peel", sise=1), "unknown setting of cells 'sise'"),
        (lambda: lost.image(SCENE, "lost"), "has no picture; failed: no such shader"),
    ):
        with pytest.raises(UsageError, match=message):
            call()


def test_a_damaged_image_is_refused(outcome: Outcome) -> None:
    calls: dict[str, Callable[[], object]] = {
        "color": lambda: outcome.image(SCENE, "peel"),
        EXACT: lambda: outcome.truth(SCENE),
    }
    for kind, call in calls.items():
        images = outcome.records[1].outcome.images  # type: ignore[union-attr]
        flip_bit(outcome.folder / images[kind].path, 2000)
        with pytest.raises(UsageError, match="is damaged; run again to render it"):
            call()


def test_settings_choose_among_several_cells(outcome: Outcome) -> None:
    cell = changed(outcome.records[1], "size", (16, 16))
    both = add(outcome, cell)
    with pytest.raises(UsageError, match=r"has 2 cells; give size, one of \(8, 6\), \(16, 16\)"):
        both.image(SCENE, "peel")
    with pytest.raises(UsageError, match="peel has 2 cells; give size"):
        both.show(SCENE)
    assert both.record(SCENE, "peel", size=(16, 16)) == cell
    assert len(both.show(SCENE, size=(16, 16)).tiles) == 3


def test_a_gallery_shows_truths_and_methods_without_loss(outcome: Outcome) -> None:
    gallery = outcome.show(SCENE)
    assert [tile.label for tile in gallery.tiles] == [
        "exact compositing", "matched tracing", "mean", "peel",
    ]  # fmt: skip
    source = gallery._repr_html_()
    pictures = decode(source)
    assert len(pictures) == 6
    for shown, seed in zip(pictures[:3], (1, 2, 3), strict=True):
        np.testing.assert_array_equal(shown, levels(picture(seed)))
    value = outcome.records[0].metric(EXACT, "flip_ldr@67ppd")
    assert f"FLIP {value:.4f}, 2.00 ms" in source
    # The largest error of all methods has the last color of the scale.
    assert (
        max(int(shown.sum(axis=2).max()) for shown in (pictures[3], pictures[5])) == 252 + 253 + 191
    )
    assert f"black 0 to pale yellow {gallery.largest:.3g}" in source
    matched = outcome.show(SCENE, MATCHED)
    assert "against matched tracing" in matched.scale
    assert matched.largest != gallery.largest
    whole = np.asarray(Picture.open(io.BytesIO(gallery._repr_png_())))
    assert whole.shape[1] > whole.shape[0] > 300
    assert gallery._repr_png_() == gallery._repr_png_()


def test_a_gallery_says_why_a_picture_is_missing(outcome: Outcome) -> None:
    lost = add(outcome, failed("<b>lost</b>", reason="no <shader>"))
    source = lost.show(SCENE)._repr_html_()
    assert "&lt;b&gt;lost&lt;/b&gt;" in source
    assert "failed: no &lt;shader&gt;" in source
    assert "<b>lost" not in source
    assert lost.show(SCENE)._repr_png_()
    alone = add(outcome, failed("lost", scene="dark"))
    assert alone.show("dark")._repr_png_()


def test_galleries_are_saved(outcome: Outcome, tmp_path: Path) -> None:
    gallery = outcome.show(SCENE)
    gallery.save(tmp_path / "a.png")
    assert Picture.open(tmp_path / "a.png").format == "PNG"
    gallery.save(tmp_path / "a.html")
    assert gallery._repr_html_() in (tmp_path / "a.html").read_text(encoding="utf-8")
    with pytest.raises(UsageError, match=r"end the name in \.html or \.png"):
        gallery.save(tmp_path / "a.svg")


def test_the_import_loads_no_large_package() -> None:
    names = ("mitsuba", "drjit", "moderngl", "pandas", "matplotlib", "IPython", "PIL", "click")
    code = f"import oitbench, sys; print(*[name for name in {names} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
