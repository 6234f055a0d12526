"""Values of surfaces while a material is computed, and as the scene model stores them."""

from __future__ import annotations

import numpy as np

from oitbench.importing.limits import Budget
from oitbench.scene import RGB, Array, Texture, Wrap

Values = Array
"""A value of a surface: shape (1,) or (3,), or (h, w, 1 or 3) if it is textured."""


class Canvas:
    """Turns values into constants and textures of one way to continue.

    Parameters
    ----------
    budget : Budget
    wrap : (Wrap, Wrap), optional
        Needed if a value is textured.
    """

    def __init__(self, budget: Budget, wrap: tuple[Wrap, Wrap] | None) -> None:
        self._budget, self._wrap = budget, wrap

    def color(self, values: Values) -> RGB | Texture:
        """Return a color, or a texture of colors."""
        if _constant(values):
            red, green, blue = np.broadcast_to(values.reshape(-1, values.shape[-1])[0], 3).tolist()
            return red, green, blue
        return self._texture(np.broadcast_to(values, (*values.shape[:2], 3)))

    def scalar(self, values: Values) -> float | Texture:
        """Return a number, or a texture of numbers."""
        return float(values.flat[0]) if _constant(values) else self._texture(values[..., 0])

    def _texture(self, texels: Values) -> Texture:
        assert self._wrap is not None
        self._budget.take("texels", texels.shape[0] * texels.shape[1])
        return Texture(np.ascontiguousarray(texels, dtype=np.float32), wrap=self._wrap)


def same_size(*values: Values) -> list[Values]:
    """Return values of which all textured ones have the size of the largest."""
    textured = [one.shape[:2] for one in values if one.ndim == 3]
    if not textured:
        return list(values)
    height, width = (max(sides) for sides in zip(*textured, strict=True))
    return [one if one.ndim < 3 else _enlarged(one, height, width) for one in values]


def _enlarged(values: Values, height: int, width: int) -> Values:
    """Return values with as many texels as another texture, by the nearest ones."""
    if values.shape[:2] == (height, width):
        return values
    rows = np.arange(height) * values.shape[0] // height
    columns = np.arange(width) * values.shape[1] // width
    return np.asarray(values[rows[:, None], columns[None]])


def _constant(values: Values) -> bool:
    return values.ndim < 3 or bool((values == values[:1, :1]).all())
