"""Lifetime of objects on the device."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Protocol, TypeVar


class Releasable(Protocol):
    """Anything with memory on the device."""

    def release(self) -> object:
        """Free the memory."""


Item = TypeVar("Item", bound=Releasable)
Self = TypeVar("Self", bound="Owner")


class Owner:
    """Base of classes that own objects on the device, which are freed in reverse order.

    A subclass builds its objects inside `with self.building():`, so that an error in the middle
    frees those that already exist.
    """

    def __init__(self) -> None:
        self._owned = ExitStack()

    @contextmanager
    def building(self) -> Iterator[None]:
        """Free the objects that already exist if an error is raised inside."""
        try:
            yield
        except BaseException:
            self.release()
            raise

    def own(self, item: Item) -> Item:
        """Take ownership of `item` and return it."""
        self._owned.callback(item.release)
        return item

    def release(self) -> None:
        """Free the device's memory."""
        self._owned.close()

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.release()
