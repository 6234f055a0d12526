"""The textures and the materials of surfaces on the device.

Every driver limits the number of layers of a texture array, and the sides of a texture. Materials
and textures beyond these limits are stored side by side.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import moderngl
import numpy as np

from oitbench.errors import CapabilityError, SceneError
from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner
from oitbench.scene import Material, Object
from oitbench.scene.environment import lobe_number, rough_lobes
from oitbench.scene.texturing import distinct_images, premultiplied_pyramid

MATERIALS_ACROSS = 1024
"""Materials in a row of their texture, two texels each."""


@dataclass(frozen=True)
class Slots:
    """Places of textures of one size in the layers of an array.

    If the array has a layer for each texture, a texture fills its layer. If not, a layer has
    `across` × `up` square slots, and a texture lies in the corner of its slot. From one mip level
    to the next, slots halve as textures do, and end with one texel.

    Parameters
    ----------
    width, height : int
        Texels of a texture; powers of two.
    across, up : int
        Slots in a layer.
    layers : int
    """

    width: int
    height: int
    across: int
    up: int
    layers: int

    @classmethod
    def of(cls, count: int, size: tuple[int, int], device: Device) -> Slots:
        """Return slots for `count` textures of `size` (width, height).

        Raises
        ------
        CapabilityError
            A texture is larger than the driver allows, or there are too many.
        """
        width, height = size
        owner = f"a texture of {width}x{height} texels"
        device.within(owner, max(size), "GL_MAX_TEXTURE_SIZE")
        most = device.limits["GL_MAX_ARRAY_TEXTURE_LAYERS"]
        in_layer = math.ceil(count / most)
        across = math.ceil(math.sqrt(in_layer))
        up = math.ceil(in_layer / across)
        largest = device.limits["GL_MAX_TEXTURE_SIZE"]
        if in_layer > 1 and max(across, up) * max(size) > largest:
            raise CapabilityError(
                f"{count} textures of {width}x{height} texels exceed {device.renderer}, where"
                f" GL_MAX_ARRAY_TEXTURE_LAYERS is {most} and GL_MAX_TEXTURE_SIZE {largest}; use"
                " fewer or smaller ones"
            )
        return cls(width, height, across, up, math.ceil(count / (across * up)))

    @property
    def size(self) -> tuple[int, int, int]:
        """Width, height and layers of the array."""
        if self.across * self.up == 1:
            return self.width, self.height, self.layers
        return self.across * self.side, self.up * self.side, self.layers

    @property
    def side(self) -> int:
        """Side of a square slot at the finest level."""
        return max(self.width, self.height)

    def corner(self, slot: int, level: int) -> tuple[int, int, int]:
        """Return column, row and layer of the first texel of a slot at a mip level."""
        layer, place = divmod(slot, self.across * self.up)
        row, column = divmod(place, self.across)
        return column * (self.side >> level), row * (self.side >> level), layer

    @property
    def macros(self) -> dict[str, int]:
        """Constants of the lookup in `textures.glsl`."""
        return {
            "TEXTURE_WIDTH": self.width,
            "TEXTURE_HEIGHT": self.height,
            "SLOTS_ACROSS": self.across,
            "SLOTS_UP": self.up,
        }


class SurfaceTextures(Owner):
    """All distinct textures of some materials, in one array.

    Parameters
    ----------
    device : Device
    owner : str
        Name of the scene in messages.
    materials : sequence of Material
        At least one has a texture.

    Attributes
    ----------
    numbers : dict of hashable to int
        Slot of each texture, by `image_key`.
    slots : Slots
    array : moderngl.TextureArray

    Raises
    ------
    SceneError
        The textures have several sizes.
    CapabilityError
        They exceed the driver's limits.
    """

    def __init__(self, device: Device, owner: str, materials: Sequence[Material]) -> None:
        super().__init__()
        images = distinct_images(materials)
        self.numbers: dict[Hashable, int] = {key: number for number, key in enumerate(images)}
        sizes = {item.texels.shape[:2] for pair in images.values() for item in pair if item}
        if len(sizes) > 1:
            raise SceneError(f"{owner}: textures of {sorted(sizes)}; give all of them one size")
        height, width = sizes.pop()
        self.slots = Slots.of(len(images), (width, height), device)
        with self.building():
            array = self.own(device.context.texture_array(self.slots.size, 4, dtype="f4"))
            array.build_mipmaps()  # allocates the levels
            for number, pair in enumerate(images.values()):
                for level, image in enumerate(premultiplied_pyramid(pair)):
                    device.write_layer(array, level, self.slots.corner(number, level), image[::-1])
            array.filter = (moderngl.NEAREST_MIPMAP_NEAREST, moderngl.NEAREST)
        self.array = array


def surface_key(item: Object) -> Hashable:
    """Return a key that objects share whose surfaces have the same numbers."""
    return id(item.material), item.casts, item.receives_shadows


def upload_surfaces(device: Device, objects: Sequence[Object]) -> moderngl.Texture:
    """Return a texture with the numbers that `surface_at` (shading.glsl) reads, of each object."""
    rows = math.ceil(len(objects) / MATERIALS_ACROSS)
    device.within(f"a scene of {len(objects)} surfaces", rows, "GL_MAX_TEXTURE_SIZE")
    numbers = np.zeros((rows * MATERIALS_ACROSS, 8), dtype=np.float32)
    lobes = rough_lobes([item.material for item in objects])
    numbers[: len(objects)] = [_row_of(item, lobes) for item in objects]
    size = (2 * MATERIALS_ACROSS, rows)
    texture = device.context.texture(size, 4, numbers.tobytes(), dtype="f4")
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture


def _row_of(item: Object, lobes: Sequence[float]) -> list[float]:
    material = item.material
    index = material.index if material.refracts else 1.0
    mapped = item.casts and not material.opaque
    facts = (material.isotropic, material.binary_coverage, item.receives_shadows, mapped)
    flags = sum(fact << bit for bit, fact in enumerate(facts))
    flags += lobe_number(material, lobes) << len(facts)
    return [
        *material.albedo, material.reflectance,
        material.roughness, index, material.collimation, float(flags),
    ]  # fmt: skip
