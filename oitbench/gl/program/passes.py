"""Compiles passes: their shaders, framebuffers and textures."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import moderngl

from oitbench.effects import Effect
from oitbench.errors import CapabilityError, DeclarationError
from oitbench.gl.capabilities import FETCH
from oitbench.gl.device import Device
from oitbench.gl.geometry import Geometry
from oitbench.gl.program import accessors, prelude
from oitbench.gl.program.bindings import Bindings
from oitbench.gl.program.compiled_pass import CompiledPass
from oitbench.gl.program.shading_inputs import UNLIT, Sampled, ShadingInputs
from oitbench.gl.program.source import Source
from oitbench.method.formats import Format
from oitbench.method.passes import OPAQUE_DEPTH, Gather, Pass, Resolve
from oitbench.method.steps import (
    indexed_families,
    is_single,
    shades_samples,
    subsample_of,
)
from oitbench.method.storage import Buffer, Target

DEPTH_COPY, DEPTH_AT_CENTERS = "opaque_depth_copy", "opaque_depth_at_centers"
"""Textures that stand in for the opaque depth: for passes that read and test it, and for passes
that rasterize pixel centers in a multisampled frame."""
LIGHT_VIEW = "LIGHT_VIEW"
"""Macro of passes that a light sees, not the camera."""
_UNITS = "GL_MAX_TEXTURE_IMAGE_UNITS"


@dataclass(frozen=True)
class Blueprint:
    """Common inputs of the passes that are compiled together.

    Parameters
    ----------
    owner : str
        Name in error messages.
    targets : mapping of str to Target
        All targets that exist, including those of the frame itself.
    buffers : mapping of str to Buffer
    bindings : Bindings
    folders : tuple of Path
        Folders of the method's shaders; empty for passes of the engine.
    macros : str
        Parameters of the method as `#define`s.
    effects : Effect
        Running effects.
    shading : ShadingInputs
    samples : int
        Samples per pixel.
    mechanism : str
        Way of programmable blending, and of counting.
    per_sample : frozenset of str
        Targets that gather passes read sample by sample.
    """

    owner: str
    targets: Mapping[str, Target] = field(default_factory=dict)
    buffers: Mapping[str, Buffer] = field(default_factory=dict)
    bindings: Bindings = field(default_factory=Bindings)
    folders: tuple[Path, ...] = ()
    macros: str = ""
    effects: Effect = Effect.NONE
    shading: ShadingInputs = UNLIT
    samples: int = 1
    mechanism: str = FETCH
    per_sample: frozenset[str] = frozenset()


def compile_pass(
    device: Device,
    geometry: Geometry,
    blueprint: Blueprint,
    step: Pass,
    textures: Mapping[str, moderngl.Texture],
    draws: Hashable | None = None,
) -> CompiledPass:
    """Assemble and compile the shaders of `step`, and collect the state of its draws.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    blueprint : Blueprint
    step : Gather or Resolve
        Checked by `oitbench.method.steps.check_pass`.
    textures : mapping of str to moderngl.Texture
        Texture of each target in this pass.
    draws : hashable, optional
        Key of the index order that a gather pass draws.

    Raises
    ------
    CapabilityError
        The driver cannot render to the targets.
    DeclarationError
        A shader does not compile; the message gives file and line.
    """
    vertex, fragment = _sources(blueprint, geometry, step)
    images = _images(blueprint, step, textures)
    colors = [] if images else [textures[name] for name in step.writes]
    limit = device.max_images if images else device.max_targets
    if len(images or colors) > limit:
        raise CapabilityError(
            f"{blueprint.owner}: {step.shader} writes {len(images or colors)} targets;"
            f" {device.renderer} allows {limit}"
        )
    samplers = _samplers(blueprint, geometry, step, textures)
    program = _program(device, vertex, fragment, f"{blueprint.owner}: {step.shader}", samplers)
    used = {name: item for name, item in samplers.items() if name in program}
    # NVIDIA links a program that has more, although OpenGL defines no units for them.
    device.within(f"{blueprint.owner}: {step.shader} (textures)", len(used), _UNITS)
    for unit, name in enumerate(used):
        # Frames share a program, but its samplers always come in this order.
        program[name] = unit
    try:
        framebuffer = device.framebuffer(colors, _depth(blueprint, step, textures))
    except moderngl.Error as error:
        formats = ", ".join(blueprint.targets[name].format for name in step.writes)
        raise CapabilityError(
            f"{blueprint.owner}: {device.renderer} cannot render to {formats} ({error})"
        ) from error
    writes_depth = step.depth is not None and (isinstance(step, Resolve) or step.depth_writes)
    compiled = CompiledPass(
        device, step, draws, program, framebuffer, used, images, geometry, writes_depth,
        not _tests_in_shader(geometry, step), _is_per_sample(blueprint, step),
        blueprint.shading.blocks, subsample_of(step, blueprint.targets),
    )  # fmt: skip
    with compiled.building():
        for name in step.clears:
            target = blueprint.targets[name]
            compiled.add_clear(attach(device, textures[name], target.texel), target)
    return compiled


def attach(device: Device, texture: moderngl.Texture, entry: Format) -> moderngl.Framebuffer:
    """Return a framebuffer with one texture, of color or of depth."""
    return device.framebuffer([], texture) if entry.depth else device.framebuffer([texture])


def _depth(
    blueprint: Blueprint, step: Pass, textures: Mapping[str, moderngl.Texture]
) -> moderngl.Texture | None:
    """Return the depth attachment of a pass."""
    if step.depth is not None:
        return textures[step.depth]
    if OPAQUE_DEPTH not in blueprint.targets:
        return None
    # A framebuffer needs an attachment even if the pass only writes buffers.
    if isinstance(step, Resolve) and step.writes:
        return None
    return textures[_opaque_depth(blueprint, step)]


def _opaque_depth(blueprint: Blueprint, step: Pass) -> str:
    """Return the name of the opaque depth at the places that the pass rasterizes."""
    centers = blueprint.samples > 1 and is_single(step, blueprint.targets)
    return DEPTH_AT_CENTERS if centers else OPAQUE_DEPTH


def _tests_in_shader(geometry: Geometry, step: Pass) -> bool:
    """Return whether a pass compares with the opaque depth in its shader.

    Where surfaces coincide, the depth test of the driver does not know which side is seen. The
    opaque depth is then attached and read at once, which is defined as long as nothing writes it.
    """
    drawn = isinstance(step, Gather) and step.depth is None and LIGHT_VIEW not in step.defines
    return geometry.planes is not None and drawn


def _is_per_sample(blueprint: Blueprint, step: Pass) -> bool:
    """Return whether the shader of a pass runs for each sample of a fragment."""
    if not isinstance(step, Gather) or is_single(step, blueprint.targets):
        return False
    return blueprint.samples > 1 and shades_samples(step, blueprint.per_sample)


def _samplers(
    blueprint: Blueprint, geometry: Geometry, step: Pass, textures: Mapping[str, moderngl.Texture]
) -> dict[str, Sampled]:
    samplers: dict[str, Sampled] = {f"{name}_texture": textures[name] for name in step.reads}
    if OPAQUE_DEPTH in step.reads:
        depth = _opaque_depth(blueprint, step)
        copied = isinstance(step, Gather) and depth == OPAQUE_DEPTH
        samplers[f"{OPAQUE_DEPTH}_texture"] = textures[DEPTH_COPY if copied else depth]
    if isinstance(step, Gather):
        if _tests_in_shader(geometry, step):
            samplers["tested_depth"] = textures[OPAQUE_DEPTH]
        samplers.update(geometry.textures)
    samplers.update(blueprint.shading.samplers)
    return samplers


def _images(
    blueprint: Blueprint, step: Pass, textures: Mapping[str, moderngl.Texture]
) -> list[moderngl.Texture]:
    """Return the images that replace targets where shaders blend without framebuffer fetch."""
    mechanism = prelude.mechanism_of(step, blueprint.mechanism, blueprint.samples)
    return [textures[name] for name in prelude.images(step, mechanism)]


def _sources(blueprint: Blueprint, geometry: Geometry, step: Pass) -> tuple[Source, Source]:
    """Return the vertex and the fragment shader of `step`."""
    mechanism = prelude.mechanism_of(step, blueprint.mechanism, blueprint.samples)
    targets, shading = blueprint.targets, blueprint.shading
    samples = 1 if is_single(step, targets) else blueprint.samples
    fragment = Source(blueprint.folders, prelude.extensions(step, mechanism, samples))
    fragment.add_text("prelude (macros)", prelude.effect_macros(blueprint.effects))
    fragment.add_text("prelude (parameters)", blueprint.macros)
    fragment.add_text("prelude (pass)", prelude.pass_macros(step))
    fragment.add_engine_file("view.glsl")
    detailed = isinstance(step, Gather) and "surface_materials" in geometry.textures
    if shading.lit or detailed:
        fragment.add_text("prelude (lights)", shading.lights)
        fragment.add_engine_file("lighting.glsl")
        fragment.add_text("prelude (shadows)", shading.shadows)
    declarations = (
        prelude.outputs(step, targets, mechanism, samples),
        prelude.reads(step, targets, blueprint.samples),
        prelude.indexed(step, targets),
        accessors.accessors(step, blueprint.buffers, blueprint.bindings, samples),
    )
    fragment.add_text("prelude (declarations)", "\n".join(declarations))
    vertex = Source()
    if isinstance(step, Resolve):
        fragment.add_text("prelude (medium)", shading.medium)
        _add_shader(fragment, blueprint, step)
        # Helper invocations read zero from buffers, and would never leave a list.
        fragment.add_text("main", "void main() { if (!gl_HelperInvocation) { resolve(); } }")
        vertex.add_engine_file("screen.vert.glsl")
        return vertex, fragment
    own_depth = step.depth not in (None, OPAQUE_DEPTH)
    places = prelude.interpolation(samples, _is_per_sample(blueprint, step), own_depth)
    for source in (vertex, fragment):
        source.add_text("prelude (samples)", places)
        source.add_text("prelude (scene)", geometry.macros)
    if detailed:
        if shading.medium:
            fragment.add_text("prelude (medium)", shading.medium)
            fragment.add_engine_file("medium.glsl")
        fragment.add_engine_file("shading.glsl")
        if shading.occluded:
            fragment.add_engine_file("inferred_occlusion.glsl")
    if _tests_in_shader(geometry, step):
        fragment.add_text("prelude (depth)", "#define TESTS_DEPTH 1")
    fragment.add_engine_file("fragment.glsl")
    _add_shader(fragment, blueprint, step)
    fragment.add_text("prelude (deliver)", prelude.deliver(step, mechanism))
    fragment.add_engine_file("lists.frag.glsl" if geometry.has_lists else "surface.frag.glsl")
    vertex.add_engine_file("view.glsl")
    vertex.add_engine_file("surface.vert.glsl")
    return vertex, fragment


def _add_shader(fragment: Source, blueprint: Blueprint, step: Pass) -> None:
    """Append the shader of a pass, and check that it defines its function and names its outputs."""
    start = len(fragment.lines)
    if not blueprint.folders:  # a pass of the engine
        fragment.add_engine_file(step.shader)
        return
    fragment.add_file(step.shader)
    text = "\n".join(fragment.lines[start:])
    function = "void gather(Fragment fragment)" if isinstance(step, Gather) else "void resolve()"
    if re.search(rf"\bvoid\s+{function.split()[1].partition('(')[0]}\s*\(", text) is None:
        raise DeclarationError(f"{blueprint.owner}: {step.shader} defines no '{function}'")
    families = indexed_families(step.writes)
    for name in step.writes:
        base = name.rstrip("0123456789")
        words = (name, base) if base in families else (name,)
        if not any(re.search(rf"(\b|_){word}\b", text) for word in words):
            raise DeclarationError(
                f"{blueprint.owner}: {step.shader} never assigns its output '{name}'"
            )


def _program(
    device: Device, vertex: Source, fragment: Source, owner: str, samplers: Mapping[str, Sampled]
) -> moderngl.Program:
    key = (vertex.text, fragment.text)
    program = device.programs.get(key)
    if program is None:
        try:
            program = device.context.program(vertex.text, fragment.text)
        except moderngl.Error as error:
            # A driver that lacks units reports that in words of its own.
            textures = [name for name in samplers if f" {name};" in fragment.text]
            device.within(f"{owner} (textures)", len(textures), _UNITS)
            source = vertex if "vertex_shader" in str(error) else fragment
            raise DeclarationError(source.explain(str(error))) from error
        device.programs[key] = program
    return program
