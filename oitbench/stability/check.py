"""What an experiment is: pictures to take, and what to hold against what."""

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
from oitbench.scene import Scene

Values = npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class Picture:
    """One picture to take of a scene.

    Parameters
    ----------
    scene : Scene
    size : (int, int), optional
        Width and height in pixels; those of the scene's lists without.
    permutation : int, optional
        Seed that shuffles the draws.
    transmittance : bool
        Show transmittance alone.
    """

    scene: Scene
    size: tuple[int, int] | None = None
    permutation: int | None = None
    transmittance: bool = False

    @property
    def pixels(self) -> tuple[int, int]:
        """Width and height."""
        if self.size is not None:
            return self.size
        if self.scene.lists is None:
            raise ValueError("a picture of a scene without lists needs a size")
        _, height, width = self.scene.lists.z.shape
        return width, height

    def shares_frame(self, other: Picture) -> bool:
        """Whether one frame can take both."""
        return self.scene is other.scene and self.pixels == other.pixels


@dataclass(frozen=True, eq=False)
class Photo:
    """What came of a picture: [h, w, 3], linear, top row first.

    Parameters
    ----------
    image : array
        The method's.
    opaque : array
        What lies behind all transparency.
    exact : array or None
        The exact truth's image, where it was asked for.
    copies : int
        Side of the square of pixels that repeats each pixel of the picture, for random methods.
    """

    image: Image
    opaque: Image
    exact: Image | None = None
    copies: int = 1


class Bound(Enum):
    """How large an error may be."""

    EQUAL = "not at all"
    FORMATS = "the rounding of the method's formats"
    DISPLAY = "one step of an 8-bit display of the brightest right value"


@dataclass(frozen=True, eq=False)
class Comparison:
    """Something found, and what it should be.

    Parameters
    ----------
    found, expected : array, shape (h, w, 3)
        `expected` may be smaller by a whole factor; it is then repeated.
    layers : int
        Fragments a pixel.
    bound : Bound
    noise : float
        Standard error of `found`, where it is already a mean of random pixels.
    slack : float
        Error that the experiment itself brings, on top of the bound.
    """

    found: Values
    expected: Values
    layers: int = 1
    bound: Bound = Bound.FORMATS
    noise: float = 0.0
    slack: float = 0.0

    @property
    def magnitude(self) -> float:
        """The largest right value, and one at least."""
        return max(1.0, float(np.abs(self.expected).max()))


Compare = Callable[[Sequence[Photo]], Iterable[Comparison]]


def _always(method: Method) -> str:
    return ""


@dataclass(frozen=True, eq=False)
class Check:
    """An identity that a method may promise, or a hard case with its right answer.

    Parameters
    ----------
    id : str
        "U1" … "U12" for identities; cases have a name.
    sentence : str
        What must hold.
    pictures : tuple of Picture
    compare : callable
        From the photos to what must agree.
    needs : Effect
        Does not apply to methods that cannot express these.
    excuse : callable
        From a method to the reason why the check does not apply to it, or "".
    identity : bool
    exact : bool
        Whether `compare` needs the exact truth's images.
    repeat : bool
        Whether each picture is taken twice, to see that nothing changes from run to run.
    """

    id: str
    sentence: str
    pictures: tuple[Picture, ...]
    compare: Compare
    needs: Effect = Effect.NONE
    excuse: Callable[[Method], str] = _always
    identity: bool = False
    exact: bool = False
    repeat: bool = True

    def reason_against(self, method: Method) -> str:
        """Return why the check does not apply to `method`, or ""."""
        missing = self.needs & ~method.shows
        if missing:
            return f"the method does not show {', '.join(names(missing)).lower()}"
        return self.excuse(method)
