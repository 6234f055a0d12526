"""One OpenGL context, its capabilities, and the entry points that moderngl does not expose."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import moderngl
import numpy as np

from oitbench.errors import CapabilityError, unknown
from oitbench.gl import context
from oitbench.gl.capabilities import CAPABILITIES, FETCH, MECHANISMS, is_software, loop_limit
from oitbench.gl.shader_cache import avoid_full_disk
from oitbench.method.blending import Blend
from oitbench.method.formats import Format

_COLOR, _TEXTURE_2D, _DEPTH_COMPONENT, _FLOAT = 0x1800, 0x0DE1, 0x1902, 0x1406
_DEPTH_COMPONENT32F, _TEXTURE_2D_MULTISAMPLE, _DEPTH = 0x8CAC, 0x9100, 0x1801
_PIXEL_UNPACK_BUFFER, _RED = 0x88EC, 0x1903
_MAX_VIEWPORT, _LOWER_LEFT, _ZERO_TO_ONE = 0x0D3A, 0x8CA1, 0x935F
_LIMITS = {
    "GL_MAX_3D_TEXTURE_SIZE": 0x8073,
    "GL_MAX_ARRAY_TEXTURE_LAYERS": 0x88FF,
    "GL_MAX_DRAW_BUFFERS": 0x8824,
    "GL_MAX_FRAGMENT_IMAGE_UNIFORMS": 0x90CE,
    "GL_MAX_IMAGE_SAMPLES": 0x906D,
    "GL_MAX_SAMPLES": 0x8D57,
    "GL_MAX_SHADER_STORAGE_BLOCK_SIZE": 0x90DE,
    "GL_MAX_TEXTURE_IMAGE_UNITS": 0x8872,
    "GL_MAX_TEXTURE_SIZE": 0x0D33,
    "GL_MAX_UNIFORM_BLOCK_SIZE": 0x8A30,
}
_R32UI, _WORDS = 0x8236, (0x8D94, 0x1405)  # GL_RED_INTEGER, GL_UNSIGNED_INT
_VOID = ctypes.c_void_p
_UINT, _INT, _BYTE = ctypes.c_uint, ctypes.c_int, ctypes.c_ubyte
_SIGNATURES: dict[str, tuple[Any, ...]] = {
    "glBlendFuncSeparatei": (_UINT, _UINT, _UINT, _UINT, _UINT),
    "glBlendEquationi": (_UINT, _UINT),
    "glClipControl": (_UINT, _UINT),
    "glColorMaski": (_UINT, _BYTE, _BYTE, _BYTE, _BYTE),
    "glDepthMask": (_BYTE,),
    "glClearBufferfv": (_UINT, _INT, _VOID),
    "glClearBufferuiv": (_UINT, _INT, _VOID),
    "glClearNamedBufferData": (_UINT, _UINT, _UINT, _UINT, _VOID),
    "glBindBuffer": (_UINT, _UINT),
    "glBindTexture": (_UINT, _UINT),
    "glGetTextureImage": (_UINT, _INT, _UINT, _UINT, _INT, _VOID),
    "glCopyImageSubData": (_UINT, _UINT, *[_INT] * 4, _UINT, _UINT, *[_INT] * 7),
    "glTexImage2D": (_UINT, _INT, _INT, _INT, _INT, _INT, _UINT, _UINT, _VOID),
    "glTextureSubImage3D": (_UINT, *[_INT] * 7, _UINT, _UINT, _VOID),
    "glTexImage2DMultisample": (_UINT, _INT, _UINT, _INT, _INT, _BYTE),
    "glGetInteger64v": (_UINT, _VOID),
    "glPixelStorei": (_UINT, _INT),
    "glMinSampleShading": (ctypes.c_float,),
    "glFinish": (),
    "glCreateQueries": (_UINT, _INT, _VOID),
    "glQueryCounter": (_UINT, _UINT),
    "glGetQueryObjectui64v": (_UINT, _UINT, _VOID),
    "glDeleteQueries": (_INT, _VOID),
}


class Device:
    """A headless OpenGL 4.5 context.

    Attributes
    ----------
    context : moderngl.Context
    renderer, vendor, version : str
        Names that the driver reports.
    software : bool
        Whether the renderer runs on the CPU; it is then timed by wall clock.
    loop_limit : int or None
        Steps after which the driver ends all loops of a shader invocation.
    limits : dict of str to int
        The driver's limits by their names in OpenGL.
    max_block_bytes, max_targets, max_images, max_side : int
        Largest storage block, number of color targets and images of a pass, and frame side.
    programs : dict
        Compiled programs by the text of their shaders.

    Raises
    ------
    CapabilityError
        There is no driver, or OpenGL is older than 4.5.
    """

    def __init__(self) -> None:
        avoid_full_disk()
        backend = context.create()
        self.context = moderngl.create_context(context=backend)
        self._functions = {
            name: self._load(backend.load, name, signature)
            for name, signature in _SIGNATURES.items()
        }
        # The usual [-1, 1] would round small depths as if they were near one.
        self.call("glClipControl", _LOWER_LEFT, _ZERO_TO_ONE)
        # For each sample, where sample shading is on.
        self.call("glMinSampleShading", 1.0)
        self.renderer = str(self.context.info["GL_RENDERER"])
        self.vendor = str(self.context.info["GL_VENDOR"])
        self.version = str(self.context.info["GL_VERSION"])
        self.software = is_software(self.renderer)
        self.loop_limit = loop_limit(self.renderer)
        self.limits = {name: self._integer(number) for name, number in _LIMITS.items()}
        self.max_block_bytes = self.limits["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]
        self.max_targets = self.limits["GL_MAX_DRAW_BUFFERS"]
        self.max_images = self.limits["GL_MAX_FRAGMENT_IMAGE_UNIFORMS"]
        self.max_side = min(self.limits["GL_MAX_TEXTURE_SIZE"], self._integer(_MAX_VIEWPORT))
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
        """Return whether the driver offers `capability`."""
        if capability not in CAPABILITIES:
            raise unknown("capability", capability, CAPABILITIES)
        return any(name in self.context.extensions for name in CAPABILITIES[capability])

    def require(self, owner: str, capabilities: tuple[str, ...]) -> None:
        """Raise `CapabilityError` unless the driver offers all of `capabilities`."""
        for capability in capabilities:
            if not self.has(capability):
                names = " or ".join(CAPABILITIES[capability])
                raise CapabilityError(f"{owner} needs {capability}: {self.renderer} has no {names}")

    def within(self, owner: str, needed: int, limit: str) -> None:
        """Raise `CapabilityError` if `needed` exceeds the driver's limit of this name.

        Parameters
        ----------
        owner : str
            What needs it, at the start of the message: "a texture of 1x32768 texels".
        needed : int
        limit : str
            A key of `limits`.
        """
        if needed > self.limits[limit]:
            raise CapabilityError(
                f"{owner}: {needed} exceeds {limit}, which is {self.limits[limit]} for"
                f" {self.renderer}"
            )

    @contextmanager
    def checked(self, owner: str) -> Iterator[None]:
        """Raise `CapabilityError` if OpenGL reports an error inside.

        moderngl does not ask for errors: without this, pictures would silently lack something.

        Parameters
        ----------
        owner : str
            What is done inside, as the subject of the message.
        """
        self._take_errors()  # those of work that has failed before
        yield
        errors = self._take_errors()
        if errors:
            raise CapabilityError(
                f"{owner}: {self.renderer} reports {' and '.join(errors)}; it lacks memory, or a"
                " limit is exceeded"
            )

    def _take_errors(self) -> list[str]:
        found: list[str] = []
        # OpenGL keeps one flag for each kind of error; without a context, it never runs out.
        while (error := self.context.error) != "GL_NO_ERROR" and error not in found:
            found.append(error)
        return found

    def mechanism(self, samples: int) -> str:
        """Return the best way of programmable blending that the driver offers.

        Without framebuffer fetch, several samples need images of as many.

        Raises
        ------
        CapabilityError
            The driver offers none.
        """
        in_images = samples == 1 or samples <= self.limits["GL_MAX_IMAGE_SAMPLES"]
        for name, capability in MECHANISMS.items():
            if self.has(capability) and (in_images or name == FETCH):
                return name
        several = f" of {samples} samples per pixel; give one (msaa=1)" if samples > 1 else ""
        raise CapabilityError(f"{self.renderer} offers no programmable blending{several}")

    def texture(self, size: tuple[int, int], entry: Format, samples: int = 1) -> moderngl.Texture:
        """Create a texture of `size` (width, height) for texel fetches."""
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
        # moderngl only creates 24-bit depth: allocate 32-bit floats under the same name.
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

    def framebuffer(
        self, colors: Sequence[moderngl.Texture], depth: moderngl.Texture | None = None
    ) -> moderngl.Framebuffer:
        """Create a framebuffer with these attachments."""
        # moderngl binds the previous framebuffer again, which may have been released.
        self.context.screen.use()
        return self.context.framebuffer(colors, depth)

    def write_volume(self, texture: moderngl.Texture3D, numbers: moderngl.Buffer) -> None:
        """Write a volume of one component from a buffer of single-precision floats."""
        self.call("glBindBuffer", _PIXEL_UNPACK_BUFFER, numbers.glo)
        self.call(
            "glTextureSubImage3D",
            *(texture.glo, 0, 0, 0, 0, texture.width, texture.height, texture.depth),
            *(_RED, _FLOAT, None),
        )
        self.call("glBindBuffer", _PIXEL_UNPACK_BUFFER, 0)

    def copy(
        self,
        source: moderngl.Texture,
        target: moderngl.Texture,
        size: tuple[int, int],
        samples: int,
    ) -> None:
        """Copy all texels between two textures of the same format, including depth and integers."""
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

    def fill(self, buffer: moderngl.Buffer, word: int = 0) -> None:
        """Set all words of a buffer to `word`, on the GPU: `moderngl.Buffer.clear` maps it."""
        value = np.array([word], dtype=np.uint32)
        self.call("glClearNamedBufferData", buffer.glo, _R32UI, *_WORDS, value.ctypes.data)

    @cached_property
    def samples_query(self) -> moderngl.Query:
        """A query of samples that pass. There is one, since moderngl never deletes queries."""
        return self.context.query(samples=True)

    def finish(self) -> None:
        """Wait until the driver has completed all work."""
        self.call("glFinish")

    def release(self) -> None:
        """Free the context and everything created with it."""
        self.programs.clear()
        self.context.release()

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *error: object) -> None:
        self.release()
