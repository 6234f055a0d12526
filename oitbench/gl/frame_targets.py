"""The textures of a frame that are pictures: targets, views of them, and maps of shared shading.

Targets have the names of the method's declaration, `color` is the image, and `opaque_color` and
`opaque_depth` the opaque picture. Of shared shading, `shadow_NAME` is a map of the first beam that
has shadows, `shadow_NAME@2` one of beam number 2, counted from 0. Depths of several channels are
one map: `shadow_map` holds those of transparent surfaces as they were drawn at random. `occluders`
and `openness` belong to ambient occlusion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import moderngl
import numpy as np

from oitbench.effects import Effect, names
from oitbench.errors import DeclarationError, UsageError, unknown
from oitbench.gl.frame import Frame
from oitbench.gl.readback import format_of, read_texels
from oitbench.image.values import Show, Values
from oitbench.method.declaration import Method, Request, plan_of
from oitbench.method.formats import Format
from oitbench.method.passes import Objects
from oitbench.method.views import View

_NEEDS = {
    "shadow_map": Effect.TRANSLUCENT_SHADOWS,
    "shadow_opaque": Effect.SHADOWS,
    "occluders": Effect.AMBIENT_OCCLUSION,
    "openness": Effect.AMBIENT_OCCLUSION,
}
"""Maps of shared shading, and the effects without which they do not exist."""


@dataclass(frozen=True)
class FrameTarget:
    """A texture, several of one kind, or a view.

    Parameters
    ----------
    name, format : str
    size : (int, int)
        Width and height in texels.
    show : Show
    read : callable
        Returns the values; shape (h, w, components).
    unit : str
    depth : bool
        Whether the format is one of depths.
    readable : bool
        False if samples have no mean; `read` then raises `UsageError`.
    view : bool
        Whether it is a view that the method declares.
    """

    name: str
    format: str
    size: tuple[int, int]
    show: Show
    read: Callable[[], Values]
    unit: str = ""
    depth: bool = False
    readable: bool = True
    view: bool = False


def targets_of(frame: Frame, method: Method) -> dict[str, FrameTarget]:
    """Return all targets of a frame of `method`, by name; the frame need not be rendered.

    Raises
    ------
    DeclarationError
        A view has the name of a target.
    """
    found = [_declared(frame, name) for name in frame.plan.declared]
    found += [
        _view(frame, name, view)
        for name, view in method.views.items()
        if _is_held(frame, method, name, view)
    ]
    found += _shading(frame)
    return {target.name: target for target in found}


def choose(frame: Frame, method: Method, name: str) -> FrameTarget:
    """Return one target of a frame.

    Raises
    ------
    UsageError
        There is no such target; the message gives the reason if an effect does not run.
    """
    found = targets_of(frame, method)
    if name in found:
        return found[name]
    lacking, scene = _lacking(frame, method, name), frame.scene.scene
    if not lacking:
        if name in _NEEDS:
            raise UsageError(f"target {name}: {scene.name} has no such map as it is shaded")
        raise UsageError(f"{unknown('target', name, found)} (all: {', '.join(sorted(found))})")
    wanted = " or ".join(names(lacking))
    if not lacking & scene.effects:
        reason = f"which {scene.name} does not request"
    elif not lacking & method.shows:
        reason = f"which {method.label} does not express"
    else:
        reason = "which --effects leaves out"
    raise UsageError(f"target {name} needs {wanted}, {reason}")


def _declared(frame: Frame, name: str) -> FrameTarget:
    target, samples = frame.plan.declared[name], frame.plan.samples_of(name)
    entry = target.texel
    text = entry.name if samples == 1 else f"{entry.name}, mean of {samples} samples"
    readable = samples == 1 or not (entry.depth or entry.integer)

    def read() -> Values:
        return frame.texels(name)

    size = target.size(frame.plan.size)
    return FrameTarget(name, text, size, _show(entry), read, depth=entry.depth, readable=readable)


def _show(entry: Format) -> Show:
    if entry.depth:
        return Show.DEPTH
    if entry.name.endswith("snorm"):
        return Show.SIGNED
    if entry.dtype == "f1":
        return Show.FRACTION
    return Show.LIGHT if entry.components > 2 and not entry.integer else Show.AMOUNT


def _is_held(frame: Frame, method: Method, name: str, view: View) -> bool:
    """Return whether the target of a view exists and holds its quantity."""
    if name in frame.plan.declared:
        raise DeclarationError(f"{method.name}: the view {name} has the name of a target")
    return view.target in frame.plan.declared and view.effect in frame.plan.effects


def _view(frame: Frame, name: str, view: View) -> FrameTarget:
    held = _declared(frame, view.target)
    text = f"{view.channels} of {view.target}, {held.format}"

    def read() -> Values:
        return view.of(held.read())

    return FrameTarget(
        name, text, held.size, view.show, read, view.unit, readable=held.readable, view=True
    )


def _shading(frame: Frame) -> Iterator[FrameTarget]:
    if frame.lighting is not None:
        casting = [k for k, maps in enumerate(frame.lighting.maps) if maps is not None]
        for beam in casting:
            maps = frame.lighting.maps[beam]
            assert maps is not None
            suffix = "" if beam == casting[0] else f"@{beam}"
            for name, textures in _grouped(maps.textures).items():
                yield _map(frame, f"shadow_{name}{suffix}", textures)
    if frame.occlusion is not None:
        for name, texture in frame.occlusion.samplers.items():
            if isinstance(texture, moderngl.Texture):
                yield _map(frame, name.removesuffix("_texture"), [texture])


def _grouped(textures: Mapping[str, object]) -> dict[str, list[moderngl.Texture]]:
    """Return textures by name; those of one component are grouped by their name less its digit."""
    found: dict[str, list[moderngl.Texture]] = {}
    for name, texture in textures.items():
        if isinstance(texture, moderngl.Texture):
            common = name.rstrip("0123456789") if texture.components == 1 else name
            found.setdefault(common, []).append(texture)
    return found


def _map(frame: Frame, name: str, textures: list[moderngl.Texture]) -> FrameTarget:
    """Return a map of shading: distances as near / z, moments of the distance, or a fraction."""
    first = textures[0]
    entry = format_of(first)
    show = Show.FRACTION if entry.dtype == "f1" else Show.DEPTH
    if entry.components > 1:
        show = Show.MOMENTS
    several = f"{len(textures)} × " if len(textures) > 1 else ""

    def read() -> Values:
        parts = [read_texels(frame.device, item, item.size, entry) for item in textures]
        values: Values = np.concatenate(parts, axis=-1)
        return values

    return FrameTarget(name, f"{several}{entry.name}", first.size, show, read, depth=entry.depth)


def _lacking(frame: Frame, method: Method, name: str) -> Effect:
    """Return the effects, of those that do not run, any of which would bring a target."""
    absent = [effect for effect in Effect if effect and effect not in frame.plan.effects]
    geometry = frame.scene.geometry
    kinds = geometry.has(Objects.PARTICLES), geometry.has(Objects.OTHERS)

    def brings(effect: Effect) -> bool:
        if _NEEDS.get(name.partition("@")[0]) == effect:
            return True
        view = method.views.get(name)
        if view is not None and view.effect:
            return view.effect == effect
        request = Request(frame.plan.effects | effect, *kinds)
        return (name if view is None else view.target) in plan_of(method, request).targets

    found = Effect.NONE
    for effect in absent:
        if brings(effect):
            found |= effect
    return found
