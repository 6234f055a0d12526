"""Adaptive transparency (AT): visibility as at most N steps per pixel, kept where they matter.

    vis(z) = prod_{z_i < z} tau_i,    C = sum_i alpha_i L_i vis(z_i) + C0 prod_i tau_i

A node is a depth and the transmittance behind it. A fragment multiplies the curve by its step. When
there are N + 1 nodes, the node is removed that changes the integral of the curve least (AT
eq. 7). With `under` the node in front takes over the transmittance of the removed one, and the
curve never exceeds the truth. With `over` the whole node is removed, and the curve is never below
it; the last node stays, since it holds the total. The total transmittance is exact for any N, so no
pass is needed to correct it.

`variable` stores all fragments in lists and keeps the curve in local memory. `fixed` keeps it in
targets: one geometry pass of programmable blending builds it, another composites against it. `rgb`
builds and uses one curve per channel, in three rounds instead of three times the storage. With
`msaa` 4 each of four samples is rendered separately: lists have coverage masks in the low four bits
of depth (AT section 4.2), targets have four times the texels.

Memory, `variable`: 4 B/pixel + 12 B/fragment (16 with `rgb`, 32 with `precise`). `fixed`: 8 B per
node and pixel, two floats, up to 16 nodes; above, 4 B per node, with 24 bits of depth and 8 bits of
transmittance.

Source: Salvi, Montgomery & Lefohn 2011 [Salvi2011], "Adaptive Transparency". Fragments are inserted
in submission order; lists on GPUs keep the order of arrival instead. The paper's curve is strict
(H(0) = 0, eq. 5), and so is this one: layers of exactly equal depth do not hide each other, whereas
in the recursion of eq. 3 one hides the other.

Known failures: more than N layers darken (`under`) or brighten (`over`) the picture, which then
depends on the order of submission. With lists on GPUs it changes from run to run. Many faint layers
of similar strength darken most: the area of each removal is small, but their sum is not. Coplanar
layers are too bright. Packed nodes round transmittance to 1/255 at each insertion, so layers that
hide less than half a step leave no trace: of hundreds of faint layers, 32 packed nodes show far
less than 16 float nodes. Contrary to the paper's ranking, 16 nodes err more than 16 stochastic
samples on the 650-layer lists of the tests (mean error 0.022 against 0.013); 32 nodes err less than
64 samples.
"""

import oitbench as oit
from oitbench.method.kits.curves import CurveMethod
from oitbench.method.kits.linked_lists import LISTS, RECORD_STEPS, REVERSE

_FAR, _FAR_PACKED = 2.0**127, 0xFE0000FF  # nodes that hide nothing
_MOST_FLOAT_NODES = 16


class Adaptive(CurveMethod):
    family = "lists"
    nodes = oit.Parameter(
        8, low=2, high=32, grid=(2, 4, 8, 16, 32), sweep=True, help="N, steps of a curve"
    )
    removal = oit.Parameter(
        "under",
        choices=("under", "over", "best"),
        help="way to remove a node: `under` as in the paper, `best` of both at each removal",
    )
    depth = oit.Parameter(
        "linear", choices=("linear", "window"), help="of the curve: view distance in m, or window"
    )
    traversals = 2

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact total_transmittance_exact zero_coverage_ignored two_layers_ordered"
            " visibility_monotonic"
        )
        kept |= oit.promise("colored_layer_exact" if self.tinted else "")
        # Underestimates hide everything behind an opaque layer.
        kept |= oit.promise("opaque_front_hides" if self.removal == "under" else "")
        return kept | oit.promise("scales_with_radiance" if self.precise else "")

    @property
    def packed(self) -> bool:
        return self.fixed and self.nodes > _MOST_FLOAT_NODES

    @property
    def record_step(self) -> float:
        return RECORD_STEPS["compact"] if self.packed else super().record_step

    @property
    def list_steps(self) -> tuple[oit.Step, ...]:
        capture = oit.Gather("capture.glsl", buffers=LISTS)
        resolve = oit.Resolve("resolve.glsl", writes={"color": oit.COMPOSITE}, buffers=LISTS)
        return (capture, REVERSE, *self.rounds(resolve))

    @property
    def fixed_plan(self) -> oit.Plan:
        count = -(-self.nodes // (4 if self.packed else 2))
        nodes = tuple(f"nodes{i}" for i in range(count))
        texel = oit.Target("rgba32f", clear=(_FAR, 1.0, _FAR, 1.0))
        if self.packed:
            texel = oit.Target("rgba32ui", clear=(_FAR_PACKED,) * 4)
        defines = {"TARGETS": count, **({"PACKED": 1} if self.packed else {})}
        build = oit.Gather(
            "build.glsl",
            writes=dict.fromkeys(nodes, oit.PROGRAMMABLE),
            clears=nodes if self.tinted else (),
            defines=defines,
        )
        attenuate = oit.Resolve(
            "attenuate.glsl", reads=nodes, writes={"color": oit.MODULATE}, defines=defines
        )
        composite = oit.Gather(
            "composite.glsl", reads=nodes, writes={"color": oit.ADD}, defines=defines
        )
        return oit.Plan(dict.fromkeys(nodes, texel), self.rounds(build, attenuate, composite))
