"""Wavelet transparency: absorbance over depth in a pixel as coefficients of Haar wavelets.

    a = -ln(1 - o),    A(x) = sum_{x_i < x} a_i,    n = 2^(rank + 1) bins
    x = (n - 1) / n (z - nearest + 1e-5 m) / (farthest - nearest + 1e-5 m + 1e-2 m)
    mean:  sum_i a_i (1 - x_i)
    c_jk = -sum_i a_i min(2^j x_i - k, k + 1 - 2^j x_i),    k = floor(2^j x_i),    j = 0 ... rank
    bin b: mean + sum_j (c_jk in the first half of wavelet jk, -c_jk in its second half)
    -ln vis(x) = value of bins b - 1 and b = floor(n x), mixed by the fraction of n x
    C = (1 - T) sum_i alpha_i L_i vis(x_i) / sum_i o_i vis(x_i) + C0 T,    T = exp(-last bin)

A bin holds exactly the mean of A over it, and the last one the total. A layer touches only one
coefficient of each level. All operations are sums, so the order of the draws does not matter. The
bounds are those of the layers that absorb; the margins are uneven so that a nearest layer lies at
the start of its bin. Published coefficients are larger by 2^(j/2), and wavelets too.

`correction` takes a layer's own deposit out of its bin: a (1 - fraction of n x). `precision` is
that of coefficients in `fixed` memory, which takes three geometry passes: bounds, coefficients,
compositing. `variable`, `rgb` and `msaa` are those of `opacity_map`.

Memory, `fixed`: 16, 32 or 64 B of coefficients for ranks 1, 2 and 3 (half of it with `half`), 8 B
of bounds and 16 B of sums per pixel.

Source: Aizenshtein et al. 2022 [Aizenshtein2022], "Wavelet Transparency", arXiv 2201.00094.

Known failures: layers in one bin hide each other by parts, in no order. A single far layer
stretches all bins. With `half`, differences of large coefficients lose faint layers, and T drifts.
An opaque layer counts as one that transmits 1e-5.
"""

import oitbench as oit
from oitbench.method.kits.absorbance import AbsorbanceMap


class Wavelet(AbsorbanceMap):
    family = "curves"
    quick = False
    rank = oit.Parameter(
        3, choices=(1, 2, 3), grid=(1, 2, 3), sweep=True, help="highest level of wavelets"
    )
    precision = oit.Parameter("float", choices=("half", "float"), help="of coefficients in targets")
    correction = oit.Parameter(True, help="a layer does not hide itself")
    normalized = oit.Parameter(True, help="divide the sum of layers by the sum of their weights")
    memory = oit.Parameter(
        "fixed",
        choices=("variable", "fixed"),
        help="`variable` keeps all fragments in lists, `fixed` keeps the curve in targets",
    )

    @property
    def terms(self) -> int:
        return 2 << self.rank

    @property
    def curve_format(self) -> str:
        return oit.float_format("rgba", self.precision)
