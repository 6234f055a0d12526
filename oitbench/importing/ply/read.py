"""Reads a PLY file as one mesh with colors and alpha of its vertices."""

from __future__ import annotations

import numpy as np

from oitbench.errors import SceneError
from oitbench.image.pictures import from_srgb
from oitbench.importing import polygons, shapes
from oitbench.importing.content import Content
from oitbench.importing.files import Folder
from oitbench.importing.limits import Budget, short
from oitbench.importing.looks import PLASTIC
from oitbench.importing.notes import Notes
from oitbench.importing.ply.body import BinaryBody, Body, Columns, TextBody
from oitbench.importing.ply.header import Element, read_header
from oitbench.scene import Floats, Material, Mesh, Object
from oitbench.scene.vectors import WHITE

_COLORS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), tuple("rgb"))
_ALPHA = ("alpha", "diffuse_alpha", "a")
_GRAY = (0.6, 0.6, 0.6)
_ROUGHNESS = 0.6
_LISTS = ("vertex_indices", "vertex_index")


def read_ply(folder: Folder, budget: Budget, notes: Notes) -> Content:
    """Return the content of a .ply file."""
    content = folder.read_main()
    order, elements, head, start = read_header(content)
    if b"TextureFile" in head:
        notes.add("textures of PLY files are ignored")
    if order:
        body: Body = BinaryBody(memoryview(content)[start:])
    else:
        budget.take("bytes of text", len(content))
        body = TextBody(content[start:])
    vertices: Columns = {}
    found: list[shapes.Indices] = []
    kinds: dict[str, np.dtype[np.generic]] = {}
    for element in elements:
        _check_rows(element, len(content) - start)
        if element.name == "vertex" and not vertices:
            budget.take("vertices", element.rows)
            if element.has_lists:
                raise SceneError("its vertices have lists; export plain vertices")
            vertices = body.columns(element)
            kinds = {item.name: item.type for item in element.properties}
        elif element.name == "face":
            if any(item.name in _COLORS[0] for item in element.properties):
                notes.add("colors of faces are ignored; those of vertices count")
            found += body.lists(element, _LISTS)
        else:
            notes.add(f"elements '{short(element.name)}' are left out")
            body.lists(element, ())
    return Content([_object(vertices, kinds, found, budget, notes)])


def _check_rows(element: Element, size: int) -> None:
    """Refuse more rows than bytes, so that no loop runs long for a small file."""
    if element.rows > size or (element.rows and not element.properties):
        raise SceneError(
            f"element '{short(element.name)}' has {element.rows} rows; the file is too short"
        )


def _object(
    vertices: Columns, kinds: dict[str, np.dtype[np.generic]], faces: list[shapes.Indices],
    budget: Budget, notes: Notes,
) -> Object:  # fmt: skip
    positions = _vectors(vertices, ("x", "y", "z"))
    if positions is None:
        raise SceneError("its vertices have no x, y and z")
    for name, values in vertices.items():
        if not np.isfinite(values).all():
            raise SceneError(f"'{short(name)}' holds NaN or infinity; export the file again")
    parts = [rows[polygons.cut(positions, rows, budget, notes)] for rows in faces if len(rows)]
    triangles = np.concatenate(parts) if parts else np.zeros((0, 3), dtype=np.int64)
    if not len(triangles):
        raise SceneError("it has no triangle that can be seen; points have no surface")
    used, triangles = shapes.compact(positions, triangles)
    positions = positions[used]
    normals = _vectors(vertices, ("nx", "ny", "nz"))
    if normals is not None:
        normals = shapes.unit_normals(normals[used], positions, triangles)
    colors = next(
        (c for names in _COLORS if (c := _linear(vertices, kinds, names)) is not None), None
    )
    alpha = next((_fraction(vertices[n], kinds[n]) for n in _ALPHA if n in vertices), None)
    if alpha is not None and (alpha == 1).all():
        alpha = None
    mesh = Mesh.from_arrays(
        positions, triangles, normals=normals,
        albedo=None if colors is None else colors[used],
        coverage=None if alpha is None else alpha[used],
    )  # fmt: skip
    albedo = _GRAY if colors is None else WHITE
    return Object("mesh", mesh, Material(albedo=albedo, specular=PLASTIC, roughness=_ROUGHNESS))


def _vectors(vertices: Columns, names: tuple[str, ...]) -> Floats | None:
    if any(name not in vertices for name in names):
        return None
    return np.stack([vertices[name] for name in names], axis=1)


def _linear(
    vertices: Columns, kinds: dict[str, np.dtype[np.generic]], names: tuple[str, ...]
) -> Floats | None:
    """Return colors: whole numbers are encoded as sRGB, others are linear."""
    if any(name not in vertices for name in names):
        return None
    encoded = np.stack([_fraction(vertices[name], kinds[name]) for name in names], axis=1)
    if kinds[names[0]].kind == "f":
        return encoded
    return np.asarray(from_srgb(encoded), dtype=np.float64)


def _fraction(values: Floats, kind: np.dtype[np.generic]) -> Floats:
    largest = 1.0 if kind.kind == "f" else float(np.iinfo(kind).max)  # type: ignore[type-var]
    return np.asarray((values / largest).clip(0, 1))
