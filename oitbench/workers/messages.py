"""The messages of all workers; each kind of worker has requests and replies of its own."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote_to_bytes

import msgspec
from msgspec import Struct


def encode(message: Struct) -> bytes:
    """Return a message as one line of JSON; its fields may be paths."""
    return msgspec.json.encode(message, enc_hook=_text) + b"\n"


def decoder(messages: Any) -> msgspec.json.Decoder[Any]:
    """Return the decoder of lines that hold a message of a type, or of a union of types."""
    return msgspec.json.Decoder(messages, dec_hook=_path)


def _text(value: object) -> str:
    """Return a path as text; its name may be any bytes, and JSON is UTF-8."""
    if isinstance(value, Path):
        return quote(os.fsencode(value))
    raise NotImplementedError(f"a message cannot hold {value!r}")


def _path(kind: type, text: str) -> Path:
    if issubclass(kind, Path):
        return Path(os.fsdecode(unquote_to_bytes(text)))
    raise NotImplementedError(f"a message cannot hold a {kind.__name__}")


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
