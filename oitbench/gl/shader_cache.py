"""The cache of compiled shaders that Mesa keeps on the disk.

Mesa maps its index into memory, so the kernel ends the process with SIGBUS when the disk is full.
"""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import MutableMapping
from pathlib import Path

_DISABLE = ("MESA_SHADER_CACHE_DISABLE", "MESA_GLSL_CACHE_DISABLE")
_FOLDERS = ("MESA_SHADER_CACHE_DIR", "MESA_GLSL_CACHE_DIR", "XDG_CACHE_HOME")
# The index takes 1.3 MB, and the programs of one run some more.
_NEEDED_BYTES = 16 * 2**20
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def avoid_full_disk(environment: MutableMapping[str, str] = os.environ) -> None:
    """Turn the cache off if its disk has no room; call this before the first context exists."""
    folder = _folder(environment)
    if folder is None:
        return
    try:
        with tempfile.TemporaryFile(dir=folder) as probe:
            # Asking for free space instead would miss quotas.
            os.posix_fallocate(probe.fileno(), 0, _NEEDED_BYTES)
    except OSError as error:
        # Mesa itself copes with a folder that it cannot write to.
        if error.errno in _FULL:
            environment.update(dict.fromkeys(_DISABLE, "true"))


def _folder(environment: MutableMapping[str, str]) -> Path | None:
    """Return the folder of the cache or the nearest one above it that exists, or None."""
    named = next(filter(None, map(environment.get, _FOLDERS)), None)
    try:
        wanted = Path(named) if named else Path.home() / ".cache"
    except RuntimeError:
        return None
    return next((place for place in (wanted, *wanted.parents) if place.is_dir()), None)
