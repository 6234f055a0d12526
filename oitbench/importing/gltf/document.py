"""Opens .glb and .gltf files: the checked document, and the bytes of its buffers."""

from __future__ import annotations

import struct
from contextlib import suppress
from typing import TypeVar

import msgspec
from msgspec import Struct

from oitbench.errors import SceneError
from oitbench.importing.files import Folder
from oitbench.importing.gltf.extensions import KNOWN, PACKED
from oitbench.importing.gltf.schema import Asset, BufferView, Gltf
from oitbench.importing.limits import Budget, short
from oitbench.importing.notes import Notes
from oitbench.scene import Floats

Part = TypeVar("Part")
_MAGIC = b"glTF"
_UNREADABLE = (msgspec.MsgspecError, RecursionError, UnicodeDecodeError)
_JSON, _BINARY = 0x4E4F534A, 0x004E4942


class _Head(Struct, frozen=True):
    """What every version of glTF has."""

    asset: Asset = Asset()


class Document:
    """A glTF file.

    Parameters
    ----------
    folder : Folder
    budget : Budget
    notes : Notes

    Attributes
    ----------
    vectors : dict of int to array
        The accessors that were read already; primitives often share them.

    Raises
    ------
    SceneError
        The file is damaged, or needs an extension that is not known.
    """

    def __init__(self, folder: Folder, budget: Budget, notes: Notes) -> None:
        self.folder, self.budget, self.notes = folder, budget, notes
        text, self._chunk = _split(folder.read_main())
        budget.take("entries of JSON", sum(text.count(sign) for sign in (b",", b"{", b"[")))
        try:
            # Some writers pad with zero bytes.
            self.gltf = msgspec.json.decode(text.rstrip(b"\0"), type=Gltf)
        except _UNREADABLE as error:
            with suppress(*_UNREADABLE):
                # Another version is the better reason.
                _check_version(msgspec.json.decode(text.rstrip(b"\0"), type=_Head).asset)
            raise SceneError(f"its JSON cannot be read: {error}") from error
        self._buffers: dict[int, memoryview] = {}
        self.vectors: dict[int, Floats] = {}
        _check_version(self.gltf.asset)
        _check_extensions(self.gltf, notes)

    def part(self, kind: str, parts: list[Part], index: int) -> Part:
        """Return a part by its number.

        Raises
        ------
        SceneError
            There is no such part.
        """
        if index >= len(parts):
            raise SceneError(f"{kind} {index} is used, but there are {len(parts)}")
        return parts[index]

    def view(self, index: int) -> tuple[BufferView, memoryview]:
        """Return a buffer view and its bytes."""
        view = self.part("buffer view", self.gltf.buffer_views, index)
        if PACKED & view.extensions.keys():
            raise SceneError("its geometry is compressed; export it without compression")
        content = self._buffer(view.buffer)
        end = view.byte_offset + view.byte_length
        if end > len(content):
            raise SceneError(f"buffer view {index} ends at byte {end} of {len(content)}")
        return view, content[view.byte_offset : end]

    def _buffer(self, index: int) -> memoryview:
        if index not in self._buffers:
            buffer = self.part("buffer", self.gltf.buffers, index)
            if buffer.uri is not None:
                content = self.folder.read_uri(buffer.uri)
            elif self._chunk is not None and index == 0:
                content = self._chunk
            else:
                raise SceneError(f"buffer {index} has no data; export the file again")
            if len(content) < buffer.byte_length:
                raise SceneError(
                    f"buffer {index} has {len(content)} bytes, but {buffer.byte_length} are"
                    " announced; the file is damaged"
                )
            self._buffers[index] = memoryview(content)[: buffer.byte_length]
        return self._buffers[index]


def _split(content: bytes) -> tuple[bytes, bytes | None]:
    """Return the JSON and the binary chunk of a file; a .gltf file has no binary chunk."""
    if content[:4] != _MAGIC:
        return content, None
    if len(content) < 20:
        raise SceneError("it ends in its header; the file is damaged")
    version, length = struct.unpack_from("<II", content, 4)
    if version != 2:
        raise SceneError(f"it is glTF {version}; convert it to glTF 2.0")
    end = min(length, len(content))
    chunks: dict[int, bytes] = {}
    start = 12
    while start + 8 <= end:
        size, kind = struct.unpack_from("<II", content, start)
        if start + 8 + size > end:
            raise SceneError(f"a chunk at byte {start} is longer than the file; it is damaged")
        if not chunks and kind != _JSON:
            raise SceneError("its first chunk is no JSON; the file is damaged")
        if kind in (_JSON, _BINARY):
            chunks.setdefault(kind, content[start + 8 : start + 8 + size])
        start += 8 + size + -size % 4
    if _JSON not in chunks:
        raise SceneError("it has no chunk of JSON; the file is damaged")
    return chunks[_JSON], chunks.get(_BINARY)


def _check_version(asset: Asset) -> None:
    version = asset.min_version or asset.version
    if version.partition(".")[0] != "2":
        raise SceneError(f"it is glTF '{short(version)}'; convert it to glTF 2.0")


def _check_extensions(gltf: Gltf, notes: Notes) -> None:
    required = sorted(set(gltf.extensions_required) - KNOWN)
    if PACKED.intersection(required):
        raise SceneError(f"it needs {short(required[0])}; export it without compression")
    if required:
        raise SceneError(f"it needs {short(', '.join(required))}, which cannot be imported")
    for name in sorted(set(gltf.extensions_used) - KNOWN):
        notes.add(f"{short(name)} is ignored")
    if gltf.animations:
        notes.add("animations are ignored; the scene is shown at rest")
    if gltf.skins:
        notes.add("skins are ignored; meshes are shown in the pose that they are stored in")
