"""The papers whose figures are redrawn: which report draws which figure, and which has none."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import msgspec
from msgspec import Struct

from oitbench.errors import DeclarationError, UsageError
from oitbench.papers.picture import Picture
from oitbench.report.page import Edition

FOLDER = Path("reports") / "papers"
"""Folder of a collection that has a file for each paper."""


class StandIn(Struct, frozen=True, forbid_unknown_fields=True):
    """A scene of this suite that stands for one of a paper.

    Parameters
    ----------
    scene : str
        Label.
    methods : dict of str to str
        Labels of methods with the settings that the paper has in this scene, by the paper's names.
    """

    scene: str
    methods: dict[str, str] = {}


class Paper(Struct, frozen=True, forbid_unknown_fields=True):
    """The figures and tables of a paper.

    Parameters
    ----------
    cite : str
        Authors, year, title, and where it appeared.
    drawn : dict of str to str
        Names of reports by number, as in "Figure 7".
    omitted : dict of str to str
        Why the other numbers are not drawn, without a period.
    variants : dict of str to str
        Methods that this paper shows instead of those that the reports name, both as labels.
    methods : dict of str to str
        Labels of methods with the settings that the paper has in all scenes, by the paper's names.
    scenes : dict of str to StandIn
        By the paper's names.
    """

    cite: str
    drawn: dict[str, str]
    omitted: dict[str, str] = {}
    variants: dict[str, str] = {}
    methods: dict[str, str] = {}
    scenes: dict[str, StandIn] = {}

    def picture(self, scene: str, method: str, label: str = "") -> Picture:
        """Return the picture of a scene by a method, both by the paper's names."""
        found = self.scenes[scene]
        return Picture(found.scene, (self.methods | found.methods)[method], label)

    @property
    def edition(self) -> Edition:
        """The page of this paper."""
        numbers = {report: number for number, report in self.drawn.items()}
        return Edition(self.cite, numbers, self.variants, self.omitted)


def read_papers(folders: Iterable[Path]) -> dict[str, Paper]:
    """Return the papers of some collections by the names of their files; see `read_paper`.

    Raises
    ------
    DeclarationError
        Two of them have one name.
    """
    found: dict[str, Paper] = {}
    for path in (path for folder in folders for path in sorted((folder / FOLDER).glob("*.toml"))):
        if path.stem in found:
            raise DeclarationError(f"{path}: another collection also has this paper; rename one")
        found[path.stem] = read_paper(path)
    return found


def read_paper(path: Path) -> Paper:
    """Return the paper of one file.

    Raises
    ------
    DeclarationError
        The file does not describe a paper.
    UsageError
        The file cannot be read.
    """
    try:
        return msgspec.toml.decode(path.read_bytes(), type=Paper)
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise DeclarationError(f"{path}: {error}") from error


def figures_of(papers: Iterable[Paper]) -> set[str]:
    """Return the names of all reports that draw figures of papers."""
    return {report for paper in papers for report in paper.drawn.values()}
