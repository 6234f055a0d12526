"""The transparent fragments at one pixel, as every method receives them."""

from __future__ import annotations

import numpy as np

from oitbench.effects import SHADING, Effect
from oitbench.gl.draws.chain import Chain
from oitbench.gl.ownership import Owner
from oitbench.gl.plan import FramePlan
from oitbench.gl.program.bindings import Bindings
from oitbench.gl.program.passes import Blueprint
from oitbench.gl.program.shading_inputs import UNLIT
from oitbench.gl.resources import Resources
from oitbench.gl.shading.occlusion import Occlusion, occludes
from oitbench.gl.shading.opaque import DEPTH, OpaquePicture
from oitbench.gl.tiling import TILE
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.method.passes import OPAQUE_DEPTH, Gather
from oitbench.method.storage import Buffer, Items, Target
from oitbench.scene import FragmentLists

_BUFFERS = {
    "fragments": Buffer({"draw": "uint", "light": "vec4", "glass": "vec4"}, Items.FRAGMENTS)
}
_PROBE = Gather("probe.glsl", buffers=("fragments",))
_COLOR = Target("rgba16f")


def probe(scene: UploadedScene, size: tuple[int, int], pixel: tuple[int, int]) -> FragmentLists:
    """Return the visible transparent fragments at the center of one pixel.

    Parameters
    ----------
    scene : UploadedScene
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
    effects = scene.scene.effects & SHADING
    count = int(scene.fragment_counts(size, effects)[row, column])
    with Owner() as owner:
        resources = _record(owner, scene, size, effects, (column, row), count)
        # Records come in the order of their allocation, which no driver guarantees.
        order = np.argsort(resources.read("fragments", "draw")[:count, 0], kind="stable")
        light, glass = (
            resources.read("fragments", name)[:count][order].view(np.float32)
            for name in ("light", "glass")
        )
    return FragmentLists(
        glass[:, 3].reshape(-1, 1, 1).copy(),
        light[:, 3].reshape(-1, 1, 1).copy(),
        light[:, :3].reshape(-1, 1, 1, 3).copy(),
        glass[:, :3].reshape(-1, 1, 1, 3).copy(),
    )


def _record(
    owner: Owner,
    scene: UploadedScene,
    size: tuple[int, int],
    effects: Effect,
    place: tuple[int, int],
    count: int,
) -> Resources:
    """Draw the transparent geometry at one pixel; return the buffers that hold its fragments."""
    device, geometry = scene.device, scene.geometry
    lighting = scene.lighting(effects)
    shading = lighting.inputs(effects) if lighting else UNLIT
    if lighting is not None:
        lighting.prepare()
    if occludes(scene.scene, effects):
        occlusion = owner.own(Occlusion(device, geometry, size))
        occlusion.prepare()
        shading = shading.with_occlusion(occlusion.samplers)
    plan = FramePlan(
        "probe", size, effects, None, {}, _COLOR, _BUFFERS, (_PROBE,), Bindings.of(_BUFFERS, False)
    )
    resources = owner.own(Resources(device, plan))
    demand = np.zeros(resources.tiles, dtype=np.int64)
    demand[place[1] // TILE, place[0] // TILE] = count
    resources.reserve(demand)
    view = owner.own(device.context.buffer(geometry.view(size)))
    color = owner.own(device.texture(size, _COLOR.texel))
    depth = owner.own(device.texture(size, DEPTH.texel))
    opaque = owner.own(
        OpaquePicture(
            device, geometry, color, depth, _COLOR, view, effects=effects, shading=shading
        )
    )
    opaque.draw()
    blueprint = Blueprint(
        "probe", buffers=plan.buffers, bindings=plan.bindings, effects=effects, shading=shading
    )
    targets, sizes = {OPAQUE_DEPTH: DEPTH}, {OPAQUE_DEPTH: size}
    chain = owner.own(Chain(device, geometry, targets, sizes, view, {OPAQUE_DEPTH: depth}))
    if count:
        chain.add(_PROBE, blueprint, batch=geometry.transparent)
        resources.begin(resources.regions[0])
        resources.bind()
        chain.issue(scissor=(*place, 1, 1))
    return resources
