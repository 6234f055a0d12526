"""Issuing a frame's steps: single passes, interleaved ones and loops, and measuring them."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.program.passes import CompiledPass
from oitbench.gl.resources import Resources
from oitbench.method.declaration import Draws, Interleaved, Loop, Objects, Order, Pass, Step

Scissor = tuple[int, int, int, int]
Drawn = tuple[Order, Objects]
"""What a sequence of triangles is made for."""
ITERATION_OFFSET = 160
"""Byte of `iteration` in the uniform block `View`."""


@dataclass
class PassRecord:
    """What one pass did in a measured frame.

    Parameters
    ----------
    name : str
    runs : int
        Draws of the screen, or of all geometry, that were issued.
    fragments : int
        Samples that passed the depth test, or fragments kept in buffers.
    milliseconds : float
        Waiting after every draw included.
    accesses : dict
        Accesses to buffers by (buffer, field, kind).
    """

    name: str
    runs: int = 0
    fragments: int = 0
    milliseconds: float = 0.0
    accesses: dict[tuple[str, str, str], int] = field(default_factory=dict)


@dataclass(frozen=True)
class Sequence:
    """Indices of one draw order on the device, and the units of interleaved passes."""

    indices: moderngl.Buffer
    units: npt.NDArray[np.int64]
    triangles: int


@dataclass(frozen=True)
class CompiledStep:
    """A step that can be issued.

    Parameters
    ----------
    step : Step
    rounds : tuple of tuple of CompiledPass
        One entry, or two for a loop that swaps targets: those of even and of odd rounds.
    """

    step: Step
    rounds: tuple[tuple[CompiledPass, ...], ...]

    def release(self) -> None:
        """Free what the passes own."""
        for passes in self.rounds:
            for item in passes:
                item.release()


def passes_of(step: Step) -> tuple[Pass, ...]:
    """Return the passes of a step, in order."""
    return (step,) if isinstance(step, Pass) else step.passes


def runs(when: Effect, effects: Effect) -> bool:
    """Tell whether something that is there for `when` takes part under `effects`."""
    return when is Effect.NONE or bool(when & effects)


def names_of(step: Pass) -> set[str]:
    """Return the names of all targets and buffers that a pass has to do with."""
    depths = [name for name in (step.depth, step.tests) if name is not None]
    return {*step.reads, *step.writes, *step.buffers, *step.clears, *depths}


def unneeded(steps: Iterable[Step], present: Collection[Objects]) -> set[str]:
    """Return the targets and buffers that serve only passes for objects that are not `present`."""
    passes = [item for step in steps for item in passes_of(step)]
    needed = [names_of(item) for item in passes if item.objects in present]
    others = [names_of(item) for item in passes if item.objects not in present]
    return set().union(*others) - set().union(*needed)


def running(
    step: Step, effects: Effect, absent: set[str], present: Collection[Objects]
) -> Step | None:
    """Return what is left of `step`: the passes that run, without the `absent` resources."""
    passes = tuple(
        replace(
            item,
            reads=tuple(name for name in item.reads if name not in absent),
            writes={name: blend for name, blend in item.writes.items() if name not in absent},
            buffers=tuple(name for name in item.buffers if name not in absent),
            clears=tuple(name for name in item.clears if name not in absent),
        )
        for item in passes_of(step)
        if runs(item.when, effects) and item.objects in present
    )
    if not passes:
        return None
    return passes[0] if isinstance(step, Pass) else replace(step, passes=passes)


class Issuer:
    """Issues compiled steps, and measures them if asked to.

    Parameters
    ----------
    device : Device
    views : mapping of int to moderngl.Buffer
        The uniform block `View`, by the `subsample` of what is written.
    resources : Resources
        Of which the targets that loops swap, and the counters of buffer accesses, are needed.
    """

    def __init__(
        self, device: Device, views: Mapping[int, moderngl.Buffer], resources: Resources
    ) -> None:
        self.device, self.views, self.resources = device, views, resources

    def issue(
        self,
        steps: list[CompiledStep],
        sequences: Mapping[Drawn, Sequence],
        scissor: Scissor,
        records: list[PassRecord] | None,
    ) -> None:
        """Issue all steps once, within `scissor`; what is subsampled is done as a whole."""
        first = 0
        for compiled in steps:
            count = len(compiled.rounds[0])
            if records is not None:
                while len(records) < first + count:
                    records.append(PassRecord(compiled.rounds[0][len(records) - first].step.name))
            mine = records[first : first + count] if records is not None else None
            order = compiled.step.order
            each = [sequences[order, item.step.objects] for item in compiled.rounds[0]]
            if isinstance(compiled.step, Interleaved):
                self._interleave(compiled, each[0], scissor, mine)
            elif isinstance(compiled.step, Loop):
                self._loop(compiled, compiled.step, each, scissor, mine)
            else:
                self._draw(
                    compiled.rounds[0][0], each[0], scissor, mine[0] if mine else None, None, False
                )
            first += count

    def _interleave(
        self,
        compiled: CompiledStep,
        sequence: Sequence,
        scissor: Scissor,
        records: list[PassRecord] | None,
    ) -> None:
        for unit in sequence.units:
            for number, item in enumerate(compiled.rounds[0]):
                record = records[number] if records is not None else None
                self._draw(item, sequence, scissor, record, (int(unit[0]), int(unit[1])), False)
        for record in records or ():
            record.runs = 1

    def _loop(
        self,
        compiled: CompiledStep,
        loop: Loop,
        sequences: list[Sequence],
        scissor: Scissor,
        records: list[PassRecord] | None,
    ) -> None:
        done = 0
        for number in range(loop.times):
            self._tell(number)
            empty = False
            for index, item in enumerate(compiled.rounds[number % len(compiled.rounds)]):
                record = records[index] if records is not None else None
                asked = item.step.name == loop.until_empty
                passed = self._draw(item, sequences[index], scissor, record, None, asked)
                empty = empty or (asked and passed == 0)
            done = number + 1
            if empty:
                break
        if done % 2:
            for one, other in loop.swaps:
                self.resources.copy(other, one)
        self._tell(0)

    def _tell(self, iteration: int) -> None:
        for view in self.views.values():
            view.write(np.uint32(iteration).tobytes(), offset=ITERATION_OFFSET)

    def _within(self, framebuffer: moderngl.Framebuffer, scissor: Scissor) -> Scissor:
        """Return the part to write: `scissor` is one of the frame, and no smaller target's."""
        whole = framebuffer.size == self.resources.size
        return scissor if whole else (0, 0, *framebuffer.size)

    def _draw(
        self,
        item: CompiledPass,
        sequence: Sequence,
        scissor: Scissor,
        record: PassRecord | None,
        unit: tuple[int, int] | None,
        asked: bool,
    ) -> int:
        """Draw one pass; return the samples that passed, if `asked` or measured."""
        first, count = unit or (0, sequence.triangles)
        query = self.device.context.query(samples=True) if asked or record is not None else None
        with self._measured(item, record):
            for framebuffer, entry, value in item.clears:
                framebuffer.use()
                framebuffer.scissor = self._within(framebuffer, scissor)
                self.device.clear(0, entry, value)
            item.begin(self.views[item.subsample], self._within(item.framebuffer, scissor))
            with query or nullcontext():
                if item.step.draws is Draws.PIXELS:
                    item.draw_screen()
                elif count:
                    item.draw(sequence.indices, first, count)
        passed = int(query.samples) if query is not None else 0
        if record is not None:
            kept = item.step.draws is Draws.FRAGMENTS and bool(item.step.buffers)
            if not kept:
                record.fragments += passed
            record.runs += 1
        return passed

    @contextmanager
    def _measured(self, item: CompiledPass, record: PassRecord | None) -> Iterator[None]:
        if record is None:
            yield
            return
        self.device.finish()
        start = time.perf_counter()
        yield
        self.device.finish()
        record.milliseconds += 1e3 * (time.perf_counter() - start)
        for key, count in self.resources.take_counts().items():
            record.accesses[key] = record.accesses.get(key, 0) + count
