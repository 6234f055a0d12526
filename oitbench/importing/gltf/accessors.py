"""Arrays of a glTF file: typed, interleaved, sparse, normalized; all bounds are checked."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError
from oitbench.importing.gltf.document import Document
from oitbench.importing.gltf.schema import Accessor, Sparse
from oitbench.scene import Floats

Numbers = npt.NDArray[np.generic]
_TYPES: dict[int, np.dtype[np.generic]] = {
    5120: np.dtype("<i1"), 5121: np.dtype("<u1"), 5122: np.dtype("<i2"),
    5123: np.dtype("<u2"), 5125: np.dtype("<u4"), 5126: np.dtype("<f4"),
}  # fmt: skip
_LARGEST = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535, 5125: 2**32 - 1}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def read_vectors(document: Document, index: int, *widths: int) -> Floats:
    """Return vectors of a file as numbers, shape (count, width), float64.

    Parameters
    ----------
    document : Document
    index : int
        Of the accessor.
    *widths : int
        Allowed numbers of components.

    Raises
    ------
    SceneError
        The accessor is out of bounds, has another width, or holds NaN or infinity.
    """
    if index not in document.vectors:
        document.vectors[index] = _read_vectors(document, index)
    values = document.vectors[index]
    if values.shape[1] not in widths:
        kind = document.gltf.accessors[index].type
        raise SceneError(f"accessor {index} is {kind}; the attribute needs another type")
    return values


def _read_vectors(document: Document, index: int) -> Floats:
    accessor, array = _read(document, index)
    values = np.asarray(array, dtype=np.float64)
    if accessor.normalized and array.dtype.kind in "iu":
        values = np.maximum(values / _LARGEST[accessor.component_type], -1.0)
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise SceneError(f"accessor {index} holds NaN or infinity; export the file again")
    return values


def read_indices(document: Document, index: int) -> npt.NDArray[np.int64]:
    """Return vertex indices, shape (count,)."""
    _, array = _read(document, index)
    if array.shape[1] != 1 or array.dtype.kind != "u":
        raise SceneError(f"accessor {index} holds no indices; use unsigned scalars")
    return np.asarray(array[:, 0], dtype=np.int64)


def _read(document: Document, index: int) -> tuple[Accessor, Numbers]:
    accessor = document.part("accessor", document.gltf.accessors, index)
    width = _WIDTHS.get(accessor.type)
    if width is None:
        raise SceneError(f"accessor {index} is {accessor.type}; vertices have no matrices")
    kind = _TYPES[accessor.component_type]
    document.budget.take("numbers of arrays", accessor.count * width)
    if accessor.buffer_view is None:
        array: Numbers = np.zeros((accessor.count, width), dtype=kind)
    else:
        start, count = accessor.byte_offset, accessor.count
        array = _strided(document, index, accessor.buffer_view, start, count, kind, width)
    if accessor.sparse is not None:
        array = _replaced(document, index, array, accessor.sparse)
    return accessor, array


def _strided(
    document: Document, index: int, view_index: int, start: int, count: int,
    kind: np.dtype[np.generic], width: int,
) -> Numbers:  # fmt: skip
    """Return elements of a buffer view, which may be interleaved with others; shares its memory."""
    view, content = document.view(view_index)
    size = kind.itemsize * width
    stride = view.byte_stride or size
    if stride < size:
        raise SceneError(f"accessor {index} has elements of {size} bytes, {stride} apart")
    end = start + (count - 1) * stride + size
    if end > len(content):
        raise SceneError(f"accessor {index} ends at byte {end} of {len(content)} of its view")
    rows: Numbers = np.ndarray((count, width), kind, content, start, (stride, kind.itemsize))
    return rows


def _replaced(document: Document, index: int, array: Numbers, sparse: Sparse) -> Numbers:
    """Return a copy of an array in which the elements of a sparse accessor are replaced."""
    count = sparse.count
    if count > len(array):
        raise SceneError(f"accessor {index} replaces {count} of {len(array)} elements")
    places, values = sparse.indices, sparse.values
    kind = _TYPES[places.component_type]
    start = places.byte_offset
    rows = _strided(document, index, places.buffer_view, start, count, kind, 1)[:, 0]
    if int(np.asarray(rows).max()) >= len(array):
        raise SceneError(f"accessor {index} replaces an element that it does not have")
    start, width = values.byte_offset, array.shape[1]
    new = _strided(document, index, values.buffer_view, start, count, array.dtype, width)
    changed = np.array(array)
    changed[np.asarray(rows, dtype=np.int64)] = new
    return changed
