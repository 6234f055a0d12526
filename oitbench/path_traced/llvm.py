"""The LLVM library that drjit uses, and the fastest variant of Mitsuba that it allows.

drjit 1.5 ends the whole process with LLVM 15 or 16, and these are the versions that Mesa often
installs. This module therefore selects a library of a suitable version before Mitsuba is imported.
"""

from __future__ import annotations

import ctypes
import functools
import importlib
import os
import re
import subprocess
import sysconfig
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType

from oitbench.errors import CapabilityError

USABLE_VERSIONS = range(17, 23)
PATH_VARIABLE = "DRJIT_LIBLLVM_PATH"
FAST_VARIANT = "llvm_ad_rgb"
SLOW_VARIANT = "scalar_rgb"
INSTALL = "apt install libllvm19"
"""The command that installs a suitable library."""

_MAJOR = re.compile(r"libLLVM(?:[-.](?P<before>\d+)|\.(?:so|dylib)\.(?P<after>\d+))")


@dataclass(frozen=True)
class Library:
    """An LLVM library.

    Parameters
    ----------
    path : str
    version : int or None
        Major version; None if it is unknown.
    """

    path: str
    version: int | None

    @property
    def usable(self) -> bool:
        """Whether drjit works with this version."""
        return self.version in USABLE_VERSIONS


@dataclass(frozen=True)
class Backend:
    """The variant of Mitsuba that the path tracer uses, and the reason for it.

    Parameters
    ----------
    mitsuba : str or None
        Version; None if Mitsuba is not installed.
    variant : str or None
        None if Mitsuba is not installed.
    llvm_path : str or None
    llvm_version : int or None
        None if the variant does not use LLVM.
    reason : str
        One line, with the fix if a faster variant could be installed.
    """

    mitsuba: str | None
    variant: str | None
    llvm_path: str | None
    llvm_version: int | None
    reason: str


def describe() -> dict[str, str | int | None]:
    """Return the fields of `backend()` by name, for `oitbench doctor`."""
    return asdict(backend())


@functools.cache
def backend() -> Backend:
    """Choose a variant of Mitsuba, once per process, and set it; never raises.

    The environment variable `DRJIT_LIBLLVM_PATH` is set to the library that was chosen.
    """
    library, reason = choose(os.environ, _installed())
    if library is not None:
        os.environ[PATH_VARIABLE] = library.path
    try:
        mitsuba = importlib.import_module("mitsuba")
    except ImportError as error:
        fix = "apt install libatomic1" if "libatomic" in str(error) else "pip install mitsuba"
        return Backend(None, None, None, None, f"Mitsuba cannot be imported ({error}); {fix}")
    version = str(mitsuba.__version__)
    if library is not None:
        try:
            mitsuba.set_variant(FAST_VARIANT)
            return Backend(version, FAST_VARIANT, library.path, library.version, reason)
        except ImportError as error:
            reason = f"{library.path} cannot be loaded ({error}); {INSTALL}"
    mitsuba.set_variant(SLOW_VARIANT)
    return Backend(version, SLOW_VARIANT, None, None, f"{reason}; the slow {SLOW_VARIANT} is used")


def load(variant: str | None = None) -> ModuleType:
    """Return the module `mitsuba` with a variant set.

    Parameters
    ----------
    variant : str, optional
        Default: the variant that `backend` chose.

    Raises
    ------
    CapabilityError
        If Mitsuba is not installed.
    """
    found = backend()
    if found.variant is None:
        raise CapabilityError(found.reason)
    mitsuba = importlib.import_module("mitsuba")
    mitsuba.set_variant(variant or found.variant)
    return mitsuba


def choose(
    environment: Mapping[str, str], installed: Iterable[Library]
) -> tuple[Library | None, str]:
    """Choose an LLVM library: the user's own if it is usable, else the newest usable one.

    Parameters
    ----------
    environment : mapping
        Environment variables; the user may have set `DRJIT_LIBLLVM_PATH`.
    installed : iterable of Library
        The libraries of this machine.

    Returns
    -------
    library : Library or None
        None if no library is usable.
    reason : str
        One line.
    """
    own = environment.get(PATH_VARIABLE)
    refused = ""
    if own:
        library = inspect(Path(own))
        if library is not None and library.usable:
            return library, f"{PATH_VARIABLE} names LLVM {library.version}"
        refused = f"{PATH_VARIABLE}={own} is {_description(library)}; "
    wanted = f"{USABLE_VERSIONS[0]} to {USABLE_VERSIONS[-1]}"
    candidates = list(installed)
    usable = [library for library in candidates if library.usable]
    if usable:
        best = max(usable, key=lambda library: library.version or 0)
        return best, f"{refused}found LLVM {best.version}"
    versions = sorted({library.version for library in candidates if library.version})
    others = f" (found {', '.join(map(str, versions))})" if versions else ""
    return None, f"{refused}no LLVM {wanted} is installed{others}; {INSTALL}"


def inspect(path: Path) -> Library | None:
    """Return the library at `path` with its version, or None if there is no such file."""
    if not path.is_file():
        return None
    for name in (path.name, path.resolve().name):
        match = _MAJOR.match(name)
        if match is not None:
            return Library(str(path), int(match["before"] or match["after"]))
    return Library(str(path), _query_version(path))


def _query_version(path: Path) -> int | None:
    """Return the version that the library itself reports; LLVM before 16 reports none."""
    try:
        get_version = ctypes.CDLL(str(path)).LLVMGetVersion
    except (OSError, AttributeError):
        return None
    major = ctypes.c_uint(0)
    get_version(ctypes.byref(major), None, None)
    return major.value


def _description(library: Library | None) -> str:
    if library is None:
        return "no file"
    return "of unknown version" if library.version is None else f"LLVM {library.version}"


def _installed() -> Iterator[Library]:
    """Yield the LLVM libraries of the loader's cache and of the usual folders."""
    seen: set[Path] = set()
    for path in _candidates():
        real = path.resolve()
        if real in seen:
            continue
        seen.add(real)
        library = inspect(path)
        if library is not None:
            yield library


def _candidates() -> Iterator[Path]:
    yield from _loader_cache()
    multiarch = sysconfig.get_config_var("MULTIARCH") or "*-linux-gnu"
    folders = [
        "/usr/lib64",
        "/usr/local/lib",
        "/usr/local/lib64",
        "/usr/lib",
        f"/usr/lib/{multiarch}",
    ]
    folders += ["/usr/lib/llvm-*/lib", "/usr/lib64/llvm*/lib", "/usr/lib/llvm/*/lib64"]
    folders += ["/opt/homebrew/opt/llvm*/lib", "/usr/local/opt/llvm*/lib"]
    folders += [part for part in os.environ.get("LD_LIBRARY_PATH", "").split(":") if part]
    for folder in folders:
        for name in ("libLLVM[-.]*so*", "libLLVM[-.]*dylib"):
            yield from sorted(Path("/").glob(f"{folder.lstrip('/')}/{name}"))


def _loader_cache() -> Iterator[Path]:
    command = next((p for p in ("/sbin/ldconfig", "/usr/sbin/ldconfig") if Path(p).is_file()), None)
    if command is None:
        return
    listing = subprocess.run([command, "-p"], capture_output=True, text=True, check=False).stdout
    machine = os.uname().machine.replace("_", "-")
    for line in listing.splitlines():
        name, _, path = line.strip().partition(" => ")
        if name.startswith(("libLLVM-", "libLLVM.")) and (machine in name or machine != "x86-64"):
            yield Path(path)
