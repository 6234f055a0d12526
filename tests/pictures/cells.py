"""The guard's cells, derived from what methods declare: a new method is guarded without a change.

On the scenes for methods, every pair of values of two parameters runs at least once. The truth runs
on all scenes, with all effects that the scene requests and without each one, and with settings of
shared shading on scenes with shadows. All methods run on the
scene of all effects of compositing, with and without those that they express; on the scenes of
shading, only methods that express more than colored coverage do, because all receive the same
fragments.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from oitbench.effects import Effect
from oitbench.matrix.cell import choose_effects
from oitbench.method.ablation import REQUESTED, effects_axis
from oitbench.method.declaration import Method
from oitbench.parameters import AnyParameter, Value
from oitbench.plugins import Collection
from tests.pictures.scenes import ALL_EFFECTS, DECALS, METHOD_SCENES, SCENES

SHADOWED = ("beams", "fog")
"""Scenes on which the settings of shared shading run."""
SHADING = (
    "translucent=published", "translucent=occluders", "translucent=published,downsampling=1",
    "translucent=occluders,downsampling=1", "downsampling=8", "slices=8", "rays=2",
)  # fmt: skip
FURTHER = (
    "moments[count=6,storage=unorm16]",
    "moments[count=8,storage=unorm16]",
    "a_buffer[storage=counted,msaa=4]",
)
"""Methods of three values that reach branches which no pair of values reaches."""
_GRAY = "-colored_shadows"
_PLAIN = Effect.COVERAGE | Effect.COLORED_TRANSMISSION


class Cell(NamedTuple):
    """A picture of the guard.

    Parameters
    ----------
    scene : str
        A key of `SCENES`.
    method : str
        Label.
    effects : str
        "requested", or one effect left out.
    shading : str
        Settings of shared shading that differ from the guard's.
    """

    scene: str
    method: str
    effects: str = REQUESTED
    shading: str = ""

    def __str__(self) -> str:
        return " ".join(part for part in self if part)


def values(parameter: AnyParameter) -> tuple[Value, ...]:
    """Return the values of a parameter that the guard runs, the default first.

    All choices, or both bounds of a range and its grid. A number without an upper bound also runs
    two above its default.
    """
    default = parameter.default
    found: list[Value] = [default, *parameter.choices]
    if isinstance(default, bool):
        found.append(not default)
    elif isinstance(default, int | float) and not parameter.choices:
        high = default + 2 if parameter.high is None else parameter.high
        bounds = [bound for bound in (parameter.low, high) if bound is not None]
        found += [*map(type(default), bounds), *parameter.grid]
    return tuple(dict.fromkeys(found))


def combinations(parameters: Mapping[str, AnyParameter]) -> list[dict[str, Value]]:
    """Return values of all parameters, such that every pair of two parameters' values occurs.

    The defaults come first. Each further one takes the first pair that is missing, and then, for
    one parameter after another, the value that adds the most missing pairs; at a tie, the default.
    """
    domains = {name: values(parameter) for name, parameter in parameters.items()}
    found = [{name: domain[0] for name, domain in domains.items()}]
    if len(domains) == 1:
        ((name, domain),) = domains.items()
        return [{name: value} for value in domain]
    axes = [[(name, value) for value in domain] for name, domain in domains.items()]
    missing = {
        pair
        for first, second in itertools.combinations(axes, 2)
        for pair in itertools.product(first, second)
    }
    order = sorted(missing, key=repr)
    missing -= set(_pairs(found[0], domains))
    while missing:
        chosen = dict(next(pair for pair in order if pair in missing))
        for name, domain in domains.items():
            if name not in chosen:
                gains = [
                    len(missing & set(_pairs({**chosen, name: value}, domains))) for value in domain
                ]
                chosen[name] = domain[gains.index(max(gains))]
        missing -= set(_pairs(chosen, domains))
        found.append({name: chosen[name] for name in domains})
    return found


def _pairs(
    chosen: Mapping[str, Value], order: Mapping[str, object]
) -> Iterator[tuple[tuple[str, Value], tuple[str, Value]]]:
    """Yield the pairs of values in `chosen`, parameters in the given order."""
    present = [(name, chosen[name]) for name in order if name in chosen]
    return itertools.combinations(present, 2)


def variants(method: type[Method]) -> list[Method]:
    """Return the method with every pair of values of its parameters."""
    return [method(**chosen) for chosen in combinations(method.parameters)]


def running(cell: Cell, method: Method, requested: Effect) -> Effect:
    """Return the effects of a cell's picture, of those that its scene requests."""
    return choose_effects(cell.effects, requested) & method.shows


def cells(collection: Collection) -> list[Cell]:
    """Return all cells, scene by scene."""
    found = [cell for scene in SCENES for cell in _of_scene(scene, collection)]
    return list(dict.fromkeys(found))


def _of_scene(scene: str, collection: Collection) -> Iterator[Cell]:
    requested, truth = SCENES[scene]().effects, collection.truth()
    yield from (Cell(scene, truth.label, effects) for effects in effects_axis(requested, truth))
    if scene in SHADOWED:
        for effects in (REQUESTED, _GRAY):
            yield from (Cell(scene, truth.label, effects, shading) for shading in SHADING)
    if scene == METHOD_SCENES[0]:
        yield from (Cell(scene, item.label) for item in collection.expand_methods(FURTHER))
    for name in collection.methods:
        plain = collection.methods[name]()
        rich = bool(plain.expresses & ~_PLAIN)
        if scene in (("lists", ALL_EFFECTS) if rich else METHOD_SCENES):
            yield from (Cell(scene, item.label) for item in variants(type(plain)))
        elif scene in (ALL_EFFECTS, DECALS) or rich:
            yield Cell(scene, plain.label)
        own = requested & plain.expresses & ~Effect.COVERAGE
        kept = {f"-{str(effect.name).lower()}" for effect in Effect if effect & own}
        if rich or scene == ALL_EFFECTS:
            for effects in effects_axis(requested, plain):
                if effects in kept:
                    yield Cell(scene, plain.label, effects)
