"""Captions: what a figure shows, and what of its paper's statements reproduced in these results."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from oitbench.papers.album import Album
from oitbench.papers.picture import Picture
from oitbench.report.artifacts import fixed

ALIKE = 0.02
"""Mean FLIP up to which two pictures count as the same to the eye."""
TONE = 0.04
"""Difference of mean displayed values up to which two parts count as of one tone."""


@dataclass(frozen=True)
class Finding:
    """A statement of a paper, and whether it holds here.

    Parameters
    ----------
    text : str
        The statement with its numbers here, a part of a sentence.
    holds : bool, optional
        None if the results cannot tell.
    """

    text: str
    holds: bool | None


def nearer(
    album: Album, picture: Picture, others: Sequence[Picture], truth: str | Picture, text: str
) -> Finding:
    """Return whether a picture has a lower error against a truth than each of some others.

    Parameters
    ----------
    album : Album
    picture : Picture
    others : sequence of Picture
    truth : str or Picture
        Key of a truth of each cell, or the picture that shows the truth of another cell.
    text : str
        The statement.
    """

    def error_of(shown: Picture) -> float | None:
        if isinstance(truth, Picture):
            return album.distance(shown, truth)
        return album.error(shown, truth)

    error = error_of(picture)
    known = [found for found in map(error_of, others) if found is not None]
    if error is None or not known:
        return Finding(text, None)
    against = ", ".join(fixed(value, 4) for value in known)
    return Finding(f"{text} (FLIP {fixed(error, 4)} against {against})", error < min(known))


def faithful(album: Album, picture: Picture, truth: str, text: str) -> Finding:
    """Return whether the error of a picture against a truth is at most `ALIKE`."""
    error = album.error(picture, truth)
    if error is None:
        return Finding(text, None)
    return Finding(f"{text} (FLIP {fixed(error, 4)})", error <= ALIKE)


def less(value: float | None, other: float | None, text: str, digits: int = 2) -> Finding:
    """Return whether a number is below another one; both stand behind the statement.

    Parameters
    ----------
    value, other : float, optional
        None if the results cannot tell.
    text : str
    digits : int
        Decimals of both numbers.
    """
    if value is None or other is None:
        return Finding(text, None)
    return Finding(f"{text} ({value:.{digits}f} against {other:.{digits}f})", value < other)


def alike(album: Album, picture: Picture, other: Picture, text: str) -> Finding:
    """Return whether two pictures look the same: their FLIP is at most `ALIKE`."""
    return _apart(album, picture, other, text, True)


def unlike(album: Album, picture: Picture, other: Picture, text: str) -> Finding:
    """Return whether two pictures look different: their FLIP is above `ALIKE`."""
    return _apart(album, picture, other, text, False)


def _apart(album: Album, picture: Picture, other: Picture, text: str, same: bool) -> Finding:
    distance = album.distance(picture, other)
    if distance is None:
        return Finding(text, None)
    text = f"{text} (FLIP {fixed(distance, 4)} between them)"
    return Finding(text, (distance <= ALIKE) == same)


def darker(album: Album, picture: Picture, other: Picture, text: str) -> Finding:
    """Return whether a picture is darker than another: by more than `TONE`, as displayed."""
    return _lower(album, picture, other, text, True)


def even(album: Album, picture: Picture, other: Picture, text: str) -> Finding:
    """Return whether a picture is not darker than another."""
    return _lower(album, picture, other, text, False)


def _lower(album: Album, picture: Picture, other: Picture, text: str, lower: bool) -> Finding:
    tones = album.tone(picture), album.tone(other)
    if tones[0] is None or tones[1] is None:
        return Finding(text, None)
    text = f"{text} (mean displayed value {tones[0]:.2f} against {tones[1]:.2f})"
    return Finding(text, (tones[1] - tones[0] > TONE) == lower)


def caption(album: Album, shown: str, findings: Iterable[Finding] = ()) -> str:
    """Return the text below a figure.

    Parameters
    ----------
    album : Album
    shown : str
        What the figure shows, in sentences.
    findings : iterable of Finding
    """
    found = list(findings)
    groups = (("Reproduced", True), ("Not reproduced", False), ("These results cannot tell", None))
    parts = [shown]
    for word, holds in groups:
        texts = [item.text for item in found if item.holds is holds]
        if texts:
            parts.append(f"{word}: {'; '.join(texts)}.")
    if album.lacking:
        count, whole = len(album.lacking), len(album.needs)
        parts.append(f"{count} of the {whole} cells of this figure are not in these results.")
    return " ".join(parts)
