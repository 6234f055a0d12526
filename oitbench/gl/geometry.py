"""Triangles, materials and textures of a scene on the device.

All vertices share one buffer, so that any draw order is an order of indices.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError, UsageError
from oitbench.gl.batches import Batch, IndexOrder, batch_of, part_of
from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner
from oitbench.method.passes import Objects, Order
from oitbench.scene import BLACK, FragmentLists, Material, Object, Scene, Texture
from oitbench.scene.texturing import premultiplied_pyramid

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


class Geometry(Owner):
    """Triangles, materials and textures of a scene on the device.

    Parameters
    ----------
    device : Device
    scene : Scene

    Attributes
    ----------
    opaque, transparent : Batch
    casting : Batch
        Transparent objects that cast shadows.
    cutouts : Batch
        Transparent objects of binary coverage.
    batches : dict of Objects to Batch
        Transparent objects by the choice of a pass.
    vertices : moderngl.Buffer
    textures : dict of str to moderngl.TextureArray or moderngl.Texture
        Samplers of the surface shader by name.

    Raises
    ------
    SceneError
        The scene mixes fragment lists and objects, or its textures have several sizes.
    UsageError
        The fragment lists exceed the driver's limits.
    """

    def __init__(self, device: Device, scene: Scene) -> None:
        if scene.lists is not None and scene.objects:
            raise SceneError(f"scene {scene.name}: fragment lists cannot be mixed with objects")
        super().__init__()
        self.scene = scene
        self.textures: dict[str, moderngl.TextureArray | moderngl.Texture] = {}
        self._device = device
        self._layers: dict[int, int] = {}
        self._storeys = 1
        self._orders: dict[Batch, IndexOrder] = {}
        self._materials = _distinct(scene.objects)
        with self.building():
            if scene.lists is not None:
                self._upload_lists(scene.lists)
            self._upload_textures()
            if any(_reflects_or_bends(material) for material in self._materials):
                self._upload_materials()
            self._upload_triangles()

    def _upload_triangles(self) -> None:
        scene = self.scene
        opaque = [self._vertices(item) for item in scene.opaque]
        transparent = [self._vertices(item) for item in scene.transparent]
        self.opaque = batch_of(scene.opaque, scene.camera, 0)
        if scene.lists is not None:
            transparent, self.transparent = _list_batch(scene.lists)
        else:
            base = sum(map(len, opaque))
            self.transparent = batch_of(scene.transparent, scene.camera, base)
        self.casting = self._part(lambda item: item.casts)
        self.cutouts = self._part(lambda item: item.material.binary_coverage)
        particles = self._part(lambda item: item.particles)
        others = self._part(lambda item: not item.particles)
        self.batches = {
            Objects.ALL: self.transparent,
            Objects.PARTICLES: particles,
            Objects.OTHERS: others if len(particles) else self.transparent,
        }
        parts = [*opaque, *transparent]
        vertices = np.concatenate(parts) if parts else np.zeros(1, VERTEX)
        self.vertices = self.own(self._device.context.buffer(vertices.tobytes()))

    @property
    def has_lists(self) -> bool:
        """Whether the scene consists of fragment lists."""
        return self.scene.lists is not None

    def has(self, objects: Objects) -> bool:
        """Return whether the scene has transparent objects of this choice."""
        return len(self.batches[objects]) > 0

    @property
    def macros(self) -> str:
        """Facts about the scene that the surface shader needs at compile time."""
        if self.has_lists:
            return f"#define LISTS {self._storeys}"
        found = {"TEXTURED": "surface_textures", "DETAILED": "surface_materials"}
        return "\n".join(f"#define {k} 1" for k, name in found.items() if name in self.textures)

    def in_submission_order(self, batch: Batch) -> IndexOrder:
        """Return the draw order of a batch as submitted; it is uploaded once."""
        if batch not in self._orders:
            triangles, units = batch.arrange(Order.SUBMISSION)
            order = IndexOrder.upload(self._device.context, triangles, units)
            self.own(order.indices)
            self._orders[batch] = order
        return self._orders[batch]

    def _part(self, chosen: Callable[[Object], bool]) -> Batch:
        """Return the transparent objects that are `chosen`."""
        numbers = [k for k, item in enumerate(self.scene.transparent) if chosen(item)]
        return part_of(self.transparent, numbers)

    def _vertices(self, item: Object) -> npt.NDArray[np.void]:
        mesh, material = item.mesh, item.material
        layer = self._layers.get(id(material))
        vertices = np.zeros(len(mesh.positions), VERTEX)
        vertices["in_position"] = mesh.positions
        vertices["in_uv"] = 0.0 if mesh.uvs is None else mesh.uvs
        # A texture replaces material values; the vertex keeps the remaining factor.
        emission = (1, 1, 1) if isinstance(material.emission, Texture) else material.emission
        if layer is not None:
            emission = (1, 1, 1)
        factor = 1.0 if mesh.radiance is None else mesh.radiance
        vertices["in_radiance"] = np.asarray(emission, dtype=np.float32) * factor
        vertices["in_transmission"] = material.transmission
        coverage = 1.0 if layer is not None else material.coverage
        vertices["in_coverage"] = 1.0 if isinstance(coverage, Texture) else coverage
        vertices["in_layer"] = _UNTEXTURED if layer is None else layer
        # A zero normal selects the normal of the triangle.
        vertices["in_normal"] = 0.0 if mesh.normals is None else mesh.normals
        vertices["in_material"] = self._materials.index(material)
        return vertices

    def _upload_materials(self) -> None:
        rows = np.array([_material_row(item) for item in self._materials], dtype=np.float32)
        texture = self.own(
            self._device.context.texture((2, len(rows)), 4, rows.tobytes(), dtype="f4")
        )
        texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.textures["surface_materials"] = texture

    def _upload_textures(self) -> None:
        scene = self.scene
        pyramids = {
            id(item.material): premultiplied_pyramid(item.material) for item in scene.objects
        }
        kept = {key: levels for key, levels in pyramids.items() if levels is not None}
        if not kept:
            return
        self._layers = {key: layer for layer, key in enumerate(kept)}
        sizes = {levels[0].shape[:2] for levels in kept.values()}
        if len(sizes) > 1:
            raise SceneError(
                f"scene {scene.name}: textures of {sorted(sizes)}; give all of them one size"
            )
        height, width = sizes.pop()
        context = self._device.context
        array = self.own(context.texture_array((width, height, len(kept)), 4, dtype="f4"))
        array.build_mipmaps()
        for layer, levels in enumerate(kept.values()):
            for level, image in enumerate(levels):
                rows, columns = image.shape[:2]
                self._device.write_layer(array, level, layer, (columns, rows), image[::-1])
        array.filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
        array.repeat_x = array.repeat_y = False
        self.textures["surface_textures"] = array

    def _upload_lists(self, lists: FragmentLists) -> None:
        context = self._device.context
        layers, height, width = lists.z.shape
        limit = int(context.info["GL_MAX_ARRAY_TEXTURE_LAYERS"])
        # Beyond the driver's limit on texture layers, each layer holds several, stacked in height.
        self._storeys = math.ceil(layers / limit)
        stored = math.ceil(layers / self._storeys)
        if max(self._storeys * height, width) > self._device.max_side:
            raise UsageError(
                f"fragment lists of {layers} layers of {width}x{height} exceed the driver's limit"
                f" of {self._device.max_side} texels; use fewer layers or a smaller frame"
            )
        spare = [(0, self._storeys * stored - layers), (0, 0), (0, 0), (0, 0)]
        for name, color, last in (
            ("list_radiance", lists.radiance, lists.coverage),
            ("list_transmission", lists.transmission, lists.z),
        ):
            data = np.concatenate([color, last[..., None]], axis=-1)[:, ::-1].astype(np.float32)
            storeys = np.pad(data, spare).reshape(self._storeys, stored, height, width, 4)
            size = (width, self._storeys * height, stored)
            texels = storeys.swapaxes(0, 1).tobytes()
            array = self.own(context.texture_array(size, 4, texels, dtype="f4"))
            array.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self.textures[name] = array


def _list_batch(lists: FragmentLists) -> tuple[list[npt.NDArray[np.void]], Batch]:
    """Return one triangle over the whole frame per layer."""
    layers = len(lists.z)
    vertices = np.zeros((layers, 3), VERTEX)
    vertices["in_position"] = [(-1, -1, 0), (3, -1, 0), (-1, 3, 0)]
    vertices["in_layer"] = np.arange(layers)[:, None]
    # A layer has no place; its mean depth is the best key for sorting.
    depths = lists.z.mean(axis=(1, 2), dtype=np.float64)
    units = np.stack([np.arange(layers), np.ones(layers, dtype=np.int64)], axis=1)
    triangles = np.arange(3 * layers, dtype=np.uint32).reshape(-1, 3)
    batch = Batch(triangles, units, depths, depths, distances=lambda places: places)
    return [vertices.reshape(-1)], batch


def _distinct(objects: Sequence[Object]) -> list[Material]:
    """Return the materials in order of first use; they are compared by identity."""
    return list({id(item.material): item.material for item in objects}.values())


def _reflects_or_bends(material: Material) -> bool:
    """Return whether the surface does more to light than cover, tint and emit it."""
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
