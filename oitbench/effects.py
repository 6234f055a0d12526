"""The effects that a scene can request and a method can express."""

from __future__ import annotations

import enum


class Effect(enum.Flag):
    """A phenomenon of transparency. `Scene.effects` derives the effects that a scene requests.

    Only effects that are requested and expressed are simulated; no others cost a target, a pass or
    a macro.
    """

    NONE = 0
    COVERAGE = enum.auto()
    """Some surface has an opacity below one."""
    COLORED_TRANSMISSION = enum.auto()
    """Some transmission differs between wavelengths."""
    REFRACTION = enum.auto()
    """Some solid has a refractive index other than one."""
    DIFFUSION = enum.auto()
    """Some collimation is below one: transmitted light is spread."""
    SHADOWS = enum.auto()
    """A light and an opaque caster."""
    TRANSLUCENT_SHADOWS = enum.auto()
    """A light and a transparent caster."""
    COLORED_SHADOWS = enum.auto()
    """A light and a caster of wavelength-varying transmission."""
    CAUSTICS = enum.auto()
    """A light and a refracting caster."""
    VOLUME = enum.auto()
    """A participating medium."""
    AMBIENT_OCCLUSION = enum.auto()
    """Surfaces hide the environment light from each other."""
    INFERRED_AO = enum.auto()
    """Ambient occlusion over foliage of binary coverage."""


SHADING = (
    Effect.SHADOWS
    | Effect.TRANSLUCENT_SHADOWS
    | Effect.COLORED_SHADOWS
    | Effect.CAUSTICS
    | Effect.AMBIENT_OCCLUSION
    | Effect.INFERRED_AO
)
"""Effects of shading, before compositing; they are the same for every method."""


def names(effects: Effect) -> list[str]:
    """Return the names of the single effects in `effects`, in order of definition."""
    return [e.name for e in Effect if e in effects and e.name and e is not Effect.NONE]
