"""Facts about OpenGL drivers, as tables; no driver is loaded."""

from __future__ import annotations

from collections.abc import Mapping

CAPABILITIES: Mapping[str, tuple[str, ...]] = {
    "dual_source": ("GL_ARB_blend_func_extended",),
    "framebuffer_fetch": ("GL_EXT_shader_framebuffer_fetch",),
    "interlock": ("GL_ARB_fragment_shader_interlock",),
    "image_load_store": ("GL_ARB_shader_image_load_store",),
    "post_depth_coverage": ("GL_ARB_post_depth_coverage",),
}
"""Capability names for `Method.requires`; any one of the extensions provides the capability.

They are those that shaders name: others of the same kind have other functions in GLSL.
"""

FETCH, INTERLOCK, SPIN_LOCK = "framebuffer fetch", "interlock", "spin lock"
ATOMICS = "atomics"
"""Way of counting in a target that framebuffer fetch does not reach."""
MECHANISMS: Mapping[str, str] = {
    FETCH: "framebuffer_fetch",
    INTERLOCK: "interlock",
    SPIN_LOCK: "image_load_store",
}
"""Ways of programmable blending, best first, and the capability that each needs."""

_SOFTWARE_RENDERERS = ("llvmpipe", "softpipe", "swrast", "swiftshader", "lavapipe")
_LOOP_LIMITS: Mapping[str, int] = {"llvmpipe": 65_535}


def is_software(renderer: str) -> bool:
    """Return whether a GL renderer string names a renderer that runs on the CPU."""
    return any(name in renderer.lower() for name in _SOFTWARE_RENDERERS)


def loop_limit(renderer: str) -> int | None:
    """Return the steps after which the driver ends all loops of an invocation, or None."""
    found = [limit for name, limit in _LOOP_LIMITS.items() if name in renderer.lower()]
    return min(found, default=None)
