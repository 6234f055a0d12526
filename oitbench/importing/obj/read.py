"""Reads a Wavefront file: one object for each object and material of the file."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from oitbench.importing import polygons, shapes
from oitbench.importing.content import Content, Names
from oitbench.importing.files import Folder
from oitbench.importing.limits import Budget, short
from oitbench.importing.notes import Notes
from oitbench.importing.obj.faces import Run, corners_of
from oitbench.importing.obj.materials import Library
from oitbench.importing.obj.text import keyword_of, lines_of, table_of
from oitbench.importing.shapes import Indices
from oitbench.scene import Floats, Mesh, Object

_STATE = ("v", "vt", "vn", "s", "usemtl", "o", "g")
"""Keywords after which faces mean something else; others may stand between faces of one run."""
_SILENT = ("", "#", "g", "vp", "cstype", "deg")


@dataclass
class _Lines:
    """The lines of a file by kind; faces in runs of equal state."""

    vertices: list[str] = field(default_factory=list)
    coordinates: list[str] = field(default_factory=list)
    normals: list[str] = field(default_factory=list)
    runs: dict[tuple[str, str], list[Run]] = field(default_factory=dict)
    libraries: list[str] = field(default_factory=list)

    def new_run(self, title: str, material: str, smooth: int) -> Run:
        """Return an empty run of faces that come after the lines so far."""
        before = len(self.vertices), len(self.coordinates), len(self.normals)
        run = Run(before, smooth)
        self.runs.setdefault((title, material), []).append(run)
        return run


def read_obj(folder: Folder, budget: Budget, notes: Notes) -> Content:
    """Return the content of an .obj file."""
    content = folder.read_main()
    budget.take("bytes of text", len(content))
    lines = _sorted(lines_of(content), notes)
    budget.take("vertices", len(lines.vertices))
    budget.take("nodes", len(lines.runs))
    library = Library(folder, budget, notes)
    for name in dict.fromkeys(lines.libraries):
        library.add(name)
    table = table_of(lines.vertices, 3, "v")
    data = _Data(
        table[:, :3],
        table[:, 3:6].clip(0, 1) if table.shape[1] >= 6 else None,
        table_of(lines.coordinates, 1, "vt"),
        table_of(lines.normals, 3, "vn"),
    )
    found, names = Content(), Names()
    for (title, material), runs in lines.runs.items():
        name = names.free(title or material or "mesh")
        mesh = _mesh(data, runs, budget, notes)
        if mesh is None:
            continue
        look = library.look(material, mesh.albedo)
        if look.textured:
            uvs = np.zeros((len(mesh.positions), 2)) if mesh.uvs is None else mesh.uvs
            if mesh.uvs is None:
                notes.add("a texture without coordinates shows one texel", name)
            uvs = np.asarray(uvs, dtype=np.float64) * look.scale + look.offset
        mesh = Mesh.from_arrays(
            mesh.positions, mesh.triangles, normals=mesh.normals, albedo=mesh.albedo,
            uvs=uvs if look.textured else None,
        )  # fmt: skip
        surface = look.on_mesh(mesh, notes, name)
        if surface is not None:
            found.objects.append(Object(name, mesh, surface))
    return found


def _sorted(lines: list[str], notes: Notes) -> _Lines:
    found = _Lines()
    title, group, material, smooth = "", "", "", 0
    run: Run | None = None
    for line in lines:
        key, rest = keyword_of(line)
        if key == "f":
            if run is None:
                run = found.new_run(title or group, material, smooth)
            run.faces.append(rest)
            continue
        if key in _STATE:
            run = None
        if key == "v":
            found.vertices.append(rest)
        elif key == "vt":
            found.coordinates.append(rest)
        elif key == "vn":
            found.normals.append(rest)
        elif key == "usemtl":
            material = rest
        elif key == "o":
            title = rest
        elif key == "g":
            group = rest
        elif key == "s":
            smooth = _smoothing(rest)
        elif key == "mtllib":
            found.libraries.append(rest)
        elif key in ("p", "l"):
            notes.add("points and lines are left out")
        elif key not in _SILENT and not key.startswith("#"):
            notes.add(f"'{short(key)}' of OBJ files is ignored")
    return found


def _smoothing(text: str) -> int:
    """Return the number of a smoothing group; 0 for flat faces."""
    if text in ("", "off"):
        return 0
    return min(int(text), 2**30) if text.isascii() and text.isdigit() else 1


@dataclass(frozen=True, eq=False)
class _Data:
    positions: Floats
    colors: Floats | None
    coordinates: Floats
    normals: Floats


def _mesh(data: _Data, runs: list[Run], budget: Budget, notes: Notes) -> Mesh | None:
    """Return the faces of some runs as a mesh; None if they have no area."""
    counts = len(data.positions), len(data.coordinates), len(data.normals)
    parts: list[Indices] = []
    for run in runs:
        for corners in corners_of(run, counts):
            places = polygons.cut(data.positions, corners[..., 0], budget, notes)
            triples = corners[places]
            smooth = np.full((*triples.shape[:2], 1), run.smooth)
            parts.append(np.concatenate([triples, smooth], axis=2))
    if not parts or not sum(map(len, parts)):
        return None
    triples = np.concatenate(parts)
    shaded = bool((triples[..., 2] >= 0).all())
    smoothed = not shaded and bool((triples[..., 3] > 0).any())
    if smoothed:
        # Flat faces share no vertex with others.
        flat = triples[..., 3] == 0
        triples[..., 3] = np.where(flat, -1 - np.arange(len(triples))[:, None], triples[..., 3])
    else:
        triples[..., 3] = 0
    if not shaded:
        triples[..., 2] = -1
    mapped = bool((triples[..., 1] >= 0).all())
    if not mapped:
        triples[..., 1] = -1
    corners, triangles = shapes.distinct_rows(triples.reshape(-1, 4))
    triangles = triangles.reshape(-1, 3)
    positions = data.positions[corners[:, 0]]
    normals: Floats | None = None
    if shaded:
        normals = shapes.unit_normals(data.normals[corners[:, 2]][:, :3], positions, triangles)
    elif smoothed:
        normals = shapes.mean_normals(positions, triangles)
    return Mesh.from_arrays(
        positions, triangles, normals=normals,
        uvs=_pairs(data.coordinates[corners[:, 1]]) if mapped else None,
        albedo=None if data.colors is None else data.colors[corners[:, 0]],
    )  # fmt: skip


def _pairs(coordinates: Floats) -> Floats:
    """Return coordinates of which the second is 0 if a file has only one."""
    if coordinates.shape[1] >= 2:
        return coordinates[:, :2]
    return np.stack([coordinates[:, 0], np.zeros(len(coordinates))], axis=1)
