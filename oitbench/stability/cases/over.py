"""The most common hard case: fragment lists and their image by the over operator."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from oitbench.measure.oracle import composite
from oitbench.scene import BLACK, RGB, FragmentLists
from oitbench.stability.check import Bound, Check, Expectation, Rendering, Shot
from oitbench.stability.layers import scene_of


def over(
    name: str,
    sentence: str,
    *lists: FragmentLists,
    background: RGB = BLACK,
    near: float = 0.1,
    repeat: bool = True,
) -> Check:
    """Return the case that a method composites all `lists` by the over operator.

    Methods that sort objects use the mean depth of each layer. Therefore all columns of one of the
    `lists` must have their layers in the same order of depth.

    Parameters
    ----------
    name, sentence : str
    *lists : FragmentLists
        One image each.
    background : RGB
    near : float
        Distance of the near plane in meters.
    repeat : bool
        See `Check`.
    """
    exact = [composite(item, background) for item in lists]

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        for rendering, right in zip(renderings, exact, strict=True):
            yield Expectation(rendering.image, right, bound=Bound.DISPLAY)

    shots = tuple(Shot(scene_of(item, background, near)) for item in lists)
    return Check(name, sentence, shots, expect, repeat=repeat)
