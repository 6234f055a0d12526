"""Times in the record of a cell: every field, its type and its unit."""

from __future__ import annotations

from typing import Final, Literal

from msgspec import Struct

DISTURBED: Final = 0.05
"""Share of the CPU time that other processes may take while a scene is timed."""
SIGN: Final = "†"
"""Sign of a time that other processes disturbed."""


class _Typed(Struct, frozen=True, forbid_unknown_fields=True):
    """Base of all parts of a record."""


class Interval(_Typed, frozen=True):
    """A median in milliseconds, an interval that holds the true median, and all samples.

    The ends are two of the samples, so the interval is valid for any distribution. `coverage`, at
    least 0.95, is the probability that it holds the true median. Below six samples no interval
    reaches that, and `low`, `high` and `coverage` are null.
    """

    median: float
    low: float | None
    high: float | None
    coverage: float | None
    samples: list[float]

    @property
    def ends(self) -> tuple[float, float] | None:
        """Both ends of the interval; None if there is none."""
        return None if self.low is None or self.high is None else (self.low, self.high)

    @property
    def span(self) -> tuple[float, float]:
        """Both ends of the interval; the median twice if there is none."""
        return self.ends or (self.median, self.median)


class Processor(_Typed, frozen=True):
    """The processor: its name, the cores that this process may use, and Linux's `governor`.

    The governor chooses the clock frequency; null if the system does not tell.
    """

    model: str
    cores: int | None = None
    governor: str | None = None


class PassTime(_Typed, frozen=True):
    """Time of one part of a frame in milliseconds: of a pass, or of passes that take turns."""

    name: str
    ms: Interval


class Block(_Typed, frozen=True):
    """The conditions under which the cells of a scene were timed together.

    `clock` is "wall" on a software renderer, and "gpu" where timestamps of the GPU count. `foreign`
    is the share of the CPU time that other processes took, of all cores that the renderer may use;
    null if the system does not tell. `repeated` says that a first attempt was disturbed. `seconds`
    is the wall-clock time of all rounds. `rounds` and `budget` are those of the preset: the
    largest number of rounds, and the seconds after which a cell with enough rounds gets no more.
    `code` is the fingerprint of the sources that time.
    """

    clock: Literal["wall", "gpu"]
    cpu: Processor
    seconds: float
    foreign: float | None = None
    repeated: bool = False
    rounds: int = 0
    budget: float = 0.0
    code: str = ""

    @property
    def disturbed(self) -> bool:
        """Whether other processes took more CPU time than times allow."""
        return self.foreign is not None and self.foreign > DISTURBED


class Time(_Typed, frozen=True):
    """Times of a frame; the samples are in order of the rounds.

    `method_ms` is the time of the method alone: sorting, uploading what was sorted, and all passes,
    over the opaque picture, shadow maps and occlusion of an earlier frame. `sort_ms` is its part of
    sorting and uploading, null for a method that never sorts. `gpu_ms` is its part on the GPU, null
    on a software renderer. `shading_ms` is the shading that all methods share: shadow maps, ambient
    occlusion and the opaque picture, measured once per scene. `frame_ms` is the sum of
    `method_ms` and `shading_ms`, round by round. `passes` and `shading` are the parts of the
    drawing, timed one by one in further frames. `remark` says why the passes do not add up to
    their time in a whole frame; empty if they do.
    """

    method_ms: Interval
    sort_ms: Interval | None
    gpu_ms: Interval | None
    shading_ms: Interval
    frame_ms: Interval
    passes: list[PassTime]
    shading: list[PassTime]
    block: Block
    remark: str = ""
