"""The sources that methods, claims and figures cite: entries of BibTeX files."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from oitbench.errors import DeclarationError, UsageError

NAME = "bibliography.bib"
"""Name of the file, in the folder `reports` of a collection."""
OWN = ("our own", "folklore")
"""Words with which the sources of a method begin that no publication describes."""
_SOURCES = re.compile(r"Sources?: (.+)")
KEY = re.compile(r"\[([A-Z][A-Za-z]*(?:19|20)\d\d[a-z]?)\]")
"""A key in brackets, as in the docstring of a method."""
_VENUES = ("journal", "booktitle", "institution", "howpublished", "note")


@dataclass(frozen=True)
class Source:
    """An entry.

    Parameters
    ----------
    key : str
    authors : str
        Family names: one, two with "and", or the first with "et al.".
    year, title, venue : str
        Empty if they are unknown.
    bibtex : str
        The entry as it stands in the file.
    """

    key: str
    authors: str
    year: str
    title: str
    venue: str
    bibtex: str

    @property
    def text(self) -> str:
        """The entry as one sentence."""
        parts = (" ".join(filter(None, (self.authors, self.year))), f"“{self.title}”", self.venue)
        return ", ".join(filter(None, parts))


def read(paths: Iterable[Path]) -> dict[str, Source]:
    """Return the entries of BibTeX files by key, in alphabetical order.

    Raises
    ------
    DeclarationError
        A file cannot be parsed, or a key has two entries.
    UsageError
        A file cannot be read.
    """
    found: dict[str, Source] = {}
    for path in paths:
        for source in _entries(path):
            if source.key in found:
                raise DeclarationError(f"{path}: a second entry is named '{source.key}'; rename it")
            found[source.key] = source
    return dict(sorted(found.items()))


def files(folders: Iterable[Path]) -> list[Path]:
    """Return the files of some collections, of those that have one."""
    return [path for path in (folder / "reports" / NAME for folder in folders) if path.is_file()]


def text(sources: Iterable[Source]) -> str:
    """Return the content of a BibTeX file with these entries."""
    return "\n".join(f"{source.bibtex}\n" for source in sources)


def sources_text(doc: str) -> str:
    """Return the paragraph of a docstring after "Source:" or "Sources:"; "" if there is none."""
    paragraphs = (" ".join(part.split()) for part in re.split(r"\n\s*\n", doc))
    return next((found[1] for found in map(_SOURCES.match, paragraphs) if found), "")


def keys(doc: str) -> list[str]:
    """Return the keys of the sources of a method, in the order in which its docstring has them."""
    return list(dict.fromkeys(KEY.findall(sources_text(doc))))


def _entries(path: Path) -> list[Source]:
    from bibtexparser.entrypoint import parse_string

    try:
        content = path.read_text(encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise DeclarationError(f"{path}: {error}") from error
    library = parse_string(content)
    for block in library.failed_blocks:
        line = (block.start_line or 0) + 1
        raise DeclarationError(f"{path}:{line}: no entry of BibTeX; correct it")
    return [_source(entry.key, entry.raw or "", entry.fields_dict) for entry in library.entries]


def _source(key: str, bibtex: str, fields: Mapping[str, object]) -> Source:
    def plain(name: str) -> str:
        value = getattr(fields.get(name), "value", "")
        return " ".join(str(value).replace("{", "").replace("}", "").split())

    venue = next(filter(None, map(plain, _VENUES)), "")
    eprint = f"arXiv:{plain('eprint')}" if plain("eprint") else ""
    venue = ", ".join(filter(None, (venue, eprint)))
    return Source(
        key, _names(plain("author")), plain("year"), plain("title"), venue, bibtex.strip()
    )


def _names(authors: str) -> str:
    """Return the family names of authors, "Family, Given and Family, Given"."""
    names = [name.partition(",")[0].strip() for name in authors.split(" and ")]
    if len(names) > 2 or names[1:] == ["others"]:
        return f"{names[0]} et al."
    return " and ".join(names)
