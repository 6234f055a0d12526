"""Cost and gain of effects, from cells that leave one effect out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from oitbench.image.ties import clear_difference
from oitbench.measure.intervals import interval
from oitbench.report.cells import effect_labels, total_memory, total_traffic
from oitbench.report.times import is_disturbed
from oitbench.results.records import Ablation, Panel
from oitbench.results.schema import Record
from oitbench.results.times import Interval


@dataclass(frozen=True)
class EffectCost:
    """Cost and gain of an effect with one method in one scene.

    Parameters
    ----------
    ablation : Ablation
    time : Interval, optional
        Frame time that leaving the effect out saves.
    memory, traffic : int
        Bytes that leaving the effect out saves, shared shading included.
    gain : float, optional
        Increase of the error when the effect is left out, against the truth that ranks the scene
        with all effects.
    clear : bool
        Whether the gain is more than noise of that truth; see `oitbench.image.ties`.
    noise_floor : float, optional
        Of that truth.
    """

    ablation: Ablation
    time: Interval | None
    memory: int
    traffic: int
    gain: float | None
    clear: bool
    noise_floor: float | None

    @property
    def method(self) -> str:
        """Label of the method."""
        return self.ablation.complete.method

    @property
    def effect(self) -> str:
        """Name of the effect as readers see it; several names if several were left out."""
        return effect_labels(self.ablation.named)

    @property
    def disturbed(self) -> bool:
        """Whether other processes disturbed the time of either picture."""
        return is_disturbed(self.ablation.complete) or is_disturbed(self.ablation.reduced)

    @property
    def verdict(self) -> str:
        """How the effect changes the error: "better", "worse" or "tie"; empty if unknown."""
        if self.gain is None:
            return ""
        if not self.clear:
            return "tie"
        return "better" if self.gain > 0 else "worse"


def effect_costs(panel: Panel, metric: str) -> Iterator[EffectCost]:
    """Yield the cost and gain of every effect that was left out of a finished cell."""
    for ablation in panel.ablations:
        complete, reduced = ablation.complete, ablation.reduced
        if complete.outcome is None or reduced.outcome is None:
            continue
        truth = complete.ranking_truth
        before, after = complete.errors(truth, metric), reduced.errors(reduced.whole_truth, metric)
        yield EffectCost(
            ablation,
            saved_time(complete, reduced),
            total_memory(complete.outcome) - total_memory(reduced.outcome),
            total_traffic(complete.outcome) - total_traffic(reduced.outcome),
            after.error - before.error if before and after else None,
            bool(before and after and clear_difference(after, before)),
            complete.noise_floor(truth, metric),
        )


def saved_time(complete: Record, reduced: Record) -> Interval | None:
    """Return the frame time that leaving effects out saves; None if a cell has no times.

    The cells of a scene are timed in the same rounds, so the difference is taken in each round.
    """
    if complete.time is None or reduced.time is None:
        return None
    samples = (complete.time.frame_ms.samples, reduced.time.frame_ms.samples)
    return interval([one - other for one, other in zip(*samples, strict=False)])
