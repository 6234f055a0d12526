"""The walk through refracting solids and frosted sheets: at each of them the path branches.

A path that leaves a solid is refracted, and its inner reflection is a branch of its own. All
branches are followed to the end, so that no random number chooses between them. Branches that are
left to follow wait on a stack.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from oitbench.effects import Effect
from oitbench.path_traced.matched.straight import Sight, StraightWalk
from oitbench.path_traced.optics.reflection import meet_interface, sample_spread
from oitbench.path_traced.trace.hits import Hit, Line
from oitbench.path_traced.trace.sequence import Turn
from oitbench.path_traced.trace.surfaces import Surfaces

WAITING = 16
"""Branches that can wait at a time; further ones are lost."""
FAINT = 2.0**-12
"""Throughput at which a branch is given up."""
MAX_TURNS = 64
"""Crossings of surfaces of solids after which a branch is given up."""


@dataclass
class Branch:
    """A part of a path that is still to be followed.

    Parameters
    ----------
    line : Line
    throughput : Color3f
    """

    line: Line
    throughput: Any


@dataclass
class Stack:
    """Branches that wait.

    Parameters
    ----------
    columns : tuple of Local
        Origin, direction, start, face and throughput, and the nest of solids.
    top : UInt32
        Number of branches.
    """

    columns: tuple[Any, ...]
    top: Any

    @classmethod
    def empty(cls, mitsuba: Any, drjit: Any, depth: int) -> Stack:
        """Return a stack without branches, for lines whose nests have `depth` elements."""
        place = mitsuba.Point3f, mitsuba.Vector3f, mitsuba.Float, mitsuba.UInt32
        kinds = (*place, mitsuba.Color3f, *([mitsuba.UInt32] * depth))
        columns = tuple(drjit.alloc_local(kind, WAITING) for kind in kinds)
        return cls(columns, mitsuba.UInt32(0))

    def push(self, mitsuba: Any, drjit: Any, branch: Branch, active: Any) -> None:
        """Let `branch` wait where `active`, unless it is faint."""
        kept = active & (drjit.max(branch.throughput) > FAINT) & (self.top < WAITING)
        line = branch.line
        values = line.o, line.d, line.along, line.known, branch.throughput, *line.nest
        for column, value in zip(self.columns, values, strict=True):
            column.write(value, self.top, active=kept)
        self.top = self.top + drjit.select(kept, mitsuba.UInt32(1), 0)

    def pop(self, mitsuba: Any, drjit: Any, active: Any) -> tuple[Branch, Any]:
        """Return the last branch where `active`, and where there is one."""
        found = active & (self.top > 0)
        self.top = self.top - drjit.select(found, mitsuba.UInt32(1), 0)
        o, d, along, known, throughput, *nest = (
            column.read(self.top, active=found) for column in self.columns
        )
        return Branch(Line(o, d, along, known, tuple(nest)), throughput), found


class BranchingWalk(StraightWalk):
    """An integrator like `StraightWalk`, with refraction and diffusion as far as they run.

    A solid's outer surface mirrors as any surface does: its shading has F times the mirrored
    environment, and 1 − F enters. Inside, the Fresnel equations divide the light. Beer–Lambert
    absorbs it. Diffusion draws random numbers for the directions.
    """

    @staticmethod
    def needed(surfaces: Surfaces, effects: Effect) -> bool:
        """Return whether paths branch under `effects`."""
        refracts = Effect.REFRACTION in effects and "refracts" in surfaces.has
        return refracts or (Effect.DIFFUSION in effects and "spread" in surfaces.has)

    def __call__(self, content: Any, ray: Any, turn: Turn) -> Any:
        """Return the radiance along `ray`."""
        mitsuba, drjit = self._mitsuba, self._drjit
        sight = self._start(ray, turn)
        stack = Stack.empty(mitsuba, drjit, len(sight.line.nest))
        state = sight, mitsuba.UInt32(0), mitsuba.UInt32(0), stack, mitsuba.Bool(True)
        return drjit.while_loop(state, lambda *v: v[4], self._follow)[0].light

    def _follow(
        self, sight: Sight, turns: Any, spread: Any, stack: Stack, active: Any
    ) -> tuple[Any, ...]:
        """Go on behind the next surface, or with a branch that waits.

        `spread` is how often surfaces have spread the path so far.
        """
        mitsuba, drjit = self._mitsuba, self._drjit
        hit = self._surfaces.intersect(sight.line, active)
        passing = self._surfaces.passing(sight.line, hit.at, active)
        sight.throughput = sight.throughput * self._perceived(passing)
        solid = hit.fresh & hit.layer.refracts & (Effect.REFRACTION in self._effects)
        self._look(sight, hit, hit.fresh & ~(solid & hit.inner), active)
        two = mitsuba.Point2f(0.5, 0.5)
        if Effect.DIFFUSION in self._effects:
            rng = sight.rng
            two = mitsuba.Point2f(rng.next_float32(hit.fresh), rng.next_float32(hit.fresh))
            assert sight.choices is not None
            # A path is spread by independent numbers: as it enters a pane and as it leaves it.
            two = drjit.select(spread == 1, sight.choices.sky, two)
            two = drjit.select(spread == 0, sight.choices.facet, two)
            rough = drjit.select(solid, hit.layer.facets, hit.layer.spread) > 0
            spread = spread + drjit.select(hit.fresh & rough, mitsuba.UInt32(1), 0)
        self._pass_film(sight, hit, stack, two, hit.fresh & ~solid)
        self._cross(sight, hit, stack, two, solid)
        sight.line = sight.line.onward(drjit, hit, hit.valid & ~hit.fresh)
        turns = turns + drjit.select(solid, mitsuba.UInt32(1), 0)
        goes_on = hit.valid & (drjit.max(sight.throughput) > FAINT) & (turns < MAX_TURNS)
        branch, found = stack.pop(mitsuba, drjit, active & ~goes_on)
        sight.line = branch.line.where(drjit, found, sight.line)
        sight.throughput = drjit.select(found, branch.throughput, sight.throughput)
        turns = drjit.select(found, 0, turns)
        spread = drjit.select(found, MAX_TURNS, spread)
        return sight, turns, spread, stack, goes_on | found

    def _pass_film(self, sight: Sight, hit: Hit, stack: Stack, two: Any, film: Any) -> None:
        """Go straight on behind a film, or into a random direction behind a frosted one."""
        mitsuba, drjit, layer = self._mitsuba, self._drjit, hit.layer
        straight = sight.line.onward(drjit, hit, film)
        part = self._perceived(layer.transmittance)
        line = straight
        if Effect.DIFFUSION in self._effects:
            frosted = film & (layer.spread > 0)
            beside = Branch(straight, sight.throughput * (1 - layer.coverage))
            stack.push(mitsuba, drjit, beside, frosted)
            passed = self._perceived(layer.coverage * layer.passing)
            part = drjit.select(frosted, passed, part)
            d = sample_spread(mitsuba, drjit, layer.spread, sight.line.d, two)
            line = sight.line.turned(drjit, hit, d, frosted).where(drjit, frosted, straight)
        sight.throughput = drjit.select(film, sight.throughput * part, sight.throughput)
        sight.line = line.where(drjit, film, sight.line)

    def _cross(self, sight: Sight, hit: Hit, stack: Stack, two: Any, solid: Any) -> None:
        """Refract the path at the boundary of a solid."""
        mitsuba, drjit, layer = self._mitsuba, self._drjit, hit.layer
        geometric = mitsuba.Vector3f(hit.si.n)
        # The interpolated normal, unless it is on the other side of the triangle.
        normal = drjit.select(hit.outside, hit.n, -hit.n)
        normal = drjit.select(drjit.dot(normal, geometric) > 0, normal, geometric)
        alpha = layer.facets if Effect.DIFFUSION in self._effects else mitsuba.Float(0)
        found = meet_interface(mitsuba, drjit, layer.index, alpha, normal, hit.si.wi, two)
        through, line = sight.throughput, sight.line
        beside = Branch(line.onward(drjit, hit, solid), through * (1 - layer.coverage))
        stack.push(mitsuba, drjit, beside, solid & (layer.coverage < 1))
        within, total = solid & hit.inner, found.reflectance >= 1
        covered = through * layer.coverage
        # Reflected light stays on its side of the triangle, refracted light is on the other one.
        mirrored = _on_side(drjit, found.mirrored, geometric, hit.outside)
        refracted = _on_side(drjit, found.refracted, geometric, ~hit.outside)
        inner = covered * found.mirrored_part * found.reflectance
        reflected = Branch(line.turned(drjit, hit, mirrored, solid), inner)
        stack.push(mitsuba, drjit, reflected, within & ~total)
        entering = self._perceived((1 - layer.albedo) * (1 - layer.fresnel))
        passed = drjit.select(hit.inner, mitsuba.Color3f(1 - found.reflectance), entering)
        passed = covered * found.refracted_part * passed
        kept = within & total
        through = drjit.select(kept, inner, drjit.select(solid, passed, through))
        sight.throughput = through
        d = drjit.select(kept, mirrored, refracted)
        sight.line = line.turned(drjit, hit, d, solid, ~kept)


def _on_side(drjit: Any, d: Any, normal: Any, front: Any) -> Any:
    """Return `d`, mirrored if it is not on the wanted side of the plane with `normal`."""
    out = drjit.dot(d, normal)
    return drjit.select((out > 0) ^ front, d - 2 * out * normal, d)
