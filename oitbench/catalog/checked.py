"""A collection for commands that run plugins in their own process."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from oitbench.catalog.catalog import Catalog, Choice
from oitbench.errors import DeclarationError
from oitbench.plugins import Collection


def load_checked(
    extra: Iterable[Path | str], choose: Callable[[Catalog], Iterable[Choice]]
) -> Collection:
    """Return the collection, after a worker has loaded the files that are going to be used.

    Parameters
    ----------
    extra : iterable of path
        Further collection folders.
    choose : callable
        Returns the methods and scenes that are going to be used.

    Raises
    ------
    DeclarationError
        A file fails, or would end or block this process.
    UsageError
        Something is unknown or out of range.
    """
    with Catalog(extra) as catalog:
        for choice in choose(catalog):
            if choice.error:
                raise DeclarationError(choice.error)
        return Collection(catalog.places)
