"""The fingerprint of a scene: a digest of all values that a picture of it depends on.

Processors and libraries differ in the last digits of sines and sums. Values are therefore rounded,
to steps that are far above such differences and far below everything that a picture shows:

- positions of vertices, sprites and strands, to 10⁻⁶ of the scene's size, which is the longest side
  of the bounding box of all vertices that a triangle uses;
- positions of cameras, lights and media, to 10⁻⁹ of their distance from the origin or of the
  scene's size, whichever is larger, but not coarser than vertices;
- all other numbers, to 30 binary digits, which are nine decimal ones;
- other arrays, such as textures and normals, to 20 binary digits of each value.

Numbers of one tuple or array that are below 10⁻⁴ of its largest are rounded like numbers of that
size, because small ones may be nothing but rounding.

Names of objects and of classes do not matter, and neither do views other than the scene's camera.
Names of fields do, and so does every value. A mesh that depends on the view is digested as it is
described.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable
from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.scene import Camera, Material, Mesh, Object, Scene, Texture
from oitbench.scene.vectors import Floats

_VERTEX_STEP = 1e-6
_PLACE_STEP = 1e-9
_RESOLVED = 2.0**-45
"""Steps of points are at least this fraction of the largest coordinate: 256 last digits."""
_NUMBER_DIGITS = 30
_ARRAY_DIGITS = 20
_SMALL = 1e-4
_PLACES = frozenset({"position", "target", "low", "high"})
"""Fields that hold a point in the world as a tuple."""
_POINTS = frozenset({"positions", "centers", "points"})
"""Fields of meshes that hold points in the world as an array."""
_UNSEEN = (
    (Scene, "name"), (Scene, "full_samples"), (Scene, "views"), (Scene, "path"), (Object, "name"),
)  # fmt: skip
_LATER = (
    (Camera, "height"), (Texture, "wrap"), (Material, "cutoff"), (Material, "culled"),
    (Mesh, "albedo"), (Mesh, "transmission"), (Mesh, "coverage"),
)  # fmt: skip
"""Fields that are younger than stored fingerprints: they count only where they differ from their
defaults."""
_ROUND = 0.88196601125
"""Added before rounding down: one half, and a shift by an irrational fraction of a step.

The shift moves the ends of steps away from round numbers, on which many values lie. A difference in
the last digit of such a value then never moves it to another step.
"""


def scene_fingerprint(scene: Scene) -> str:
    """Return the fingerprint of a scene: 32 hexadecimal digits."""
    size = scene_size(item.mesh for item in scene.objects)
    # Vertices are stored relative to the size.
    return _digest("scene", _numbers([size]), _Encoder(scene, size).encode(scene)).hex()[:32]


def scene_size(meshes: Iterable[Mesh]) -> float:
    """Return the longest side of the bounding box of all used vertices; 1 if it is empty."""
    used = [mesh.used_positions for mesh in meshes]
    if not used:
        return 1.0
    low = np.min([points.min(axis=0) for points in used], axis=0)
    high = np.max([points.max(axis=0) for points in used], axis=0)
    return float((high - low).max()) or 1.0


class _Encoder:
    """Digests of the values of one scene; each covers kind, shape and content."""

    def __init__(self, scene: Scene, size: float) -> None:
        self._size = size
        self._objects = {item.name: number for number, item in enumerate(scene.objects)}
        # Objects often share a mesh or a texture. The value is kept, so that its id stays its own.
        self._known: dict[int, tuple[object, bytes]] = {}

    def encode(self, value: Any) -> bytes:
        """Return the digest of a value.

        Raises
        ------
        TypeError
            The value is of a kind for which there is no rule here.
        """
        if dataclasses.is_dataclass(value) or isinstance(value, np.ndarray):
            known = self._known.get(id(value))
            if known is None:
                made = _array(value) if isinstance(value, np.ndarray) else self._fields(value)
                known = self._known[id(value)] = (value, made)
            return known[1]
        if isinstance(value, bool) or value is None:
            return _digest("constant", repr(value))
        if _is_number(value):
            return _numbers([value])
        if isinstance(value, tuple | list):
            if value and all(map(_is_number, value)):
                return _numbers(value)
            return _digest("sequence", *map(self.encode, value))
        if isinstance(value, str):
            # An object may refer to another by its name, which itself changes no picture.
            number = self._objects.get(value)
            text = value.value if isinstance(value, Enum) else value
            return _digest("text", text) if number is None else _digest("object", str(number))
        raise TypeError(f"{type(value).__name__} has no fingerprint")

    def _fields(self, owner: Any) -> bytes:
        parts: list[str | bytes] = []
        for field in dataclasses.fields(owner):
            later = _is_in(_LATER, owner, field.name)
            default = later and _is_default(getattr(owner, field.name), field.default)
            if field.init and not default and not _is_in(_UNSEEN, owner, field.name):
                parts += [field.name, self._field(owner, field.name)]
        return _digest("fields", *parts)

    def _field(self, owner: Any, name: str) -> bytes:
        value = getattr(owner, name)
        if isinstance(owner, Mesh) and name in _POINTS:
            return _points(value, _VERTEX_STEP * self._size)
        if name in _PLACES and isinstance(value, tuple):
            reach = max(self._size, *map(abs, value))
            return _points(value, min(_PLACE_STEP * reach, _VERTEX_STEP * self._size))
        return self.encode(value)


def _is_in(fields: Iterable[tuple[type, str]], owner: object, name: str) -> bool:
    return any(isinstance(owner, kind) and name == one for kind, one in fields)


def _is_default(value: object, default: object) -> bool:
    return not isinstance(value, np.ndarray) and value == default


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)


def _points(values: npt.ArrayLike, step: float) -> bytes:
    points = np.asarray(values, dtype=np.float64)
    step = max(step, _RESOLVED * float(np.abs(points).max(initial=0.0)))
    return _digest("points", repr(points.shape), _bytes(np.floor(points / step + _ROUND)))


def _numbers(values: Iterable[Any]) -> bytes:
    array = np.array([float(value) for value in values])
    return _digest("numbers", _bytes(_rounded(array, _NUMBER_DIGITS)))


def _array(values: npt.NDArray[Any]) -> bytes:
    shape = repr(values.shape)
    if values.dtype.kind in "iub":
        return _digest("integers", shape, values.astype("<i8").tobytes())
    return _digest("array", shape, _bytes(_rounded(values.astype(np.float64), _ARRAY_DIGITS)))


def _rounded(values: Floats, digits: int) -> Floats:
    """Round numbers to binary digits, small ones like those of `_SMALL` times the largest.

    Steps are powers of two, so that the largest number below a power and the power itself, whose
    steps differ, are rounded to the same value.
    """
    largest = np.abs(values).max(initial=0.0)
    least = _SMALL * float(_rounded_alone(largest, digits))
    return _rounded_alone(values, digits, least)


def _rounded_alone(values: npt.ArrayLike, digits: int, least: float = 0.0) -> Floats:
    array = np.asarray(values, dtype=np.float64)
    _, exponents = np.frexp(np.maximum(np.abs(array), max(least, np.finfo(np.float64).tiny)))
    steps = np.ldexp(1.0, np.maximum(exponents - digits, -1000))
    return np.asarray(np.floor(array / steps + _ROUND) * steps)


def _bytes(values: Floats) -> bytes:
    return (values + 0.0).astype("<f8").tobytes()  # Adding zero turns −0 into 0.


def _digest(kind: str, *parts: str | bytes) -> bytes:
    digest = hashlib.sha256()
    for part in (kind, *parts):
        content = part.encode() if isinstance(part, str) else part
        digest.update(f"{len(content)}:".encode())
        digest.update(content)
    return digest.digest()
