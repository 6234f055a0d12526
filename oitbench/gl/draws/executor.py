"""Issuing and counting the steps of a frame: passes, interleaved passes and loops."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from fractions import Fraction

import moderngl
import numpy as np

from oitbench.gl.batches import IndexOrder
from oitbench.gl.device import Device
from oitbench.gl.draws.records import PassRecord, no_lap
from oitbench.gl.program.bindings import Access
from oitbench.gl.program.compiled_pass import CompiledPass
from oitbench.gl.tiling import Scissor, rectangle
from oitbench.gl.view import FRAME_OFFSET, ITERATION_OFFSET
from oitbench.image.values import Values
from oitbench.method.passes import Gather, Interleaved, Loop, Step


@dataclass(frozen=True)
class CompiledStep:
    """A step that can be issued.

    Parameters
    ----------
    step : Step
    rounds : tuple of tuple of CompiledPass
        One entry, or two for a loop that swaps targets: the passes of even and of odd rounds.
    """

    step: Step
    rounds: tuple[tuple[CompiledPass, ...], ...]

    @property
    def passes(self) -> tuple[CompiledPass, ...]:
        """The passes of the first round."""
        return self.rounds[0]


def _no_counts() -> dict[Access, int]:
    return {}


class Executor:
    """Issues compiled steps, and counts their work on request.

    Parameters
    ----------
    device : Device
    views : mapping of int to moderngl.Buffer
        The uniform block `View` by the `subsample` of the written targets.
    copy : callable, optional
        Copies the first of two named targets to the second; for loops that swap targets.
    take_counts : callable, optional
        Returns the accesses to buffers since its last call.
    texels : callable, optional
        Returns the texels of a named target, top row first; for loops `within` one.
    """

    def __init__(
        self,
        device: Device,
        views: Mapping[int, moderngl.Buffer],
        copy: Callable[[str, str], None] | None = None,
        take_counts: Callable[[], dict[Access, int]] = _no_counts,
        texels: Callable[[str], Values] | None = None,
    ) -> None:
        self._device, self._views, self._texels = device, views, texels
        self._copy, self._take_counts = copy, take_counts

    def issue(
        self,
        steps: Sequence[CompiledStep],
        orders: Mapping[Hashable, IndexOrder],
        scissor: Scissor | None = None,
        records: Sequence[PassRecord] | None = None,
        lap: Callable[[int], None] = no_lap,
    ) -> None:
        """Issue all steps once.

        Parameters
        ----------
        steps : sequence of CompiledStep
        orders : mapping
            Draw order by the key that a gather pass asks for.
        scissor : (int, int, int, int), optional
            Part of the frame to draw; downsampled targets are drawn as a whole. Default: all.
        records : sequence of PassRecord, optional
            One record per pass, in order, to which the counts are added. Counting waits after
            every draw.
        lap : callable, optional
            Called after every draw with the pass's place in order; for interleaved passes once,
            after the last of them, with the place of the first.
        """
        first = 0
        for compiled in steps:
            count = len(compiled.passes)
            mine = records[first : first + count] if records is not None else None
            draws = _Draws(self._device, self._views, orders, scissor, mine, self._take_counts)
            if isinstance(compiled.step, Interleaved):
                draws.interleave(compiled)
                lap(first)
            elif isinstance(compiled.step, Loop):
                self._loop(compiled, compiled.step, draws, lap, first)
            else:
                draws.draw(0, compiled.passes[0])
                lap(first)
            first += count

    def _loop(
        self,
        compiled: CompiledStep,
        loop: Loop,
        draws: _Draws,
        lap: Callable[[int], None],
        first: int,
    ) -> None:
        done = 0
        for number in itertools.count() if loop.times is None else range(loop.times):
            self._set(ITERATION_OFFSET, number)
            empty = False
            for index, item in enumerate(compiled.rounds[number % len(compiled.rounds)]):
                queried = item.step.name == loop.until_empty
                passed = draws.draw(index, item, queried=queried)
                lap(first + index)
                empty = empty or (queried and passed == 0)
            done = number + 1
            if loop.within and self._texels and draws.scissor:
                side = next(p.subsample for p in compiled.passes if loop.within in p.step.writes)
                marked = self._texels(loop.within)[::-1, :, 0] != 0
                part = rectangle(marked, side, draws.scissor)
                draws, empty = replace(draws, part=part), empty or part is None
            if empty:
                break
        if done % 2 and self._copy is not None and loop.swaps:
            for one, other in loop.swaps:
                self._copy(other, one)
            lap(first + len(loop.passes) - 1)
        self._set(ITERATION_OFFSET, 0)

    def set_frame(self, number: int) -> None:
        """Set the number of the frame that shaders see."""
        self._set(FRAME_OFFSET, number)

    def _set(self, offset: int, number: int) -> None:
        for view in self._views.values():
            view.write(np.uint32(number).tobytes(), offset=offset)


@dataclass(frozen=True)
class _Draws:
    """The draws of one step."""

    device: Device
    views: Mapping[int, moderngl.Buffer]
    orders: Mapping[Hashable, IndexOrder]
    scissor: Scissor | None
    records: Sequence[PassRecord] | None
    take_counts: Callable[[], dict[Access, int]]
    part: Scissor | None = None
    """Part of `scissor` in which passes draw; clears fill all of it."""

    def interleave(self, compiled: CompiledStep) -> None:
        """Draw all passes for one unit before the next unit."""
        runs = [record.runs for record in self.records or ()]
        for first, count in self.orders[compiled.passes[0].draws].units:
            for index, item in enumerate(compiled.passes):
                self.draw(index, item, (int(first), int(count)))
        for record, before in zip(self.records or (), runs, strict=True):
            record.runs = before + 1

    def draw(
        self,
        index: int,
        item: CompiledPass,
        unit: tuple[int, int] | None = None,
        queried: bool = False,
    ) -> int:
        """Draw one pass; return the samples that passed if they were `queried` or counted."""
        record = self.records[index] if self.records is not None else None
        query = self.device.samples_query if queried or record is not None else None
        for framebuffer, entry, value in item.clears:
            framebuffer.use()
            framebuffer.scissor = self._within(framebuffer, item)
            self.device.clear(0, entry, value)
        part = self.part if item.subsample == 1 else None
        item.begin(self.views[item.subsample], part or self._within(item.framebuffer, item))
        with query or nullcontext():
            self._submit(item, unit)
        passed = int(query.samples) if query is not None else 0
        if record is not None:
            # Early tests also count fragments that the scene's shader discards; a pass that
            # stores its fragments in buffers is counted there.
            stored = isinstance(item.step, Gather) and bool(item.step.buffers)
            record.fragments += 0 if stored else passed
            record.runs += 1
            record.cleared += self._share(item)
            for key, count in self.take_counts().items():
                record.accesses[key] = record.accesses.get(key, 0) + count
        return passed

    def _share(self, item: CompiledPass) -> Fraction:
        """Return the part of the targets that a pass clears, of the area of the frame."""
        framebuffer = item.framebuffer
        width, height = self._within(framebuffer, item)[2:]
        return Fraction(width * height, math.prod(framebuffer.size))

    def _submit(self, item: CompiledPass, unit: tuple[int, int] | None) -> None:
        if item.draws is None:
            item.draw_screen()
            return
        order = self.orders[item.draws]
        first, count = unit or (0, order.triangles)
        if count:
            item.draw(order.indices, first, count)

    def _within(self, framebuffer: moderngl.Framebuffer, item: CompiledPass) -> Scissor:
        """Return the part to draw: the scissor applies to the frame, not to smaller targets."""
        if self.scissor is not None and item.subsample == 1:
            return self.scissor
        return (0, 0, *framebuffer.size)
