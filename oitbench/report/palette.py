"""Colors, markers and lines of methods and their families: the same in all pictures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from oitbench.method.families import BLENDING, CURVES, EXACT, LISTS, OTHER, RANDOM, SORTING
from oitbench.parameters import natural

# Hues of what is no method, none of them that of a family: indigo, olive, violet, wine, brown.
_HUES = ("#332288", "#A3A13A", "#A48FD0", "#882255", "#8C5A2B")
# The same hues mixed with white, then with black. Color-blind readers distinguish the lightness.
_MIXTURES = (("#000000", 0.0), ("#FFFFFF", 0.55), ("#000000", 0.5), ("#FFFFFF", 0.78))
# Mixtures of the color of a family, for its curves in one plot.
_TINTS = (("#000000", 0.0), ("#000000", 0.5), ("#FFFFFF", 0.45), ("#000000", 0.75))
# Color and marker of each family of methods: Okabe & Ito (2008) without black, and without yellow,
# which is illegible on white paper.
_LOOKS: Mapping[str, tuple[str, str]] = {
    BLENDING: ("#0072B2", "o"),
    SORTING: ("#E69F00", "s"),
    EXACT: ("#3a3a3a", "*"),
    LISTS: ("#009E73", "^"),
    CURVES: ("#D55E00", "D"),
    RANDOM: ("#CC79A7", "X"),
    OTHER: ("#56B4E9", "P"),
}
_LEGIBLE_LUMA = 105
_WHITE_TEXT_BELOW = 140
_LINES = ("-", "--", ":", "-.")


@dataclass(frozen=True)
class Style:
    """The look of a method: color and marker of its family, and a line style within it."""

    color: str
    marker: str
    line: str


def mix(color: str, other: str, share: float) -> str:
    """Return `color` mixed with a share in [0, 1] of `other`; all are "#rrggbb", sRGB-encoded."""
    pairs = zip(_channels(color), _channels(other), strict=True)
    return "#" + "".join(f"{round(a + (b - a) * share):02x}" for a, b in pairs)


def ink(color: str) -> str:
    """Return `color`, darkened until text in it is legible on white."""
    while _luma(color) > _LEGIBLE_LUMA:
        color = mix(color, "#000000", 0.1)
    return color


def is_dark(color: str) -> bool:
    """Return whether text on `color` should be white."""
    return _luma(color) < _WHITE_TEXT_BELOW


def categories(names: Iterable[str]) -> dict[str, str]:
    """Return a color for each name of what is no method, by its place; 20 are distinct."""
    return {name: _color(place) for place, name in enumerate(names)}


def family_look(family: str) -> tuple[str, str]:
    """Return the color and the marker of a family."""
    return _LOOKS.get(family, _LOOKS[OTHER])


def styles(methods: Mapping[str, str], families: Mapping[str, str]) -> dict[str, Style]:
    """Return a style for every method.

    Parameters
    ----------
    methods : mapping of str to str
        From a method's label to its bare name.
    families : mapping of str to str
        From a bare name to its family; see `oitbench.method.families`. Methods of a family share
        color and marker, and differ in line style.
    """
    found: dict[str, Style] = {}
    seen: Counter[str] = Counter()
    for label in sorted(methods, key=natural):
        family = families.get(methods[label], OTHER)
        found[label] = Style(*family_look(family), _LINES[seen[family] % len(_LINES)])
        seen[family] += 1
    return found


def tinted(styles: Iterable[Style]) -> list[Style]:
    """Return the styles of curves in one plot: those of one family differ in lightness."""
    found: list[Style] = []
    seen: Counter[str] = Counter()
    for style in styles:
        other, share = _TINTS[seen[style.color] % len(_TINTS)]
        line = _LINES[seen[style.color] // len(_TINTS) % len(_LINES)]
        found.append(Style(mix(style.color, other, share), style.marker, line))
        seen[style.color] += 1
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
