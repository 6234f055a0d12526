"""Adaptive transparency (AT): visibility as at most N steps a pixel, refined where it matters.

    vis(z) = prod_{z_i < z} tau_i,    C = sum_i alpha_i L_i vis(z_i) + C0 prod_i tau_i

A node is a depth and the transmittance behind it. A fragment multiplies the curve by its step; when
N + 1 nodes are there, one is removed so that the integral of the curve changes least (AT eq. 7).
With `under` the node in front takes over the removed one's transmittance: the curve is never above
the truth. With `over` the node goes as a whole and the curve is never below; the last node stays,
for it holds the total. With either the total transmittance is exact for any N, so no pass is needed
to correct it.

Parameters
----------
nodes : N, 2 to 32.
removal : `under` (the paper's choice), `over`, or `best`: whichever loses less at each removal.
memory : `variable` keeps all fragments in lists and has the curve in local memory. `fixed` has it
    in targets: one geometry pass of programmable blending builds it, another composites against it.
depth : `linear` view distance (m) or `window` depth, in which the removal measures its areas.
channels : `grey` has one curve, of the mean transmittance over the channels. `rgb` has one for each
    channel, made and used one after another: three rounds instead of three times the storage.
node : the record of a list, as of an A-buffer: `compact` clips radiance above one and has 8 bits a
    value. `fixed` has nothing to do with it.
msaa : 4 renders each of four samples by itself: lists have coverage masks in the low four bits of
    depth (AT section 4.2), targets four times the texels.

Memory, `variable`: 4 B/pixel + 12 B/fragment (16 with `rgb`, 32 with `precise`). `fixed`: 8 B a
node and pixel, two floats, up to 16 nodes; beyond, 4 B a node, with 24 bits of depth and 8 bits of
transmittance.

Source: Salvi, Montgomery & Lefohn 2011, "Adaptive Transparency". Fragments are inserted in the
order of submission. The paper's curve is strict (H(0) = 0, eq. 5), and so is this one: layers at
exactly one depth do not hide each other, where the recursion of eq. 3 has one hide the other.

Known failures: more than N layers darken (`under`) or brighten (`over`) the picture, and then the
order of submission shows. Many faint layers of like strength darken most, because the area of each
removal is small and their sum is not. Coplanar layers come out too bright. Packed nodes round
transmittance to 1/255 at each insertion, so layers that hide less than half a step leave no trace:
of hundreds of faint layers, 32 packed nodes show far less than 16 of floats. Against the paper's
ranking, 16 nodes err more than 16 stochastic samples on the 650-layer lists of the tests (mean
error 0.022 against 0.013); 32 nodes err less than 64 samples.
"""

from collections.abc import Mapping

from oitbench import (
    ADD,
    COMPOSITE,
    MODULATE,
    PROGRAMMABLE,
    Buffer,
    Draws,
    Effect,
    Loop,
    Method,
    Parameter,
    Pass,
    Step,
    Target,
)
from oitbench.method.kits.linked_lists import LISTS, RECORD_STEPS, REVERSE, linked_lists

_FAR, _FAR_PACKED = 2.0**127, 0xFE0000FF  # nodes that hide nothing
_MOST_FLOAT_NODES = 16


class Adaptive(Method):
    parameters = {
        "nodes": Parameter(8, low=2, high=32, grid=(4, 8, 16), help="steps of a curve"),
        "removal": Parameter("under", choices=("under", "over", "best"), help="how nodes go"),
        "memory": Parameter(
            "variable", choices=("variable", "fixed"), grid=("variable", "fixed"), help="storage"
        ),
        "depth": Parameter("linear", choices=("linear", "window"), help="depth of the curve"),
        "channels": Parameter("grey", choices=("grey", "rgb"), help="one curve, or three"),
        "node": Parameter("compact", choices=("compact", "precise"), help="record of a list"),
        "msaa": Parameter(1, choices=(1, 4), help="samples a pixel"),
    }

    @property
    def holds(self) -> frozenset[str]:
        held = {"U1", "U2", "U6", "U7", "U9", "U11"}
        held |= {"U2c"} if self._tinted else set()
        # Underestimates hide all that lies behind an opaque layer.
        held |= {"U5"} if self.text("removal") == "under" else set()
        return frozenset(held | ({"U10"} if self._precise else set()))

    @property
    def record_step(self) -> float:
        packed = "compact" if self._packed else "precise"
        return RECORD_STEPS[packed if self._fixed else self.text("node")]

    @property
    def expresses(self) -> Effect:
        return Effect.COVERAGE | (Effect.COLORED_TRANSMISSION if self._tinted else Effect.NONE)

    @property
    def samples(self) -> int:
        return int(self.values["msaa"])

    @property
    def deepest(self) -> int | None:
        # Two traversals of a list in one shader.
        return None if self._fixed else 32_000

    @property
    def targets(self) -> Mapping[str, Target]:
        color = {"color": Target("rgba32f" if self._precise else "rgba16f")}
        nodes = Target("rgba32f", clear=(_FAR, 1.0, _FAR, 1.0))
        if self._packed:
            nodes = Target("rgba32ui", clear=(_FAR_PACKED,) * 4)
        return {**color, **dict.fromkeys(self._nodes, nodes)}

    @property
    def buffers(self) -> Mapping[str, Buffer]:
        return {} if self._fixed else linked_lists(self.text("node"), self._tinted)

    @property
    def passes(self) -> tuple[Step, ...]:
        return self._fixed_passes if self._fixed else self._variable_passes

    @property
    def _variable_passes(self) -> tuple[Step, ...]:
        capture = Pass("capture.glsl", Draws.FRAGMENTS, buffers=LISTS)
        resolve = Pass("resolve.glsl", Draws.PIXELS, writes={"color": COMPOSITE}, buffers=LISTS)
        return (capture, REVERSE, *self._rounds(resolve))

    @property
    def _fixed_passes(self) -> tuple[Step, ...]:
        defines = {"TARGETS": len(self._nodes), **({"PACKED": 1} if self._packed else {})}
        build = Pass(
            "build.glsl",
            Draws.FRAGMENTS,
            writes=dict.fromkeys(self._nodes, PROGRAMMABLE),
            clears=self._nodes if self._tinted else (),
            defines=defines,
        )
        attenuate = Pass(
            "attenuate.glsl",
            Draws.PIXELS,
            reads=self._nodes,
            writes={"color": MODULATE},
            defines=defines,
        )
        composite = Pass(
            "composite.glsl",
            Draws.FRAGMENTS,
            reads=self._nodes,
            writes={"color": ADD},
            defines=defines,
        )
        return self._rounds(build, attenuate, composite)

    def _rounds(self, *passes: Pass) -> tuple[Step, ...]:
        return (Loop(passes, times=3),) if self._tinted else passes

    @property
    def _nodes(self) -> tuple[str, ...]:
        """The targets that hold nodes."""
        per_target = 4 if self._packed else 2
        count = -(-int(self.values["nodes"]) // per_target) if self._fixed else 0
        return tuple(f"nodes{i}" for i in range(count))

    @property
    def _fixed(self) -> bool:
        return self.text("memory") == "fixed"

    @property
    def _packed(self) -> bool:
        return self._fixed and int(self.values["nodes"]) > _MOST_FLOAT_NODES

    @property
    def _precise(self) -> bool:
        return self._fixed or self.text("node") == "precise"

    @property
    def _tinted(self) -> bool:
        return self.text("channels") == "rgb"
