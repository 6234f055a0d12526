"""A scene on the device: one vertex buffer, so that any draw order is an order of indices."""

from __future__ import annotations

import math
from dataclasses import dataclass

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.declare import Order
from oitbench.errors import SceneError, UsageError
from oitbench.gl.device import Device
from oitbench.gl.prelude import TILE
from oitbench.scene import Camera, FragmentLists, Object, Scene, Texture
from oitbench.texturing import premultiplied_pyramid

VERTEX = np.dtype(
    [
        ("in_position", "f4", 3),
        ("in_uv", "f4", 2),
        ("in_radiance", "f4", 3),
        ("in_transmission", "f4", 3),
        ("in_coverage", "f4"),
        ("in_layer", "f4"),
    ]
)
VERTEX_FORMAT = "3f4 2f4 3f4 3f4 1f4 1f4"
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
    vertices : moderngl.Buffer
    textures : dict of str to moderngl.TextureArray
        Samplers of the surface shader by name.
    complexities : dict of (width, height) to array
        Fragments a pixel at the frame sizes that were counted.
    """

    def __init__(self, device: Device, scene: Scene) -> None:
        if scene.lists is not None and scene.objects:
            raise SceneError(f"scene {scene.name}: fragment lists cannot be mixed with objects")
        if scene.lights or scene.medium is not None:
            raise SceneError(
                f"scene {scene.name}: lights and media are not rendered; bake them into emission"
            )
        self.scene = scene
        self.textures: dict[str, moderngl.TextureArray] = {}
        self.layers: dict[int, int] = {}
        self._storeys = 1
        self.complexities: dict[tuple[int, int], npt.NDArray[np.int64]] = {}
        if scene.lists is not None:
            self._upload_lists(device, scene.lists)
        self._upload_textures(device, scene)
        parts: list[npt.NDArray[np.void]] = []
        self.opaque = self._batch(scene.opaque, parts)
        self.transparent = (
            self._list_batch(scene.lists, parts)
            if scene.lists is not None
            else self._batch(scene.transparent, parts)
        )
        vertices = np.concatenate(parts) if parts else np.zeros(1, VERTEX)
        self.vertices = device.context.buffer(vertices.tobytes())

    @property
    def macros(self) -> str:
        """What the surface shader must know at compile time."""
        if self.scene.lists is not None:
            return f"#define LISTS {self._storeys}"
        return "#define TEXTURED 1" if self.textures else ""

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
        return vertices

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
        self.vertices.release()
        for texture in self.textures.values():
            texture.release()


def view_block(camera: Camera, size: tuple[int, int], transmittance: bool) -> bytes:
    """Return the bytes of the uniform block `View` (glsl/view.glsl) for a frame of `size`."""
    width, height = size
    axes = camera.axes
    to_camera = np.eye(4)
    to_camera[:3, :3] = axes
    to_camera[:3, 3] = -axes @ np.asarray(camera.position, dtype=np.float64)
    focal = 1 / math.tan(camera.fov_y / 2)
    near, far = camera.near, camera.far
    # The limits of the usual (far + near)/(near − far) and 2·far·near/(near − far).
    ratio = 0.0 if math.isinf(far) else near / far
    to_clip = np.zeros((4, 4))
    to_clip[0, 0] = focal * height / width
    to_clip[1, 1] = focal
    to_clip[2, 2] = -(1 + ratio) / (1 - ratio)
    to_clip[2, 3] = -2 * near / (1 - ratio)
    to_clip[3, 2] = -1
    tiles = [math.ceil(side / TILE) for side in size]
    return b"".join(
        (
            (to_clip @ to_camera).T.astype(np.float32).tobytes(),
            to_camera.T.astype(np.float32).tobytes(),
            np.array(
                [near, far, focal * height / 2, 0.0 if transmittance else 1.0], dtype=np.float32
            ).tobytes(),
            np.array([width, height, *tiles, 0, 0, 0, 0], dtype=np.uint32).tobytes(),
        )
    )
