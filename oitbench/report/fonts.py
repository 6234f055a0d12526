"""The font of figures: the characters of DejaVu Sans that reports use.

A PDF embeds the letters that a figure shows. To find them in the whole font takes longer than to
draw the figure; in this small one it does not. Characters that it lacks come from the whole font.
"""

from __future__ import annotations

import functools
from pathlib import Path

from oitbench.atomic import replacing

FAMILY = "oitbench DejaVu Sans"
_RANGES = ((0x20, 0x7E), (0xA0, 0x17F), (0x391, 0x3C9), (0x2010, 0x2044), (0x2070, 0x209C),
           (0x2190, 0x2195), (0x2200, 0x226B), (0x25A0, 0x25CF), (0x2605, 0x2606))  # fmt: skip
"""Latin, Greek, punctuation, raised and lowered digits, arrows, operators, marks."""
_FILES = ("DejaVuSans.ttf", "DejaVuSans-Bold.ttf")
_NAMES = {1: FAMILY, 4: FAMILY, 6: FAMILY.replace(" ", "-"), 16: FAMILY}
"""Names of the family and of the font, by their number in the font's table."""


@functools.cache
def add_family() -> None:
    """Let figures use `FAMILY`; its files are kept in matplotlib's cache."""
    import matplotlib
    from matplotlib import font_manager

    whole = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
    cache = Path(matplotlib.get_cachedir())
    for name in _FILES:
        path = cache / f"oitbench-{matplotlib.__version__}-{name}"
        if not path.exists():
            _write_subset(whole / name, path)
        font_manager.fontManager.addfont(path)


def _write_subset(whole: Path, path: Path) -> None:
    """Write the part of a font that holds the characters of `_RANGES`, as a family of its own."""
    from fontTools import subset

    options = subset.Options(glyph_names=True, recommended_glyphs=True, name_IDs=["*"])
    options.layout_features = ["kern"]
    options.drop_tables += ["FFTM", "PfEd"]
    with subset.load_font(whole, options) as font:
        subsetter = subset.Subsetter(options)
        subsetter.populate(unicodes=[c for low, high in _RANGES for c in range(low, high + 1)])
        subsetter.subset(font)
        for record in font["name"].names:
            record.string = _NAMES.get(record.nameID, record.toUnicode())
        with replacing(path) as partial:
            font.save(partial)
