"""Triangles, materials and textures of a scene on the device.

All vertices share one buffer, so that any draw order is an order of indices.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError
from oitbench.gl.batches import Batch, IndexOrder, batch_of, part_of
from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner
from oitbench.gl.planes import nearness_of_vertices, with_separate_corners
from oitbench.gl.surface_textures import (
    MATERIALS_ACROSS,
    SurfaceTextures,
    Variation,
    surface_key,
    upload_surfaces,
)
from oitbench.gl.view import bounded_camera, transparent_range, view_block
from oitbench.method.passes import Objects, Order
from oitbench.scene import (
    BLACK,
    LEAST_LOBE,
    Camera,
    Floats,
    FragmentLists,
    Material,
    Mesh,
    Object,
    Scene,
    Vector,
)
from oitbench.scene.texturing import constant, constants_of, image_key, images_of

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
FACTORS = np.dtype([("in_albedo", "f4", 3), ("in_passing", "f4", 3), ("in_part", "f4")])
"""Factors of vertices on albedo, transmission and coverage; only scenes that have some."""
FACTORS_FORMAT = "3f4 3f4 1f4"
_UNTEXTURED = -1


@dataclass
class _Eye:
    """The camera where it is now. Batches refer to it, not to the geometry that holds them."""

    camera: Camera

    def distances(self, places: Floats) -> Floats:
        """Return the view distances of places in meters."""
        return self.camera.view_distance(places)


class Geometry(Owner):
    """Triangles, materials and textures of a scene on the device.

    Parameters
    ----------
    device : Device
    scene : Scene

    Attributes
    ----------
    scene : Scene
        In meters, with the camera of the upload at the origin: vertices are relative to it.
    origin : Vector
        Position of that camera in the world in meters, less whole kilometers so that single
        precision resolves it. Patterns that stick to surfaces add it to relative positions.
    transparent_range : (float, float)
        `view.transparent_range` of the scene from where its camera is now.
    opaque, transparent : Batch
    casting : Batch
        Transparent objects that cast shadows.
    cutouts : Batch
        Transparent objects of binary coverage.
    batches : dict of Objects to Batch
        Transparent objects by the choice of a pass.
    vertices : moderngl.Buffer
    planes : moderngl.Buffer or None
        Planes of the vertices, if surfaces coincide (see `oitbench.scene.coincidence`).
    factors : moderngl.Buffer or None
        Factors of the vertices, if any mesh has some.
    textures : dict of str to moderngl.TextureArray or moderngl.Texture
        Samplers of the surface shader by name.

    Raises
    ------
    SceneError
        The scene mixes fragment lists and objects.
    CapabilityError
        The scene exceeds the driver's limits.
    """

    def __init__(self, device: Device, scene: Scene) -> None:
        if scene.lists is not None and scene.objects:
            raise SceneError(f"scene {scene.name}: fragment lists cannot be mixed with objects")
        super().__init__()
        self.scene, self._coincidence = with_separate_corners(scene.seen_from_camera())
        self._eye = _Eye(self.scene.camera)
        self._camera = bounded_camera(self.scene)
        self.origin = _less_kilometers(scene.in_meters().camera.position)
        self._place, self._unit = scene.camera.position, scene.meters_per_unit
        self.transparent_range = transparent_range(self.scene)
        self.textures: dict[str, moderngl.TextureArray | moderngl.Texture] = {}
        self._device = device
        self._storeys = 1
        self.planes: moderngl.Buffer | None = None
        self.factors: moderngl.Buffer | None = None
        self._macros: dict[str, float] = {}
        self._orders: dict[Batch, IndexOrder] = {}
        surfaces = {surface_key(item): item for item in scene.objects}
        self._numbers = {key: number for number, key in enumerate(surfaces)}
        self._images: dict[Hashable, int] = {}
        with self.building():
            if self.scene.lists is not None:
                self._upload_lists(self.scene.lists)
            self._upload_surfaces(list(surfaces.values()))
            self._upload_triangles()

    def _upload_surfaces(self, objects: list[Object]) -> None:
        materials = [item.material for item in objects]
        if any(images_of(material) for material in materials):
            textures = self.own(SurfaceTextures(self._device, materials))
            self._images = textures.numbers
            self.textures |= textures.samplers
            self._macros |= {"TEXTURED": 1, **textures.macros}
        if any(_reflects_or_bends(material) for material in materials):
            self.textures["surface_materials"] = self.own(upload_surfaces(self._device, objects))
            self._macros |= {"DETAILED": 1, "MATERIALS_ACROSS": MATERIALS_ACROSS}
            self._macros["LEAST_LOBE"] = LEAST_LOBE
        if objects:
            variation = self.own(Variation(self._device, objects, self._images))
            self.textures |= variation.samplers
            self._macros |= variation.macros

    def _upload_triangles(self) -> None:
        scene = self.scene
        opaque = [self._vertices(item) for item in scene.opaque]
        transparent = [self._vertices(item) for item in scene.transparent]
        self.opaque = batch_of(scene.opaque, self._eye.distances, 0)
        if scene.lists is not None:
            transparent, self.transparent = _list_batch(scene.lists)
        else:
            base = sum(map(len, opaque))
            self.transparent = batch_of(scene.transparent, self._eye.distances, base)
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
        objects = [*scene.opaque, *scene.transparent]
        if any(item.mesh.factors for item in objects):
            factors = np.concatenate([_factors_of(item.mesh) for item in objects])
            self.factors = self.own(self._device.context.buffer(factors.tobytes()))
            self._macros |= {"VARIED": 1, "VERTEX_FACTORS": 1}
        if self._coincidence is not None:
            rows = nearness_of_vertices(scene, self._coincidence)
            self.planes = self.own(self._device.context.buffer(rows.tobytes()))

    @property
    def movable(self) -> bool:
        """Whether the camera can move: vertices do not depend on it."""
        return not self.has_lists and self._coincidence is None

    def move(self, camera: Camera) -> None:
        """Look from another camera, given in the scene's own unit; vertices stay as they are."""
        self.scene = replace(self.scene, camera=camera.relocated(self._place, self._unit))
        self._eye.camera = self.scene.camera
        self._camera = bounded_camera(self.scene)
        self.transparent_range = transparent_range(self.scene)

    def view(self, size: tuple[int, int], transmittance: bool = False, subsample: int = 1) -> bytes:
        """Return the bytes of `View` for a frame of the scene's camera; see `view_block`."""
        camera, within = self._camera, self.transparent_range
        return view_block(camera, size, transmittance, subsample, self.origin, within)

    @property
    def coincident(self) -> tuple[str, str] | None:
        """Two of the objects that coincide; None if none do."""
        return None if self._coincidence is None else self._coincidence.pair

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
        found = self._macros | ({} if self.planes is None else {"PLANES": 1})
        return "\n".join(f"#define {name} {value}" for name, value in found.items())

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
        emission, coverage = constants_of(material)
        vertices = np.zeros(len(mesh.positions), VERTEX)
        vertices["in_position"] = mesh.positions
        vertices["in_uv"] = 0.0 if mesh.uvs is None else mesh.uvs
        factor = 1.0 if mesh.radiance is None else mesh.radiance
        vertices["in_radiance"] = np.asarray(emission, dtype=np.float32) * factor
        vertices["in_transmission"] = constant(material.transmission)
        vertices["in_coverage"] = coverage
        vertices["in_layer"] = self._texture(material)
        # A zero normal selects the normal of the triangle.
        vertices["in_normal"] = 0.0 if mesh.normals is None else mesh.normals
        vertices["in_material"] = self._numbers[surface_key(item)]
        return vertices

    def _texture(self, material: Material) -> int:
        images = images_of(material).get("emission")
        return _UNTEXTURED if images is None else self._images[image_key(images)]

    def _upload_lists(self, lists: FragmentLists) -> None:
        device, context = self._device, self._device.context
        layers, height, width = lists.z.shape
        limit = device.limits["GL_MAX_ARRAY_TEXTURE_LAYERS"]
        # Beyond the driver's limit on texture layers, each layer holds several, stacked in height.
        self._storeys = math.ceil(layers / limit)
        stored = math.ceil(layers / self._storeys)
        owner = f"fragment lists of {layers} layers of {width}x{height}"
        device.within(owner, max(self._storeys * height, width), "GL_MAX_TEXTURE_SIZE")
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


def _factors_of(mesh: Mesh) -> npt.NDArray[np.void]:
    factors = np.ones(len(mesh.positions), FACTORS)
    for name, own in zip(FACTORS.names or (), ("albedo", "transmission", "coverage"), strict=True):
        factors[name] = mesh.factors.get(own, 1.0)
    return factors


def _less_kilometers(position: Vector) -> Vector:
    x, y, z = (part - 1000 * round(part / 1000) for part in position)
    return x, y, z


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


def _reflects_or_bends(material: Material) -> bool:
    """Return whether the surface does more to light than cover, tint and emit it."""
    plain = material.albedo == BLACK and material.reflectance == 0 and material.collimation == 1
    return not plain or material.refracts
