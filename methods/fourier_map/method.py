"""Fourier-map transparency: a pixel's absorbance over depth as a truncated Fourier series.

    a = -ln(1 - o),    u = (z - nearest) / (farthest - nearest)
    a_k = 2 sum_i a_i cos(2 pi k u_i),    b_k = 2 sum_i a_i sin(2 pi k u_i),    k = 0 ... n
    -ln vis(u) = a_0 u / 2 + sum_k (a_k sin(2 pi k u) + b_k (1 - cos(2 pi k u))) / (2 pi k)
    C = sum_i alpha_i L_i vis(u_i) + C0 exp(-a_0 / 2)

The bounds are those of the layers that absorb. vis(0) is 1 and the total transmittance is exact;
between them vis is clamped to at most 1. All sums, so the order of the draws does not matter.

Parameters
----------
coefficients : 2 n + 1 = 7, 15 or 31.
lanczos : damp harmonic k by sinc(k / (n + 1)): less ringing, blurrier steps.
memory : `variable` keeps all fragments in lists, and coefficients in local memory. `fixed` takes
    three geometry passes: bounds, coefficients, compositing.
channels : `grey` has one curve, of the mean transmittance over the channels. `rgb` has one for each
    channel, made and used one after another: three rounds instead of three times the storage.
node : the record of a list, as of an A-buffer: `compact` clips radiance above one and has 8 bits a
    value. `fixed` has nothing to do with it.
msaa : 4 renders each of four samples by itself: lists have coverage masks in the low four bits of
    depth, targets four times the texels.

Memory, `variable`: 4 B/pixel + 12 B/fragment (16 with `rgb`, 32 with `precise`). `fixed`: 4 B a
coefficient, 4 B left over, and 8 B of bounds a pixel: 72 B for 15 coefficients.

Sources: Jansen & Bavoil 2010, "Fourier Opacity Mapping"; Salvi et al. 2011, "Adaptive
Transparency", whose FOMT this is (section 4).

Known failures: few strong layers ring, so that layers between them are darkened or show through;
the series repeats, so half of what the nearest layer absorbs appears only at the farthest. An
opaque layer counts as one that lets 1e-5 pass.
"""

from oitbench import Parameter
from oitbench.method.kits.absorbance import AbsorbanceMap


class FourierMap(AbsorbanceMap):
    quick = False
    parameters = {
        "coefficients": Parameter(15, choices=(7, 15, 31), help="terms of the series"),
        "lanczos": Parameter(False, help="damp high harmonics"),
        **AbsorbanceMap.parameters,
    }

    @property
    def terms(self) -> int:
        return int(self.values["coefficients"]) + 1
