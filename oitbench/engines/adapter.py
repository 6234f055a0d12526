"""An adapter of an engine: what it can draw, and with which of the suite's methods it compares."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from oitbench.image.files import Image
from oitbench.scene import RGB, Camera

Floats = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles with a color and an opacity at each vertex, as blending with `over` needs them.

    Parameters
    ----------
    positions : array, shape (n, 3), float32
        Meters.
    triangles : array, shape (m, 3), uint32
        Vertex indices.
    color : array, shape (n, 3), float32
        Linear radiance, not premultiplied.
    opacity : array, shape (n,), float32
        In [0, 1].
    opaque : bool
        It hides everything behind it.
    """

    positions: Floats
    triangles: npt.NDArray[np.uint32]
    color: Floats
    opacity: Floats
    opaque: bool

    @property
    def even(self) -> bool:
        """Whether all vertices have one color and one opacity."""
        values = np.column_stack([self.color, self.opacity])
        return bool((values == values[0]).all())


@dataclass(frozen=True, eq=False)
class Content:
    """A scene as engines draw it: surfaces without light, in order of submission.

    Parameters
    ----------
    camera : Camera
        Its far plane is finite, and lengths are meters.
    surfaces : tuple of Surface
    background : RGB
        Linear radiance.
    """

    camera: Camera
    surfaces: tuple[Surface, ...]
    background: RGB

    @property
    def brightest(self) -> float:
        """The largest radiance of a channel."""
        return max([*self.background, *(float(item.color.max()) for item in self.surfaces)])


@dataclass(frozen=True)
class Algorithm:
    """One way in which an engine draws transparent geometry.

    Parameters
    ----------
    peer : str
        The method of the suite that comes nearest, `NAME[param=v]`.
    remark : str
        Formats and limits, and where it differs from its peer; for readers.
    """

    peer: str
    remark: str


class Drawing(ABC):
    """A scene that is ready to be drawn again and again at one size."""

    @abstractmethod
    def draw(self) -> None:
        """Draw a whole frame, and return when it is complete."""

    @abstractmethod
    def image(self) -> Image:
        """Return the last frame, shape (h, w, 3), linear radiance, top row first."""

    def release(self) -> None:  # noqa: B027 - most engines free it by themselves
        """Free what the drawing holds."""


class Engine(ABC):
    """An engine, made in a process of its own. A subclass imports the engine in `__init__`.

    Attributes
    ----------
    algorithms : mapping of str to Algorithm
        By the name that follows the engine's in the label of a row.
    brightest : float
        The largest radiance that its targets hold.

    Raises
    ------
    CapabilityError
        By `__init__`: the engine is not installed, or finds no driver. All its rows are skipped.
    """

    algorithms: ClassVar[Mapping[str, Algorithm]]
    brightest: ClassVar[float] = 1.0

    @property
    @abstractmethod
    def version(self) -> str:
        """The version of the engine."""

    @property
    @abstractmethod
    def renderer(self) -> str:
        """The name of the renderer; that of OpenGL if it is the suite's own. After a drawing."""

    @abstractmethod
    def open(self, content: Content, algorithm: str, size: tuple[int, int]) -> Drawing:
        """Return a drawing of `content` with one of `algorithms`, `size` in pixels.

        Raises
        ------
        SceneError
            The engine cannot draw this scene. The row is skipped.
        """
