"""The textures and the materials of surfaces on the device.

Textures of a scene have any sizes. All of them are one row of texels, which is folded into the
layers of an array texture, because every driver limits their sides and their number.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import moderngl
import numpy as np

from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner
from oitbench.scene import WRAPS, Array, Material, Object, Texture
from oitbench.scene.environment import GRADES, lobe_number, rough_lobes
from oitbench.scene.texturing import (
    SLOTS,
    constant,
    distinct_images,
    image_key,
    images_of,
    premultiplied_pyramid,
    threshold_of,
)

MATERIALS_ACROSS = 1024
"""Materials in a row of their texture, two texels each."""


_ACROSS = 4096
"""Texels in a row of the store, at most; a power of two."""


@dataclass(frozen=True)
class Pages:
    """Places in an array texture for a row of texels, however long.

    Parameters
    ----------
    across, up : int
        Texels of a layer.
    layers : int
    """

    across: int
    up: int
    layers: int

    @classmethod
    def of(cls, count: int, device: Device) -> Pages:
        """Return pages for `count` texels.

        Raises
        ------
        CapabilityError
            There are more than the driver allows.
        """
        largest = 1 << (device.limits["GL_MAX_TEXTURE_SIZE"].bit_length() - 1)
        across = min(1 << math.ceil(math.log2(max(math.sqrt(count), 1))), _ACROSS, largest)
        up = min(math.ceil(count / across), largest)
        layers = math.ceil(count / (across * up))
        owner = f"a scene with textures of {count} texels, mip levels included"
        device.within(owner, layers, "GL_MAX_ARRAY_TEXTURE_LAYERS")
        return cls(across, up, layers)

    @property
    def macros(self) -> dict[str, int]:
        """Constants of the lookup in `textures.glsl`."""
        return {"TEXELS_ACROSS": self.across, "TEXELS_UP": self.up}


class SurfaceTextures(Owner):
    """All distinct textures of some materials: one row of texels, and a table of their levels.

    Parameters
    ----------
    device : Device
    materials : sequence of Material
        At least one has a texture.

    Attributes
    ----------
    numbers : dict of hashable to int
        Place of each texture in the table, by `image_key`.
    samplers : dict of str to texture
        `surface_textures`: the texels, texture by texture, level by level, row by row from below.
        `texture_levels`: for each level of each texture the number of its first texel, width,
        height, and how it wraps; the number of levels times 16 is added to the last one.
    macros : dict of str to int

    Raises
    ------
    CapabilityError
        They exceed the driver's limits.
    """

    def __init__(self, device: Device, materials: Sequence[Material]) -> None:
        super().__init__()
        images = distinct_images(materials)
        self.numbers: dict[Hashable, int] = {}
        rows: list[tuple[int, int, int, int]] = []
        texels: list[Array] = []
        first = 0
        for key, one in images.items():
            self.numbers[key] = len(rows)
            pyramid = premultiplied_pyramid(one)
            wraps = sum(WRAPS.index(wrap) << 2 * axis for axis, wrap in enumerate(one.wrap))
            for image in pyramid:
                height, width = image.shape[:2]
                rows.append((first, width, height, wraps + (len(pyramid) << 4)))
                texels.append(image[::-1].reshape(-1, 4))
                first += height * width
        pages = Pages.of(first, device)
        across = min(len(rows), _ACROSS)
        up = math.ceil(len(rows) / across)
        device.within(f"{len(images)} textures", up, "GL_MAX_TEXTURE_SIZE")
        wraps_any = any(row[3] & 15 for row in rows)
        self.macros = pages.macros | {"LEVELS_ACROSS": across} | ({"WRAPS": 1} if wraps_any else {})
        stored = np.zeros((pages.layers * pages.up * pages.across, 4), dtype=np.float32)
        np.concatenate(texels, out=stored[:first])
        table = np.zeros((up * across, 4), dtype=np.int32)
        table[: len(rows)] = rows
        context = device.context
        with self.building():
            size = pages.across, pages.up, pages.layers
            array = self.own(context.texture_array(size, 4, stored, dtype="f4"))
            levels = self.own(context.texture((across, up), 4, table.tobytes(), dtype="i4"))
            for texture in (array, levels):
                texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.samplers: dict[str, moderngl.TextureArray | moderngl.Texture] = {
            "surface_textures": array, "texture_levels": levels
        }  # fmt: skip


def surface_key(item: Object) -> Hashable:
    """Return a key that objects share whose surfaces have the same numbers."""
    return id(item.material), item.casts, item.receives_shadows, item.opaque


def upload_surfaces(device: Device, objects: Sequence[Object]) -> moderngl.Texture:
    """Return a texture with the numbers that `surface_at` (shading.glsl) reads, of each object."""
    lobes = rough_lobes([item.material for item in objects])
    return _table(device, [_row_of(item, lobes) for item in objects])


def _table(device: Device, numbers: Sequence[Sequence[float]]) -> moderngl.Texture:
    """Return a texture of two texels for each row of eight numbers."""
    rows = math.ceil(len(numbers) / MATERIALS_ACROSS)
    device.within(f"a scene of {len(numbers)} surfaces", rows, "GL_MAX_TEXTURE_SIZE")
    stored = np.zeros((rows * MATERIALS_ACROSS, 8), dtype=np.float32)
    stored[: len(numbers)] = numbers
    size = (2 * MATERIALS_ACROSS, rows)
    texture = device.context.texture(size, 4, stored.tobytes(), dtype="f4")
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture


def _row_of(item: Object, lobes: Sequence[float]) -> list[float]:
    material = item.material
    roughness = 1.0 if isinstance(material.roughness, Texture) else material.roughness
    index = material.index if item.refracts else 1.0
    mapped = item.casts and not item.opaque
    facts = (material.isotropic, material.binary_coverage, item.receives_shadows, mapped)
    flags = sum(fact << bit for bit, fact in enumerate(facts))
    # A negative number of a lobe, too, is what is left of its bits.
    flags += lobe_number(material, lobes) << len(facts)
    return [
        *constant(material.albedo), material.reflectance,
        roughness, index, material.collimation, float(flags),
    ]  # fmt: skip


class Variation(Owner):
    """What varies over surfaces beside emission and coverage, and what is not drawn of them.

    Parameters
    ----------
    device : Device
    objects : sequence of Object
        One for each surface of `surface_key`.
    numbers : mapping of hashable to int
        Of the textures; see `SurfaceTextures`.

    Attributes
    ----------
    samplers : dict of str to texture
        `surface_variation`: for each surface the numbers of its textures of albedo, transmission
        and roughness, or −1; the least coverage at which it is drawn; and whether it is culled.
    macros : dict of str to int
        What occurs in the scene. Without any, there is no texture.
    """

    def __init__(
        self, device: Device, objects: Sequence[Object], numbers: Mapping[Hashable, int]
    ) -> None:
        super().__init__()
        rows = [_variation_of(item.material, numbers) for item in objects]
        names = [f"{slot.upper()}_TEXTURES" for slot in SLOTS[1:]]
        present = {name: max(row[k] for row in rows) >= 0 for k, name in enumerate(names)}
        present |= {
            "CUTOFF": any(item.material.cutoff is not None for item in objects),
            "CULLED": any(item.material.culled for item in objects),
        }
        self.macros = {name: 1 for name, occurs in present.items() if occurs}
        if "ROUGHNESS_TEXTURES" in self.macros:
            self.macros["GRADES"] = GRADES
        self.samplers: dict[str, moderngl.Texture] = {}
        if self.macros:
            self.macros |= {"VARIED": 1, "MATERIALS_ACROSS": MATERIALS_ACROSS}
            with self.building():
                self.samplers["surface_variation"] = self.own(_table(device, rows))


def _variation_of(material: Material, numbers: Mapping[Hashable, int]) -> list[float]:
    images = images_of(material)
    textures = [
        float(numbers[image_key(images[slot])]) if slot in images else -1.0 for slot in SLOTS[1:]
    ]
    return [*textures, threshold_of(material), float(material.culled), 0.0, 0.0, 0.0]
