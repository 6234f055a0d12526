"""The inputs that shading adds to the shaders of a pass: GLSL, samplers and uniform blocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import moderngl

Sampled = moderngl.Texture | moderngl.TextureArray | moderngl.Texture3D
"""Textures that a sampler can be bound to."""


@dataclass(frozen=True)
class ShadingInputs:
    """Text and resources for the shaders of all passes of a frame.

    Parameters
    ----------
    lit : bool
        Whether there are lights or a medium; without them only emission shines.
    lights : str
        Macros of `lighting.glsl`.
    shadows : str
        Samplers of shadow maps, and the function `beam_visibility` that reads them.
    medium : str
        Macros of `medium.glsl`; empty unless the medium runs.
    occluded : bool
        Whether surfaces hide the environment from each other.
    samplers : mapping of str to texture
    blocks : mapping of int to moderngl.Buffer
        Uniform blocks by binding.
    """

    lit: bool = False
    lights: str = "#define BEAMS 0"
    shadows: str = "vec3 beam_visibility(int i, Receiver receiver) { return vec3(1.0); }"
    medium: str = ""
    occluded: bool = False
    samplers: Mapping[str, Sampled] = field(default_factory=dict)
    blocks: Mapping[int, moderngl.Buffer] = field(default_factory=dict)

    def with_occlusion(self, samplers: Mapping[str, Sampled]) -> ShadingInputs:
        """Return the same inputs with the textures of ambient occlusion."""
        return replace(self, occluded=True, samplers={**self.samplers, **samplers})


UNLIT = ShadingInputs()
"""Shading by emission alone."""
