"""How to cite the suite and to repeat a figure: its entry, commands, and a digest of results."""

from __future__ import annotations

import hashlib
import re
import shlex
from dataclasses import dataclass
from functools import cache
from pathlib import PurePath

import msgspec

from oitbench.places import own_folder
from oitbench.results.records import Results

_FILE = "CITATION.cff"
_TITLE = re.compile(r'^title: "(.+)"$', re.MULTILINE)
_AUTHOR = re.compile(r'^  - name: "(.+)"$', re.MULTILINE)
_VERSION = re.compile(r"^version: (.+)$", re.MULTILINE)
_BIBTEX = re.compile(r"([&%$#_{}])")
_DIGITS = 16


@dataclass(frozen=True)
class Citation:
    """The facts that a reader needs to cite a figure of some results.

    Parameters
    ----------
    commands : tuple of str
        Lines for a shell that repeat the results.
    fingerprint : str
        Of the results.
    version : str
        The version of the suite that made them.
    """

    commands: tuple[str, ...]
    fingerprint: str
    version: str

    def repeat(self, section: str) -> tuple[str, ...]:
        """Return the commands, and the one that draws a section of the report; "" for all."""
        chosen = f" --section {shlex.quote(section)}" if section else ""
        return (*self.commands, f"oitbench report RESULTS{chosen}")

    def draw(self, section: str) -> tuple[str, ...]:
        """Return the commands, and the one that draws the figures of a section as PNG and PDF."""
        return (*self.commands, f"oitbench report RESULTS --figure {shlex.quote(section)}")

    def entry(self, figure: str) -> str:
        """Return the BibTeX entry of the suite, from its CITATION.cff, with a note on a figure."""
        title, authors, _ = _suite()
        note = f"{figure}; results {self.fingerprint}"
        fields = {
            "author": f"{{{authors}}}",
            "title": title,
            "version": self.version,
            "note": " ".join(_BIBTEX.sub(r"\\\1", note).split()),
        }
        lines = "".join(f"  {name} = {{{value}}},\n" for name, value in fields.items())
        return f"@software{{oitbench,\n{lines}}}"


def citation(results: Results) -> Citation:
    """Return how to cite results."""
    facts = results.facts
    command = [PurePath(facts.argv[0]).name, *facts.argv[1:]] if facts.argv else []
    version = facts.packages.get("oitbench") or _suite()[2]
    commands = (shlex.join(command),) if command else ()
    return Citation(commands, fingerprint(results), version)


def fingerprint(results: Results) -> str:
    """Return a digest of all cells with all of their numbers, whatever their order."""
    cells = sorted(msgspec.json.encode(record) for record in results.records)
    digest = hashlib.sha256()
    for cell in cells:
        digest.update(hashlib.sha256(cell).digest())
    return digest.hexdigest()[:_DIGITS]


@cache
def _suite() -> tuple[str, str, str]:
    """Return the title, the authors and the version of the suite."""
    text = (own_folder() / _FILE).read_text(encoding="utf-8")
    title, version = _TITLE.search(text), _VERSION.search(text)
    if title is None or version is None:
        raise ValueError(f"{_FILE} has no title or no version")
    return title[1], " and ".join(_AUTHOR.findall(text)), version[1]
