"""The effects that a scene can request and a method can express."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Mapping


class Effect(enum.Flag):
    """A phenomenon of transparency. `Scene.effects` derives the effects that a scene requests.

    Only effects that are requested and expressed are simulated; no others cost a target, a pass or
    a macro.
    """

    NONE = 0
    COVERAGE = enum.auto()
    COLORED_TRANSMISSION = enum.auto()
    REFRACTION = enum.auto()
    DIFFUSION = enum.auto()
    SHADOWS = enum.auto()
    TRANSLUCENT_SHADOWS = enum.auto()
    COLORED_SHADOWS = enum.auto()
    CAUSTICS = enum.auto()
    VOLUME = enum.auto()
    AMBIENT_OCCLUSION = enum.auto()
    INFERRED_AO = enum.auto()


REQUESTED_BY: Mapping[Effect, str] = {
    Effect.COVERAGE: "a transparent surface",
    Effect.COLORED_TRANSMISSION: "a transmission that differs between channels",
    Effect.REFRACTION: "a transparent solid with a refractive index other than 1",
    Effect.DIFFUSION: "a collimation below 1, of a surface or of the medium",
    Effect.SHADOWS: "a light and an opaque caster",
    Effect.TRANSLUCENT_SHADOWS: "a light and a transparent caster",
    Effect.COLORED_SHADOWS: "a light and a caster of colored transmission",
    Effect.CAUSTICS: "a light and a refracting caster",
    Effect.VOLUME: "a participating medium",
    Effect.AMBIENT_OCCLUSION: "a radius within which surfaces hide the environment from each other",
    Effect.INFERRED_AO: "such a radius and surfaces of binary coverage",
}
"""The content of a scene that requests each effect."""

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


def effects_of(names: Iterable[str]) -> Effect:
    """Return the effects with the names that `names` gives them."""
    found = Effect.NONE
    for name in names:
        found |= Effect[name]
    return found
