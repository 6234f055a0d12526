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

from oitbench.path_traced.export.texture import FilteredTextures
from oitbench.path_traced.export.view import View
from oitbench.path_traced.optics.reflection import schlick

LIGHT = "vertex_light"
"""Mesh attribute: α·L, where a texture is a factor on both."""
ABSORPTION = "face_absorption"
"""Mesh attribute: α(1 − T(1 − albedo)), where a texture is a factor on α.

It is constant on each triangle. Interpolation between equal vertices would turn 1 into 0.99999998,
and a very bright light would shine through an opaque surface.
"""
COVERAGE = "face_coverage"
"""Mesh attribute: α, on which a texture is a factor."""
REFLECTANCE = "face_reflectance"
"""Mesh attribute: F₀."""
TEXTURE = "face_texture"
"""Mesh attribute: number of the texture plus one; 0 for none."""


@dataclass(frozen=True)
class Film:
    """The optical properties that the BSDF and the emitter of a film share.

    Parameters
    ----------
    mitsuba, drjit : module
        With a variant set.
    view : View
        For the far plane, beyond which nothing is drawn.
    textures : FilteredTextures, optional
        Emission and coverage of textured faces.
    """

    mitsuba: Any
    drjit: Any
    view: View
    textures: FilteredTextures | None = None

    def transmittance(self, si: Any, active: Any) -> Any:
        """Return τ = 1 − α + αt, with t = T (1 − F)(1 − albedo)."""
        color = self.mitsuba.Color3f
        absorption = color(si.shape.eval_attribute_3(ABSORPTION, si, active))
        coverage = si.shape.eval_attribute_1(COVERAGE, si, active)
        reflectance = si.shape.eval_attribute_1(REFLECTANCE, si, active)
        absorption += schlick(self.drjit, reflectance, abs(si.wi.z)) * (coverage - absorption)
        if self.textures is not None:
            absorption = absorption * self._texel(si, active)[3]
        drawn = self.view.before_far_plane(self.mitsuba, self.drjit, si.p)
        return self.drjit.select(drawn, 1 - absorption, color(1))

    def light(self, si: Any, active: Any) -> Any:
        """Return α·L."""
        color = self.mitsuba.Color3f
        light = color(si.shape.eval_attribute_3(LIGHT, si, active))
        if self.textures is not None:
            light = light * color(*self._texel(si, active)[:3])
        drawn = self.view.before_far_plane(self.mitsuba, self.drjit, si.p)
        return self.drjit.select(drawn, light, color(0))

    def _texel(self, si: Any, active: Any) -> list[Any]:
        """Return the factors on α·L and on α at `si`; one where the face has no texture."""
        assert self.textures is not None
        number = self.mitsuba.UInt32(si.shape.eval_attribute_1(TEXTURE, si, active))
        return self.textures.factors(si, number, active)


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
