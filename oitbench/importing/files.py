"""Reads a file and what it refers to: only regular files of its own folder, and no network."""

from __future__ import annotations

import base64
import binascii
import os
import re
import stat
from pathlib import Path
from urllib.parse import unquote

from oitbench.errors import SceneError
from oitbench.importing.limits import Budget, short

_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")
_DATA = re.compile(r"data:[^,;]*(?:;[^,;]*)*;base64,", re.IGNORECASE)


class MissingFileError(SceneError):
    """There is no such file in the folder."""


class Folder:
    """The folder of a file; everything that is read counts against a budget.

    Parameters
    ----------
    file : Path
        The file that was named by the user.
    budget : Budget

    Attributes
    ----------
    read_files : dict of str to Path
        Files that were read beside `file`, by their paths relative to the folder.
    """

    def __init__(self, file: Path, budget: Budget) -> None:
        self._file, self._budget = file.resolve(), budget
        self.read_files: dict[str, Path] = {}

    def read_main(self) -> bytes:
        """Return the content of the file itself."""
        return self._read(self._file, self._file.name)

    def read(self, name: str) -> bytes:
        """Return the content of a file of the folder, or of one below it.

        Parameters
        ----------
        name : str
            Relative path.

        Raises
        ------
        MissingFileError
            There is no such file.
        SceneError
            The path leads elsewhere, or the file is too large or no regular file.
        """
        folder = self._file.parent
        text = name.replace("\\", "/")
        if not text or "\0" in text or text.startswith(("/", "~")) or _SCHEME.match(text):
            raise SceneError(f"'{short(name)}' is no file of its own folder; copy the file there")
        try:
            path = (folder / text).resolve()
        except (OSError, RuntimeError, ValueError) as error:
            raise SceneError(f"'{short(name)}' cannot be read: {error}") from error
        if not path.is_relative_to(folder):
            raise SceneError(f"'{short(name)}' is outside the file's folder; copy the file there")
        content = self._read(path, name)
        self.read_files[path.relative_to(folder).as_posix()] = path
        return content

    def read_uri(self, uri: str) -> bytes:
        """Return what a URI of glTF refers to: base64 data, or a file of the folder."""
        found = _DATA.match(uri[:200])
        if found is not None:
            self._budget.take("bytes", (len(uri) - found.end()) * 3 // 4)
            try:
                return base64.b64decode(uri[found.end() :], validate=True)
            except (binascii.Error, ValueError) as error:
                raise SceneError(f"data of a URI is no base64: {error}") from error
        if _SCHEME.match(uri):
            raise SceneError(f"'{short(uri)}' is no file of its own folder; nothing is downloaded")
        return self.read(unquote(uri))

    def _read(self, path: Path, name: str) -> bytes:
        try:
            # A pipe or a device would never end.
            handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW)
            with os.fdopen(handle, "rb") as file:
                facts = os.fstat(handle)
                if not stat.S_ISREG(facts.st_mode):
                    raise SceneError(f"'{short(name)}' is no regular file; give one")
                self._budget.take("bytes", facts.st_size)
                return file.read(facts.st_size)
        except FileNotFoundError as error:
            raise MissingFileError(f"'{short(name)}' cannot be read: {error.strerror}") from error
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise SceneError(f"'{short(name)}' cannot be read: {reason}") from error
