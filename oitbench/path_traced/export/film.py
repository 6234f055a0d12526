# mypy: allow-subclassing-any
"""A film: a surface that covers, transmits and glows, as a BSDF and an emitter for Mitsuba.

A film of coverage α and transmission t lets light through straight, times τ = 1 − α + αt, and adds
α·L, seen from either side. No plugin of Mitsuba does this: `mask` has no colored transmission, and
`area` lights shine to one side only and have no opacity. The BSDF and the emitter defined here draw
no random numbers, so the path-traced image of a stack of films is free of noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from oitbench.path_traced.export.variation import Factors, Variation
from oitbench.path_traced.export.view import View
from oitbench.path_traced.optics.reflection import schlick

LIGHT = "vertex_light"
"""Mesh attribute: α·L, on which `Variation` has a factor."""
ABSORPTION = "face_absorption"
"""Mesh attribute: α(1 − T(1 − albedo)), where `Variation` has a factor on α alone.

It is constant on each triangle. Interpolation between equal vertices would turn 1 into 0.99999998,
and a very bright light would shine through an opaque surface.
"""
COVERAGE, TRANSMISSION, ALBEDO = "face_coverage", "face_transmission", "face_albedo"
"""Mesh attributes: α, T and albedo, on which `Variation` has factors. The last two are there if
they vary."""
REFLECTANCE = "face_reflectance"
"""Mesh attribute: F₀."""
COLUMN = "face_varied_"
"""Prefix of the mesh attributes for the columns of `Variation`."""


@dataclass(frozen=True)
class Film:
    """The optical properties that the BSDF and the emitter of a film share.

    Parameters
    ----------
    mitsuba, drjit : module
        With a variant set.
    view : View
        For the far plane, beyond which nothing is drawn.
    variation : Variation
        Textures, factors of vertices, cutoffs and culling.
    """

    mitsuba: Any
    drjit: Any
    view: View
    variation: Variation

    def transmittance(self, si: Any, active: Any) -> Any:
        """Return τ = 1 − α + αt, with t = T (1 − F)(1 − albedo)."""
        color, shape, factors = self.mitsuba.Color3f, si.shape, self._factors(si, active)
        coverage = shape.eval_attribute_1(COVERAGE, si, active)
        if self.variation.inner:
            kept = color(shape.eval_attribute_3(TRANSMISSION, si, active))
            albedo = color(shape.eval_attribute_3(ALBEDO, si, active))
            kept = kept if factors.transmission is None else kept * factors.transmission
            albedo = albedo if factors.albedo is None else albedo * factors.albedo
            absorption = coverage * (1 - kept * (1 - albedo))
        else:
            absorption = color(shape.eval_attribute_3(ABSORPTION, si, active))
        reflectance = shape.eval_attribute_1(REFLECTANCE, si, active)
        absorption += schlick(self.drjit, reflectance, abs(si.wi.z)) * (coverage - absorption)
        if factors.coverage is not None:
            absorption = absorption * factors.coverage
        drawn = self.view.before_far_plane(self.mitsuba, self.drjit, si.p)
        return self.drjit.select(drawn, 1 - absorption, color(1))

    def light(self, si: Any, active: Any) -> Any:
        """Return α·L."""
        color = self.mitsuba.Color3f
        light = color(si.shape.eval_attribute_3(LIGHT, si, active))
        factor = self._factors(si, active).light
        if factor is not None:
            light = light * factor
        drawn = self.view.before_far_plane(self.mitsuba, self.drjit, si.p)
        return self.drjit.select(drawn, light, color(0))

    def _factors(self, si: Any, active: Any) -> Factors:
        columns = self.variation.columns
        numbers = {one: si.shape.eval_attribute_1(COLUMN + one, si, active) for one in columns}
        outside = self.drjit.dot(si.n, si.to_world(si.wi)) > 0
        return self.variation.at(si, numbers, outside, active)


def make_bsdf(film: Film) -> Any:
    """Return a Mitsuba BSDF that always continues straight, with the weight τ.

    The integrators of this package call `eval_null_transmission` alone. Mitsuba's `volpath`, with
    which the tests compare, calls `sample`, and drjit also records `eval` and `pdf` there.
    """
    mitsuba, drjit = film.mitsuba, film.drjit

    base: Any = mitsuba.BSDF

    class Straight(base):
        def __init__(self) -> None:
            super().__init__(mitsuba.Properties("film"))
            sides = mitsuba.BSDFFlags.FrontSide | mitsuba.BSDFFlags.BackSide
            self.m_components = [mitsuba.BSDFFlags.Null | sides]
            self.m_flags = self.m_components[0]

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any) -> Any:
            sample = drjit.zeros(mitsuba.BSDFSample3f)
            sample.wo = -si.wi
            sample.pdf = 1
            sample.eta = 1
            sample.sampled_type = mitsuba.UInt32(+mitsuba.BSDFFlags.Null)
            return sample, film.transmittance(si, active)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any) -> Any:
            return mitsuba.Color3f(0)

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any) -> Any:
            return mitsuba.Float(0)

        def eval_null_transmission(self, si: Any, active: Any) -> Any:
            return film.transmittance(si, active)

        def to_string(self) -> str:
            return "Film"

    return Straight()


def make_emitter(film: Film) -> Any:
    """Return a Mitsuba emitter that shows α·L on both sides of its surface.

    Rays hit this emitter; it is never sampled, because films scatter nothing. In `volpath`, with
    which the tests compare, drjit records `sample_direction` and `pdf_direction` nevertheless, so
    they return zeros.
    """
    mitsuba, drjit = film.mitsuba, film.drjit

    base: Any = mitsuba.Emitter

    class Glow(base):
        def __init__(self) -> None:
            super().__init__(mitsuba.Properties("glow"))
            self.m_flags = mitsuba.EmitterFlags.Surface

        def eval(self, si: Any, active: Any) -> Any:
            return film.light(si, active)

        def sample_direction(self, it: Any, sample: Any, active: Any) -> Any:
            return drjit.zeros(mitsuba.DirectionSample3f), mitsuba.Color3f(0)

        def pdf_direction(self, it: Any, ds: Any, active: Any) -> Any:
            return mitsuba.Float(0)

        def to_string(self) -> str:
            return "Glow"

    return Glow()
