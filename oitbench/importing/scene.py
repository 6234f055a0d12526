"""Builds a scene from a file of a user: reads it, and adds what it lacks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError, UsageError
from oitbench.importing import framing
from oitbench.importing.content import Content, Names
from oitbench.importing.files import Folder
from oitbench.importing.gltf.beams import FRAME
from oitbench.importing.gltf.read import read_gltf
from oitbench.importing.limits import Budget
from oitbench.importing.notes import Notes
from oitbench.importing.obj.read import read_obj
from oitbench.importing.ply.read import read_ply
from oitbench.parameters import AnyParameter, Parameter, Value
from oitbench.places import IMPORTED
from oitbench.scene import DirectionalLight, EnvironmentLight, Light, Scene, Texture, Vector

AUTO, NONE = "auto", "none"
_READERS: Mapping[str, Callable[[Folder, Budget, Notes], Content]] = {
    ".glb": read_gltf, ".gltf": read_gltf, ".obj": read_obj, ".ply": read_ply,
}  # fmt: skip
assert set(_READERS) == set(IMPORTED)

PARAMETERS: Mapping[str, AnyParameter] = {
    "light": Parameter(
        AUTO,
        choices=(AUTO, "file", "sun", NONE),
        help="auto: those of the file, or a sun if it has none",
    ),
    "environment": Parameter(
        AUTO, help="an .hdr, .exr, .png or .jpg by latitude and longitude; auto: a soft sky; none"
    ),
    "ground": Parameter(
        AUTO, choices=(AUTO, "yes", "no"), help="auto: a ground if the file has none"
    ),
    "exposure": Parameter(
        0.0, low=-60, high=60, help="stops, beside those that suit the lights of the file"
    ),
    "unit": Parameter(1.0, low=1e-6, high=1e6, help="length of the file's unit, m"),
    "up": Parameter("y", choices=("y", "z"), help="axis of the file that points up"),
    "limit": Parameter(1.0, low=0.01, high=100.0, help="factor on the limits of size"),
}
"""Parameters of every imported scene."""


def with_defaults(**values: Value) -> Mapping[str, AnyParameter]:
    """Return `PARAMETERS` with other defaults.

    Raises
    ------
    UsageError
        A value is not allowed.
    """
    found = dict(PARAMETERS)
    for name, value in values.items():
        checked = PARAMETERS[name].check("import", name, value)
        found[name] = replace(PARAMETERS[name], default=checked)
    return found


@dataclass(frozen=True, eq=False)
class Imported:
    """A scene that was read from a file.

    Parameters
    ----------
    scene : Scene
    notes : tuple of str
        What it shows differently from its file: one line for each kind.
    files : mapping of str to Path
        Files beside it that were read, by their paths relative to its folder.
    """

    scene: Scene
    notes: tuple[str, ...]
    files: Mapping[str, Path]


def read_scene(
    file: Path | str,
    name: str = "",
    *,
    light: str = AUTO,
    environment: str = AUTO,
    ground: str = AUTO,
    exposure: float = 0.0,
    unit: float = 1.0,
    up: str = "y",
    limit: float = 1.0,
) -> Imported:
    """Read a .glb, .gltf, .obj or .ply file as a scene.

    Nothing is read but the file, regular files of its own folder that it names, and `environment`.

    Parameters
    ----------
    file : path
    name : str
        Name of the scene. Default: that of the file.
    light, environment, ground, exposure, unit, up, limit
        See `PARAMETERS`.

    Raises
    ------
    SceneError
        The file is damaged, refers to other places, or is too large.
    UsageError
        The format is unknown.
    """
    path = Path(file)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise UsageError(f"{path}: unknown format; give one of {', '.join(_READERS)}")
    notes, budget = Notes(), Budget(limit)
    folder = Folder(path, budget)
    try:
        with np.errstate(over="ignore", invalid="ignore", under="ignore"):
            content = reader(folder, budget, notes)
        if up == "z":
            content = _turned(content)
        scene = _complete(
            path, content, name or path.stem, notes, light, environment, ground, exposure, unit
        )
    except (MemoryError, OverflowError) as error:
        raise SceneError("it needs more memory than there is") from error
    return Imported(scene, notes.lines, folder.read_files)


def _complete(
    file: Path, content: Content, name: str, notes: Notes, light: str, environment: str,
    ground: str, exposure: float, unit: float,
) -> Scene:  # fmt: skip
    low, high = content.bounds
    beams: list[Light] = [*content.lights, *framing.spots(content.points, low, high, notes)]
    if light == NONE:
        beams = []
    elif light == "sun" or (light == AUTO and not beams and environment in (AUTO, NONE)):
        beams = [framing.sun()]
    stops = framing.stops_for(beams, low, high, unit)
    if stops:
        notes.add(f"the lights of the file suit an exposure of {stops:+g} stops")
    around = _environment(file, environment, stops)
    objects = list(content.objects)
    below = None if ground == "no" else framing.ground(objects, low, high, ground == "yes")
    if below is not None:
        names = Names(item.name for item in objects)
        objects.append(replace(below, name=names.free(below.name)))
    views = {key: framing.aimed(camera, low, high) for key, camera in content.cameras.items()}
    camera = next(iter(views.values()), None)
    return Scene(
        name,
        framing.frame(low, high) if camera is None else camera,
        tuple(objects),
        lights=(*beams, *around),
        exposure=stops + exposure,
        meters_per_unit=unit,
        views=views if camera is None else {**views, FRAME: framing.frame(low, high)},
    )


def environment_file(file: Path, text: str) -> Path | None:
    """Return the picture that a value of `environment` names: beside `file`, else from anywhere.

    None if the value is auto or none.
    """
    if text in (AUTO, NONE):
        return None
    beside = file.parent / text
    return beside if beside.is_file() else Path(text)


def _environment(file: Path, text: str, stops: float) -> list[EnvironmentLight]:
    picture = environment_file(file, text)
    if picture is not None:
        from oitbench.image.reading import read_image

        return [EnvironmentLight(Texture(np.ascontiguousarray(read_image(picture)[..., :3])))]
    if text == NONE:
        return []
    sky = framing.sky()
    # It is as bright beside the lights of a file as beside the sun.
    return [EnvironmentLight(Texture(sky.texels.astype(np.float32) * np.float32(2**-stops)))]


def _turned(content: Content) -> Content:
    """Return a content whose z axis points up with y up: (x, y, z) becomes (x, z, −y)."""

    def rows(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.stack([values[:, 0], values[:, 2], -values[:, 1]], axis=1)

    def one(vector: Vector) -> Vector:
        x, y, z = vector
        return x, z, -y

    objects = []
    for item in content.objects:
        mesh, normals = item.mesh, item.mesh.normals
        turned = replace(
            mesh,
            positions=rows(mesh.positions),
            normals=None if normals is None else rows(normals),
        )
        objects.append(replace(item, mesh=turned))
    cameras = {
        name: replace(c, position=one(c.position), target=one(c.target), up=one(c.up))
        for name, c in content.cameras.items()
    }
    lights = [
        replace(light, direction=one(light.direction))
        if isinstance(light, DirectionalLight)
        else replace(light, position=one(light.position), target=one(light.target))
        for light in content.lights
    ]
    points = [replace(point, position=one(point.position)) for point in content.points]
    return Content(objects, cameras, lights, points)
