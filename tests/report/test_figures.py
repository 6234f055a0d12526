"""The files of figures: their letters, and their bytes."""

import re
import warnings
from pathlib import Path

from oitbench.report import figures


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
