"""One OpenGL context, its capabilities, and the entry points that moderngl does not expose."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import glcontext
import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.errors import CapabilityError, unknown
from oitbench.method.declaration import Blend
from oitbench.method.formats import Format

CAPABILITIES: dict[str, tuple[str, ...]] = {
    "dual_source": ("GL_ARB_blend_func_extended",),
    "framebuffer_fetch": ("GL_EXT_shader_framebuffer_fetch",),
    "interlock": ("GL_ARB_fragment_shader_interlock", "GL_NV_fragment_shader_interlock"),
    "image_load_store": ("GL_ARB_shader_image_load_store",),
    "post_depth_coverage": ("GL_ARB_post_depth_coverage", "GL_EXT_post_depth_coverage"),
}
"""Capability names for `Method.requires`, each with the extensions any one of which gives it."""

_MECHANISMS = {
    "framebuffer fetch": "framebuffer_fetch",
    "interlock": "interlock",
    "spin lock": "image_load_store",
}
_SOFTWARE = ("llvmpipe", "softpipe", "swiftshader", "swrast")
_COLOR, _TEXTURE_2D, _DEPTH_COMPONENT, _FLOAT = 0x1800, 0x0DE1, 0x1902, 0x1406
_DEPTH_COMPONENT32F, _MAX_STORAGE_BLOCK, _MAX_TEXTURE = 0x8CAC, 0x90DE, 0x0D33
_TEXTURE_2D_MULTISAMPLE, _DEPTH = 0x9100, 0x1801
_MAX_VIEWPORT, _RGBA = 0x0D3A, 0x1908
_MAX_DRAW_BUFFERS, _MAX_IMAGES = 0x8824, 0x90CE
_VOID = ctypes.c_void_p
_UINT, _INT, _BYTE = ctypes.c_uint, ctypes.c_int, ctypes.c_ubyte
_SIGNATURES: dict[str, tuple[Any, ...]] = {
    "glBlendFuncSeparatei": (_UINT, _UINT, _UINT, _UINT, _UINT),
    "glBlendEquationi": (_UINT, _UINT),
    "glColorMaski": (_UINT, _BYTE, _BYTE, _BYTE, _BYTE),
    "glDepthMask": (_BYTE,),
    "glClearBufferfv": (_UINT, _INT, _VOID),
    "glClearBufferuiv": (_UINT, _INT, _VOID),
    "glBindTexture": (_UINT, _UINT),
    "glCopyImageSubData": (_UINT, _UINT, *[_INT] * 4, _UINT, _UINT, *[_INT] * 7),
    "glTexImage2D": (_UINT, _INT, _INT, _INT, _INT, _INT, _UINT, _UINT, _VOID),
    "glTextureSubImage3D": (_UINT, *[_INT] * 7, _UINT, _UINT, _VOID),
    "glTexImage2DMultisample": (_UINT, _INT, _UINT, _INT, _INT, _BYTE),
    "glGetInteger64v": (_UINT, _VOID),
    "glFinish": (),
}


class Device:
    """A headless OpenGL 4.5 context.

    Parameters
    ----------
    software : bool
        Whether the renderer runs on the CPU; such a renderer is timed by wall clock.
    limits_loops : bool
        Whether it ends loops after 65,535 steps; see `Method.deepest`.

    Raises
    ------
    CapabilityError
        No EGL device or OpenGL below 4.5.
    """

    def __init__(self) -> None:
        try:
            backend = glcontext.get_backend_by_name("egl")(
                mode="standalone", libgl="libGL.so.1", libegl="libEGL.so.1", glversion=450
            )
        except Exception as error:
            raise CapabilityError(
                f"no OpenGL 4.5 context through EGL ({error}); install libegl1 libgl1 and a driver"
                " (Mesa: libgl1-mesa-dri)"
            ) from error
        self.context = moderngl.create_context(context=backend)
        self._functions = {
            name: self._load(backend.load, name, signature)
            for name, signature in _SIGNATURES.items()
        }
        self.renderer = str(self.context.info["GL_RENDERER"])
        self.version = str(self.context.info["GL_VERSION"])
        self.software = any(name in self.renderer.lower() for name in _SOFTWARE)
        self.limits_loops = "llvmpipe" in self.renderer
        self.max_block_bytes = self._integer(_MAX_STORAGE_BLOCK)
        self.max_targets = self._integer(_MAX_DRAW_BUFFERS)
        self.max_images = self._integer(_MAX_IMAGES)
        self.max_side = min(self._integer(_MAX_TEXTURE), self._integer(_MAX_VIEWPORT))
        self.programs: dict[tuple[str, str], moderngl.Program] = {}

    @staticmethod
    def _load(load: Callable[[str], int], name: str, signature: tuple[Any, ...]) -> Any:
        address = load(name)
        if not address:
            raise CapabilityError(f"the OpenGL driver has no {name}; it needs OpenGL 4.5")
        return ctypes.CFUNCTYPE(None, *signature)(address)

    def call(self, name: str, *arguments: Any) -> None:
        """Call the OpenGL function `name`."""
        self._functions[name](*arguments)

    def _integer(self, name: int) -> int:
        value = (ctypes.c_longlong * 2)()
        self.call("glGetInteger64v", name, ctypes.cast(value, _VOID))
        return int(value[0])

    def has(self, capability: str) -> bool:
        """Tell whether the driver offers `capability`."""
        if capability not in CAPABILITIES:
            raise unknown("capability", capability, CAPABILITIES)
        return any(name in self.context.extensions for name in CAPABILITIES[capability])

    def require(self, owner: str, capabilities: tuple[str, ...]) -> None:
        """Raise `CapabilityError` unless the driver offers all of `capabilities`."""
        for capability in capabilities:
            if not self.has(capability):
                names = " or ".join(CAPABILITIES[capability])
                raise CapabilityError(f"{owner} needs {capability}: {self.renderer} has no {names}")

    def mechanism(self, samples: int) -> str:
        """Return how programmable blending is done here: the first that the driver offers.

        A lock and images would have to be multisampled too; only fetch serves `samples` above 1.
        """
        for name, capability in _MECHANISMS.items():
            if self.has(capability) and (samples == 1 or capability == "framebuffer_fetch"):
                return name
        raise CapabilityError(f"{self.renderer} offers no programmable blending")

    def texture(self, size: tuple[int, int], entry: Format, samples: int = 1) -> moderngl.Texture:
        """Create a texture of `size` (width, height) that is fetched texel by texel."""
        several = 0 if samples == 1 else samples
        if entry.depth:
            texture = self._depth_texture(size, several)
        elif entry.internal is not None:
            texture = self.context.texture(
                size,
                entry.components,
                samples=several,
                dtype=entry.dtype,
                internal_format=entry.internal,
            )
        else:
            texture = self.context.texture(
                size, entry.components, samples=several, dtype=entry.dtype
            )
        if not several:
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            texture.repeat_x = texture.repeat_y = False
        return texture

    def _depth_texture(self, size: tuple[int, int], samples: int) -> moderngl.Texture:
        # moderngl knows 24-bit depth only: the same name gets a 32-bit float store.
        texture = self.context.depth_texture(size, samples=samples)
        if samples:
            self.call("glBindTexture", _TEXTURE_2D_MULTISAMPLE, texture.glo)
            self.call(
                "glTexImage2DMultisample",
                *(_TEXTURE_2D_MULTISAMPLE, samples, _DEPTH_COMPONENT32F, *size, 1),
            )
            return texture
        self.call("glBindTexture", _TEXTURE_2D, texture.glo)
        self.call(
            "glTexImage2D",
            *(_TEXTURE_2D, 0, _DEPTH_COMPONENT32F, *size, 0, _DEPTH_COMPONENT, _FLOAT, None),
        )
        texture.compare_func = ""
        return texture

    def write_layer(
        self,
        array: moderngl.TextureArray,
        level: int,
        layer: int,
        size: tuple[int, int],
        texels: npt.NDArray[np.float32],
    ) -> None:
        """Write one mip level of one layer of a float RGBA array; moderngl writes level 0 only."""
        data = np.ascontiguousarray(texels, dtype=np.float32)
        self.call(
            "glTextureSubImage3D",
            *(array.glo, level, 0, 0, layer, *size, 1, _RGBA, _FLOAT, data.ctypes.data),
        )

    def copy(
        self,
        source: moderngl.Texture,
        target: moderngl.Texture,
        size: tuple[int, int],
        samples: int,
    ) -> None:
        """Copy all texels between textures of one format, depth and integers included."""
        kind = _TEXTURE_2D if samples == 1 else _TEXTURE_2D_MULTISAMPLE
        origin = (0, 0, 0, 0)
        self.call(
            "glCopyImageSubData",
            *(source.glo, kind, *origin, target.glo, kind, *origin, *size, 1),
        )

    def set_blend(self, slot: int, blend: Blend) -> None:
        """Set the blend state of the color attachment `slot`, all channels writable."""
        source_alpha = blend.source if blend.source_alpha is None else blend.source_alpha
        target_alpha = blend.target if blend.target_alpha is None else blend.target_alpha
        self.call("glColorMaski", slot, 1, 1, 1, 1)
        self.call("glBlendEquationi", slot, blend.equation)
        self.call(
            "glBlendFuncSeparatei", slot, blend.source, blend.target, source_alpha, target_alpha
        )

    def clear(self, slot: int, entry: Format, value: tuple[float, ...]) -> None:
        """Clear the attachment `slot` of the bound framebuffer to `value`."""
        if entry.depth:
            depth = np.array(value[:1], dtype=np.float32)
            self.call("glDepthMask", 1)
            self.call("glClearBufferfv", _DEPTH, 0, depth.ctypes.data)
            return
        padded = (*value, *([value[-1]] * (4 - len(value))))
        numbers = np.array(padded, dtype=np.uint32 if entry.integer else np.float32)
        name = "glClearBufferuiv" if entry.integer else "glClearBufferfv"
        self.call("glColorMaski", slot, 1, 1, 1, 1)
        self.call(name, _COLOR, slot, numbers.ctypes.data)

    def finish(self) -> None:
        """Wait until all work is done."""
        self.call("glFinish")

    def release(self) -> None:
        """Free the context and all that was made with it."""
        self.programs.clear()
        self.context.release()
