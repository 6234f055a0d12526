"""Views: quantities that a method's targets hold, as its paper shows them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oitbench.effects import Effect
from oitbench.errors import DeclarationError
from oitbench.image.values import Show, Values

_LETTERS = "rgba"


@dataclass(frozen=True)
class View:
    """A quantity: scale · texel ^ power, in some channels of a target.

    Parameters
    ----------
    target : str
        Name of the target.
    channels : str
        Its channels, such as "rgb" or "a".
    show : Show
        The rule by which the quantity becomes a picture.
    scale, power : float
    unit : str
        Of the quantity.
    effect : Effect
        The effect without which the quantity has no meaning.
    """

    target: str
    channels: str
    show: Show = Show.AMOUNT
    scale: float = 1.0
    power: float = 1.0
    unit: str = ""
    effect: Effect = Effect.NONE

    def __post_init__(self) -> None:
        if not self.channels or not set(self.channels) <= set(_LETTERS):
            raise DeclarationError(
                f"view of {self.target}: channels is '{self.channels}'; give some of {_LETTERS}"
            )

    def of(self, texels: Values) -> Values:
        """Return the quantity, shape (h, w, channels), of the texels of the target."""
        places = [_LETTERS.index(letter) for letter in self.channels]
        chosen = texels[..., places].astype(np.float32)
        if self.power != 1:
            chosen = np.sign(chosen) * np.abs(chosen) ** np.float32(self.power)
        values: Values = chosen * np.float32(self.scale)
        return values
