"""The files of figures: their letters, and their bytes."""

import re
import warnings
from pathlib import Path

import numpy as np
from PIL import Image

from oitbench.report import figures, plates
from tests.report.made_up import words


def draw(folder: Path, text: str) -> bytes:
    """Return the PDF file of a figure with a title."""
    with figures.canvas(3, 2) as canvas:
        canvas.subplots().set_title(text)
        figure = figures.save(canvas, folder / "figure", title="", caption="")
    return figure.pdf.read_bytes()


def embedded(pdf: bytes) -> set[str]:
    """Return the names of the fonts of a PDF file."""
    found = re.findall(rb"/FontName /[A-Z]{6}\+([\w-]+)", pdf)
    return {name.decode() for name in found}


def test_letters_of_reports_come_from_the_small_font(tmp_path: Path) -> None:
    text = "÷ Ωα “5 × 4” – T² ≤ 10⁻³ → ● ★ … Ł"
    assert embedded(draw(tmp_path, text)) == {"oitbench-DejaVu-Sans"}


def test_a_letter_that_the_small_font_lacks_comes_from_the_whole_one(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fonts = embedded(draw(tmp_path, "Жuk"))
    assert {"oitbench-DejaVu-Sans", "DejaVuSans-Bold"} <= fonts


def test_equal_figures_have_equal_bytes(tmp_path: Path) -> None:
    assert draw(tmp_path / "one", "a") == draw(tmp_path / "two", "a")
    one, two = ((tmp_path / name / "figure.png").read_bytes() for name in ("one", "two"))
    assert one == two


def test_both_files_show_the_same_at_the_resolution_of_the_screen(tmp_path: Path) -> None:
    colors = np.array([[[1.0, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 1, 1]]])
    with figures.canvas(3, 2, by_hand=True) as canvas:
        plates.draw_picture(canvas, colors, 1.0, 0.5, 1.0)
        figure = figures.save(canvas, tmp_path / "figure", title="", caption="")
    with Image.open(figure.png) as opened:
        pixels = np.asarray(opened.convert("RGB"))
    per_inch = figures.DOTS_PER_INCH
    assert pixels.shape == (2 * per_inch, 3 * per_inch, 3)
    picture = pixels[per_inch // 2 : 3 * per_inch // 2, per_inch : 2 * per_inch]
    expected = np.kron(255 * colors, np.ones((per_inch // 2, per_inch // 2, 1)))
    np.testing.assert_array_equal(picture, expected)
    background = pixels.sum(dtype=np.int64) - picture.sum(dtype=np.int64)
    assert background == 255 * (pixels.size - picture.size)


def test_enlarged_pixels_stay_sharp_between_dots(tmp_path: Path) -> None:
    checks = np.indices((7, 7)).sum(axis=0) % 2.0
    with figures.canvas(2, 2, by_hand=True) as canvas:
        plates.draw_picture(canvas, np.repeat(checks[..., None], 3, axis=2), 0.51, 0.51, 1.02)
        figure = figures.save(canvas, tmp_path / "figure", title="", caption="")
    with Image.open(figure.png) as opened:
        levels = np.asarray(opened.convert("L"))
    inside = slice(int(0.6 * figures.DOTS_PER_INCH), int(1.4 * figures.DOTS_PER_INCH))
    assert set(np.unique(levels[inside, inside])) == {0, 255}


def test_numbers_of_logarithmic_axes_are_text_as_a_dollar_is(tmp_path: Path) -> None:
    with figures.canvas(3, 2) as canvas:
        axes = canvas.subplots()
        axes.plot([2, 8, 30], [0.1, 1.0, 20.0])
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        axes.set_title("5 $_x$")
        figure = figures.save(canvas, tmp_path / "figure", title="", caption="")
    found = words(figure.pdf)
    assert {"$_x$", "2", "4", "8", "16", "0.1", "1", "10"} <= {*found}
    assert not any("mathdefault" in word for word in found)
