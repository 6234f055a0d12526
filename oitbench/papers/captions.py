"""Captions: what a figure shows, and what of its paper's statements reproduced in these results."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from oitbench.papers.album import Album
from oitbench.papers.picture import Picture
from oitbench.report.artifacts import fixed

ALIKE = 0.02
"""Mean FLIP up to which two pictures count as the same to the eye."""


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
    album: Album, picture: Picture, others: Sequence[Picture], truth: str, text: str
) -> Finding:
    """Return whether a picture has a lower error against a truth than each of some others.

    Parameters
    ----------
    album : Album
    picture : Picture
    others : sequence of Picture
    truth : str
        Key.
    text : str
        The statement.
    """
    error = album.error(picture, truth)
    known = [
        found for found in (album.error(other, truth) for other in others) if found is not None
    ]
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
