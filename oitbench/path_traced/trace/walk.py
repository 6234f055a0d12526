"""Following paths through whatever a scene can express.

A path goes from the eye straight on through films, or in a random direction where it is reflected,
refracted, spread or scattered. Of all places at which a beam or the surroundings could have been
scattered toward the eye, each weighted by the light that would arrive without any shadow, one is
chosen (Talbot et al. 2005, "Importance resampling for global illumination"), and only from there
light is looked for. So a sample's cost grows by one with each layer, not by one walk to each light.

Where nothing is random, as with beams, films and surfaces that mirror nothing, light is looked for
at every layer instead, and the answer is free of noise.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

from oitbench.path_traced.trace.gathering import Choices, Gathering
from oitbench.path_traced.trace.medium import Fog
from oitbench.path_traced.trace.reflection import interface, reflected, scattered
from oitbench.path_traced.trace.surfaces import NOWHERE, Hit, Line, Surfaces
from oitbench.path_traced.trace.surroundings import Surroundings
from oitbench.scene import Scene

MOST_TURNS = 1000
"""Turns after which a path ends: light that is totally reflected in a solid never leaves it."""
FAINT = 0.05
"""Throughput below which a path is ended at random, without bias."""


def is_random(scene: Scene) -> bool:
    """Tell whether light takes random directions in `scene`, or light is looked for at random."""
    materials = [item.material for item in scene.objects]
    passing = [item.material for item in scene.transparent]
    diffuse = any(any(material.albedo) for material in materials)
    return (
        scene.medium is not None
        or any(material.reflectance > 0 and not material.isotropic for material in materials)
        or any(material.refracts or material.collimation < 1 for material in passing)
        or (scene.environment is not None and diffuse)
        # Hundreds of layers would each look for the beams.
        or (bool(scene.beams) and any(item.particles for item in scene.objects))
    )


def is_straight(scene: Scene) -> bool:
    """Tell whether all that `scene` does to light is to tint it."""
    return not scene.lights and not is_random(scene)


@dataclass
class Path:
    """The state of paths.

    Parameters
    ----------
    line : Line
    light : Color3f
        Radiance found so far.
    through : Color3f
        Part of the light from what lies ahead that reaches the eye.
    since : Float
        Metres since the boundary of a solid was last met.
    turns : UInt32
    rng : PCG32
    """

    line: Line
    light: Any
    through: Any
    since: Any
    turns: Any
    rng: Any


class Walk:
    """An integrator: call it with a Mitsuba scene, rays and a seed.

    Parameters
    ----------
    mitsuba : module
        With an LLVM or CUDA variant set.
    scene : Scene
    surfaces : Surfaces
    caustics : CausticMap, optional
    """

    def __init__(self, mitsuba: Any, scene: Scene, surfaces: Surfaces, caustics: Any = None):
        self._mitsuba, self._drjit = mitsuba, importlib.import_module("drjit")
        self._surfaces, self._caustics = surfaces, caustics
        self._random = is_random(scene)
        self._around = Surroundings.build(mitsuba, self._drjit, scene)
        self._fog = None
        if scene.medium is not None and scene.medium.extinction > 0:
            self._fog = Fog.build(mitsuba, self._drjit, scene.medium)
        self._gathering = Gathering(mitsuba, self._drjit, scene, surfaces, self._around, self._fog)

    def __call__(self, exported: Any, ray: Any, seed: int) -> Any:
        """Return the radiance along `ray`."""
        mitsuba, drjit = self._mitsuba, self._drjit
        count = ray.o.shape[1]
        o, d = mitsuba.Point3f(ray.o), mitsuba.Vector3f(ray.d)
        line = Line(o, d, mitsuba.Float(0), mitsuba.UInt32(NOWHERE))
        rng = mitsuba.PCG32(size=count, initstate=drjit.opaque(mitsuba.UInt64, seed))
        color, zero = mitsuba.Color3f, mitsuba.Float(0)
        path = Path(line, color(0), color(1), zero, mitsuba.UInt32(0), rng)
        choices = self._gathering.nothing() if self._random else None
        state = (path, choices, mitsuba.Bool(True))
        path, choices, _ = drjit.while_loop(state, lambda *variables: variables[2], self._advance)
        if choices is None:
            return path.light
        return path.light + self._gathering.chosen_light(choices, path.rng, self._bend)

    def _advance(self, path: Path, choices: Any, active: Any) -> tuple[Any, Any, Any]:
        """Follow paths up to the next place where anything happens."""
        drjit = self._drjit
        hit = self._surfaces.meet(path.line, active)
        if self._fog is not None:
            path, choices, here, active = self._through_fog(path, choices, hit, active)
        else:
            here = active
        missed = here & ~hit.valid
        around = self._around.radiance(path.line.d)
        path.light = path.light + drjit.select(missed, path.through * around, 0)
        met = here & hit.fresh
        path, choices = self._shade(path, choices, hit, met)
        known = here & hit.valid & ~hit.fresh
        path.line = self._surfaces.onward(path.line, hit, known)
        if self._random:
            path = self._pass(path, hit, met)
        else:
            layer = hit.layer
            tau = 1 - layer.coverage + layer.coverage * layer.passing
            path.through = drjit.select(met, path.through * tau, path.through)
            path.line = self._surfaces.onward(path.line, hit, met)
        active = active & ~missed & drjit.any(path.through > 0)
        return self._thinned(path, choices, active)

    def _thinned(self, path: Path, choices: Any, active: Any) -> tuple[Any, Any, Any]:
        """End faint paths at random, and those that are caught in a solid."""
        if not self._random:
            return path, choices, active
        drjit = self._drjit
        kept = drjit.minimum(drjit.max(path.through) / FAINT, 1)
        lives = path.rng.next_float32(active) < kept
        path.through = drjit.select(active & lives, path.through / kept, path.through)
        return path, choices, active & lives & (path.turns < MOST_TURNS)

    def _shade(self, path: Path, choices: Any, hit: Hit, met: Any) -> tuple[Path, Any]:
        """Add emission and caustics, and look for light, or note where it may be looked for."""
        drjit, layer = self._drjit, hit.layer
        if "glows" in self._surfaces.has:
            path.light = path.light + drjit.select(met, path.through * layer.light, 0)
        if self._caustics is not None:
            lambert = met & ~layer.isotropic & ~layer.refracts
            irradiance = self._caustics.irradiance(hit.si, lambert)
            diffuse = layer.coverage * layer.albedo / drjit.pi * irradiance
            path.light = path.light + drjit.select(lambert, path.through * diffuse, 0)
        if choices is None:
            found = self._gathering.light_at(path.line, hit, met)
            path.light = path.light + drjit.select(met, path.through * found, 0)
            return path, choices
        choices, path.rng = self._gathering.offer(
            choices, path.line, hit, path.through, path.rng, met
        )
        return path, choices

    def _through_fog(
        self, path: Path, choices: Choices, hit: Hit, active: Any
    ) -> tuple[Path, Choices, Any, Any]:
        """Scatter the paths that meet the medium before a surface; return which ones do not."""
        drjit, mitsuba, line, fog = self._drjit, self._mitsuba, path.line, self._fog
        assert fog is not None
        at, path.rng = fog.free_path(line.o, line.d, line.along, hit.at, path.rng, active)
        collides = active & (at < drjit.inf)
        p = line.o + line.d * drjit.select(collides, at, 0)
        choices, path.rng = self._gathering.offer_in_fog(
            choices, line, hit.at, path.through, path.rng, active
        )
        two = mitsuba.Point2f(path.rng.next_float32(collides), path.rng.next_float32(collides))
        d = fog.scattered(line.d, two)
        turned = Line(p, d, mitsuba.Float(0), mitsuba.UInt32(NOWHERE))
        path.line = turned.where(drjit, collides, line)
        path.through = drjit.select(collides, path.through * fog.albedo, path.through)
        path.turns = path.turns + drjit.select(collides, mitsuba.UInt32(1), 0)
        return path, choices, active & ~collides, active

    def _pass(self, path: Path, hit: Hit, met: Any) -> Path:
        """Choose what a path does at a surface: go on, be reflected or spread, or enter a solid."""
        drjit, mitsuba, has = self._drjit, self._mitsuba, self._surfaces.has
        layer, line, rng = hit.layer, path.line, path.rng
        film = met & ~layer.refracts
        one = rng.next_float32(film)
        two = mitsuba.Point2f(rng.next_float32(film), rng.next_float32(film))
        spreads = layer.spread > 0
        passing = layer.coverage * layer.passing
        straight = (1 - layer.coverage) + drjit.select(spreads, 0, passing)
        spread = drjit.select(spreads, passing, 0)
        mirror = layer.coverage * layer.fresnel
        parts = [drjit.mean(path.through * part) for part in (straight, spread)]
        parts.append(drjit.mean(path.through) * mirror)
        total = parts[0] + parts[1] + parts[2]
        one = one * total
        goes, spread_on = one < parts[0], one < parts[0] + parts[1]
        weight = drjit.select(
            goes,
            straight / parts[0],
            drjit.select(spread_on, spread / parts[1], mirror / parts[2]),
        )
        weight = drjit.select(total > 0, weight * total, 0)
        onward = film & goes
        path.line = self._surfaces.onward(line, hit, onward)
        d = line.d
        if "spread" in has:
            d = drjit.select(spread_on, scattered(mitsuba, drjit, layer.spread, line.d, two), d)
        if "reflectance" in has:
            mirrored = reflected(mitsuba, drjit, layer.roughness, hit.n, -line.d, two)
            d = drjit.select(spread_on, d, mirrored)
        path.line = self._surfaces.turned(path.line, hit, d, film & ~goes)
        path.turns = path.turns + drjit.select(film & ~goes, mitsuba.UInt32(1), 0)
        path.through = drjit.select(film, path.through * weight, path.through)
        path.since = path.since + drjit.select(film, hit.at - line.along, 0)
        path.rng = rng
        if "refracts" in has:
            path.line, factor, path.since, path.rng = self._bend(
                path.line, hit, path.since, path.rng, met & layer.refracts
            )
            path.through = drjit.select(met & layer.refracts, path.through * factor, path.through)
            path.turns = path.turns + drjit.select(met & layer.refracts, mitsuba.UInt32(1), 0)
        return path

    def _bend(
        self, line: Line, hit: Hit, since: Any, rng: Any, active: Any
    ) -> tuple[Line, Any, Any, Any]:
        """Cross or leave the boundary of a solid; return the factor on what comes from beyond."""
        drjit, mitsuba, layer = self._drjit, self._mitsuba, hit.layer
        one, missing = rng.next_float32(active), rng.next_float32(active)
        two = mitsuba.Point2f(rng.next_float32(active), rng.next_float32(active))
        v, geometric = -line.d, mitsuba.Vector3f(hit.si.n)
        # The interpolated normal, unless it is on the other side than the triangle itself.
        normal = drjit.select(hit.outside, hit.n, -hit.n)
        normal = drjit.select(drjit.dot(normal, geometric) > 0, normal, geometric)
        d, weight, passed = interface(
            mitsuba, drjit, layer.index, layer.facets, normal, v, one, two
        )
        gloss = hit.outside & ~passed & (layer.roughness > 0)
        if "roughness" in self._surfaces.has:
            mirrored = reflected(mitsuba, drjit, layer.roughness, hit.n, v, two)
            d, weight = drjit.select(gloss, mirrored, d), drjit.select(gloss, 1, weight)
        # What passes must be on the other side of the triangle, what is reflected on this one.
        out = drjit.dot(d, geometric)
        wrong = ((out > 0) ^ hit.outside) ^ passed
        d = drjit.select(wrong, d - 2 * out * geometric, d)
        absorbed = drjit.exp(-layer.absorption * (since + hit.at - line.along))
        factor = drjit.select(hit.outside, mitsuba.Color3f(1), absorbed)
        there = missing < layer.coverage
        kept = 1 - layer.albedo * drjit.select(hit.outside, mitsuba.Float(1), 0)
        factor = factor * drjit.select(there, weight, 1)
        factor = drjit.select(there & passed, factor * kept, factor)
        onward = self._surfaces.onward(line, hit, active & ~there)
        turned = self._surfaces.turned(onward, hit, d, active & there)
        return turned, factor, drjit.select(active, 0, since), rng
