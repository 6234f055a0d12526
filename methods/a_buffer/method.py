"""A-buffer: every fragment is kept in a list at its pixel, then sorted and composited.

    C = sum_i alpha_i L_i prod_{j nearer than i} tau_j + C0 prod_j tau_j

The only method here that is exact for any geometry, order and depth complexity. Fragments of equal
depth are ordered by what they carry, never by arrival, so the image is the same for every order of
the draws: bit for bit where they are sorted, to float rounding where they are not.

Parameters
----------
node : what a fragment's record holds. `precise` has 32 bytes: next, depth, and alpha L and tau as
    three floats each. `compact` has 12 bytes: next, depth, and alpha L with net opacity in RGBA8
    (AT section 4.2); it clips radiance above one and sees grey transmission only.
resolve : `sorted` composites the nearest records first (AT eq. 3); lists that are too long for
    local arrays are merge-sorted in their links. `iterative` multiplies the visibility of each
    record over all nearer ones (AT eq. 2): no local array, quadratic in list reads.
msaa : 4 resolves each of four samples by itself, from the records whose coverage mask has it. The
    mask is in the low four bits of the record's depth, which are left out where depths are compared
    (AT section 4.2): depths that differ by less than two millionths of themselves count as equal.

Memory 4 B/pixel + 12 (or 32) B/fragment. Records come from one counter for each screen tile of
64 x 64 pixels: a single counter is contended by every fragment of the frame. When a tile's share
runs out, its counter still tells what it needed and the frame is redone with enough.

Sources: Yang et al. 2010, "Real-Time Concurrent Linked List Construction on the GPU"; Salvi et al.
2011, "Adaptive Transparency" (AT), equations 2 and 3. The two equations differ at exactly equal
depths; here both order ties by content and agree.

Known failures: memory without bound. `compact` quantizes to 8 bits: one step of 1/255 a layer.
"""

from collections.abc import Mapping

from oitbench import (
    COMPOSITE,
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
from oitbench.method.kits.linked_lists import CAPTURE, LISTS, RECORD_STEPS, linked_lists

_ROUNDS = 1 << 16


class ABuffer(Method):
    parameters = {
        "node": Parameter(
            "precise", choices=("precise", "compact"), grid=("precise", "compact"), help="record"
        ),
        "resolve": Parameter("sorted", choices=("sorted", "iterative"), help="compositing"),
        "msaa": Parameter(1, choices=(1, 4), help="samples a pixel"),
    }
    truth = {"node": "precise", "resolve": "sorted", "msaa": 1}

    @property
    def holds(self) -> frozenset[str]:
        held = {"U1", "U2", "U3", "U4", "U5", "U6", "U7", "U8", "U9", "U11"}
        # A packed record is grey and clips.
        return frozenset(held | {"U2c", "U10"} if self.text("node") == "precise" else held)

    @property
    def record_step(self) -> float:
        return RECORD_STEPS[self.text("node")]

    @property
    def expresses(self) -> Effect:
        colored = self.text("node") == "precise"
        return Effect.COVERAGE | (Effect.COLORED_TRANSMISSION if colored else Effect.NONE)

    @property
    def deepest(self) -> int:
        # n log2 n steps of merging, or a chunk of 32 against all n.
        return 4000 if self.text("resolve") == "sorted" else 1900

    @property
    def targets(self) -> Mapping[str, Target]:
        return {"color": Target("rgba32f" if self.text("node") == "precise" else "rgba16f")}

    @property
    def samples(self) -> int:
        return int(self.values["msaa"])

    @property
    def buffers(self) -> Mapping[str, Buffer]:
        return linked_lists(self.text("node"))

    @property
    def passes(self) -> tuple[Step, ...]:
        shader = f"resolve_{self.text('resolve')}.glsl"
        resolve = Pass(shader, Draws.PIXELS, writes={"color": COMPOSITE}, buffers=LISTS)
        if self.text("resolve") == "iterative":
            return (CAPTURE, Loop((resolve,), times=_ROUNDS, until_empty=resolve.name))
        # The samples of a pixel share its list, so only one of them may sort it.
        long = Pass("sort_long.glsl", Draws.PIXELS, buffers=LISTS)
        return (CAPTURE, long, resolve) if self.samples > 1 else (CAPTURE, resolve)
