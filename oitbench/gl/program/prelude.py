"""The GLSL that a declaration implies: macros, outputs, reads and programmable blending.

A shader can use only the names that its pass declares, because nothing else is generated. Passes
have been checked (`oitbench.method.steps.check_pass`).
"""

from __future__ import annotations

from collections.abc import Mapping

from oitbench.effects import Effect, names
from oitbench.gl.capabilities import ATOMICS, FETCH, INTERLOCK, SPIN_LOCK
from oitbench.method.blending import Blend
from oitbench.method.declaration import Method
from oitbench.method.formats import LARGEST_HALF
from oitbench.method.passes import BLUE_NOISE, OPAQUE_DEPTH, Gather, Pass
from oitbench.method.steps import indexed_families, is_counter, is_programmable, is_single
from oitbench.method.storage import Target


def effect_macros(effects: Effect) -> str:
    """Return the running effects as `#define`s."""
    return "\n".join(f"#define EFFECT_{name} 1" for name in names(effects))


def parameter_macros(method: Method) -> str:
    """Return the values of the method's parameters as `#define`s."""
    lines = []
    for name, parameter in method.parameters.items():
        value, macro = method.values[name], name.upper()
        if isinstance(value, str):
            for index, choice in enumerate(parameter.choices):
                suffix = "".join(c if c.isalnum() else "_" for c in str(choice)).upper()
                lines.append(f"#define {macro}_{suffix} {index}")
            lines.append(f"#define {macro} {parameter.choices.index(value)}")
        else:
            number = int(value) if isinstance(value, bool) else value
            lines.append(f"#define {macro} {number!r}")
    return "\n".join(lines)


def pass_macros(item: Pass) -> str:
    """Return the macros of a pass, and those that configure the scene's shader for it."""
    lines = [f"#define {name} {value}" for name, value in item.defines.items()]
    if item.depth is not None:
        lines.append("#define OWN_DEPTH 1")
    return "\n".join(lines)


def interpolation(samples: int, per_sample: bool, own_depth: bool) -> str:
    """Return where values between vertices are taken: `PLACED` for places, `INSIDE` for others.

    With several samples a pixel's center may lie outside of the triangle, where colors and normals
    that are extended over it have no meaning. But a pass with a depth buffer of its own takes all
    values there: drivers may put a centroid among the samples that pass the depth test, as llvmpipe
    does, so that colors would depend on the order of the draws.

    Parameters
    ----------
    samples : int
        Of a pixel.
    per_sample : bool
        Whether each sample is shaded by itself.
    own_depth : bool
        Whether the pass tests against a depth target of the method.
    """
    if samples == 1 or (own_depth and not per_sample):
        return "#define PLACED\n#define INSIDE"
    if per_sample:
        return (
            "#define PLACED sample\n#define INSIDE sample\n#define OF_SEVERAL\n#define PER_SAMPLE"
        )
    return "#define PLACED\n#define INSIDE centroid\n#define OF_SEVERAL"


def outputs(
    item: Pass, targets: Mapping[str, Target], mechanism: str = FETCH, samples: int = 1
) -> str:
    """Return the fragment shader's outputs, one per written target.

    Parameters
    ----------
    item : Gather or Resolve
    targets : mapping of str to Target
    mechanism : str
        Way of programmable blending or of counting, for passes that need it.
    samples : int
        Samples per pixel of the written targets.
    """
    if is_programmable(item):
        return _programmable(item, targets, mechanism, samples)
    if is_counter(item):
        return _counter(next(iter(item.writes)), mechanism)
    lines = []
    for slot, (name, blend) in enumerate(item.writes.items()):
        lines += _output(slot, name, targets[name].texel.glsl, blend)
    return "\n".join(lines)


def _output(slot: int, name: str, kind: str, blend: Blend) -> list[str]:
    if not blend.dual:
        return [f"layout(location = {slot}) out {kind} {name};"]
    return [
        f"layout(location = 0, index = 0) out {kind} {name};",
        f"layout(location = 0, index = 1) out {kind} {name}_factor;",
    ]


def indexed(item: Pass, targets: Mapping[str, Target]) -> str:
    """Return access by index to numbered targets: `read_NAME(i)`, `get_NAME(i)`, `set_NAME(i, v)`.

    Loops over them have constant length, so compilers unroll them and no branch remains.
    """
    lines = []
    for base, count in indexed_families(item.reads).items():
        kind = targets[f"{base}0"].texel.glsl
        cases = " ".join(f"if (i == {i}) return read_{base}{i}();" for i in range(1, count))
        lines.append(f"{kind} read_{base}(int i) {{ {cases} return read_{base}0(); }}")
    for base, count in indexed_families(item.writes).items():
        kind = targets[f"{base}0"].texel.glsl
        cases = " ".join(f"if (i == {i}) return {base}{i};" for i in range(1, count))
        lines.append(f"{kind} get_{base}(int i) {{ {cases} return {base}0; }}")
        cases = " ".join(f"if (i == {i}) {base}{i} = value;" for i in range(count))
        lines.append(f"void set_{base}(int i, {kind} value) {{ {cases} }}")
    return "\n".join(lines)


def reads(item: Pass, targets: Mapping[str, Target], samples: int = 1) -> str:
    """Return `read_NAME()` for each target that the pass reads; of several samples, its own.

    A pass into targets of one sample per pixel reads the opaque depth at pixel centers. A half
    float that overflowed is read as the greatest one on all drivers.
    """
    lines = []
    for name in item.reads:
        entry = targets[name].texel
        swizzle = {1: ".r", 2: ".rg", 3: ".rgb"}.get(entry.components, "")
        at_center = name == OPAQUE_DEPTH and is_single(item, targets)
        several = samples > 1 and not (targets[name].single or at_center)
        sampler = f"{'u' if entry.integer else ''}sampler2D{'MS' if several else ''}"
        sample = "gl_SampleID" if several else "0"
        # The mask repeats; pixels and shifts are not negative.
        place = f"pixel % textureSize({name}_texture, 0)" if name == BLUE_NOISE else "pixel"
        texel = f"texelFetch({name}_texture, {place}, {sample}){swizzle}"
        if entry.half:
            texel = f"clamp({texel}, -{LARGEST_HALF}, {LARGEST_HALF})"
        lines += [
            f"uniform {sampler} {name}_texture;",
            f"{entry.glsl} read_{name}(ivec2 pixel) {{ return {texel}; }}",
            f"{entry.glsl} read_{name}() {{ return read_{name}(ivec2(gl_FragCoord.xy)); }}",
        ]
    return "\n".join(lines)


def mechanism_of(item: Pass, mechanism: str, samples: int) -> str:
    """Return the way in which the shader of a pass blends, or counts, if it does."""
    return ATOMICS if is_counter(item) and samples > 1 else mechanism


def images(item: Pass, mechanism: str) -> tuple[str, ...]:
    """Return the targets that shaders access as images: where they blend or count without fetch."""
    if mechanism == FETCH or not (is_programmable(item) or is_counter(item)):
        return ()
    locked = mechanism == SPIN_LOCK and is_programmable(item)
    return (*item.writes, "lock") if locked else tuple(item.writes)


def _counter(name: str, mechanism: str) -> str:
    if mechanism == FETCH:
        return (
            f"layout(location = 0) inout uint {name};\nuint count_{name}() {{ return {name}++; }}"
        )
    return "\n".join(
        (
            "layout(early_fragment_tests) in;",
            f"layout(r32ui, binding = 0) coherent uniform uimage2D {name}_image;",
            f"uint count_{name}() {{"
            f" return imageAtomicAdd({name}_image, ivec2(gl_FragCoord.xy), 1u); }}",
        )
    )


def _programmable(item: Pass, targets: Mapping[str, Target], mechanism: str, samples: int) -> str:
    kinds = {name: targets[name].texel for name in item.writes}
    if mechanism == FETCH:
        return "\n".join(
            f"layout(location = {slot}) inout {entry.glsl} {name};"
            for slot, (name, entry) in enumerate(kinds.items())
        )
    image = "image2DMS" if samples > 1 else "image2D"
    lines, loads, stores = [], [], []
    for slot, (name, entry) in enumerate(kinds.items()):
        vector = "uvec4" if entry.integer else "vec4"
        swizzle = {1: ".r", 2: ".rg"}.get(entry.components, "")
        filled = {1: f"{vector}({name})", 2: f"{vector}({name}, {name})"}.get(
            entry.components, name
        )
        lines += [
            f"layout({entry.name}, binding = {slot}) coherent uniform"
            f" {'u' if entry.integer else ''}{image} {name}_image;",
            f"{entry.glsl} {name};",
        ]
        loads.append(f"{name} = imageLoad({name}_image, TEXEL){swizzle};")
        stores.append(f"imageStore({name}_image, TEXEL, {filled});")
    lines += [
        "layout(early_fragment_tests) in;",
        f"layout(r32ui, binding = {len(kinds)}) coherent uniform u{image} lock_image;"
        if mechanism == SPIN_LOCK
        else f"layout({'sample' if samples > 1 else 'pixel'}_interlock_ordered) in;",
        # To name the sample makes one invocation for each of them.
        f"#define TEXEL ivec2(gl_FragCoord.xy){', gl_SampleID' if samples > 1 else ''}",
        f"#define LOAD_TARGETS {' '.join(loads)}",
        f"#define STORE_TARGETS {' '.join(stores)}",
    ]
    return "\n".join(lines)


def deliver(item: Gather, mechanism: str) -> str:
    """Return the macro by which `main` of the scene's shader passes a fragment to `gather`.

    It is no function: interlocks may only begin and end in `main`, outside of any branch.
    """
    if mechanism == FETCH or not is_programmable(item):
        return "#define DELIVER(fragment) gather(fragment);"
    work = "LOAD_TARGETS gather(fragment); STORE_TARGETS"
    if mechanism == INTERLOCK:
        return (
            "#define DELIVER(fragment) beginInvocationInterlockARB();"
            f" {work} endInvocationInterlockARB();"
        )
    return (
        "#define DELIVER(fragment)"
        " bool waiting = !gl_HelperInvocation; while (waiting) {"
        " if (imageAtomicCompSwap(lock_image, TEXEL, 0u, 1u) == 0u) {"
        f" {work} memoryBarrier(); imageAtomicExchange(lock_image, TEXEL, 0u);"
        " waiting = false; } }"
    )


def extensions(item: Pass, mechanism: str, samples: int) -> tuple[str, ...]:
    """Return the GLSL extensions that the pass needs."""
    found: list[str] = []
    if is_counter(item) and mechanism == FETCH:
        found.append("GL_EXT_shader_framebuffer_fetch")
    if is_programmable(item):
        found += {
            FETCH: ["GL_EXT_shader_framebuffer_fetch"],
            INTERLOCK: ["GL_ARB_fragment_shader_interlock"],
        }.get(mechanism, [])
    if samples > 1 and isinstance(item, Gather) and item.buffers:
        found.append("GL_ARB_post_depth_coverage")
    return tuple(found)
