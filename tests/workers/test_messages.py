"""Messages as lines of JSON."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from msgspec import Struct

from oitbench.places import PluginFiles
from oitbench.workers.messages import Ready, decoder, encode


class Odd(Struct, frozen=True, tag=True):
    """A message with a field that no message can have."""

    value: complex


def test_paths_of_any_bytes_arrive_as_they_are() -> None:
    odd = Path(os.fsdecode(b"/a b/caf\xe9/%41\n"))
    files = PluginFiles([odd, Path("/caf\u00e9")], methods={"glow": odd})
    line = encode(files)
    assert line.count(b"\n") == 1
    assert decoder(PluginFiles).decode(line) == files


def test_a_union_of_messages_is_read_by_tag() -> None:
    assert decoder(Ready | Odd).decode(encode(Ready())) == Ready()


def test_other_objects_are_refused() -> None:
    with pytest.raises(NotImplementedError, match="cannot hold 1j"):
        encode(Odd(1j))
    with pytest.raises(NotImplementedError, match="a complex"):
        decoder(Odd).decode(b'{"type":"Odd","value":"1"}')
