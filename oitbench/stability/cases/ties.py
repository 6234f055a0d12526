"""Hard cases of equal depths, and of meshes that intersect."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from oitbench.method.declaration import Method
from oitbench.modeling.mesh import box
from oitbench.scene import BLACK, WHITE, Camera, Material, Object, Scene
from oitbench.stability.cases.over import over
from oitbench.stability.check import Bound, Check, Expectation, Rendering, Shot
from oitbench.stability.layers import BACKGROUND, BLUE, GREEN, RED, Layer, columns, scene_of


def cases() -> Iterable[Check]:
    """Yield the cases."""
    yield over(
        "coincident black",
        "two coincident layers with α = 1/2 have a total transmittance of 1/4",
        columns([[Layer(3, 0.5, BLACK)] * 2]),
        background=WHITE,
    )
    yield _coincident_colors()
    yield _crossing_boxes()


def _coincident_colors() -> Check:
    orders = ((RED, BLUE), (BLUE, RED))
    pairs = (columns([[Layer(3, 0.5, color) for color in colors]]) for colors in orders)

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        first, other = renderings
        yield Expectation(other.image, first.image, bound=Bound.DISPLAY)

    return Check(
        "coincident colors",
        "two coincident layers give the same image in both orders of their draws",
        tuple(Shot(scene_of(pair, GREEN)) for pair in pairs),
        expect,
    )


def _crossing_boxes() -> Check:
    boxes = (
        Object(name, box((0, 0, 0), size), Material(coverage=0.5, emission=color))
        for name, size, color in (("one", (2, 1.2, 1.2), RED), ("other", (1.2, 2, 1.4), BLUE))
    )
    camera = Camera((1.1, 0.9, 2.2), (0.3, 0.3, 0.4))
    scene = Scene("crossing boxes", camera, tuple(boxes), background=BACKGROUND)

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        exact = renderings[0].exact
        assert exact is not None
        yield Expectation(renderings[0].image, exact, bound=Bound.DISPLAY)

    return Check(
        "crossing boxes",
        "two boxes that intersect are composited exactly along their intersection",
        (Shot(scene, (64, 64)),),
        expect,
        exemption=_antialiased,
        exact=True,
    )


def _antialiased(method: Method) -> str:
    """Return a reason if the method antialiases edges, which the exact image does not."""
    return (
        "edges are antialiased; those of the exact image are not" if method.sample_count > 1 else ""
    )
