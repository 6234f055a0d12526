"""What one pixel is made of: the transparent fragments that every method is given there."""

from __future__ import annotations

import numpy as np

from oitbench.effects import SHADING
from oitbench.gl.device import Device
from oitbench.gl.geometry import Geometry
from oitbench.gl.program.passes import Blueprint, compile_pass
from oitbench.gl.program.prelude import TILE, bind
from oitbench.gl.resources import Resources
from oitbench.gl.shading.lighting import lighting_of
from oitbench.gl.shading.occlusion import occlusion_of
from oitbench.gl.shading.opaque import DEPTH, count_fragments, draw_opaque
from oitbench.gl.view import view_block
from oitbench.method.declaration import Buffer, Draws, Items, Method, Order, Pass, Target
from oitbench.scene import FragmentLists

_BUFFERS = {
    "fragments": Buffer({"draw": "uint", "light": "vec4", "glass": "vec4"}, Items.FRAGMENTS)
}
_PROBE = Pass("probe.glsl", Draws.FRAGMENTS, buffers=("fragments",))
_COLOR = Target("rgba16f")


def probe(
    device: Device, geometry: Geometry, size: tuple[int, int], pixel: tuple[int, int]
) -> FragmentLists:
    """Return the visible transparent fragments at the center of one pixel.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    size : (int, int)
        Width and height of the frame in pixels.
    pixel : (int, int)
        Column from the left and row from the top.

    Returns
    -------
    FragmentLists
        One pixel, (n, 1, 1), in the order in which they are submitted.
    """
    column, row = pixel[0], size[1] - 1 - pixel[1]
    effects = geometry.scene.effects & SHADING
    count = int(count_fragments(device, geometry, size, effects)[row, column])
    lighting = lighting_of(device, geometry, effects)
    occlusion = occlusion_of(device, geometry, size, effects)
    for stage in (lighting, occlusion):
        if stage is not None:
            stage.prepare()
    bindings = bind(_BUFFERS, False)
    resources = Resources(device, size, {}, _BUFFERS, bindings, device.max_block_bytes)
    demand = np.zeros(resources.tiles, dtype=np.int64)
    demand[row // TILE, column // TILE] = count
    resources.reserve(demand)
    color, depth = (device.texture(size, target.texel) for target in (_COLOR, DEPTH))
    view = device.context.buffer(view_block(geometry.scene.camera, size, False))
    draw_opaque(
        device, geometry, view, (color, depth), _COLOR, 1, False, lighting, effects, occlusion
    )
    blueprint = Blueprint(
        device, geometry, Method(), None, effects, {"opaque_depth": DEPTH}, _BUFFERS, bindings,
        lighting=lighting, occlusion=occlusion,
    )  # fmt: skip
    indices = geometry.transparent.arrange(Order.SUBMISSION)[0]
    if count:
        compiled = compile_pass(blueprint, _PROBE, {"opaque_depth": depth})
        buffer = device.context.buffer(indices.tobytes())
        resources.begin(resources.regions[0])
        resources.bind()
        compiled.begin(view, (column, row, 1, 1))
        compiled.draw(buffer, 0, len(indices))
        compiled.release()
        buffer.release()
    # Records come in the order of their allocation, which no driver owes us.
    order = np.argsort(resources.read("fragments", "draw")[:count, 0], kind="stable")
    light, glass = (
        resources.read("fragments", name)[:count][order].view(np.float32)
        for name in ("light", "glass")
    )
    for item in (color, depth, view, resources):
        item.release()
    if occlusion is not None:
        occlusion.release()
    return FragmentLists(
        glass[:, 3].reshape(-1, 1, 1).copy(),
        light[:, 3].reshape(-1, 1, 1).copy(),
        light[:, :3].reshape(-1, 1, 1, 3).copy(),
        glass[:, :3].reshape(-1, 1, 1, 3).copy(),
    )
