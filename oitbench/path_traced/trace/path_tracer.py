"""The general integrator, for all that a scene can express.

A path starts at the eye. It continues straight through films, and in a random direction where it is
reflected, refracted, spread by a frosted sheet or scattered by a medium. The light of beams and of
the environment is found by next-event estimation from one point of the path (see `next_event`).
The cost of a sample thus grows by one intersection with each layer, and not by one shadow ray to
each light.

Some scenes have lights but need no random numbers: only beams, and films that mirror nothing. There
the path looks for light at every layer, and the image is free of noise.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from typing import Any

from oitbench.path_traced.optics.reflection import (
    sample_interface,
    sample_reflection,
    sample_spread,
)
from oitbench.path_traced.photons.map import CausticMap
from oitbench.path_traced.trace.hits import Hit, Line
from oitbench.path_traced.trace.lights import TracedEnvironment
from oitbench.path_traced.trace.medium import TracedMedium
from oitbench.path_traced.trace.next_event import LightSampler
from oitbench.path_traced.trace.reservoirs import Reservoirs
from oitbench.path_traced.trace.sequence import EVEN_BOUNCES, Choices, Turn
from oitbench.path_traced.trace.surfaces import Surfaces
from oitbench.scene import Scene

MAX_BOUNCES = 1000
"""Bounces after which a path ends. Light that is totally reflected in a solid never leaves it."""
FAINT = 0.05
"""Throughput below which Russian roulette ends a path, without bias."""


def is_random(scene: Scene) -> bool:
    """Return whether paths in `scene` need random numbers, for directions or to look for light."""
    materials = [item.material for item in scene.objects]
    diffuse = any(material.diffuse for material in materials)
    return (
        scene.medium is not None
        or any(material.reflectance > 0 and not material.isotropic for material in materials)
        or any(item.refracts or item.material.collimation < 1 for item in scene.transparent)
        or (scene.environment is not None and diffuse)
        # A ray may cross hundreds of particles, and each would look for the beams.
        or (bool(scene.beams) and any(item.particles for item in scene.objects))
    )


@dataclass
class Path:
    """The state of a path.

    Parameters
    ----------
    line : Line
    light : Color3f
        Radiance found so far.
    throughput : Color3f
        Part of the light from ahead that reaches the eye.
    bounces : UInt32
        How often the path has changed its direction.
    choices : Choices
        Random numbers for the first choices, as far as they are not spent.
    rng : PCG32
        For all others.
    """

    line: Line
    light: Any
    throughput: Any
    bounces: Any
    choices: Choices
    rng: Any

    def draw(self, drjit: Any, even: Any, active: Any) -> Any:
        """Return the random number `even`, or another one if the path has turned often."""
        early = self.bounces < EVEN_BOUNCES
        return drjit.select(early, even, self.rng.next_float32(active))

    def draw_pair(self, drjit: Any, even: Any, active: Any) -> Any:
        """Return the two random numbers `even`, or others, as `draw` does."""
        return type(even)(*(self.draw(drjit, part, active) for part in even))

    def draw_facet(self, drjit: Any, active: Any) -> Any:
        """Return two random numbers for a direction in which the path goes on.

        Directions of one path must be independent, so only the first one is evenly spread.
        """
        even = self.choices.facet
        other = type(even)(self.rng.next_float32(active), self.rng.next_float32(active))
        return drjit.select(self.bounces == 0, even, other)


class PathTracer:
    """An integrator (see `integrators.Integrator`).

    Parameters
    ----------
    mitsuba : module
        With an LLVM or CUDA variant set.
    scene : Scene
    surfaces : Surfaces
    caustics : CausticMap or None
    """

    def __init__(
        self, mitsuba: Any, scene: Scene, surfaces: Surfaces, caustics: CausticMap | None
    ) -> None:
        self._mitsuba, self._drjit = mitsuba, importlib.import_module("drjit")
        self._surfaces, self._caustics = surfaces, caustics
        self._random = is_random(scene)
        self._environment = TracedEnvironment.build(mitsuba, self._drjit, scene)
        self._medium = None
        if scene.medium is not None and scene.medium.extinction > 0:
            self._medium = TracedMedium.build(mitsuba, self._drjit, scene.medium)
        # Radiance grows by N² inside a solid. The camera measures it as if it were outside.
        around = 1.0 if surfaces.solids is None else surfaces.solids.index_around()
        self._basic = around**-2
        self._sampler = LightSampler(
            mitsuba, self._drjit, scene, surfaces, self._environment, self._medium
        )

    def __call__(self, content: Any, ray: Any, turn: Turn) -> Any:
        """Return the radiance along `ray`."""
        mitsuba, drjit = self._mitsuba, self._drjit
        count = ray.o.shape[1]
        line = self._surfaces.eye_line(ray.o, ray.d)
        rng = mitsuba.PCG32(size=count, initstate=drjit.opaque(mitsuba.UInt64, turn.seed))
        color = mitsuba.Color3f
        choices = turn.choices(mitsuba, drjit, count)
        path = Path(line, color(0), color(self._basic), mitsuba.UInt32(0), choices, rng)
        reservoirs = self._sampler.empty() if self._random else None
        state = (path, reservoirs, mitsuba.Bool(True))
        path, reservoirs, _ = drjit.while_loop(state, lambda *v: v[2], self._advance)
        if reservoirs is None:
            return path.light
        return path.light + self._sampler.selected_light(reservoirs, path.rng, self._cross)

    def _advance(self, path: Path, reservoirs: Any, active: Any) -> tuple[Any, Any, Any]:
        """Follow paths to their next hit or scattering event."""
        drjit = self._drjit
        hit = self._surfaces.intersect(path.line, active)
        here = active
        if self._medium is None:
            passing = self._surfaces.passing(path.line, hit.at, active)
            path.throughput = path.throughput * passing
        else:
            path, reservoirs, here = self._scatter_in_medium(path, reservoirs, hit, active)
        missed = here & ~hit.valid
        environment = self._environment.radiance(path.line.d)
        path.light = path.light + drjit.select(missed, path.throughput * environment, 0)
        struck = here & hit.fresh
        path, reservoirs = self._shade(path, reservoirs, hit, struck)
        known = here & hit.valid & ~hit.fresh
        path.line = path.line.onward(drjit, hit, known)
        if self._random:
            path = self._pass(path, hit, struck)
        else:
            passed = path.throughput * hit.layer.transmittance
            path.throughput = drjit.select(struck, passed, path.throughput)
            path.line = path.line.onward(drjit, hit, struck)
        active = active & ~missed & drjit.any(path.throughput > 0)
        return self._thinned(path, reservoirs, active)

    def _thinned(self, path: Path, reservoirs: Any, active: Any) -> tuple[Any, Any, Any]:
        """End faint paths by Russian roulette, and paths with too many bounces."""
        if not self._random:
            return path, reservoirs, active
        drjit = self._drjit
        kept = drjit.minimum(drjit.max(path.throughput) / FAINT, 1)
        lives = path.rng.next_float32(active) < kept
        path.throughput = drjit.select(active & lives, path.throughput / kept, path.throughput)
        return path, reservoirs, active & lives & (path.bounces < MAX_BOUNCES)

    def _shade(self, path: Path, reservoirs: Any, hit: Hit, struck: Any) -> tuple[Path, Any]:
        """Add emission and caustics, and either the light of beams or candidates for light."""
        drjit, layer = self._drjit, hit.layer
        if "glows" in self._surfaces.has:
            path.light = path.light + drjit.select(struck, path.throughput * layer.light, 0)
        if self._caustics is not None:
            lambert = struck & ~layer.isotropic & ~layer.refracts
            irradiance = self._caustics.irradiance(hit.si, lambert)
            diffuse = layer.coverage * layer.albedo / drjit.pi * irradiance
            path.light = path.light + drjit.select(lambert, path.throughput * diffuse, 0)
        if reservoirs is None:
            found = self._sampler.beam_light(path.line, hit, struck)
            path.light = path.light + drjit.select(struck, path.throughput * found, 0)
            return path, reservoirs
        choices = path.choices
        look = path.draw(drjit, choices.source, struck), path.draw_pair(drjit, choices.sky, struck)
        reservoirs, path.rng = self._sampler.add_surface(
            reservoirs, hit, path.throughput, look, path.rng, struck
        )
        return path, reservoirs

    def _scatter_in_medium(
        self, path: Path, reservoirs: Reservoirs, hit: Hit, active: Any
    ) -> tuple[Path, Reservoirs, Any]:
        """Scatter the paths that collide before `hit`; return also which paths do not."""
        drjit, mitsuba, line, medium = self._drjit, self._mitsuba, path.line, self._medium
        assert medium is not None
        straight, choices, sampler = path.bounces == 0, path.choices, self._sampler
        part = line.o, line.d, line.along, hit.at
        free, path.rng = medium.sample_free_path(*part, path.rng, active & ~straight)
        at, choices.reach = medium.spend(*part, choices.reach, active & straight)
        at = drjit.select(straight, at, free)
        collides = active & (at < drjit.inf)
        p = line.o + line.d * drjit.select(collides, at, 0)
        end, through = hit.at, path.throughput
        place = path.draw(drjit, choices.place, active)
        single, path.rng = sampler.add_medium(
            reservoirs.single_beam, line, end, through, choices.place, path.rng, active & straight
        )
        several, path.rng = sampler.add_medium(
            reservoirs.medium_beam, line, end, through, place, path.rng, active & ~straight
        )
        reservoirs = replace(reservoirs, single_beam=single, medium_beam=several)
        two = path.draw_facet(drjit, collides)
        d = medium.sample_phase(line.d, two)
        passing = self._surfaces.passing(line, drjit.minimum(at, hit.at), active)
        path.throughput = path.throughput * passing
        path.line = line.scattered(p, d).where(drjit, collides, line)
        path.throughput = drjit.select(collides, path.throughput * medium.albedo, path.throughput)
        path.bounces = path.bounces + drjit.select(collides, mitsuba.UInt32(1), 0)
        return path, reservoirs, active & ~collides

    def _pass(self, path: Path, hit: Hit, struck: Any) -> Path:
        """Choose how a path continues at a surface.

        It goes straight on, is reflected, is spread by a frosted sheet, or crosses the boundary of
        a refracting solid.
        """
        drjit, mitsuba, has = self._drjit, self._mitsuba, self._surfaces.has
        layer, line = hit.layer, path.line
        film, choices = struck & ~layer.refracts, path.choices
        one = path.draw(drjit, choices.side, struck)
        two = path.draw_facet(drjit, struck)
        pair = one, two
        spreads = layer.spread > 0
        passing = layer.coverage * layer.passing
        straight = (1 - layer.coverage) + drjit.select(spreads, 0, passing)
        spread = drjit.select(spreads, passing, 0)
        mirror = layer.coverage * layer.fresnel
        parts = [drjit.mean(path.throughput * part) for part in (straight, spread)]
        parts.append(drjit.mean(path.throughput) * mirror)
        total = parts[0] + parts[1] + parts[2]
        one = one * total
        goes, spread_on = one < parts[0], one < parts[0] + parts[1]
        weight = drjit.select(
            goes,
            straight / parts[0],
            drjit.select(spread_on, spread / parts[1], mirror / parts[2]),
        )
        weight = drjit.select(total > 0, weight * total, 0)
        # A number that has decided is uniform within its interval, which is stretched again.
        past = drjit.select(goes, 0, drjit.select(spread_on, parts[0], parts[0] + parts[1]))
        part = drjit.select(goes, parts[0], drjit.select(spread_on, parts[1], parts[2]))
        rest = drjit.clip((one - past) / drjit.maximum(part, 1e-30), 0, 1 - 2**-24)
        choices.side = drjit.select(film, rest, choices.side)
        path.line = line.onward(drjit, hit, film & goes)
        d = line.d
        if "spread" in has:
            d = drjit.select(spread_on, sample_spread(mitsuba, drjit, layer.spread, line.d, two), d)
        if "reflectance" in has:
            mirrored = sample_reflection(mitsuba, drjit, layer.roughness, hit.n, -line.d, two)
            d = drjit.select(spread_on, d, mirrored)
        path.line = path.line.turned(drjit, hit, d, film & ~goes)
        path.bounces = path.bounces + drjit.select(film & ~goes, mitsuba.UInt32(1), 0)
        path.throughput = drjit.select(film, path.throughput * weight, path.throughput)
        if "refracts" in has:
            solid = struck & layer.refracts
            path.line, factor, rest, path.rng = self._cross(path.line, hit, *pair, path.rng, solid)
            choices.side = drjit.select(solid, rest, choices.side)
            path.throughput = drjit.select(solid, path.throughput * factor, path.throughput)
            path.bounces = path.bounces + drjit.select(solid, mitsuba.UInt32(1), 0)
        return path

    def _cross(
        self, line: Line, hit: Hit, one: Any, two: Any, rng: Any, active: Any
    ) -> tuple[Line, Any, Any, Any]:
        """Refract or reflect a line at the boundary of a solid.

        Return the new line, the factor on the radiance from beyond, a random number that `one`
        leaves, and the generator of random numbers.
        """
        drjit, mitsuba, layer = self._drjit, self._mitsuba, hit.layer
        missing = rng.next_float32(active)
        v, geometric = -line.d, mitsuba.Vector3f(hit.si.n)
        # The interpolated normal, unless it is on the other side of the triangle.
        normal = drjit.select(hit.outside, hit.n, -hit.n)
        normal = drjit.select(drjit.dot(normal, geometric) > 0, normal, geometric)
        d, weight, passed, rest = sample_interface(
            mitsuba, drjit, layer.index, layer.facets, normal, v, one, two
        )
        gloss = hit.outside & ~passed & (layer.roughness > 0)
        if "roughness" in self._surfaces.has:
            mirrored = sample_reflection(mitsuba, drjit, layer.roughness, hit.n, v, two)
            d, weight = drjit.select(gloss, mirrored, d), drjit.select(gloss, 1, weight)
        # Refracted light must be on the other side of the triangle, reflected light on this side.
        out = drjit.dot(d, geometric)
        wrong = ((out > 0) ^ hit.outside) ^ passed
        d = drjit.select(wrong, d - 2 * out * geometric, d)
        there = missing < layer.coverage
        kept = 1 - layer.albedo * drjit.select(hit.outside, mitsuba.Float(1), 0)
        factor = mitsuba.Color3f(drjit.select(there, weight, 1))
        factor = drjit.select(there & passed, factor * kept, factor)
        onward = line.onward(drjit, hit, active & ~there)
        return onward.turned(drjit, hit, d, active & there, passed), factor, rest, rng
