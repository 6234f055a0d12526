"""Adapters by name: those of the suite, and those of entry points of the group `GROUP`."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import EntryPoint, entry_points

from oitbench.engines.adapter import Engine
from oitbench.errors import DeclarationError, UsageError, locate, unknown

GROUP = "oitbench.engines"
_FOLDER = "oitbench.engines.adapters"
_OWN = tuple(
    EntryPoint(name, f"{_FOLDER}.{module}:{kind}", GROUP)
    for name, module, kind in (("vtk", "vtk_engine", "Vtk"), ("pygfx", "pygfx_engine", "Pygfx"))
)


def entries() -> dict[str, EntryPoint]:
    """Return all adapters by name.

    Raises
    ------
    UsageError
        Two adapters have one name.
    """
    found: dict[str, EntryPoint] = {}
    for entry in (*_OWN, *entry_points(group=GROUP)):
        if found.setdefault(entry.name, entry).value != entry.value:
            raise UsageError(
                f"two adapters are named {entry.name}: {found[entry.name].value} and {entry.value};"
                " rename one"
            )
    return found


def choose(texts: Iterable[str]) -> list[str]:
    """Return the names of engines that lists of names select, as in "vtk,pygfx".

    Raises
    ------
    UsageError
        There is no such engine.
    """
    known = entries()
    names = [name.strip() for text in texts for name in text.split(",")]
    for name in names:
        if name not in known:
            raise unknown("engine", name, known)
    return list(dict.fromkeys(names))


def load(name: str) -> type[Engine]:
    """Return the adapter of a name. It is code of a plugin, which only a worker process runs.

    Raises
    ------
    DeclarationError
        Its module cannot be imported, or holds no adapter of that name.
    """
    entry = entries()[name]
    try:
        found = entry.load()
    except Exception as error:
        raise DeclarationError(f"engine {name}: {locate(error)}") from error
    if not (isinstance(found, type) and issubclass(found, Engine)):
        raise DeclarationError(f"engine {name}: {entry.value} is no Engine; derive it from Engine")
    return found
