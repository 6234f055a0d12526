"""What the suite found: the record of one check on one variant of a method."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

HOLDS, BREAKS, DOES_NOT_APPLY = "holds", "breaks", "does not apply"


@dataclass(frozen=True)
class Finding:
    """What one check found about one variant of a method.

    Parameters
    ----------
    method, name : str
        Label, and bare name.
    check, sentence : str
    identity : bool
        An identity, or a hard case.
    result : str
        "holds", "breaks" or "does not apply".
    promised : bool
        Whether the method has the identity in `holds`.
    in_mean : bool
        Held by the mean of a random method's pixels, within 4 standard errors, not by each pixel.
    error, allowed : float or None
        The comparison that is nearest to, or farthest beyond, its bound; None if not finite.
    reason : str
        Why it does not apply, or why there is no picture.
    nan, inf, negative : int
        Such pixels, over all pictures.
    signed : bool
        Whether the method's own formula may be negative, so that such pixels are no fault.
    repeatable : bool
        Whether pictures taken twice were equal bit for bit.
    """

    method: str
    name: str
    check: str
    sentence: str
    identity: bool
    result: str
    promised: bool
    in_mean: bool = False
    error: float | None = None
    allowed: float | None = None
    reason: str = ""
    nan: int = 0
    inf: int = 0
    negative: int = 0
    signed: bool = False
    repeatable: bool = True

    @property
    def unstable(self) -> bool:
        """Whether a pixel was not finite or wrongly negative, or changed between two runs."""
        negative = self.negative and not self.signed
        return bool(self.nan or self.inf or negative) or not self.repeatable

    @property
    def failed(self) -> bool:
        """Whether this must not be: a broken promise, an unstable picture, or none at all."""
        return self.unstable or (self.result == BREAKS and bool(self.promised or self.reason))

    def facts(self) -> dict[str, Any]:
        """Return the finding for a file."""
        return {**asdict(self), "failed": self.failed}
