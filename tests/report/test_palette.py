"""Colors of methods."""

from __future__ import annotations

from oitbench.report import palette


def test_24_methods_have_distinct_colors() -> None:
    assert len(set(palette.colors(f"m{place:02d}" for place in range(24)).values())) == 24


def test_a_color_follows_from_the_known_names() -> None:
    alone = palette.styles({"murk": "murk"}, known=["glow", "murk"])
    both = palette.styles({"murk": "murk", "glow": "glow"}, known=["glow", "murk"])
    assert alone["murk"] == both["murk"]


def test_text_is_legible() -> None:
    for color in palette.colors(f"m{place:02d}" for place in range(24)).values():
        assert palette.is_dark(palette.ink(color))
    assert palette.mix("#000000", "#ffffff", 0.0) == "#000000"
    assert palette.mix("#000000", "#ffffff", 1.0) == "#ffffff"
