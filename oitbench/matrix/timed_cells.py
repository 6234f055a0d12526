"""Times the cells of a scene, and checks that the timed pictures are those that were scored."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from hashlib import blake2b

from msgspec import Struct

from oitbench.errors import OitbenchError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.matrix import machine
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.measure import timing
from oitbench.measure.agreement import difference
from oitbench.measure.clock import clock_of
from oitbench.measure.rounds import Schedule
from oitbench.plugins import Collection
from oitbench.results.schema import Fingerprints
from oitbench.results.times import Time
from oitbench.scene import Scene


class ScoredCell(Struct, frozen=True):
    """A cell that has been scored, and the content that its picture comes from.

    `plan` is the digest of its plan.
    """

    cell: Cell
    plan: str
    fingerprints: Fingerprints | None = None


class Timing(Struct, frozen=True):
    """The times of a cell, or the reason why there are none.

    `suspect` says that the method draws something else while it is timed.
    """

    time: Time | None = None
    reason: str = ""
    suspect: bool = False


def time_cells(
    device: Device,
    collection: Collection,
    scene: Scene,
    cells: Sequence[ScoredCell],
    schedule: Schedule,
) -> list[Timing]:
    """Time the cells of one scene against each other; return their times in order.

    A cell that fails has a reason, and does not affect the others.
    """
    found: dict[str, Timing] = {}
    with ExitStack() as stack:
        uploaded: dict[str, UploadedScene] = {}
        frames: dict[str, Frame] = {}
        drawn: dict[str, bytes] = {}
        for scored in cells:
            name, shading = str(scored.cell.key), scored.cell.shading
            try:
                if shading not in uploaded:
                    rows = scored.cell.size[1]
                    opened = UploadedScene(device, scene, scored.cell.settings, rows)
                    uploaded[shading] = stack.enter_context(opened)
                frame = stack.enter_context(_frame(uploaded[shading], collection, scored.cell))
                frame.render()
            except OitbenchError as error:
                found[name] = Timing(reason=str(error))
                continue
            if frame.plan.digest == scored.plan:
                frames[name], drawn[name] = frame, _digest(frame.image())
            else:
                reason = "the method declares other passes when it is timed"
                found[name] = Timing(reason=reason, suspect=True)
        clock = stack.enter_context(clock_of(device))
        measured = timing.measure(frames, schedule, clock, machine.processor())
        found |= {name: Timing(reason=str(error)) for name, error in measured.errors.items()}
        for scored in cells:
            name = str(scored.cell.key)
            time = measured.times.get(name)
            if time is None:
                continue
            same = _digest(frames[name].image()) == drawn[name]
            found[name] = (
                Timing(time) if same else _checked(frames[name], collection, scored.cell, time)
            )
    return [found[str(scored.cell.key)] for scored in cells]


def _digest(image: Image) -> bytes:
    """Return a digest of a picture: those of all cells of a scene would fill the memory."""
    return blake2b(image.tobytes()).digest()


def _checked(frame: Frame, collection: Collection, cell: Cell, time: Time) -> Timing:
    """Return the times of a frame if its picture is one that the scored frame may draw."""
    with _frame(frame.scene, collection, cell) as accurate:

        def render() -> Image:
            accurate.render()
            return accurate.image()

        try:
            reason = difference(frame.image(), render)
        except OitbenchError as error:
            return Timing(reason=str(error))
    return Timing(reason=reason, suspect=True) if reason else Timing(time)


def _frame(uploaded: UploadedScene, collection: Collection, cell: Cell) -> Frame:
    """Return a frame of the cell without sub-pixels."""
    (method,) = collection.expand_methods([cell.method])
    effects = choose_effects(cell.effects, uploaded.scene.effects) & method.shows
    return Frame(uploaded, method, cell.size, effects)
