"""Hard cases: scenes that make transparency methods fail, each with its right answer.

No method promises them. A method that fails one says so with its error; what none may do is return
NaN, infinity or a negative pixel, or change its answer between two runs.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from math import prod

import numpy as np

from oitbench.measure.oracle import composite, transmittances
from oitbench.method.declaration import Method, Request
from oitbench.method.passes import Gather, Loop
from oitbench.modeling.mesh import box
from oitbench.scene import BLACK, RGB, WHITE, Camera, FragmentLists, Material, Object, Scene
from oitbench.stability.check import Bound, Check, Comparison, Photo, Picture
from oitbench.stability.grace import graceful
from oitbench.stability.layers import (
    BACKGROUND,
    BLUE,
    GREEN,
    RED,
    Layer,
    columns,
    random_lists,
    scene_of,
    stack,
)

_SWEEP = 2001
_HALF = 0.5


@cache
def cases() -> tuple[Check, ...]:
    """Return the hard cases."""
    return (
        *_weights(),
        *_deep_stacks(),
        *_extremes(),
        *_bounded_memory(),
        *_moments(),
        *_ties_and_seams(),
        *_random_methods(),
        *graceful(),
    )


def _case(
    id_: str,
    sentence: str,
    *lists: FragmentLists,
    background: RGB = BLACK,
    near: float = 0.1,
    repeat: bool = True,
) -> Check:
    """Return the case that a method agrees with the over operator on all `lists`.

    Methods that sort do so by a layer's mean depth: lists whose layers lie in different orders must
    not be columns of one picture.
    """
    expected = [composite(item, background) for item in lists]

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        for photo, right in zip(photos, expected, strict=True):
            yield Comparison(photo.image, right, len(lists[0].z), Bound.DISPLAY)

    pictures = tuple(Picture(scene_of(item, background, near)) for item in lists)
    return Check(id_, sentence, pictures, compare, repeat=repeat)


def _weights() -> Iterable[Check]:
    """Yield what goes wrong with weights that follow from depth alone."""
    pairs = [
        [Layer(z + 1, _HALF, back), Layer(z, _HALF, front)]
        for z in (1.0, 5.0, 50.0)
        for front, back in ((RED, BLUE), (BLUE, RED))
    ]
    yield _case(
        "two halves",
        "of two half covering layers at 1, 5 or 50 m the front one has 2/3 of the color",
        columns(pairs),
    )
    yield _case(
        "near opaque",
        "a front layer of α = 0.9, 0.99, 0.999 or 1 at 5 m hides a white wall at 6 m",
        columns([[Layer(6, 1), Layer(5, a, RED)] for a in (0.9, 0.99, 0.999, 1.0)]),
    )
    near = [Layer(0.11 + 0.01 * i, 0.1, BLACK) for i in range(8)]
    yield _case(
        "near black",
        "black layers just behind the near plane attenuate by Π(1 − α), whatever their weight",
        columns([near]),
        background=WHITE,
    )
    yield _near_planes()
    decades = [10.0**k for k in range(-3, 7)]
    colors = (RED, GREEN, BLUE)
    layers = [Layer(z, 0.3, colors[i % 3]) for i, z in enumerate(decades)][::-1]
    yield _case(
        "1 mm to 1000 km",
        "ten layers from 0.001 to 1,000,000 m keep their order",
        columns([layers]),
        background=BACKGROUND,
        near=5e-4,
    )
    sweep = [[Layer(z, _HALF)] for z in np.geomspace(0.2, 200.0, _SWEEP)]
    yield _case(
        "swept layer", "one layer shows its own color at each of 2001 depths", columns(sweep)
    )


def _near_planes() -> Check:
    layers = [Layer(z, _HALF, color) for z, color in ((8, BLUE), (4, GREEN), (2, RED))]
    lists = columns([layers])

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        for photo in photos[1:]:
            yield Comparison(photo.image, photos[0].image, len(layers), Bound.DISPLAY)

    planes = (0.001, 0.01, 0.1, 1.0)
    return Check(
        "near plane",
        "a near plane at 0.001, 0.01, 0.1 or 1 m gives one picture",
        tuple(Picture(scene_of(lists, BACKGROUND, near)) for near in planes),
        compare,
    )


def _deep_stacks() -> Iterable[Check]:
    """Yield sums that stall, saturate or underflow."""
    thin = [Layer(z, 1 / 512, RED) for z in np.linspace(2, 6, 1000)]
    yield _case(
        "1000 thin layers",
        "1000 layers of α = 1/512 let 0.1416 through",
        columns([thin]),
        background=GREEN,
        repeat=False,
    )
    faint = [Layer(z, 0.003, RED) for z in np.linspace(2, 6, 200)]
    yield _case(
        "200 faint layers",
        "200 layers of α = 0.003 let 0.548 through",
        columns([faint]),
        background=GREEN,
    )
    walls = [Layer(z, 1) for z in np.linspace(0.2, 1, 3000)]
    white = _case(
        "3000 white walls", "3000 opaque white layers are white", columns([walls]), repeat=False
    )
    yield replace(white, excuse=_peels)
    veils = [Layer(z, _HALF, BLACK) for z in np.linspace(2, 6, 60)]
    yield _case(
        "underflow",
        "60 black layers of α = 1/2 over radiance 10⁴ are black",
        columns([veils]),
        background=(1e4, 1e4, 1e4),
    )


def _peels(method: Method) -> str:
    steps = method.plan(Request()).passes
    loops = [item for item in steps if isinstance(item, Loop) and item.until_empty]
    peeling = any(isinstance(item, Gather) for loop in loops for item in loop.passes)
    return "3000 geometry passes of 3000 layers take too long" if peeling else ""


def _extremes() -> Iterable[Check]:
    """Yield values at the ends of their ranges."""
    for radiance in (100.0, 1e4):
        light: RGB = (radiance, radiance / 2, radiance / 4)
        layers = [Layer(z, _HALF, light) for z in np.linspace(1, 4, 8)]
        yield _case(
            f"radiance {radiance:g}",
            f"eight layers of α = 1/2 and radiance {radiance:g} composite as dim ones do",
            columns([layers]),
            background=light,
        )
    bright: RGB = (1e4, 1e4, 1e4)
    clear = [Layer(z, 0.0, bright) for z in np.linspace(0.5, 5, 40)]
    yield _case(
        "α = 0",
        "forty layers of α = 0 and radiance 10⁴ change nothing",
        columns([clear]),
        background=BACKGROUND,
    )
    glass = [[Layer(2, 1, (0.5, 0.5, 0.5), (t, t, t))] for t in (0.9, 0.99, 0.999, 0.9999, 1.0)]
    yield _case(
        "clear glass",
        "a highlight on glass of transmission 0.9 to 1 shows, whatever passes behind it",
        columns(glass),
        background=(0.25, 0.25, 0.25),
    )
    stacks = [
        [Layer(4, _HALF, BLUE), Layer(3, a, GREEN), Layer(2, 0.3, RED)]
        for a in (0, 1 / 510, 1 / 255, 254 / 255, 1 - 2**-20, 1)
    ]
    yield _case(
        "middle layer from 0 to 1",
        "a middle layer of α from exactly 0 to exactly 1 hides what it covers",
        columns(stacks),
        background=BACKGROUND,
    )
    yield _case(
        "faint and bright",
        "one layer of α = 0.0005 and radiance 1000 shows 0.5",
        columns([[Layer(3, 5e-4, (1000.0, 1000.0, 1000.0))]]),
    )


def _bounded_memory() -> Iterable[Check]:
    """Yield what nodes of fixed number merge, drop or divide by zero."""
    behind = [Layer(z, 0.4, BLUE) for z in np.random.default_rng(1).permutation(range(2, 41))]
    lists = [[*behind[:k], Layer(1, 1, RED), *behind[k:]] for k in (0, 20, 39)]
    yield _case(
        "opaque front of 40",
        "an opaque layer before 39 others, drawn first, in their midst or last, hides them",
        *(columns([item]) for item in lists),
        background=BACKGROUND,
    )
    layers = [Layer(1, 0.1, RED), Layer(3, 0.1, RED), Layer(5, 0.9, BLUE), Layer(4, 0.9, GREEN)]
    yield _case(
        "late arrival",
        "a layer drawn last that lies before one drawn earlier hides it",
        columns([layers]),
        columns([layers[:2] + layers[:1:-1]]),
    )
    many = random_lists(64)
    yield _total_transmittance(many)
    yield _both_orders(many)


def _total_transmittance(lists: FragmentLists) -> Check:
    expected = transmittances(lists).prod(axis=0)

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        yield Comparison(photos[0].image, expected, len(lists.z), Bound.DISPLAY)

    sentence = "64 layers in random order let Π(1 − α) through in all"
    picture = Picture(scene_of(lists), transmittance=True)
    return Check("transmittance of 64", sentence, (picture,), compare)


def _both_orders(lists: FragmentLists) -> Check:
    parts = (lists.z, lists.coverage, lists.radiance, lists.transmission)
    reversed_lists = FragmentLists(*(part[::-1].copy() for part in parts))
    expected = composite(lists, BACKGROUND)

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        for photo in photos:
            yield Comparison(photo.image, expected, len(lists.z), Bound.DISPLAY)

    sentence = "none of 64 layers is lost, be they drawn in one order or the other"
    pictures = tuple(Picture(scene_of(item)) for item in (lists, reversed_lists))
    return Check("64 layers", sentence, pictures, compare)


def _moments() -> Iterable[Check]:
    """Yield what curves of few coefficients cannot follow."""
    behind = [Layer(4 + 0.2 * i, 0.6, RED) for i in range(10)]
    yield _case(
        "strong before many",
        "a layer of α = 0.95 before ten of α = 0.6 has 0.95 of the color",
        columns([[*behind[::-1], Layer(2, 0.95, GREEN)]]),
    )
    groups = [Layer(z, 0.5, RED if z < 4 else BLUE) for z in (2, 2.01, 2.02, 6, 6.01, 6.02)]
    yield _case(
        "two clusters",
        "three layers at 2 m hide three at 6 m",
        columns([groups[::-1]]),
        background=BACKGROUND,
    )


def _ties_and_seams() -> Iterable[Check]:
    """Yield equal depths, and meshes that intersect."""
    black = [Layer(3, _HALF, BLACK)] * 2
    yield _case(
        "coincident black",
        "two coincident layers of α = 1/2 let 1/4 through",
        columns([black]),
        background=WHITE,
    )
    coincident = scene_of(columns([[Layer(3, _HALF, RED), Layer(3, _HALF, BLUE)]]), GREEN)
    swapped = scene_of(columns([[Layer(3, _HALF, BLUE), Layer(3, _HALF, RED)]]), GREEN)

    def agree(photos: Sequence[Photo]) -> Iterable[Comparison]:
        yield Comparison(photos[1].image, photos[0].image, 2, Bound.DISPLAY)

    yield Check(
        "coincident colors",
        "two coincident layers look the same in either order of their draws",
        (Picture(coincident), Picture(swapped)),
        agree,
    )

    def seamless(photos: Sequence[Photo]) -> Iterable[Comparison]:
        exact = photos[0].exact
        assert exact is not None
        yield Comparison(photos[0].image, exact, 8, Bound.DISPLAY)

    yield Check(
        "crossing boxes",
        "two boxes that cross each other have no gap where they meet",
        (Picture(_crossing_boxes(), (64, 64)),),
        seamless,
        excuse=_antialiased,
        exact=True,
    )


def _crossing_boxes() -> Scene:
    one, other = (
        Object(name, box((0, 0, 0), size), Material(coverage=_HALF, emission=color))
        for name, size, color in (("one", (2, 1.2, 1.2), RED), ("other", (1.2, 2, 1.4), BLUE))
    )
    camera = Camera((1.1, 0.9, 2.2), (0.3, 0.3, 0.4))
    return Scene("crossing boxes", camera, (one, other), background=BACKGROUND)


def _antialiased(method: Method) -> str:
    return "edges are antialiased; the exact picture's are not" if method.sample_count > 1 else ""


def _random_methods() -> Iterable[Check]:
    """Yield what random masks must not do: agree with each other, or scatter beyond reason."""
    pair = stack([Layer(2, _HALF, BLACK), Layer(3, _HALF, BLACK)], 16, 16)
    yield _case(
        "two masks",
        "two layers of α = 1/2 let 1/4 through: their masks are independent",
        pair,
        background=WHITE,
    )
    veils = [Layer(2 + i, a, BLACK) for i, a in enumerate((0.3, 0.5, 0.4))]
    passed = prod(1 - layer.coverage for layer in veils)

    def scatter(photos: Sequence[Photo]) -> Iterable[Comparison]:
        image = photos[0].image.astype(np.float64)
        excess = np.maximum(image.var(axis=(0, 1)) - passed * (1 - passed), 0)
        count = image.shape[0] * image.shape[1]
        yield Comparison(excess[None, None], np.zeros((1, 1, 3)), noise=count**-0.5 / 4)

    lists = stack(veils, 128, 128)
    yield Check(
        "scatter",
        "pixels scatter no more than single independent samples would: T(1 − T)",
        (Picture(scene_of(lists, WHITE)),),
        scatter,
        excuse=lambda method: "" if method.noisy else "the method is not random",
    )
