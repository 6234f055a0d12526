"""The engine's own passes: the opaque picture behind everything, and the count of fragments."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.geometry import Batch, Geometry
from oitbench.gl.program.passes import Blueprint, compile_pass
from oitbench.gl.program.prelude import bind
from oitbench.gl.shading.lighting import Lighting
from oitbench.gl.shading.occlusion import Occlusion, occludes
from oitbench.gl.view import view_block
from oitbench.method.declaration import ADD, REPLACE, Draws, Method, Order, Pass, Target

_OPAQUE = Pass("opaque.glsl", Draws.FRAGMENTS, writes={"color": REPLACE}, defines={"OPAQUE": 1})
_INTERIOR = replace(_OPAQUE, defines={"OPAQUE": 1, "INTERIOR": 1})
_COUNT = Pass("count.glsl", Draws.FRAGMENTS, writes={"count": ADD})
_BACKGROUND = Pass(
    "background.glsl", Draws.PIXELS, reads=("opaque_depth",), writes={"color": REPLACE}
)
_COLOR, _COUNTED, DEPTH = Target("rgba16f"), Target("r32f"), Target("depth32f")


def draw_opaque(
    device: Device,
    geometry: Geometry,
    view: moderngl.Buffer,
    textures: tuple[moderngl.Texture, moderngl.Texture],
    color: Target,
    samples: int,
    transmittance: bool,
    lighting: Lighting | None = None,
    effects: Effect = Effect.NONE,
    occlusion: Occlusion | None = None,
) -> None:
    """Render what lies behind all transparency, and fill the uniform block for `view`.

    Under ambient occlusion that includes what binary coverage covers whole. Passes over transparent
    fragments test their depth against it, and so meet none of those again.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    view : moderngl.Buffer
        The uniform block `View`.
    textures : (color, depth)
    color : Target
        Of the color texture.
    samples : int
        Samples a pixel of both textures.
    transmittance : bool
        Show a background of one instead of radiance.
    lighting : Lighting, optional
        What shades; without it nothing is lit.
    effects : Effect
        Those that run.
    occlusion : Occlusion, optional
        What hides the environment from surfaces; without it nothing does.
    """
    scene, size = geometry.scene, textures[0].size
    view.write(view_block(scene.camera, size, transmittance))
    background = (1.0, 1.0, 1.0) if transmittance else scene.background
    framebuffer = device.context.framebuffer([textures[0]], textures[1])
    framebuffer.use()
    framebuffer.scissor = (0, 0, *size)
    device.clear(0, color.texel, (*background, 1.0))
    device.clear(0, DEPTH.texel, (1.0,))
    framebuffer.release()
    names = {"color": textures[0], "opaque_depth": textures[1]}
    declared = {"color": color, "opaque_depth": DEPTH}
    blueprint = replace(
        _blueprint(device, geometry, declared, samples),
        lighting=lighting, effects=effects, occlusion=occlusion,
    )  # fmt: skip
    _draw(blueprint, _OPAQUE, names, geometry.opaque, view, depth_writes=True)
    if occludes(scene, effects):
        _draw(blueprint, _INTERIOR, names, geometry.cutouts, view, depth_writes=True)
    if scene.environment is not None and lighting is not None and not transmittance:
        background_pass = compile_pass(blueprint, _BACKGROUND, names)
        background_pass.begin(view, (0, 0, *size))
        background_pass.draw_screen()
        background_pass.release()


def count_fragments(
    device: Device, geometry: Geometry, size: tuple[int, int], effects: Effect = Effect.NONE
) -> npt.NDArray[np.int64]:
    """Return the number of visible transparent fragments a pixel, shape (h, w), bottom row first.

    One sample a pixel is taken, at its center. The geometry remembers the counts. `effects` are
    those that run: ambient occlusion makes some fragments opaque.
    """
    key = (size, occludes(geometry.scene, effects))
    known = geometry.complexities.get(key)
    if known is not None:
        return known
    color = device.texture(size, _COLOR.texel)
    depth = device.texture(size, DEPTH.texel)
    count = device.texture(size, _COUNTED.texel)
    view = device.context.buffer(view_block(geometry.scene.camera, size, False))
    draw_opaque(device, geometry, view, (color, depth), _COLOR, 1, False, effects=effects)
    framebuffer = device.context.framebuffer([count])
    framebuffer.use()
    framebuffer.scissor = (0, 0, *size)
    device.clear(0, _COUNTED.texel, (0.0,))
    framebuffer.release()
    declared = {"count": _COUNTED, "opaque_depth": DEPTH}
    names = {"count": count, "opaque_depth": depth}
    _draw(_blueprint(device, geometry, declared, 1), _COUNT, names, geometry.transparent, view)
    counts = np.frombuffer(count.read(), dtype=np.float32).reshape(size[::-1])
    for item in (color, depth, count, view):
        item.release()
    geometry.complexities[key] = counts.astype(np.int64)
    return geometry.complexities[key]


def _blueprint(
    device: Device, geometry: Geometry, declared: Mapping[str, Target], samples: int
) -> Blueprint:
    return Blueprint(
        device, geometry, Method(), None, Effect.NONE, declared, {}, bind({}, False), samples
    )


def _draw(
    blueprint: Blueprint,
    step: Pass,
    textures: Mapping[str, moderngl.Texture],
    batch: Batch,
    view: moderngl.Buffer,
    depth_writes: bool = False,
) -> None:
    indices = batch.arrange(Order.SUBMISSION)[0]
    if not len(indices):
        return
    compiled = compile_pass(blueprint, step, textures, depth_writes)
    buffer = blueprint.device.context.buffer(indices.tobytes())
    some = next(iter(textures.values()))
    compiled.begin(view, (0, 0, *some.size))
    compiled.draw(buffer, 0, len(indices))
    compiled.release()
    buffer.release()
