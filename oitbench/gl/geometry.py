"""A scene on the device: one vertex buffer, so that any draw order is an order of indices."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.errors import SceneError, UsageError
from oitbench.gl.device import Device
from oitbench.method.declaration import Objects, Order
from oitbench.scene import BLACK, FragmentLists, Material, Object, Scene, Texture
from oitbench.scene.texturing import premultiplied_pyramid

if TYPE_CHECKING:
    from oitbench.gl.shading.lighting import Lighting

VERTEX = np.dtype(
    [
        ("in_position", "f4", 3),
        ("in_uv", "f4", 2),
        ("in_radiance", "f4", 3),
        ("in_transmission", "f4", 3),
        ("in_coverage", "f4"),
        ("in_layer", "f4"),
        ("in_normal", "f4", 3),
        ("in_material", "f4"),
    ]
)
VERTEX_FORMAT = "3f4 2f4 3f4 3f4 1f4 1f4 3f4 1f4"
_UNTEXTURED = -1.0


@dataclass(frozen=True)
class Batch:
    """Triangles that are drawn together: indices into the geometry's vertices, (m, 3) uint32.

    `units` gives each object's (first triangle, count); `keys` the view distance of each triangle's
    centroid and `unit_keys` that of each object's bounding box center, in metres.
    """

    triangles: npt.NDArray[np.uint32]
    units: npt.NDArray[np.int64]
    keys: npt.NDArray[np.float64]
    unit_keys: npt.NDArray[np.float64]

    def arrange(
        self, order: Order, permutation: int | None = None
    ) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.int64]]:
        """Return the triangles in `order`, and the (first, count) of each unit.

        Parameters
        ----------
        order : Order
        permutation : int, optional
            Seed by which units, and triangles within them, are shuffled before any sort.
        """
        count = len(self.triangles)
        rank = np.arange(count)
        units = np.arange(len(self.units))
        if permutation is not None:
            generator = np.random.default_rng(permutation)
            rank, units = generator.permutation(count), generator.permutation(units)
        if order is Order.TRIANGLES:
            # Ties break by the triangle's own number, so that a permutation changes nothing.
            chosen = np.lexsort((np.arange(count), -self.keys))
            return self.triangles[chosen], np.stack([np.arange(count), np.ones(count, int)], axis=1)
        if order is Order.OBJECTS:
            units = np.lexsort((np.arange(len(self.units)), -self.unit_keys))
        if order is Order.SUBMISSION and permutation is not None and len(units) == 1:
            return self.triangles[rank], self.units
        runs = [np.arange(first, first + size) for first, size in self.units[units]]
        if permutation is not None:
            runs = [run[np.argsort(rank[run])] for run in runs]
        chosen = np.concatenate(runs) if runs else np.zeros(0, dtype=np.int64)
        sizes = self.units[units, 1]
        return self.triangles[chosen], np.stack([np.cumsum(sizes) - sizes, sizes], axis=1)


class Geometry:
    """All of a scene that lives on the device.

    Parameters
    ----------
    device : Device
    scene : Scene

    Attributes
    ----------
    opaque, transparent : Batch
    casting : Batch
        What is transparent and casts shadows.
    cutouts : Batch
        What is transparent and of binary coverage.
    batches : dict of Objects to Batch
        What is transparent, by what a pass asks for.
    vertices : moderngl.Buffer
    textures : dict of str to moderngl.TextureArray or moderngl.Texture
        Samplers of the surface shader by name.
    complexities : dict of (width, height), bool to array
        Fragments a pixel at the frame sizes that were counted, without and with those of binary
        coverage that are opaque under ambient occlusion.
    lightings : dict of Effect to Lighting
        The shadow maps that were drawn, by the effects of shading that ran.
    """

    def __init__(self, device: Device, scene: Scene) -> None:
        if scene.lists is not None and scene.objects:
            raise SceneError(f"scene {scene.name}: fragment lists cannot be mixed with objects")
        self.scene = scene
        self.textures: dict[str, moderngl.TextureArray | moderngl.Texture] = {}
        self.layers: dict[int, int] = {}
        self._storeys = 1
        self.complexities: dict[tuple[tuple[int, int], bool], npt.NDArray[np.int64]] = {}
        self.lightings: dict[Effect, Lighting] = {}
        if scene.lists is not None:
            self._upload_lists(device, scene.lists)
        self._upload_textures(device, scene)
        self.materials = _distinct(scene.objects)
        if any(_reflects_or_bends(material) for material in self.materials):
            self._upload_materials(device)
        parts: list[npt.NDArray[np.void]] = []
        self.opaque = self._batch(scene.opaque, parts)
        self.transparent = (
            self._list_batch(scene.lists, parts)
            if scene.lists is not None
            else self._batch(scene.transparent, parts)
        )
        self.casting = self._part(scene.transparent, lambda item: item.casts)
        self.cutouts = self._part(scene.transparent, lambda item: item.material.binary_coverage)
        particles = self._part(scene.transparent, lambda item: item.particles)
        others = self._part(scene.transparent, lambda item: not item.particles)
        self.batches = {
            Objects.ALL: self.transparent,
            Objects.PARTICLES: particles,
            Objects.OTHERS: others if len(particles.triangles) else self.transparent,
        }
        vertices = np.concatenate(parts) if parts else np.zeros(1, VERTEX)
        self.vertices = device.context.buffer(vertices.tobytes())

    @property
    def macros(self) -> str:
        """What the surface shader must know at compile time."""
        if self.scene.lists is not None:
            return f"#define LISTS {self._storeys}"
        found = {"TEXTURED": "surface_textures", "DETAILED": "surface_materials"}
        return "\n".join(f"#define {k} 1" for k, name in found.items() if name in self.textures)

    @property
    def present(self) -> frozenset[Objects]:
        """Choices of objects that the scene has any of; of all, always."""
        found = {kind for kind, batch in self.batches.items() if len(batch.triangles)}
        return frozenset({Objects.ALL, *found})

    def _part(self, objects: tuple[Object, ...], chosen: Callable[[Object], bool]) -> Batch:
        """Return those of the transparent objects that are `chosen`."""
        units = [self.transparent.units[k] for k, item in enumerate(objects) if chosen(item)]
        runs = [np.arange(first, first + count) for first, count in units]
        kept = np.concatenate(runs) if runs else np.zeros(0, dtype=np.int64)
        sizes = np.array([count for _, count in units], dtype=np.int64)
        return Batch(
            self.transparent.triangles[kept],
            np.stack([np.cumsum(sizes) - sizes, sizes], axis=1),
            self.transparent.keys[kept],
            np.array([self.transparent.unit_keys[k] for k, o in enumerate(objects) if chosen(o)]),
        )

    def _batch(self, objects: tuple[Object, ...], parts: list[npt.NDArray[np.void]]) -> Batch:
        base = sum(len(part) for part in parts)
        triangles, units, keys, unit_keys = [], [], [], []
        first = 0
        for item in objects:
            mesh, camera = item.mesh, self.scene.camera
            parts.append(self._vertices(item))
            triangles.append(mesh.triangles.astype(np.uint32) + np.uint32(base))
            base += len(mesh.positions)
            units.append((first, len(mesh.triangles)))
            first += len(mesh.triangles)
            corners = mesh.positions[mesh.triangles].astype(np.float64)
            keys.append(camera.view_distance(corners.mean(axis=1)))
            box = (mesh.positions.min(axis=0) + mesh.positions.max(axis=0)) / 2
            unit_keys.append(camera.view_distance(box))
        return Batch(
            np.concatenate(triangles) if triangles else np.zeros((0, 3), np.uint32),
            np.array(units, dtype=np.int64).reshape(-1, 2),
            np.concatenate(keys) if keys else np.zeros(0),
            np.array(unit_keys, dtype=np.float64),
        )

    def _vertices(self, item: Object) -> npt.NDArray[np.void]:
        mesh, material = item.mesh, item.material
        layer = self.layers.get(id(material))
        vertices = np.zeros(len(mesh.positions), VERTEX)
        vertices["in_position"] = mesh.positions
        vertices["in_uv"] = 0.0 if mesh.uvs is None else mesh.uvs
        # A texture carries what it replaces: the vertex keeps the factor that remains.
        emission = (1, 1, 1) if isinstance(material.emission, Texture) else material.emission
        if layer is not None:
            emission = (1, 1, 1)
        factor = 1.0 if mesh.radiance is None else mesh.radiance
        vertices["in_radiance"] = np.asarray(emission, dtype=np.float32) * factor
        vertices["in_transmission"] = material.transmission
        coverage = 1.0 if layer is not None else material.coverage
        vertices["in_coverage"] = 1.0 if isinstance(coverage, Texture) else coverage
        vertices["in_layer"] = _UNTEXTURED if layer is None else layer
        # A normal of zero stands for the triangle's own.
        vertices["in_normal"] = 0.0 if mesh.normals is None else mesh.normals
        vertices["in_material"] = self.materials.index(material)
        return vertices

    def _upload_materials(self, device: Device) -> None:
        rows = np.array([_material_row(item) for item in self.materials], dtype=np.float32)
        texture = device.context.texture((2, len(rows)), 4, rows.tobytes(), dtype="f4")
        texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.textures["surface_materials"] = texture

    def _upload_textures(self, device: Device, scene: Scene) -> None:
        pyramids = {
            id(item.material): premultiplied_pyramid(item.material) for item in scene.objects
        }
        kept = {key: levels for key, levels in pyramids.items() if levels is not None}
        if not kept:
            return
        self.layers = {key: layer for layer, key in enumerate(kept)}
        sizes = {levels[0].shape[:2] for levels in kept.values()}
        if len(sizes) > 1:
            raise SceneError(
                f"scene {scene.name}: textures of {sorted(sizes)}; give all of them one size"
            )
        height, width = sizes.pop()
        array = device.context.texture_array((width, height, len(kept)), 4, dtype="f4")
        array.build_mipmaps()
        for layer, levels in enumerate(kept.values()):
            for level, image in enumerate(levels):
                rows, columns = image.shape[:2]
                device.write_layer(array, level, layer, (columns, rows), image[::-1])
        array.filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
        array.repeat_x = array.repeat_y = False
        self.textures["surface_textures"] = array

    def _upload_lists(self, device: Device, lists: FragmentLists) -> None:
        layers, height, width = lists.z.shape
        limit = int(device.context.info["GL_MAX_ARRAY_TEXTURE_LAYERS"])
        # Beyond the driver's limit on layers of a texture, each holds several, one above another.
        self._storeys = math.ceil(layers / limit)
        stored = math.ceil(layers / self._storeys)
        if max(self._storeys * height, width) > device.max_side:
            raise UsageError(
                f"fragment lists of {layers} layers of {width}x{height} are beyond this driver"
            )
        spare = [(0, self._storeys * stored - layers), (0, 0), (0, 0), (0, 0)]
        for name, color, last in (
            ("list_radiance", lists.radiance, lists.coverage),
            ("list_transmission", lists.transmission, lists.z),
        ):
            data = np.concatenate([color, last[..., None]], axis=-1)[:, ::-1].astype(np.float32)
            storeys = np.pad(data, spare).reshape(self._storeys, stored, height, width, 4)
            array = device.context.texture_array(
                (width, self._storeys * height, stored),
                4,
                storeys.swapaxes(0, 1).tobytes(),
                dtype="f4",
            )
            array.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self.textures[name] = array

    @staticmethod
    def _list_batch(lists: FragmentLists, parts: list[npt.NDArray[np.void]]) -> Batch:
        layers = len(lists.z)
        vertices = np.zeros((layers, 3), VERTEX)
        vertices["in_position"] = [(-1, -1, 0), (3, -1, 0), (-1, 3, 0)]
        vertices["in_layer"] = np.arange(layers)[:, None]
        parts.append(vertices.reshape(-1))
        # One whole-frame triangle a layer: a layer's mean depth is the best key there is.
        keys = lists.z.mean(axis=(1, 2), dtype=np.float64)
        units = np.stack([np.arange(layers), np.ones(layers, dtype=np.int64)], axis=1)
        triangles = np.arange(3 * layers, dtype=np.uint32).reshape(-1, 3)
        return Batch(triangles, units, keys, keys)

    def release(self) -> None:
        """Free the device's memory."""
        for lighting in self.lightings.values():
            lighting.release()
        self.vertices.release()
        for texture in self.textures.values():
            texture.release()


def _distinct(objects: tuple[Object, ...]) -> list[Material]:
    """Return the materials in order of first use; each is one object, compared by identity."""
    return list({id(item.material): item.material for item in objects}.values())


def _reflects_or_bends(material: Material) -> bool:
    """Tell whether light does more at the surface than to be covered, tinted and emitted."""
    plain = material.albedo == BLACK and material.reflectance == 0 and material.collimation == 1
    return not plain or material.refracts


def _material_row(material: Material) -> list[float]:
    """Return the eight numbers that `surface_at` (shading.glsl) reads."""
    index = material.index if material.refracts else 1.0
    flags = int(material.isotropic) + 2 * int(material.binary_coverage)
    return [
        *material.albedo, material.reflectance,
        material.roughness, index, material.collimation, float(flags),
    ]  # fmt: skip
