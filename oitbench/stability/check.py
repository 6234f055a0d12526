"""A check: scenes to render with a method, and the images that are expected."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect, names
from oitbench.image.files import Image
from oitbench.method.declaration import Method
from oitbench.method.promises import PROMISES
from oitbench.scene import Scene

METHOD_SECONDS = 600.0
"""Time in which each check of a method, or its overview, must end by default."""
Values = npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class Shot:
    """One image to render of a scene.

    Parameters
    ----------
    scene : Scene
    size : (int, int), optional
        Width and height in pixels. Default: those of the scene's fragment lists.
    permutation : int, optional
        Seed that shuffles the draws. Default: the order of submission.
    transmittance : bool
        Render the total transmittance instead of the color.
    """

    scene: Scene
    size: tuple[int, int] | None = None
    permutation: int | None = None
    transmittance: bool = False

    @property
    def pixels(self) -> tuple[int, int]:
        """Width and height.

        Raises
        ------
        ValueError
            The scene has no fragment lists, and no size is given.
        """
        if self.size is not None:
            return self.size
        if self.scene.lists is None:
            raise ValueError(f"{self.scene.name}: a shot of a scene without lists needs a size")
        _, height, width = self.scene.lists.z.shape
        return width, height


@dataclass(frozen=True, eq=False)
class Rendering:
    """The images of one shot, linear, top row first.

    Parameters
    ----------
    color : array, shape (h, w, 4)
        The method's image with its alpha channel.
    opaque_color : array, shape (h, w, 4)
        The opaque picture that the frame starts with.
    exact : array, shape (h, w, 3), optional
        The exact image, if the check needs it.
    in_order_of_arrival : bool
        Whether the driver is free to take the fragments of a pixel in another order each time.
    """

    color: Image
    opaque_color: Image
    exact: Image | None = None
    in_order_of_arrival: bool = False

    @property
    def image(self) -> Image:
        """The method's image, shape (h, w, 3)."""
        return self.color[..., :3]

    @property
    def opaque(self) -> Image:
        """The opaque picture, shape (h, w, 3)."""
        return self.opaque_color[..., :3]


class Bound(Enum):
    """The largest error that an expectation allows."""

    EQUAL = "none: every bit is equal"
    TARGETS = "the rounding of the method's targets; both images show the same records"
    FORMATS = "the rounding of the method's targets and records"
    DISPLAY = "one step of an 8-bit display whose white is the brightest expected value"


@dataclass(frozen=True, eq=False)
class Expectation:
    """Values that were measured, and the values that are right.

    Parameters
    ----------
    found, expected : array, shape (h, w, c)
        `expected` may be smaller by a whole factor along each of the first two axes; its values are
        then repeated.
    layers : int
        Fragments per pixel.
    bound : Bound
    noise : float
        Standard error of `found`, if it is already a mean of random pixels.
    slack : float
        Error of the measurement itself, which is allowed on top of the bound.
    """

    found: Values
    expected: Values
    layers: int = 1
    bound: Bound = Bound.FORMATS
    noise: float = 0.0
    slack: float = 0.0

    @property
    def magnitude(self) -> float:
        """The largest expected value, and at least one."""
        return max(1.0, float(np.abs(self.expected).max()))


Expect = Callable[[Sequence[Rendering]], Iterable[Expectation]]
"""From the renderings of a check's shots to its expectations."""


def _no_exemption(method: Method) -> str:
    return ""


@dataclass(frozen=True, eq=False)
class Check:
    """An identity that a method may promise, or a hard case with a known answer.

    `identity` makes a check of the first kind.

    Parameters
    ----------
    name : str
        For an identity, its key in `oitbench.method.promises.PROMISES`.
    sentence : str
        The statement that must hold.
    shots : tuple of Shot
    expect : callable
        From the renderings of all shots, in order, to the expectations.
    needs : Effect
        The check does not apply to methods that cannot express all of these effects.
    exemption : callable
        From a method to the reason why the check does not apply to it; "" if it applies.
    identity : bool
    exact : bool
        Whether `expect` needs the exact images.
    repeat : bool
        Whether each shot is rendered twice, to see whether the image changes.
    """

    name: str
    sentence: str
    shots: tuple[Shot, ...]
    expect: Expect
    needs: Effect = Effect.NONE
    exemption: Callable[[Method], str] = _no_exemption
    identity: bool = False
    exact: bool = False
    repeat: bool = True

    def reason_to_skip(self, method: Method) -> str:
        """Return why the check does not apply to `method`; "" if it applies."""
        missing = self.needs & ~method.shows
        if missing:
            return f"the method does not show {', '.join(names(missing)).lower()}"
        return self.exemption(method)


def identity(name: str, shots: Iterable[Shot], expect: Expect, **options: Any) -> Check:
    """Return the check of the promise `name`; its sentence is that of the promise.

    Parameters
    ----------
    name : str
        Key of `oitbench.method.promises.PROMISES`.
    shots : iterable of Shot
    expect : callable
    **options
        Further parameters of `Check`.
    """
    return Check(name, PROMISES[name], tuple(shots), expect, identity=True, **options)
