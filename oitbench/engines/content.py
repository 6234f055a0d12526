"""Scenes as other engines draw them: by emission alone, with opacity and without textures."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from oitbench.effects import Effect, names
from oitbench.engines.adapter import Content, Surface
from oitbench.errors import SceneError
from oitbench.scene import Camera, Mesh, Object, Scene, Texture
from oitbench.scene.material import TEXTURED

_ALONE = "engines draw emission and opacity alone"
_BEHIND = 1.01
"""Distance of a far plane behind the last vertex, as a factor."""


def unlit(scene: Scene, rows: int, brightest: float) -> Content:
    """Return a scene as surfaces with a color and an opacity.

    A layer of coverage α, radiance L and gray transmission t adds αL and lets 1 − α(1 − t) pass. It
    is blended as the color L/(1 − t) of opacity α(1 − t).

    Parameters
    ----------
    scene : Scene
    rows : int
        Height of the picture in pixels.
    brightest : float
        The largest radiance that the engine can hold.

    Raises
    ------
    SceneError
        The scene needs something else, which the message names.
    """
    _require_unlit(scene)
    seen = scene.resolved(rows).near_origin()
    surfaces = tuple(_surface(item) for item in seen.objects)
    content = Content(_with_far_plane(seen.camera, surfaces), surfaces, seen.background)
    if content.brightest > brightest:
        raise SceneError(
            f"{scene.name}: its layers are up to {content.brightest:.3g} bright, and the engine's"
            f" targets hold {brightest:.3g}"
        )
    return content


def require_coverage_alone(name: str, effects: Effect) -> None:
    """Raise `SceneError` if a scene requests effects that engines are not asked for."""
    others = ", ".join(names(effects & ~Effect.COVERAGE)).lower()
    if others:
        raise SceneError(f"{name}: it requests {others}; {_ALONE}")


def _require_unlit(scene: Scene) -> None:
    require_coverage_alone(scene.name, scene.effects)
    if scene.lists is not None:
        raise SceneError(f"{scene.name}: its fragment lists have no geometry; {_ALONE}")
    if scene.lights:
        raise SceneError(f"{scene.name}: it has lights; {_ALONE}")


def _surface(item: Object) -> Surface:
    material, mesh = item.material, item.mesh
    assert isinstance(mesh, Mesh)
    transmits = material.transmission != (0.0, 0.0, 0.0)
    textured = [name for name in TEXTURED if isinstance(getattr(material, name), Texture)]
    faults = {
        f"a texture of {' and '.join(textured)}": bool(textured),
        "a cutoff": material.cutoff is not None,
        "no back": material.culled,
        "albedo or reflectance on glass": transmits
        and bool(material.diffuse or material.reflectance or mesh.albedo is not None),
    }
    for fault, present in faults.items():
        if present:
            raise SceneError(f"object {item.name}: it has {fault}, which engines do not draw yet")
    ones = np.ones(len(mesh.positions), dtype=np.float32)
    passed = np.mean(material.transmission, dtype=np.float32) * ones  # type: ignore[arg-type]
    if mesh.transmission is not None:
        passed = passed * mesh.transmission[:, 0]
    emission = np.asarray(material.emission, dtype=np.float32) * ones[:, None]
    if mesh.radiance is not None:
        emission = emission * mesh.radiance
    if bool(((passed >= 1) & emission.any(axis=1)).any()):
        raise SceneError(f"object {item.name}: it adds light but hides none, which no engine draws")
    coverage = np.float32(material.coverage) * ones  # type: ignore[arg-type]
    if mesh.coverage is not None:
        coverage = coverage * mesh.coverage
    return Surface(
        np.ascontiguousarray(mesh.positions, dtype=np.float32),
        np.ascontiguousarray(mesh.triangles, dtype=np.uint32),
        (emission / np.maximum(1 - passed, np.finfo(np.float32).tiny)[:, None]).astype(np.float32),
        (coverage * (1 - passed)).astype(np.float32),
        item.opaque,
    )


def _with_far_plane(camera: Camera, surfaces: tuple[Surface, ...]) -> Camera:
    """Return the camera with a far plane behind everything if it had none."""
    if math.isfinite(camera.far):
        return camera
    last = max(float(camera.view_distance(item.positions).max()) for item in surfaces)
    return replace(camera, far=_BEHIND * max(last, camera.near))
