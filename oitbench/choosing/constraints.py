"""The constraints of a platform, and the reasons why a cell does not meet them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from oitbench.method.demands import CLASSES, DUAL_SOURCE, INTERLOCK, Demands
from oitbench.results.schema import Record
from oitbench.results.times import Time

_ATOMICS = "buffers with atomics"
_ORDER = tuple(CLASSES)


@dataclass(frozen=True)
class Constraints:
    """What a platform offers; None: no limit.

    Parameters
    ----------
    capability_class : str, optional
        The highest class that is offered, a key of `oitbench.method.demands.CLASSES`.
    bits : int, optional
        Bits of tile memory at a pixel, all samples included.
    passes : int, optional
        Draws of the same geometry in a frame.
    targets : int, optional
        Color targets of one pass.
    dual_source, interlock, atomics : bool
        Whether dual-source blending is offered, framebuffer fetch or interlock, and buffers with
        atomics.
    msaa : int, optional
        Samples per pixel that a frame has.
    milliseconds : float, optional
        Method time.
    """

    capability_class: str | None = None
    bits: int | None = None
    passes: int | None = None
    targets: int | None = None
    dual_source: bool = True
    interlock: bool = True
    atomics: bool = True
    msaa: int | None = None
    milliseconds: float | None = None

    def __str__(self) -> str:
        return ", ".join(self._stated()) or "no constraint"

    def _stated(self) -> Iterator[str]:
        if self.capability_class is not None:
            yield f"class {CLASSES[self.capability_class]}"
        if self.bits is not None:
            yield f"at most {self.bits} bits of tile memory"
        if self.passes is not None:
            yield f"at most {_count(self.passes, 'geometry pass', 'es')}"
        if self.targets is not None:
            yield f"at most {_count(self.targets, 'target')} in a pass"
        if not self.dual_source:
            yield f"no {CLASSES[DUAL_SOURCE]}"
        if not self.interlock:
            yield f"no {CLASSES[INTERLOCK]}"
        if not self.atomics:
            yield f"no {_ATOMICS}"
        if self.msaa is not None:
            yield f"{_count(self.msaa, 'sample')} per pixel"
        if self.milliseconds is not None:
            yield f"method time up to {self.milliseconds:g} ms"

    def unmet(self, cell: Record) -> list[str]:
        """Return why a cell does not fit; nothing if it does.

        A cell without trustworthy pictures does not fit either.
        """
        if cell.status != "ok" or cell.outcome is None:
            return [f"{cell.status}: {cell.reason}" if cell.reason else cell.status]
        reasons = list(dict.fromkeys(self._exceeded(cell.outcome.demands)))
        slow = self._slow(cell.time)
        return [*reasons, slow] if slow else reasons

    def _exceeded(self, found: Demands) -> Iterator[str]:
        highest, needed = self.capability_class, found.capability_class
        if highest is not None and _ORDER.index(needed) > _ORDER.index(highest):
            yield f"needs {CLASSES[needed]}"
        if not self.dual_source and found.dual_source:
            yield f"needs {CLASSES[DUAL_SOURCE]}"
        if not self.interlock and found.programmable:
            yield f"needs {CLASSES[INTERLOCK]}"
        if not self.atomics and found.atomics:
            yield f"needs {_ATOMICS}"
        if self.targets is not None and found.targets > self.targets:
            yield f"writes {found.targets} targets in a pass"
        if self.bits is not None and found.tile_bits > self.bits:
            yield f"needs {found.tile_bits} bits of tile memory"
        if self.passes is not None and found.geometry_passes is None:
            yield "geometry passes grow with the layers"
        elif self.passes is not None and (found.geometry_passes or 0) > self.passes:
            yield f"needs {found.geometry_passes} geometry passes"
        if self.msaa is not None and found.samples != self.msaa:
            yield _samples(found, self.msaa)

    def _slow(self, time: Time | None) -> str:
        """Return why a cell is not known to be fast enough, or ""."""
        if self.milliseconds is None:
            return ""
        if time is None:
            return "was not timed"
        if time.block.disturbed:
            return "its time was disturbed by other processes; time it again"
        ends = time.method_ms.ends
        if ends is None:
            return "its time has too few samples for an interval; run more rounds"
        return f"takes {time.method_ms.median:.3g} ms" if ends[0] > self.milliseconds else ""

    def ties(self, time: Time | None) -> bool:
        """Return whether the time limit lies inside the interval of a time: it may be exceeded."""
        if time is None or time.method_ms.ends is None or self.milliseconds is None:
            return False
        low, high = time.method_ms.ends
        return low <= self.milliseconds < high


def _samples(found: Demands, wanted: int) -> str:
    here = f"has {_count(found.samples, 'sample')} per pixel"
    return f"{here}; run it with msaa={wanted}" if wanted in found.offered else here


def _count(number: int, word: str, plural: str = "s") -> str:
    return f"{number} {word}{'' if number == 1 else plural}"
