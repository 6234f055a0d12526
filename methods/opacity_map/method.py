"""Opacity-map transparency: absorbance accumulated to each of K slices of a pixel's depth range.

    Omega_k = sum_{u_i <= k/K} a_i,    a = -ln(1 - o),    u = (z - nearest) / (farthest - nearest)
    vis(u) = exp(-Omega(u)), linear in u between slices, Omega_0 = 0
    C = sum_i alpha_i L_i vis(u_i) + C0 exp(-Omega_K)

The bounds are those of the layers that absorb. The total transmittance is exact. All operations are
sums, so the order of the draws does not matter.

`normalized` divides the sum of layers by that of their weights o vis(u) and multiplies it by the
part of the light that all hide, as moments and wavelets do: errors of visibility then do not change
the amount of light.

`variable` stores all fragments in lists and keeps slices in local memory. `fixed` takes three
geometry passes: bounds, slices, compositing. `rgb` builds and uses one curve per channel, in three
rounds instead of three times the storage. With `msaa` 4 each of four samples is rendered
separately: lists have coverage masks in the low four bits of depth, targets four times the texels.

Memory, `variable`: 4 B/pixel + 12 B/fragment (16 with `rgb`, 32 with `precise`). `fixed`: 4 B per
slice and 8 B of bounds per pixel, 72 B for the 16 slices of the paper's table.

Sources: Kim & Neumann 2001 [KimNeumann2001], "Opacity Shadow Maps"; Salvi et al. 2011 [Salvi2011],
"Adaptive Transparency", the OSMT of section 4. Kim & Neumann sum opacity; its logarithm makes the
total exact.

Known failures: layers are darkened by themselves and by layers behind them in the same slice. Bands
appear where layers cross slices. A single far layer stretches all slices. An opaque layer counts as
one that transmits 1e-5.
"""

import oitbench as oit
from oitbench.method.kits.absorbance import AbsorbanceMap


class OpacityMap(AbsorbanceMap):
    family = "curves"
    quick = False
    slices = oit.Parameter(16, choices=(4, 8, 16, 32), help="K, steps of a curve")

    @property
    def terms(self) -> int:
        return self.slices
