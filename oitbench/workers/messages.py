"""The messages of all workers; each kind of worker has requests and replies of its own."""

from __future__ import annotations

from msgspec import Struct


class Ready(Struct, frozen=True, tag=True):
    """The process has started; all imports are done."""


class Step(Struct, frozen=True, tag=True):
    """A part of the work begins.

    Parameters
    ----------
    name : str
        In words, as in "building the scene".
    shared : bool
        Whether later requests need the same part, and would fail in the same way.
    """

    name: str
    shared: bool = False


class Refusal(Struct, frozen=True, tag=True):
    """A user's error that prevented the work; `kind` is the name of its class."""

    message: str
    kind: str


class Fault(Struct, frozen=True, tag=True):
    """An exception that nobody expected; the process ends after this message."""

    message: str
