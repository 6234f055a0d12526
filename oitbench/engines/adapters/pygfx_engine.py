"""pygfx: weighted blending and dithered coverage, by WebGPU on Vulkan, Metal or Direct3D.

Its color target has 8 bits a channel that encode sRGB, and blending decodes and encodes it at each
layer. Colors are linear in its shaders. Source: `pygfx/renderers/wgpu/engine/blender.py`, 0.17.
"""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from oitbench.engines.adapter import Algorithm, Content, Drawing, Engine, Surface
from oitbench.errors import CapabilityError
from oitbench.image.files import Image

_MODES = {"weighted_blended": "weighted_blend", "dither": "dither"}
_BYTE = 255
_FENCE = 16
"""Bytes of a buffer that is read to wait for the device."""


class Pygfx(Engine):
    """The render engine pygfx, in a texture of its own."""

    algorithms: ClassVar = {
        "weighted_blended": Algorithm(
            # These values hold the weight at its lower clamp, o/100 everywhere.
            "weighted_blended[weight=fitted,near_range=0.01,near_power=16]",
            "the same formats; the result is blended in 8 bits of sRGB. The weight is the opacity",
        ),
        "dither": Algorithm(
            "hashed_alpha[noise=blue]",
            "another mask of blue noise: noise agrees in the mean only. 8 bits of sRGB",
        ),
    }

    def __init__(self) -> None:
        try:
            import pygfx
            import wgpu
        except ImportError as error:
            raise CapabilityError(
                f"pygfx cannot be imported ({error}); pip install 'oitbench[engines]'"
            ) from error
        self._gfx, self._wgpu = pygfx, wgpu
        try:
            self._shared = pygfx.renderers.wgpu.get_shared()
            # An object that got no device before is given again.
            self._device = self._shared.device
        except (RuntimeError, AttributeError) as error:
            raise CapabilityError(
                "pygfx finds no driver that it can use; install one of Vulkan, as the package"
                f" mesa-vulkan-drivers has ({' '.join(str(error).split())})"
            ) from error

    @property
    def version(self) -> str:
        """The versions of pygfx and of wgpu."""
        return f"{self._gfx.__version__}, wgpu {self._wgpu.__version__}"

    @property
    def renderer(self) -> str:
        """The device with its interface: never the suite's renderer of OpenGL."""
        info = self._shared.adapter.info
        return f"{info['device']}, {info['backend_type']}"

    def open(self, content: Content, algorithm: str, size: tuple[int, int]) -> Drawing:
        """Return a texture with all surfaces as meshes, in order of submission."""
        gfx = self._gfx
        target = gfx.Texture(dim=2, size=(*size, 1), format="rgba8unorm-srgb")
        renderer = gfx.renderers.WgpuRenderer(
            target, pixel_scale=1, pixel_filter="nearest", ppaa="none", sort_objects=False
        )
        scene = gfx.Scene()
        scene.add(gfx.Background.from_color(gfx.Color.from_physical(*content.background)))
        for surface in content.surfaces:
            scene.add(self._mesh(surface, "solid" if surface.opaque else _MODES[algorithm]))
        usage = self._wgpu.BufferUsage.COPY_SRC | self._wgpu.BufferUsage.COPY_DST
        fence = self._device.create_buffer(size=_FENCE, usage=usage)
        return _Picture(renderer, scene, self._camera(content, size), self._device.queue, fence)

    def _camera(self, content: Content, size: tuple[int, int]) -> Any:
        camera, aspect = content.camera, size[0] / size[1]
        planes = (camera.near, camera.far)
        if camera.height is not None:
            shape = {"width": camera.height * aspect, "height": camera.height}
            view = self._gfx.PerspectiveCamera(0, depth_range=planes, **shape)
        else:
            # The angle of pygfx is that of the mean of width and height.
            mean = math.tan(camera.fov_y / 2) * (1 + aspect) / 2
            angle = 2 * math.degrees(math.atan(mean))
            view = self._gfx.PerspectiveCamera(angle, aspect, depth_range=planes)
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = camera.axes.T, camera.position
        view.world.matrix = place
        return view

    def _mesh(self, surface: Surface, mode: str) -> Any:
        gfx = self._gfx
        arrays = {"positions": surface.positions, "indices": surface.triangles}
        if surface.even:
            color = gfx.Color.from_physical(*map(float, surface.color[0]))
            rgba = (color.r, color.g, color.b, float(surface.opacity[0]))
            material = gfx.MeshBasicMaterial(color=rgba, alpha_mode=mode)
        else:
            colors = np.column_stack([surface.color, surface.opacity]).astype(np.float32)
            arrays["colors"] = colors
            material = gfx.MeshBasicMaterial(color_mode="vertex", alpha_mode=mode)
        return gfx.Mesh(gfx.Geometry(**arrays), material)


class _Picture(Drawing):
    """A scene of pygfx with its renderer."""

    def __init__(self, renderer: Any, scene: Any, camera: Any, queue: Any, fence: Any) -> None:
        self._renderer, self._scene, self._camera = renderer, scene, camera
        self._queue, self._fence = queue, fence

    def draw(self) -> None:
        """Render, and wait until the device has finished."""
        self._renderer.render(self._scene, self._camera)
        # The queue is in order: what is read comes after the frame.
        self._queue.read_buffer(self._fence)

    def image(self) -> Image:
        """Return the picture, decoded from 8 bits of sRGB."""
        encoded = self._renderer.snapshot()[..., :3].astype(np.float32) / np.float32(_BYTE)
        low = encoded / 12.92
        linear = np.where(encoded <= 0.04045, low, ((encoded + 0.055) / 1.055) ** 2.4)
        return np.asarray(linear, dtype=np.float32)
