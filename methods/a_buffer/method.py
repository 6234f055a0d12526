"""A-buffer: every fragment is stored in a list at its pixel, then sorted and composited.

    C = sum_i alpha_i L_i prod_{j nearer than i} tau_j + C0 prod_j tau_j

The only method here that is exact for any geometry, order and depth complexity. Fragments of equal
depth are ordered by their content, never by arrival, so the image is the same for every order of
the draws: bit for bit with `sorted`, to float rounding with `iterative`.

`linked` lists, the default, take one pass over the geometry; each record holds the place of the
next. `counted` lists take two: the first counts the fragments of each pixel, so that the second
stores them in records that follow each other. A stored fragment then takes fewer bytes, and less
time where layers are many and a pass over the geometry is cheap. `python -m tests.benchmarks.exact`
compares both.

`precise` records take 28 bytes: depth, and alpha L and tau as three floats each. `compact` records
take 8 bytes: depth, and alpha L with net opacity in RGBA8 (AT section 4.2).

`sorted` composites the nearest records first (AT eq. 3). Up to 32 records of different depths are
sorted in registers; longer lists in memory, by a heap or, if linked, by merging their links.
`iterative` multiplies the visibility of each record over all nearer ones (AT eq. 2): no local
array, but a quadratic number of list reads.

With `msaa` 4 each of four samples is resolved from the records whose coverage mask contains it. The
mask takes the low four bits of the record's depth, which comparisons ignore (AT section 4.2):
depths that differ by less than two millionths of themselves count as equal.

Memory 4 B/pixel + 12 (or 32) B/fragment; `counted` 12 B/pixel + 8 (or 28) B/fragment. Records come
from one counter per screen tile of 64 x 64 pixels. When a tile's share is used up, its counter
still records the demand, and the frame is repeated with enough memory.

Sources: Vasilakis & Fudos 2012 [VasilakisFudos2012], "S-buffer: Sparsity-aware Multi-fragment
Rendering", for `counted`; Yang et al. 2010 [Yang2010], "Real-Time Concurrent Linked List
Construction on the GPU", for `linked`; Knowles et al. 2014 [Knowles2014], "Fast Sorting for Exact
OIT of Complex Scenes", for sorting in registers; Salvi et al. 2011 [Salvi2011], "Adaptive
Transparency" (AT), equations 2 and 3. The two equations differ at exactly equal depths; here both
order ties by content and agree.

Known failures: unbounded memory. `compact` quantizes to 8 bits, one step of 1/255 per layer.
"""

import math

import oitbench as oit
from oitbench.method.kits.counted_lists import counted
from oitbench.method.kits.linked_lists import RECORD_STEPS, linked


class ABuffer(oit.Method):
    family = "exact"
    node = oit.Parameter(
        "precise",
        choices=("precise", "compact"),
        grid=("precise", "compact"),
        help="record; `compact` clips radiance above one and holds gray transmission only",
    )
    resolve = oit.Parameter("sorted", choices=("sorted", "iterative"), help="way of compositing")
    storage = oit.Parameter(
        "linked",
        choices=("linked", "counted"),
        help="lists: `linked` takes one pass over the geometry, `counted` fewer bytes a fragment",
    )
    msaa = oit.Parameter(1, choices=(1, 4), help="samples per pixel")
    truth = {"node": "precise", "resolve": "sorted", "storage": "linked", "msaa": 1}

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact equal_layers_exact order_independent opaque_front_hides"
            " total_transmittance_exact zero_coverage_ignored white_furnace two_layers_ordered"
            " visibility_monotonic"
        )
        precise = oit.promise("colored_layer_exact scales_with_radiance")
        return kept | precise if self.node == "precise" else kept

    @property
    def record_step(self) -> float:
        return RECORD_STEPS[self.node]

    @property
    def expresses(self) -> oit.Effect:
        colored = self.node == "precise"
        return oit.Effect.COVERAGE | (
            oit.Effect.COLORED_TRANSMISSION if colored else oit.Effect.NONE
        )

    def loop_steps(self, fragments: int) -> float:
        # Sorting takes n log2 n steps and some for each record. Else 32 records against all n.
        depth = math.log2(max(fragments, 1)) + 4 if self.resolve == "sorted" else 34
        return fragments * depth

    def plan(self, request: oit.Request) -> oit.Plan:
        color = oit.Target("rgba32f" if self.node == "precise" else "rgba16f")
        lists = counted(self.node) if self.storage == "counted" else linked(self.node)
        reads, buffers = tuple(lists.targets), tuple(lists.buffers)
        resolve = oit.Resolve(
            f"resolve_{self.resolve}.glsl", reads, {"color": oit.COMPOSITE}, buffers
        )
        steps: tuple[oit.Step, ...] = (resolve,)
        if self.resolve == "iterative":
            steps = (oit.Loop((resolve,), until_empty=resolve.name),)
        elif self.msaa > 1:
            # The samples of a pixel share its list, so only one of them may sort it.
            steps = (oit.Resolve("sort_all.glsl", reads, buffers=buffers), resolve)
        return oit.Plan({"color": color, **lists.targets}, (*lists.fill, *steps), lists.buffers)
