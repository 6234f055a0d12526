"""Scenes that were built in Python, as files of numpy (.npz) that hold no code.

The member `scene` is JSON: a list of parts, such as meshes and materials, each before those that
refer to it, and the last one is the scene. The other members are its arrays.
"""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

import oitbench.scene as classes
from oitbench.errors import OitbenchError, SceneError
from oitbench.scene import Scene, Wrap

_VERSION = 1
_MEMBER = "scene"
_KINDS: Mapping[str, type] = {
    name: kind
    for name, kind in vars(classes).items()
    if isinstance(kind, type) and is_dataclass(kind)
}
_DAMAGES = (
    OSError, ValueError, KeyError, IndexError, TypeError, AttributeError, ArithmeticError, EOFError,
    MemoryError, RecursionError, NotImplementedError, zipfile.BadZipFile, zlib.error,
    msgspec.MsgspecError,
)  # fmt: skip
"""Errors by which damaged files show themselves."""


def encode_scene(scene: Scene) -> bytes:
    """Return the content of a file that holds a scene; equal scenes have equal files.

    Raises
    ------
    SceneError
        A part of the scene is of a class that is not one of `oitbench.scene`.
    """
    encoder = _Encoder(f"scene {scene.name}")
    encoder.encode(scene)
    text = msgspec.json.encode({"version": _VERSION, "parts": encoder.parts})
    content = io.BytesIO()
    arrays: dict[str, Any] = {str(number): array for number, array in enumerate(encoder.arrays)}
    arrays[_MEMBER] = np.frombuffer(text, np.uint8)
    np.savez(content, **arrays)
    return content.getvalue()


def read_written(path: Path, name: str) -> Scene:
    """Return the scene of a file under a name.

    Raises
    ------
    SceneError
        The file is damaged or is none of a scene, or the scene cannot be rendered.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            content = msgspec.json.decode(file[_MEMBER].tobytes())
            if content["version"] != _VERSION:
                raise ValueError(f"it is of version {content['version']}, not {_VERSION}")
            parts: list[Any] = []
            for part in content["parts"]:
                parts.append(_decode_part(part, parts, file))
        scene = parts[-1]
    except OitbenchError:
        raise
    except _DAMAGES as error:
        raise SceneError(
            f"{path} is no scene that was built in Python, or is damaged ({error}); write it again"
        ) from error
    if not isinstance(scene, Scene):
        raise SceneError(f"{path} holds a {type(scene).__name__}, not a scene; write it again")
    return replace(scene, name=name)


class _Encoder:
    """Collects the parts and the arrays of one scene; what objects share is stored once."""

    def __init__(self, owner: str) -> None:
        self._owner = owner
        self.parts: list[dict[str, Any]] = []
        self.arrays: list[Any] = []
        # The value is kept, so that its id stays its own.
        self._known: dict[int, tuple[object, dict[str, Any]]] = {}

    def encode(self, value: Any) -> Any:
        """Return a value as JSON."""
        if is_dataclass(value) or isinstance(value, np.ndarray):
            if id(value) not in self._known:
                made = self._array(value) if isinstance(value, np.ndarray) else self._part(value)
                self._known[id(value)] = value, made
            return self._known[id(value)][1]
        if isinstance(value, Wrap):
            return {"wrap": value.value}
        if value is None or isinstance(value, bool | str):
            return value
        if isinstance(value, int | np.integer):
            return int(value)
        if isinstance(value, float | np.floating):
            number = float(value)
            return number if math.isfinite(number) else {"float": repr(number)}
        if isinstance(value, tuple | list):
            return {"tuple": [self.encode(item) for item in value]}
        if isinstance(value, Mapping):
            return {"map": {str(key): self.encode(item) for key, item in value.items()}}
        raise self._unknown(value)

    def _array(self, value: Any) -> dict[str, Any]:
        if value.dtype.kind not in "biuf":
            raise SceneError(f"{self._owner}: an array holds {value.dtype}; give numbers")
        self.arrays.append(value)
        return {"array": len(self.arrays) - 1}

    def _part(self, value: Any) -> dict[str, Any]:
        kind = type(value)
        if _KINDS.get(kind.__name__) is not kind:
            raise self._unknown(value)
        given = {
            field.name: self.encode(getattr(value, field.name))
            for field in fields(value)
            if field.init
        }
        self.parts.append({"kind": kind.__name__, "fields": given})
        return {"part": len(self.parts) - 1}

    def _unknown(self, value: object) -> SceneError:
        return SceneError(
            f"{self._owner}: it holds a {type(value).__name__}, which no file can hold; use classes"
            " of oitbench.scene, or write the scene as a file with a function build"
        )


def _decode_part(part: Any, parts: list[Any], arrays: Any) -> Any:
    kind = _KINDS[part["kind"]]
    known = {field.name for field in fields(kind) if field.init}
    given = {name: _decode(value, parts, arrays) for name, value in part["fields"].items()}
    if given.keys() - known:
        raise ValueError(f"a {part['kind']} has no {min(given.keys() - known)}")
    return kind(**given)


def _decode(value: Any, parts: list[Any], arrays: Any) -> Any:
    if not isinstance(value, dict):
        return value
    ((kind, content),) = value.items()
    if kind == "array":
        return arrays[str(content)]
    if kind == "part":
        return parts[content]
    if kind == "wrap":
        return Wrap(content)
    if kind == "float":
        return float(content)
    if kind == "tuple":
        return tuple(_decode(item, parts, arrays) for item in content)
    if kind == "map":
        return {name: _decode(item, parts, arrays) for name, item in content.items()}
    raise ValueError(f"it holds a value of the kind {kind}")
