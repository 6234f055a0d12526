"""Identities that a method can promise, by name.

`oitbench stability` and the tests hold each method to its promises, within the rounding of its
formats. Random methods keep them in the mean over many pixels.
"""

from __future__ import annotations

from collections.abc import Mapping

from oitbench.errors import DeclarationError, unknown

PROMISES: Mapping[str, str] = {
    "opaque_unchanged": "without transparency the opaque picture stays bit for bit",
    "single_layer_exact": "one layer gives α·L + (1 − α)·C₀",
    "colored_layer_exact": "one layer of colored glass gives α·L + τ·C₀",
    "equal_layers_exact": (
        "N equal layers give L·(1 − (1 − α)^N) + C₀·(1 − α)^N, at N depths and at a single one"
    ),
    "order_independent": "random orders of the draws give one picture",
    "opaque_front_hides": "an opaque nearest layer hides everything behind it, in any order",
    "total_transmittance_exact": "black layers attenuate the background by Π(1 − α)",
    "zero_coverage_ignored": "layers with α = 0 change no bit",
    "white_furnace": "white layers before a white background are invisible",
    "two_layers_ordered": "two layers that swap depths swap their shares, in any order",
    "scales_with_radiance": "radiance times 3 everywhere gives the picture times 3",
    "visibility_monotonic": "visibility stays in [0, 1] and never rises with depth",
    "resolution_independent": "at half the resolution, offsets and blurs are half as many pixels",
}
"""The identity behind each name; every method promises the first."""

ALWAYS = "opaque_unchanged"
"""The promise that every method makes."""


def promise(names: str) -> frozenset[str]:
    """Return the promises of these names.

    Parameters
    ----------
    names : str
        Keys of `PROMISES`, separated by blanks.

    Raises
    ------
    DeclarationError
        A name is unknown.
    """
    found = frozenset(names.split())
    for name in sorted(found - PROMISES.keys()):
        raise DeclarationError(str(unknown("promise", name, PROMISES)))
    return found
