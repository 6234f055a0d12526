"""Opacity-map transparency: absorbance summed up to each of K slices of a pixel's depth range.

    Omega_k = sum_{u_i <= k/K} a_i,    a = -ln(1 - o),    u = (z - nearest) / (farthest - nearest)
    vis(u) = exp(-Omega(u)), linear in u between slices, Omega_0 = 0
    C = sum_i alpha_i L_i vis(u_i) + C0 exp(-Omega_K)

The bounds are those of the layers that absorb. The total transmittance is exact. All sums, so the
order of the draws does not matter.

Parameters
----------
slices : K, 4 to 32.
memory : `variable` keeps all fragments in lists, and slices in local memory. `fixed` takes three
    geometry passes: bounds, slices, compositing.
channels : `grey` has one curve, of the mean transmittance over the channels. `rgb` has one for each
    channel, made and used one after another: three rounds instead of three times the storage.
node : the record of a list, as of an A-buffer: `compact` clips radiance above one and has 8 bits a
    value. `fixed` has nothing to do with it.
msaa : 4 renders each of four samples by itself: lists have coverage masks in the low four bits of
    depth, targets four times the texels.

Memory, `variable`: 4 B/pixel + 12 B/fragment (16 with `rgb`, 32 with `precise`). `fixed`: 4 B a
slice and 8 B of bounds a pixel, 72 B for the 16 slices of the paper's table.

Sources: Kim & Neumann 2001, "Opacity Shadow Maps"; Salvi et al. 2011, "Adaptive Transparency",
whose OSMT this is (section 4). Kim & Neumann sum opacity; its logarithm makes the total exact.

Known failures: layers are darkened by themselves and by what lies behind them in the same slice,
bands appear where layers cross slices, and a single far layer stretches all slices. An opaque layer
counts as one that lets 1e-5 pass.
"""

from oitbench import Parameter
from oitbench.method.kits.absorbance import AbsorbanceMap


class OpacityMap(AbsorbanceMap):
    quick = False
    parameters = {
        "slices": Parameter(16, choices=(4, 8, 16, 32), help="steps of a curve"),
        **AbsorbanceMap.parameters,
    }

    @property
    def terms(self) -> int:
        return int(self.values["slices"])
