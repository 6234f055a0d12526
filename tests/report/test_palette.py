"""Colors of methods."""

from __future__ import annotations

from oitbench.method.families import BLENDING, CURVES, FAMILIES, OTHER
from oitbench.report import palette


def test_families_have_looks_of_their_own() -> None:
    looks = [palette.family_look(family) for family in FAMILIES]
    colors, markers = zip(*looks, strict=True)
    assert len(set(colors)) == len(set(markers)) == len(FAMILIES)
    assert palette.family_look("unheard of") == palette.family_look(OTHER)


def test_a_family_has_one_color_and_marker_and_lines_differ() -> None:
    methods = {"glow[n=8]": "glow", "glow": "glow", "haze": "haze", "murk": "murk"}
    families = {"glow": BLENDING, "haze": BLENDING, "murk": CURVES}
    styles = palette.styles(methods, families)
    glow, wide, haze, murk = (styles[label] for label in ("glow", "glow[n=8]", "haze", "murk"))
    assert (glow.color, glow.marker) == (haze.color, haze.marker) == palette.family_look(BLENDING)
    assert (murk.color, murk.marker) == palette.family_look(CURVES)
    assert len({glow.line, wide.line, haze.line}) == 3


def test_20_names_have_distinct_colors() -> None:
    assert len(set(palette.categories(f"m{place:02d}" for place in range(20)).values())) == 20


def test_text_is_legible() -> None:
    for color in palette.categories(f"m{place:02d}" for place in range(20)).values():
        assert palette.is_dark(palette.ink(color))
    assert palette.mix("#000000", "#ffffff", 0.0) == "#000000"
    assert palette.mix("#000000", "#ffffff", 1.0) == "#ffffff"


def test_curves_of_one_family_differ_in_one_plot() -> None:
    color, marker = palette.family_look(CURVES)
    found = palette.tinted([palette.Style(color, marker, "-")] * 12)
    assert len({(style.color, style.line) for style in found}) == 12
    assert {style.marker for style in found} == {marker}
    assert found[0].color == color.lower()
