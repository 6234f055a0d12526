"""The entries of claims, as data files hold them: sources, and what each of them said."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from oitbench.claims.comparisons import Difference, Ratio, Value
from oitbench.claims.observations import Alike, Identity, Untestable
from oitbench.claims.trends import Disagreement, Slope, Storage
from oitbench.errors import DeclarationError, UsageError

AnyTrial = (
    Value | Ratio | Difference | Slope | Storage | Disagreement | Identity | Alike | Untestable
)
Text = Annotated[str, Meta(min_length=1)]


class Claim(Struct, frozen=True, forbid_unknown_fields=True):
    """What a source said, and how it is tested here.

    Parameters
    ----------
    id : str
        Unique.
    section : str
        Of the source.
    said : str
        In words of this suite.
    trials : list
        All must hold.
    figure : str
        The report whose section shows the numbers; empty for none.
    anywhere : bool
        Whether one case that holds is enough, as for "up to".
    gpu : bool
        Whether a renderer that runs on the CPU can say nothing about it.
    remark : str
        What a reader must know of the test.
    """

    id: Annotated[str, Meta(pattern="^[a-z0-9-]+$")]
    section: Text
    said: Text
    trials: Annotated[list[AnyTrial], Meta(min_length=1)]
    figure: str = ""
    anywhere: bool = False
    gpu: bool = False
    remark: str = ""


class Source(Struct, frozen=True, forbid_unknown_fields=True):
    """A paper or a project with its claims.

    Parameters
    ----------
    cite : str
        Authors, year, title, and where it appeared.
    key : str
        Of its entry in the bibliography; empty if it has none.
    machine : str
        On which its numbers were measured; empty if it names none.
    claim : list of Claim
    """

    cite: Text
    claim: list[Claim]
    key: str = ""
    machine: str = ""


class _File(Struct, frozen=True, forbid_unknown_fields=True):
    source: list[Source]


def read(folder: Path) -> list[Source]:
    """Read all data files of a folder, in the order of their names.

    Raises
    ------
    DeclarationError
        A file lists no sources of this form, or two claims have one id.
    UsageError
        A file cannot be read.
    """
    found: list[Source] = []
    owners: dict[str, Path] = {}
    for path in sorted(folder.glob("*.toml")):
        try:
            content = msgspec.toml.decode(path.read_bytes(), type=_File)
        except OSError as error:
            raise UsageError(f"{path} cannot be read: {error.strerror}") from error
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise DeclarationError(f"{path}: {error}") from error
        for claim in (claim for source in content.source for claim in source.claim):
            if claim.id in owners:
                owner = owners[claim.id]
                raise DeclarationError(f"{path}: {owner} also has the id '{claim.id}'; rename one")
            owners[claim.id] = path
        found += content.source
    return found
