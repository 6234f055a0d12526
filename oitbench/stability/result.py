"""The result of one check of one method."""

from __future__ import annotations

from typing import Final, Literal

from msgspec import Struct

from oitbench.results.schema import Nonfinite, Renderer

VERSION: Final = 2
"""Version of the schema of `stability.json`; a change of any field raises it."""

Status = Literal["holds", "breaks", "does not apply"]
HOLDS: Final = "holds"
BREAKS: Final = "breaks"
DOES_NOT_APPLY: Final = "does not apply"


class CheckResult(Struct, frozen=True):
    """The result of one check of one variant of a method.

    `method` is the label with the parameters that differ from their defaults, and `name` the
    method's bare name. `check` and `sentence` are those of the check, and `identity` distinguishes
    an identity from a hard case.

    `error` and `allowed` belong to the expectation whose error is largest relative to its bound;
    null if they are not finite. `expected` and `found` are the values of the channel with that
    error. `in_mean` says that an expectation was compared in the mean over
    the pixels of a random method, within 4 standard errors, and not in each pixel. `reason` says
    why a check does not apply, or why there is no image. `nonfinite` counts pixels of all images;
    negative ones are no fault where the method's formula `may_be_negative`. `repeatable` says that
    images that were rendered twice are equal in every bit. On a GPU they may differ by rounding
    and, if fragments are taken in the order of their arrival, as far as the method depends on it.
    """

    method: str
    name: str
    check: str
    sentence: str
    identity: bool
    promised: bool
    status: Status
    error: float | None = None
    allowed: float | None = None
    expected: float | None = None
    found: float | None = None
    in_mean: bool = False
    reason: str = ""
    nonfinite: Nonfinite = Nonfinite()
    may_be_negative: bool = False
    repeatable: bool = True

    @property
    def applies(self) -> bool:
        """Whether the check applies to the method on this machine."""
        return self.status != DOES_NOT_APPLY

    @property
    def promise_broken(self) -> bool:
        """Whether this is a promise, and it breaks."""
        return self.promised and self.status == BREAKS

    @property
    def unstable(self) -> bool:
        """Whether pixels are not finite, wrongly negative, or change between two runs."""
        bad = self.nonfinite
        negative = bad.negative and not self.may_be_negative
        return bool(bad.nan or bad.inf or negative) or not self.repeatable

    @property
    def failed(self) -> bool:
        """Whether a promise is broken, an image is unstable, or there is no image."""
        return self.promise_broken or self.unstable or (self.status == BREAKS and bool(self.reason))


class StabilityFile(Struct, frozen=True):
    """The content of `stability.json`.

    In the file, each result has a further key `failed`, the property of that name.
    """

    gl: Renderer
    results: list[CheckResult]
    schema: Literal[2] = VERSION
