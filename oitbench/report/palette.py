"""The one owner of a method's look: its color, marker and line are the same in every picture."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

# Okabe & Ito (2008) without black and yellow, which vanish as dark text or on white paper.
_HUES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
# The same hues mixed with black, then with white: lightness is what a color-blind eye still tells.
_MIXTURES = (("#000000", 0.0), ("#000000", 0.45), ("#FFFFFF", 0.5), ("#000000", 0.7))
_LEGIBLE_LUMA = 105
_WHITE_TEXT_BELOW = 140
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "h")
_LINES = ("-", "--", ":", "-.")

TRUTH_COLOR = "#444444"
"""For curves and marks that belong to a truth rather than to a method."""


@dataclass(frozen=True)
class Style:
    """How one variant of a method is drawn: the color is the method's, the rest the variant's."""

    color: str
    marker: str
    line: str


def mix(color: str, other: str, share: float) -> str:
    """Return `color` with that share of `other`, both as "#rrggbb" (display-encoded)."""
    pairs = zip(_channels(color), _channels(other), strict=True)
    return "#" + "".join(f"{round(a + (b - a) * share):02x}" for a, b in pairs)


def ink(color: str) -> str:
    """Return `color` darkened until text in it is legible on white."""
    while _luma(color) > _LEGIBLE_LUMA:
        color = mix(color, "#000000", 0.1)
    return color


def is_dark(color: str) -> bool:
    """Tell whether text on `color` should be white."""
    return _luma(color) < _WHITE_TEXT_BELOW


def natural(label: str) -> tuple[tuple[int, str], ...]:
    """Return a sort key that puts 8 before 16."""
    return tuple(
        (int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", label)
    )


def styles(variants: Mapping[str, str], known: Iterable[str] = ()) -> dict[str, Style]:
    """Return a style for every variant.

    Parameters
    ----------
    variants : mapping of str to str
        From a variant's label to its method's bare name.
    known : iterable of str
        Names of all methods that there are. The color follows from a name's place among them, so
        it does not depend on which of them a report happens to show.
    """
    names = sorted({*variants.values(), *known})
    colors = {name: _color(place) for place, name in enumerate(names)}
    found: dict[str, Style] = {}
    seen: dict[str, int] = {}
    for label in sorted(variants, key=natural):
        name = variants[label]
        place = seen.get(name, 0)
        seen[name] = place + 1
        found[label] = Style(
            colors[name], _MARKERS[place % len(_MARKERS)], _LINES[place % len(_LINES)]
        )
    return found


def _color(place: int) -> str:
    round_, hue = divmod(place, len(_HUES))
    other, share = _MIXTURES[round_ % len(_MIXTURES)]
    return mix(_HUES[hue], other, share)


def _luma(color: str) -> float:
    red, green, blue = _channels(color)
    return 0.299 * red + 0.587 * green + 0.114 * blue


def _channels(color: str) -> tuple[int, int, int]:
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
