"""Light that leaves a surface toward the eye: emission, beams and the environment."""

from __future__ import annotations

import math
from typing import Any

from oitbench.path_traced.matched.environment import OpenEnvironment
from oitbench.path_traced.matched.openness import Openness
from oitbench.path_traced.matched.visibility import BeamVisibility
from oitbench.path_traced.photons.map import CausticMap
from oitbench.path_traced.trace.hits import Hit
from oitbench.path_traced.trace.lights import TracedBeam
from oitbench.path_traced.trace.surfaces import Surfaces
from oitbench.scene import Scene


class Shading:
    """The formulas of "Reflection" in CONVENTIONS.md, with true visibility and true integrals.

    Parameters
    ----------
    mitsuba, drjit : module
    scene : Scene
    surfaces : Surfaces
    environment : OpenEnvironment
    visibility : BeamVisibility
    openness : Openness or None
        None unless ambient occlusion runs.
    caustics : CausticMap or None
        Light that solids have bent, if it runs.

    Attributes
    ----------
    beams : list of TracedBeam
    visibility : BeamVisibility
    """

    def __init__(
        self,
        mitsuba: Any,
        drjit: Any,
        scene: Scene,
        surfaces: Surfaces,
        environment: OpenEnvironment,
        visibility: BeamVisibility,
        openness: Openness | None = None,
        caustics: CausticMap | None = None,
    ) -> None:
        self._mitsuba, self._drjit, self._has = mitsuba, drjit, surfaces.has
        self._environment, self._openness, self._caustics = environment, openness, caustics
        self.visibility = visibility
        self.beams = [TracedBeam(mitsuba, drjit, light) for light in scene.beams]

    def light(self, hit: Hit, rng: Any, active: Any, share: Any = 1) -> Any:
        """Return α·L at `hit`, Color3f; `rng` is needed for occlusion alone.

        `share` is a random factor on the light of beams, of mean one.
        """
        total = self._mitsuba.Color3f(0)
        if "glows" in self._has:
            total += hit.layer.light
        if self._has & {"albedo", "reflectance"}:
            total += share * self._beam_light(hit, active & (share > 0))
            if self._caustics is not None:
                total += self._bent_light(self._caustics, hit, active)
            if self._environment.lights:
                total += hit.layer.coverage * self._environment_light(hit, rng, active)
        return total

    def _beam_light(self, hit: Hit, active: Any) -> Any:
        mitsuba, drjit = self._mitsuba, self._drjit
        total = mitsuba.Color3f(0)
        for beam in self.beams:
            toward, distance, arriving = beam.toward(hit.si.p)
            value = hit.scattering(drjit, toward, "reflectance" in self._has) * arriving
            lit = active & drjit.any(value > 0)
            line = hit.leaving(mitsuba, drjit, toward)
            part = self.visibility.along(line, hit.shadowed_up_to(drjit, distance), lit)
            total += drjit.select(lit, value * part, 0)
        return total

    def _bent_light(self, caustics: CausticMap, hit: Hit, active: Any) -> Any:
        drjit, layer = self._drjit, hit.layer
        lambert = active & ~layer.isotropic & ~layer.refracts
        diffuse = layer.coverage * layer.albedo / drjit.pi
        return drjit.select(lambert, diffuse * caustics.irradiance(hit.si, lambert), 0)

    def _environment_light(self, hit: Hit, rng: Any, active: Any) -> Any:
        mitsuba, drjit, layer = self._mitsuba, self._drjit, hit.layer
        total = mitsuba.Color3f(0)
        if "albedo" in self._has:
            lambert = self._environment.irradiance(hit.n) / math.pi
            mean = drjit.select(layer.isotropic, self._environment.mean, lambert)
            diffuse = layer.albedo * mean
            if self._openness is not None:
                lit = active & drjit.any(diffuse > 0)
                diffuse = diffuse * self._openness.at(hit, rng, lit)
            total += diffuse
        if "reflectance" in self._has:
            total += self._environment.mirrored(hit, active)
        return total
