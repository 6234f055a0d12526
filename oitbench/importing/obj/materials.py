"""Materials of a Wavefront file (.mtl); CONVENTIONS.md has the table of what becomes of them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from oitbench.errors import SceneError
from oitbench.importing.files import Folder, MissingFileError
from oitbench.importing.limits import Budget, short
from oitbench.importing.looks import METAL, PLASTIC, VERTICES, color, divided, roughness_of_exponent
from oitbench.importing.notes import Notes
from oitbench.importing.obj.text import keyword_of, lines_of, numbers_of
from oitbench.importing.pictures import Bytes, fractions, linear, read_picture
from oitbench.importing.shapes import encloses
from oitbench.importing.values import Canvas, Values, same_size
from oitbench.scene import Array, Material, Mesh, Wrap
from oitbench.scene.vectors import BLACK

_NUMBERS = {"Ka": 3, "Kd": 3, "Ks": 3, "Ke": 3, "Ns": 1, "Ni": 1, "d": 1, "Tr": 1, "illum": 1,
            "Pr": 1, "Pm": 1}  # fmt: skip
_MAPS = ("map_Kd", "map_d", "map_Ke")
_SILENT = ("Ka", "map_Ka", "sharpness")
"""Ambient reflection: there is none in oitbench."""
_GLASS, _REFRACTING, _UNLIT = (4, 6, 7, 9), (6, 7), 0
_OPTIONS = {"-blendu": 1, "-blendv": 1, "-boost": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3,
            "-texres": 1, "-clamp": 1, "-bm": 1, "-imfchan": 1, "-type": 1, "-cc": 1}  # fmt: skip
DEFAULT = Material(albedo=(0.6, 0.6, 0.6), specular=PLASTIC, roughness=0.6)
"""The material of faces that name none."""


@dataclass
class _Described:
    name: str
    values: dict[str, list[float]] = field(default_factory=dict)
    maps: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Look:
    """A material before the mesh is known; refracts if the mesh is closed and `solid` is set."""

    material: Material
    textured: bool = False
    solid: bool = False
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)

    def on_mesh(self, mesh: Mesh, notes: Notes, name: str) -> Material | None:
        """Return the material on a mesh; None if nothing of it can be seen."""
        if self.material.coverage == 0:
            return None
        if not self.solid:
            return self.material
        if encloses(mesh):
            return replace(self.material, solid=True)
        notes.add("glass that its mesh does not enclose is a thin sheet", name)
        return self.material


class Library:
    """Materials by name, from all files that a mesh names."""

    def __init__(self, folder: Folder, budget: Budget, notes: Notes) -> None:
        self._folder, self._budget, self._notes = folder, budget, notes
        self._described: dict[str, _Described] = {}
        self._looks: dict[str, Look] = {}
        self._pictures: dict[str, Bytes] = {}

    def add(self, name: str) -> None:
        """Read a file of materials; a missing one is noted."""
        try:
            content = self._folder.read(name)
        except MissingFileError:
            self._notes.add("a file of materials is missing; its surfaces are gray", name)
            return
        self._budget.take("bytes of text", len(content))
        current: _Described | None = None
        for line in lines_of(content):
            key, rest = keyword_of(line)
            if key == "newmtl":
                self._budget.take("nodes", 1)
                current = self._described.setdefault(rest, _Described(rest))
            elif key and not key.startswith("#") and current is not None:
                self._read(current, key, rest)

    def look(self, name: str, colors: Array | None) -> Look:
        """Return the look of a material; a gray one if it is unknown.

        Only metals depend on `colors`, those of the vertices, shape (n, 3).
        """
        described = self._described.get(name)
        if described is not None and colors is not None and "Pm" in described.values:
            return self._made(described, colors)
        if name not in self._looks:
            if described is None:
                if name:
                    self._notes.add("materials that no file describes are gray", name)
                self._looks[name] = Look(DEFAULT)
            else:
                self._looks[name] = self._made(described, None)
        return self._looks[name]

    def _read(self, current: _Described, key: str, rest: str) -> None:
        if key in _NUMBERS or key == "Tf":
            words = rest.split()
            if words and words[0] in ("xyz", "spectral"):
                self._notes.add(f"{key} {words[0]} is ignored; use RGB", current.name)
                return
            values = numbers_of(rest, f"{key} {rest}")
            count = _NUMBERS.get(key, 3)
            if not values:
                raise SceneError(f"material '{short(current.name)}': {key} has no number")
            # One number stands for three equal ones.
            current.values[key] = (
                (values * count)[:count] if len(values) < count else values[:count]
            )
        elif key in _MAPS:
            current.maps[key] = rest
        elif key not in _SILENT:
            self._notes.add(f"'{short(key)}' of materials is ignored", current.name)

    def _made(self, described: _Described, colors: Array | None) -> Look:
        values, maps = described.values, described.maps
        illum = int(values.get("illum", [2])[0])
        scale, offset, clamp = (1.0, 1.0), (0.0, 0.0), False
        pictures: dict[str, Bytes] = {}
        for key in _MAPS:
            if key in maps:
                name, options = self._split(maps[key], described.name)
                if not pictures:
                    scale, offset, clamp = options
                elif options != (scale, offset, clamp):
                    self._notes.add("maps of a material lie as its first one", described.name)
                found = self._picture(name)
                if found is not None:
                    pictures[key] = found
        base = _color(values.get("Kd", [0.6] * 3))
        alpha = np.array([_fraction(values, "d", 1 - _fraction(values, "Tr", 0.0))], np.float32)
        glow = np.maximum(np.array(values.get("Ke", [0.0] * 3), dtype=np.float32), 0)
        albedo: Values = base
        if "map_Kd" in pictures:
            albedo = base * linear(pictures["map_Kd"][..., :3])
            if "map_d" not in maps and (pictures["map_Kd"][..., 3] < 255).any():
                self._notes.add("alpha of map_Kd is ignored; name it in map_d", described.name)
        if "map_d" in pictures:
            alpha = alpha * _opacity(pictures["map_d"])
        if "map_Ke" in pictures:
            glow = (glow if glow.any() else np.ones(3, np.float32)) * linear(
                pictures["map_Ke"][..., :3]
            )
        albedo, alpha, glow = same_size(albedo, alpha, glow)
        wrap = Wrap.CLAMP if clamp else Wrap.REPEAT
        canvas = Canvas(self._budget, (wrap, wrap))
        material = Material(coverage=canvas.scalar(alpha), emission=canvas.color(glow))
        passes = illum in _GLASS and "Tf" in values
        if illum == _UNLIT:
            material = replace(material, emission=canvas.color(albedo), specular=0.0)
        else:
            material = self._lit(material, described, canvas, albedo, passes, colors)
        index = values.get("Ni", [1.0])[0]
        solid = passes and illum in _REFRACTING and index > 1
        return Look(material, bool(pictures), solid, scale, offset)

    def _lit(
        self, material: Material, described: _Described, canvas: Canvas, albedo: Values,
        passes: bool, colors: Array | None,
    ) -> Material:  # fmt: skip
        values = described.values
        index = max(1.0, min(values.get("Ni", [1.0])[0], 100.0))
        shiny = float(np.mean(values.get("Ks", [0.0]))) > 0 and values.get("illum", [2])[0] >= 2
        metal = _fraction(values, "Pm", 0.0)
        rough = roughness_of_exponent(values["Ns"][0]) if "Ns" in values else 0.6
        specular = None if index > 1 and (shiny or passes) else PLASTIC if shiny else 0.0
        if metal > 0:
            found = divided(albedo, np.array([metal], np.float32), np.zeros(1, np.float32), colors)
            plain = PLASTIC if specular is None else specular
            albedo = found.albedo
            specular = (1 - metal) * plain + metal * found.mirrored
            if colors is not None and (colors != colors[0]).any():
                self._notes.add(VERTICES, described.name)
            if found.colored_metal:
                self._notes.add(METAL, described.name)
        tint = color(np.clip(values["Tf"], 0, 1)) if passes else BLACK
        return replace(
            material,
            # Glass scatters no light; its Kd is what viewers without refraction show.
            albedo=BLACK if passes else canvas.color(albedo),
            transmission=tint,
            specular=specular,
            roughness=_fraction(values, "Pr", rough),
            index=index,
        )

    def _split(
        self, text: str, owner: str
    ) -> tuple[str, tuple[tuple[float, float], tuple[float, float], bool]]:
        """Return the name of a map, and its scale, its offset, and whether it is clamped."""
        words = text.split()
        scale, offset, clamp = (1.0, 1.0), (0.0, 0.0), False
        while words and words[0] in _OPTIONS:
            key, most = words[0], _OPTIONS[words[0]]
            taken = words[1 : 2 + most - 1]
            count = len(taken)
            if key in ("-o", "-s", "-t"):
                count = next((k for k, word in enumerate(taken) if not _is_number(word)), count)
                numbers = [float(word) for word in taken[:count]]
                pair = (*numbers, 1.0, 1.0) if key == "-s" else (*numbers, 0.0, 0.0)
                if key == "-s":
                    scale = pair[0], pair[1]
                elif key == "-o":
                    offset = pair[0], pair[1]
            elif key == "-clamp":
                clamp = taken == ["on"]
            else:
                self._notes.add(f"the option {key} of maps is ignored", owner)
            words = words[1 + count :]
        return " ".join(words), (scale, offset, clamp)

    def _picture(self, name: str) -> Bytes | None:
        if name not in self._pictures:
            try:
                content = self._folder.read(name)
            except MissingFileError:
                self._notes.add("a picture is missing; its surfaces have no texture", name)
                return None
            self._pictures[name] = read_picture(content, name, self._budget)
        return self._pictures[name]


def _is_number(word: str) -> bool:
    try:
        return bool(np.isfinite(float(word)))
    except ValueError:
        return False


def _color(values: list[float]) -> Values:
    return np.asarray(np.array(values, dtype=np.float32).clip(0, 1))


def _fraction(values: dict[str, list[float]], key: str, default: float) -> float:
    return float(np.clip(values.get(key, [default])[0], 0, 1))


def _opacity(pixels: Bytes) -> Values:
    """Return alpha of a picture, or its brightness if it has no alpha."""
    alpha = pixels[..., 3:]
    if (alpha < 255).any():
        return fractions(alpha)
    return np.asarray(fractions(pixels[..., :3]).mean(axis=-1, keepdims=True))
