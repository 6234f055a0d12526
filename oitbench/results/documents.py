"""Reading the JSON file of a verb: its schema is checked, and an error names the verb."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

import msgspec

from oitbench import json_text
from oitbench.errors import UsageError

_Document = TypeVar("_Document")


def read_document(path: Path, kind: type[_Document], version: int, verb: str) -> _Document:
    """Return the content of a file that a verb of the command line has written.

    Parameters
    ----------
    path : Path
    kind : type
        A msgspec structure with a field `schema`.
    version : int
        The schema of this version of the suite.
    verb : str
        The command that writes such files, for messages.

    Raises
    ------
    UsageError
        The file cannot be read, holds something else, or another version of the suite wrote it.
    """
    try:
        text = path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from error
    try:
        return msgspec.json.decode(text, type=kind)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        found = _schema(text)
        if found not in (None, version):
            raise UsageError(
                f"{path} was written by another version of oitbench (schema {found}, this one has"
                f" {version}); run `oitbench {verb}` again"
            ) from error
        raise UsageError(f"{path} holds no results of `oitbench {verb}`: {error}") from error


def _schema(text: bytes) -> object:
    """Return the schema of a JSON object, 0 if it has none, or None if this is no JSON object."""
    try:
        content = json_text.loads(text)
    except ValueError:
        return None
    return content.get("schema", 0) if isinstance(content, dict) else None
