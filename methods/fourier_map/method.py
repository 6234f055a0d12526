"""Fourier-map transparency: absorbance over depth in a pixel as a truncated Fourier series.

    a = -ln(1 - o),    u = (z - nearest) / (farthest - nearest)
    a_k = 2 sum_i a_i cos(2 pi k u_i),    b_k = 2 sum_i a_i sin(2 pi k u_i),    k = 0 ... n
    -ln vis(u) = a_0 u / 2 + sum_k (a_k sin(2 pi k u) + b_k (1 - cos(2 pi k u))) / (2 pi k)
    C = sum_i alpha_i L_i vis(u_i) + C0 exp(-a_0 / 2)

The bounds are those of the layers that absorb. vis(0) is 1 and the total transmittance is exact; in
between vis is clamped to at most 1. All operations are sums, so the order of the draws does not
matter. `lanczos` damps harmonic k by sinc(k / (n + 1)): less ringing, blurrier steps.

`normalized` divides the sum of layers by that of their weights o vis(u) and multiplies it by the
part of the light that all hide, as moments and wavelets do: errors of visibility then do not change
the amount of light.

`variable` stores all fragments in lists and keeps coefficients in local memory. `fixed` takes three
geometry passes: bounds, coefficients, compositing. `rgb` builds and uses one curve per channel, in
three rounds instead of three times the storage. With `msaa` 4 each of four samples is rendered
separately: lists have coverage masks in the low four bits of depth, targets four times the texels.

Memory, `variable`: 4 B/pixel + 12 B/fragment (16 with `rgb`, 32 with `precise`). `fixed`: 4 B per
coefficient, 4 B unused, and 8 B of bounds per pixel: 72 B for 15 coefficients.

Sources: Jansen & Bavoil 2010 [JansenBavoil2010], "Fourier Opacity Mapping"; Salvi et al. 2011
[Salvi2011], "Adaptive Transparency", the FOMT of section 4.

Known failures: a few strong layers ring, so that layers between them are darkened or show through.
The series is periodic, so half of the nearest layer's absorbance appears only at the farthest. An
opaque layer counts as one that transmits 1e-5.
"""

import oitbench as oit
from oitbench.method.kits.absorbance import AbsorbanceMap


class FourierMap(AbsorbanceMap):
    family = "curves"
    quick = False
    coefficients = oit.Parameter(15, choices=(7, 15, 31), help="2 n + 1, terms of the series")
    lanczos = oit.Parameter(False, help="damp high harmonics")

    @property
    def terms(self) -> int:
        return self.coefficients + 1
