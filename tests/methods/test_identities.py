"""The identities that methods promise in `holds`, each at the rounding error of its formats."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.gl.device import Device
from oitbench.measure.oracle import composite, transmittances
from oitbench.method.declaration import Method
from oitbench.modeling.mesh import quad
from oitbench.scene import RGB, Camera, FragmentLists, Material, Object, Scene
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    collection,
    method,
    opened,
    random_lists,
    render,
    rounding,
    scene_of,
    stack,
    tolerance,
)

SORTED = frozenset({"U1", "U2", "U2c", "U3", "U5", "U6", "U7", "U8", "U9", "U10"})
UNSORTED = SORTED - {"U5", "U9"}
LISTS = frozenset({"U1", "U2", "U3", "U4", "U5", "U6", "U7", "U8", "U9", "U11"})
SUMS = frozenset({"U1", "U2", "U3", "U4", "U6", "U7", "U8", "U10"})
PROMISED = {
    "a_buffer": LISTS | {"U2c", "U10"},
    "a_buffer[resolve=iterative]": LISTS | {"U2c", "U10"},
    "a_buffer[node=compact]": LISTS,
    "a_buffer[node=compact,resolve=iterative]": LISTS,
    "alpha_blend": UNSORTED - {"U2c"},
    # With 8 bits, hues of transmittance depend on how it was rounded, and so on the order.
    "phenomenological": (SUMS - {"U4"}) | {"U12"},
    "phenomenological[modulation=none]": SUMS | {"U12"},
    "phenomenological[precision=half]": SUMS | {"U12"},
    "phenomenological[precision=float]": SUMS | {"U12"},
    "sorted_over": SORTED,
    "sorted_over[sort=object]": SORTED,
    "sorted_two_pass": SORTED,
    "sorted_two_pass[sort=triangle]": SORTED,
    "sorted_two_pass[sort=none]": UNSORTED,
    "weighted_blended[weight=7]": SUMS,
    "weighted_blended[weight=8]": SUMS,
    "weighted_blended[weight=9]": SUMS,
    "weighted_blended": SUMS,
}
"""What follows from each method's formulas."""

Check = Callable[[Device, Method], None]


def close(found: npt.NDArray[Any], expected: npt.NDArray[Any], allowed: float) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=allowed)


def agrees_with_oracle(device: Device, chosen: Method, lists: FragmentLists) -> None:
    expected = composite(lists, BACKGROUND)
    allowed = tolerance(chosen, len(lists.z), float(expected.max()))
    close(render(device, lists, chosen), expected, allowed)


def nothing_transparent_shows_the_opaque_picture(device: Device, chosen: Method) -> None:
    wall = Object("wall", quad((0, 0, -2), (0.5, 0, 0), (0, 0.5, 0)), Material(emission=BACKGROUND))
    scene = Scene("wall", Camera((0, 0, 0), (0, 0, -1)), (wall,), background=GREEN)
    with opened(device, scene, chosen, (16, 16)) as frame:
        frame.render()
        assert frame.image().std() > 0
        np.testing.assert_array_equal(frame.read("color"), frame.read("opaque_color"))


def one_layer_is_right(device: Device, chosen: Method) -> None:
    agrees_with_oracle(device, chosen, random_lists(1))


def one_colored_layer_is_right(device: Device, chosen: Method) -> None:
    agrees_with_oracle(device, chosen, random_lists(1, tinted=True))


def identical_layers_follow_the_geometric_sum(device: Device, chosen: Method) -> None:
    count, layer = 8, Layer(3.0, 0.3, (0.9, 0.5, 0.1))
    passed = (1 - layer.coverage) ** count
    expected = np.multiply(layer.radiance, 1 - passed) + np.multiply(BACKGROUND, passed)
    found = render(device, stack([layer] * count), chosen)
    close(found, np.broadcast_to(expected, found.shape), tolerance(chosen, count, 1.0))


def the_order_of_draws_does_not_matter(device: Device, chosen: Method) -> None:
    lists = random_lists(10, tinted=True)
    pictures = [render(device, lists, chosen, permutation=seed) for seed in (None, 1, 2, 3)]
    allowed = 0.0 if chosen.values.get("resolve") == "sorted" else rounding(chosen, 10, 1.0)
    for picture in pictures[1:]:
        close(picture, pictures[0], allowed)


def an_opaque_front_layer_hides_all_behind_it(device: Device, chosen: Method) -> None:
    front = Layer(1.0, 1.0, (0.75, 0.5, 0.25))
    behind = [Layer(3.0, 0.5, WHITE), Layer(2.0, 0.9, GREEN), Layer(4.0, 1.0, BLUE)]
    alone = render(device, stack([front]), chosen)
    for place in range(4):
        layers = [*behind[:place], front, *behind[place:]]
        np.testing.assert_array_equal(render(device, stack(layers), chosen), alone)


def black_layers_attenuate_by_their_product(device: Device, chosen: Method) -> None:
    lists = random_lists(6)
    lists = replace(lists, radiance=np.zeros_like(lists.radiance))
    expected = np.asarray(BACKGROUND) * transmittances(lists).prod(axis=0)
    close(render(device, lists, chosen), expected, tolerance(chosen, 6, 1.0))


def layers_without_coverage_change_nothing(device: Device, chosen: Method) -> None:
    some = [Layer(2.0, 0.4, RED), Layer(4.0, 0.6, GREEN)]
    clear = [Layer(z, 0.0, WHITE) for z in np.linspace(1.5, 5.0, 40)]
    picture = render(device, stack([clear[0], some[0], *clear[1:20], some[1], *clear[20:]]), chosen)
    np.testing.assert_array_equal(picture, render(device, stack(some), chosen))
    unchanged = render(device, stack(clear), chosen)
    background = np.full_like(unchanged, np.asarray(BACKGROUND, dtype=np.float32))
    close(unchanged, background, 2.0**-11)


def a_white_furnace_stays_white(device: Device, chosen: Method) -> None:
    lists = random_lists(6)
    lists = replace(lists, radiance=np.ones_like(lists.radiance))
    found = render(device, scene_of(lists, WHITE), chosen)
    close(found, np.ones_like(found), tolerance(chosen, 6, 1.0))


def swapping_depths_swaps_the_layers(device: Device, chosen: Method) -> None:
    near, far = Layer(2.0, 0.5, RED), Layer(4.0, 0.5, BLUE)
    swapped = [replace(near, z=far.z), replace(far, z=near.z)]
    before, after = (render(device, stack(layers), chosen) for layers in ([near, far], swapped))
    assert abs(before - after).max() > 0.2
    agrees_with_oracle(device, chosen, stack([near, far]))
    agrees_with_oracle(device, chosen, stack(swapped))


def radiance_scales_the_picture(device: Device, chosen: Method) -> None:
    lists, factor = random_lists(4), 3.0
    brighter = replace(lists, radiance=lists.radiance * np.float32(factor))
    background: RGB = (BACKGROUND[0] * factor, BACKGROUND[1] * factor, BACKGROUND[2] * factor)
    close(
        render(device, scene_of(brighter, background), chosen),
        factor * render(device, lists, chosen),
        2 * tolerance(chosen, 4, factor),
    )


def visibility_never_rises_with_depth(device: Device, chosen: Method) -> None:
    # A clear probe that shines, at another depth in each row: what it shows is its visibility.
    side, dark = 16, [Layer(z, 0.35, NOTHING) for z in (2.0, 3.0, 3.0, 4.5, 5.5)]
    lists = stack([Layer(1.0, 1.0, WHITE, WHITE), *dark], side)
    lists.z[0] = np.linspace(1.0, 6.0, side, dtype=np.float32)[:, None]
    found = render(device, scene_of(lists, NOTHING), chosen)
    assert ((found >= 0) & (found <= 1)).all()
    assert (np.diff(found, axis=0) <= 0).all()
    assert len(np.unique(found)) == 5


def halving_the_resolution_halves_bends_and_blurs(device: Device, chosen: Method) -> None:
    """A pane moves an edge, or spreads it: over how many pixels, is the sum along a row."""
    camera = Camera((0, 0, 0), (0, 0, -1), fov_y=np.radians(40))
    wall = Object("wall", quad((4, 0, -4), (4, 0, 0), (0, 4, 0)), Material(emission=WHITE))
    black = Object("black", quad((-4, 0, -4), (4, 0, 0), (0, 4, 0)), Material())
    clear = Material(transmission=WHITE, specular=0.0)
    panes = (replace(clear, index=1.5, solid=True), replace(clear, collimation=0.1))
    for pane in panes:
        sheet = Object("sheet", quad((0, 0, -1.6), (4, 0, 1.2), (0, 4, 0)), pane)
        scene = Scene("edge", camera, (black, wall, sheet))
        small, large = (edge_reach(device, scene, chosen, k) for k in (1, 2))
        assert small > 2
        # Rounding moves light by up to one pixel of the smaller picture.
        assert abs(large - 2 * small) < 2


def edge_reach(device: Device, scene: Scene, chosen: Method, scale: int) -> float:
    """Return by how many pixels the method moves or spreads light, in a row on average."""
    with opened(device, scene, chosen, (64 * scale, 48 * scale)) as frame:
        frame.render()
        moved = abs(frame.image() - frame.read("opaque_color")[..., :3])
    return float(moved.sum(axis=1).mean())


IDENTITIES: dict[str, Check] = {
    "U1": nothing_transparent_shows_the_opaque_picture,
    "U2": one_layer_is_right,
    "U2c": one_colored_layer_is_right,
    "U3": identical_layers_follow_the_geometric_sum,
    "U4": the_order_of_draws_does_not_matter,
    "U5": an_opaque_front_layer_hides_all_behind_it,
    "U6": black_layers_attenuate_by_their_product,
    "U7": layers_without_coverage_change_nothing,
    "U8": a_white_furnace_stays_white,
    "U9": swapping_depths_swaps_the_layers,
    "U10": radiance_scales_the_picture,
    "U11": visibility_never_rises_with_depth,
    "U12": halving_the_resolution_halves_bends_and_blurs,
}


def promises() -> Iterator[tuple[str, str]]:
    """Yield every promise of the variants above, and of all other methods by their defaults."""
    others = set(collection().methods) - {name.partition("[")[0] for name in PROMISED}
    for name in [*PROMISED, *sorted(others)]:
        yield from ((name, identity) for identity in IDENTITIES if identity in method(name).holds)


@pytest.mark.parametrize(("name", "identity"), list(promises()))
def test_identity(device: Device, name: str, identity: str) -> None:
    IDENTITIES[identity](device, method(name))


@pytest.mark.parametrize("name", PROMISED)
def test_methods_promise_what_their_formulas_give(name: str) -> None:
    assert method(name).holds == PROMISED[name]
