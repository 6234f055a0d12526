"""Families of methods at equal bytes per pixel, and their errors in pictures of measured strength.

A *case* is a picture with its strength: transparent fragments at covered pixels, and the opacity of
as many equal layers that transmit as much light. A *stack* is a case of random fragment lists.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from oitbench import parameters
from oitbench.image import metrics
from oitbench.method.ablation import REQUESTED
from oitbench.results.records import Results
from oitbench.results.schema import TRANSMITTANCE, Record
from oitbench.truths import EXACT

LISTS, CURVES, BLENDING = "lists", "curves", "blending"
FAMILIES = (LISTS, CURVES, BLENDING)
EQUAL = "equal"
"""The winner where both errors are below `UNSEEN`."""
UNSEEN = 1e-4
"""An RMSE or FLIP that no display shows: a twentieth of half a step of 8 bits."""
_EQUAL = 1.2
"""Largest ratio of bytes per pixel that count as equal."""
_SWEPT = {"layers", "seed"}


@dataclass(frozen=True)
class Case:
    """One picture by all methods.

    Parameters
    ----------
    scene : str
        Label with its view.
    stack : bool
        Whether it is drawn from fragment lists.
    row, seed : str
        Label without the number of layers and the seed; the seed.
    layers : float
        Mean number of transparent fragments at covered pixels.
    opacity : float
        Mean of 1 − T^(1/n) over covered pixels, with the transmittance T of all n layers.
    rmse, flip : mapping of str to float
        Error against exact compositing by method.
    """

    scene: str
    stack: bool
    row: str
    seed: str
    layers: float
    opacity: float
    rmse: Mapping[str, float]
    flip: Mapping[str, float]


def cases(results: Results, flip: str) -> list[Case]:
    """Return all pictures with all requested effects whose strength is stored.

    Parameters
    ----------
    results : Results
    flip : str
        Name of the FLIP metric of `Case.flip`.
    """
    groups: dict[tuple[object, ...], list[Record]] = {}
    for record in results.records:
        if record.finished and record.effects == REQUESTED and not record.shading:
            groups.setdefault((record.seen, record.size, record.ssaa), []).append(record)
    found = (_case(results, cells, flip) for cells in groups.values())
    return [case for case in found if case is not None]


def _case(results: Results, cells: Sequence[Record], flip: str) -> Case | None:
    first = cells[0]
    counts, passed = results.complexity(first), results.image(first, TRANSMITTANCE)
    if first.outcome is None or counts is None or passed is None or not counts.any():
        return None
    covered = counts > 0
    n = counts[covered].astype(np.float64)
    opacity = 1 - passed[covered].astype(np.float64).mean(axis=-1).clip(0, 1) ** (1 / n)
    selected = parameters.parse(first.scene)
    kept = {key: values for key, values in selected.grid.items() if key not in _SWEPT}
    return Case(
        first.seen,
        first.outcome.statistics.objects == 0,
        parameters.selector(selected.name, kept),
        str(selected.grid.get("seed", ("",))[0]),
        float(n.mean()),
        float(opacity.mean()),
        _errors(cells, metrics.RMSE),
        _errors(cells, flip),
    )


def _errors(cells: Iterable[Record], metric: str) -> dict[str, float]:
    found = {cell.method: cell.metric(EXACT, metric) for cell in cells}
    return {method: error for method, error in found.items() if error is not None}


@dataclass(frozen=True)
class ByteGroup:
    """Methods of nearly equal bytes per pixel, by label."""

    bytes: Mapping[str, float]

    @property
    def title(self) -> str:
        """The bytes in words."""
        return bytes_text(self.bytes.values())


def byte_groups(results: Results, anchors: Iterable[str], others: Iterable[str]) -> list[ByteGroup]:
    """Return a group for each number of bytes that a method of `anchors` needs, smallest first.

    Each method of `others` joins the group of the nearest number, if the larger one is at most a
    fifth more. Groups of anchors alone are left out, and so are methods whose bytes differ between
    pictures.
    """
    fixed = {name: low for name, (low, high) in bytes_of(results).items() if low == high}
    groups: dict[float, dict[str, float]] = {}
    for name in anchors:
        if name in fixed:
            groups.setdefault(fixed[name], {})[name] = fixed[name]
    joined = set()
    for name in others:
        ratios = {size: abs(math.log(size / fixed[name])) for size in groups if name in fixed}
        nearest = min(ratios, key=ratios.__getitem__, default=0.0)
        if nearest and ratios[nearest] <= math.log(_EQUAL):
            groups[nearest][name] = fixed[name]
            joined.add(nearest)
    return [ByteGroup(groups[size]) for size in sorted(joined)]


def bytes_of(results: Results) -> dict[str, tuple[float, float]]:
    """Return the least and greatest bytes per pixel of each method over all pictures."""
    found: dict[str, list[float]] = {}
    for record in results.records:
        if record.outcome is not None:
            found.setdefault(record.method, []).append(record.outcome.memory.bits_per_pixel / 8)
    return {name: (min(sizes), max(sizes)) for name, sizes in found.items()}


def bytes_text(sizes: Iterable[float]) -> str:
    """Return the least and the greatest number of bytes per pixel in words."""
    known = [round(size) for size in sizes]
    low, high = min(known), max(known)
    return f"{low} bytes per pixel" if low == high else f"{low} to {high} bytes per pixel"


def lowest(errors: Mapping[str, float], methods: Iterable[str]) -> str | None:
    """Return the method of lowest error; None if no method has an error."""
    known = [method for method in methods if method in errors]
    return min(known, key=errors.__getitem__, default=None)


@dataclass(frozen=True)
class Comparison:
    """All methods by family and by bytes.

    Parameters
    ----------
    groups : list of ByteGroup
    members : mapping of str to list of str
        Methods by family.
    blending : str
        The bytes of blending in words.
    cases : list of Case
    """

    groups: list[ByteGroup]
    members: Mapping[str, Sequence[str]]
    blending: str
    cases: list[Case]

    def of(self, group: ByteGroup, family: str) -> list[str]:
        """Return the methods of a family in a group; blending belongs to all groups."""
        methods = self.members[family]
        return [method for method in methods if family == BLENDING or method in group.bytes]

    def winner(self, case: Case, group: ByteGroup, by_flip: bool = False) -> str:
        """Return the better of lists and curves in a picture, or `EQUAL`.

        It is empty if the picture lacks one of them.
        """
        errors = case.flip if by_flip else case.rmse
        best = {f: lowest(errors, self.of(group, f)) for f in (LISTS, CURVES)}
        known = {family: errors[method] for family, method in best.items() if method is not None}
        if len(known) < len(best):
            return ""
        return EQUAL if max(known.values()) < UNSEEN else min(known, key=known.__getitem__)


def compare(results: Results, family_of: Mapping[str, str], flip: str) -> Comparison:
    """Sort the methods of results.

    Parameters
    ----------
    results : Results
    family_of : mapping of str to str
        One of `FAMILIES` by the bare name of a method; other methods are not compared.
    flip : str
        Name of the FLIP metric of the cases.
    """
    names = {record.method: record.name for record in results.records}
    members = {
        family: [m for m in results.methods if family_of.get(names[m]) == family]
        for family in FAMILIES
    }
    sizes = bytes_of(results)
    blending = [size for method in members[BLENDING] for size in sizes.get(method, ())]
    return Comparison(
        byte_groups(results, members[LISTS], members[CURVES]),
        members,
        bytes_text(blending) if blending else "",
        cases(results, flip),
    )
