"""Five families of random stacks, from few strong layers to many thin ones: errors by the models.

The errors of the methods in OpenGL are those of the float64 models, so that the report's crossings
of lists and curves belong to the methods and not to rounding.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.measure.oracle import composite
from oitbench.scene import Floats, FragmentLists, Scene
from tests.helpers import collection, render
from tests.models import absorbance, adaptive, bounded, commutative, moments

_SIZE, _DEPTHS = "width=8,height=8", "nearest=1,farthest=30"
FAMILIES = {
    "uniform6": f"layers=6,alpha_low=0.05,alpha_high=0.6,{_DEPTHS}",
    "uniform20": f"layers=20,alpha_low=0.05,alpha_high=0.6,{_DEPTHS}",
    "glass8": f"layers=8,alpha_low=0.1,alpha_high=0.9,family=glass,{_DEPTHS}",
    "smoke60": f"layers=60,alpha_low=0.01,alpha_high=0.12,{_DEPTHS}",
    "hair40": "layers=40,alpha_low=0.2,alpha_high=0.5,family=tuft,nearest=4.5,farthest=30",
}
Model = Callable[[FragmentLists, Floats], Floats]


def scene(family: str) -> Scene:
    return collection().build_scene(f"fragment_lists[{_SIZE},{FAMILIES[family]}]")


def layers_of(lists: FragmentLists) -> tuple[Floats, Floats, Floats]:
    """Return distances, premultiplied colors and opacities in double precision."""
    color, opacity = commutative.layers_of(lists)
    return lists.z.astype(np.float64), color, opacity


def by_curve(curve: absorbance.Curve, margins: tuple[float, float] = (0.0, 0.0)) -> Model:
    def drawn(lists: FragmentLists, background: Floats) -> Floats:
        z, color, opacity = layers_of(lists)
        passed = 1 - opacity[..., None]
        return absorbance.composite(z, color, passed, background, curve, True, margins)

    return drawn


def by_moments(lists: FragmentLists, background: Floats) -> Floats:
    z, color, opacity = layers_of(lists)
    nearest, farthest = z.min(axis=0), z.max(axis=0)
    places = 2 * (z - nearest) / (farthest - nearest) - 1
    return moments.composite(places, color, opacity, background, "power", 8)


def by_nodes(lists: FragmentLists, background: Floats) -> Floats:
    z, color, opacity = layers_of(lists)
    return adaptive.composite(z, color, 1 - opacity[..., None], background, 8)[0]


MODELS: dict[str, Model] = {
    "k_buffer[k=8]": lambda lists, c0: bounded.k_buffer(lists, c0, 8, "8-bit"),
    "multilayer_alpha[k=4]": lambda lists, c0: bounded.multilayer_alpha(lists, c0, 4, "8-bit"),
    "multilayer_alpha[k=8,node=16f]": lambda lists, c0: bounded.multilayer_alpha(
        lists, c0, 8, "16f"
    ),
    "adaptive[nodes=8,memory=fixed]": by_nodes,
    "moments[count=8,depth=linear]": by_moments,
    "opacity_map[memory=fixed,normalized=true]": by_curve(absorbance.opacity_map(16)),
    "fourier_map[memory=fixed,normalized=true]": by_curve(absorbance.fourier_map(15, False)),
    "wavelet[rank=3]": by_curve(absorbance.wavelet(3), (1e-5, 1e-2)),
    "weighted_average[precision=float]": commutative.weighted_average,
}


def rmse(picture: Floats, truth: Floats) -> float:
    return float(np.sqrt(np.square(picture - truth).mean()))


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("name", MODELS)
def test_errors_of_families_are_those_of_the_models(device: Device, name: str, family: str) -> None:
    drawn = scene(family)
    assert drawn.lists is not None
    background = np.array(drawn.background)
    truth = composite(drawn.lists, drawn.background)
    modeled = MODELS[name](drawn.lists, background)
    found = render(device, drawn, name, size=(8, 8)).astype(np.float64)
    # Lists show their nodes in a picture of half floats, whose rounding the models leave out.
    rounding = 2.0**-12 if name.startswith(("k_buffer", "multilayer")) else 2e-5
    assert rmse(found, truth) == pytest.approx(rmse(modeled, truth), rel=0.02, abs=rounding)


def error(name: str, family: str) -> float:
    """Return the error of a model."""
    drawn = scene(family)
    assert drawn.lists is not None
    truth = composite(drawn.lists, drawn.background)
    return rmse(MODELS[name](drawn.lists, np.array(drawn.background)), truth)


def test_lists_win_in_glass_and_curves_in_smoke() -> None:
    lists, curves = "multilayer_alpha[k=8,node=16f]", "wavelet[rank=3]"
    assert error(lists, "glass8") < 0.1 * error(curves, "glass8")
    assert error(curves, "smoke60") < 0.5 * error(lists, "smoke60")


def centered(bins: int) -> absorbance.Curve:
    """Return the curve of the same means, each of which is read at the middle of its bin."""

    def absorbed(u: Floats, a: Floats, places: Floats) -> Floats:
        means = absorbance.bin_means(u * (bins - 1) / bins, a, bins)
        known = np.concatenate([np.zeros((1, *a.shape[1:])), means])
        place = places * (bins - 1) + 0.5
        index = np.minimum(np.floor(place).astype(int), bins - 1)
        front = np.take_along_axis(known, index, axis=0)
        behind = np.take_along_axis(known, index + 1, axis=0)
        return np.asarray(front + (behind - front) * (place - index))

    return absorbed


def test_wavelets_read_half_a_bin_late_which_helps_in_glass_and_harms_in_smoke() -> None:
    errors = {}
    for family in ("glass8", "smoke60"):
        drawn = scene(family)
        assert drawn.lists is not None
        truth = composite(drawn.lists, drawn.background)
        picture = by_curve(centered(16))(drawn.lists, np.array(drawn.background))
        errors[family] = rmse(picture, truth)
    wavelet, fourier = "wavelet[rank=3]", "fourier_map[memory=fixed,normalized=true]"
    # In smoke, the same coefficients read at the middle of bins are nearly as good as waves.
    assert errors["smoke60"] < 0.8 * error(wavelet, "smoke60")
    assert errors["smoke60"] == pytest.approx(error(fourier, "smoke60"), rel=0.15)
    # In glass, a layer then hides itself.
    assert errors["glass8"] > 1.5 * error(wavelet, "glass8")
