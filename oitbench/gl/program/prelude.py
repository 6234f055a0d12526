"""The GLSL that a declaration implies: macros, outputs, reads and buffer accessors.

A shader can use only what its pass declares, because nothing else is generated.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from oitbench.effects import Effect, names
from oitbench.errors import DeclarationError, unknown
from oitbench.method.declaration import Blend, Buffer, Draws, Items, Method, Pass, Target

TILE = 64
"""Side in pixels of the tiles in which buffers of fragments are allocated and accesses counted."""
FETCH, INTERLOCK, SPIN_LOCK = "framebuffer fetch", "interlock", "spin lock"
"""How programmable blending is done; `Device.mechanism` chooses."""
LIGHTS_BINDING, MEDIUM_BINDING = 1, 2
"""Of the uniform blocks `Lights` and `Medium` in the engine shaders; `View` has 0."""
NO_LIGHTS = "#define BEAMS 0"
NO_SHADOWS = "vec3 beam_visibility(int i, vec3 position, vec3 side) { return vec3(1.0); }"
ALLOCATOR_STRIDE = 16
"""Words from one tile's allocator to the next: a cache line, so that tiles do not contend."""


@dataclass(frozen=True)
class Bindings:
    """Where buffers are bound, and which counter each kind of access has.

    Parameters
    ----------
    fields : mapping of (buffer, field) to int
        Storage block binding.
    allocators : mapping of buffer to int
    counters : int or None
        Binding of the access counters; None in a build that does not count.
    slots : mapping of (buffer, field, kind) to int
        Counter of each access; kind is "read", "write" or "atomic".
    """

    fields: Mapping[tuple[str, str], int]
    allocators: Mapping[str, int]
    counters: int | None
    slots: Mapping[tuple[str, str, str], int]


def bind(buffers: Mapping[str, Buffer], counted: bool) -> Bindings:
    """Give each storage block of the allocated `buffers` its number."""
    pairs = [(name, field) for name, buffer in buffers.items() for field in buffer.fields]
    listed = [name for name, buffer in buffers.items() if buffer.items is Items.FRAGMENTS]
    slots = [(*pair, kind) for pair in pairs for kind in ("read", "write", "atomic")]
    slots += [(name, "allocator", "atomic") for name in listed]
    count = len(pairs) + len(listed)
    return Bindings(
        {pair: index for index, pair in enumerate(pairs)},
        {name: len(pairs) + index for index, name in enumerate(listed)},
        count if counted and slots else None,
        {slot: index for index, slot in enumerate(slots)},
    )


def macros(method: Method, effects: Effect) -> str:
    """Return the method's parameters and the running effects as `#define`s."""
    lines = [f"#define EFFECT_{name} 1" for name in names(effects)]
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


def defines(step: Pass) -> str:
    """Return the pass's own macros, and what the scene's shader must know of the pass."""
    lines = [f"#define {name} {value}" for name, value in step.defines.items()]
    if step.depth is not None or step.tests is not None:
        lines.append("#define OWN_DEPTH 1")
    return "\n".join(lines)


def outputs(step: Pass, targets: Mapping[str, Target], mechanism: str = FETCH) -> str:
    """Return the fragment shader's outputs, one a written target.

    `mechanism` is how programmable blending is done, where the pass asks for it.
    """
    if any(blend.programmable for blend in step.writes.values()):
        return _programmable(step, targets, mechanism)
    lines = []
    for slot, (name, blend) in enumerate(step.writes.items()):
        kind = _target(step, name, targets).texel.glsl
        lines += _output(step, slot, name, kind, blend)
    return "\n".join(lines)


def _output(step: Pass, slot: int, name: str, kind: str, blend: Blend) -> list[str]:
    if not blend.dual:
        return [f"layout(location = {slot}) out {kind} {name};"]
    if len(step.writes) > 1:
        raise DeclarationError(
            f"{step.shader}: {name} blends two sources, so it must be the pass's only target"
        )
    return [
        f"layout(location = 0, index = 0) out {kind} {name};",
        f"layout(location = 0, index = 1) out {kind} {name}_factor;",
    ]


def families(names: Iterable[str]) -> dict[str, int]:
    """Return the base names of numbered targets, as `slice` of `slice0`, `slice1`, with counts."""
    numbered: dict[str, set[int]] = {}
    for name in names:
        match = re.fullmatch(r"(\D+)(\d+)", name)
        if match is not None:
            numbered.setdefault(match[1], set()).add(int(match[2]))
    return {base: len(found) for base, found in numbered.items() if found == {*range(len(found))}}


def indexed(step: Pass, targets: Mapping[str, Target]) -> str:
    """Return access by index to numbered targets: `read_NAME(i)`, `get_NAME(i)`, `set_NAME(i, v)`.

    Loops over them are of constant length, so compilers unroll them and no branch is left.
    """
    lines = []
    for base, count in families(step.reads).items():
        kind = _target(step, f"{base}0", targets).texel.glsl
        cases = " ".join(f"if (i == {i}) return read_{base}{i}();" for i in range(1, count))
        lines.append(f"{kind} read_{base}(int i) {{ {cases} return read_{base}0(); }}")
    for base, count in families(step.writes).items():
        kind = _target(step, f"{base}0", targets).texel.glsl
        cases = " ".join(f"if (i == {i}) return {base}{i};" for i in range(1, count))
        lines.append(f"{kind} get_{base}(int i) {{ {cases} return {base}0; }}")
        cases = " ".join(f"if (i == {i}) {base}{i} = value;" for i in range(count))
        lines.append(f"void set_{base}(int i, {kind} value) {{ {cases} }}")
    return "\n".join(lines)


def _programmable(step: Pass, targets: Mapping[str, Target], mechanism: str) -> str:
    if not all(blend.programmable for blend in step.writes.values()):
        raise DeclarationError(f"{step.shader}: all targets or none must blend programmably")
    kinds = {name: _target(step, name, targets).texel for name in step.writes}
    if mechanism == FETCH:
        return "\n".join(
            f"layout(location = {slot}) inout {entry.glsl} {name};"
            for slot, (name, entry) in enumerate(kinds.items())
        )
    lines, loads, stores = [], [], []
    for slot, (name, entry) in enumerate(kinds.items()):
        vector = "uvec4" if entry.integer else "vec4"
        swizzle = {1: ".r", 2: ".rg"}.get(entry.components, "")
        filled = {1: f"{vector}({name})", 2: f"{vector}({name}, {name})"}.get(
            entry.components, name
        )
        lines += [
            f"layout({entry.name}, binding = {slot}) coherent uniform"
            f" {'u' if entry.integer else ''}image2D {name}_image;",
            f"{entry.glsl} {name};",
        ]
        loads.append(f"{name} = imageLoad({name}_image, pixel){swizzle};")
        stores.append(f"imageStore({name}_image, pixel, {filled});")
    lines += [
        "layout(early_fragment_tests) in;",
        f"layout(r32ui, binding = {len(kinds)}) coherent uniform uimage2D lock_image;"
        if mechanism == SPIN_LOCK
        else "layout(pixel_interlock_ordered) in;",
        f"#define LOAD_TARGETS(pixel) {' '.join(loads)}",
        f"#define STORE_TARGETS(pixel) {' '.join(stores)}",
    ]
    return "\n".join(lines)


def deliver(step: Pass, mechanism: str) -> str:
    """Return the function through which the scene's shader hands a fragment to `gather`."""
    if mechanism == FETCH or not any(b.programmable for b in step.writes.values()):
        return "void deliver(Fragment fragment) { gather(fragment); }"
    work = "LOAD_TARGETS(pixel) gather(fragment); STORE_TARGETS(pixel)"
    if mechanism == INTERLOCK:
        return (
            "void deliver(Fragment fragment) { ivec2 pixel = ivec2(gl_FragCoord.xy);"
            f" beginInvocationInterlockARB(); {work} endInvocationInterlockARB(); }}"
        )
    return (
        "void deliver(Fragment fragment) { ivec2 pixel = ivec2(gl_FragCoord.xy);"
        " bool waiting = !gl_HelperInvocation; while (waiting) {"
        " if (imageAtomicCompSwap(lock_image, pixel, 0u, 1u) == 0u) {"
        f" {work} memoryBarrier(); imageAtomicExchange(lock_image, pixel, 0u);"
        " waiting = false; } } }"
    )


def extensions(step: Pass, mechanism: str, samples: int) -> tuple[str, ...]:
    """Return the GLSL extensions that the pass needs."""
    names: list[str] = []
    if any(blend.programmable for blend in step.writes.values()):
        names += {
            FETCH: ["GL_EXT_shader_framebuffer_fetch"],
            INTERLOCK: ["GL_ARB_fragment_shader_interlock"],
        }.get(mechanism, [])
    if samples > 1 and step.draws is Draws.FRAGMENTS and step.buffers:
        names.append("GL_ARB_post_depth_coverage")
    return tuple(names)


def single(step: Pass, targets: Mapping[str, Target]) -> bool:
    """Tell whether the pass writes targets of one sample a pixel, whatever the frame has."""
    kinds = {_target(step, name, targets).single for name in step.writes}
    if len(kinds) > 1:
        raise DeclarationError(f"{step.shader}: all targets or none must be single")
    return kinds == {True}


def reads(step: Pass, targets: Mapping[str, Target], samples: int = 1) -> str:
    """Return `read_NAME()` for each target that the pass reads; of several samples, its own."""
    lines = []
    for name in step.reads:
        entry = _target(step, name, targets).texel
        if name in step.writes:
            raise DeclarationError(f"{step.shader}: reads and writes '{name}' in one pass")
        swizzle = {1: ".r", 2: ".rg", 3: ".rgb"}.get(entry.components, "")
        several = samples > 1 and not targets[name].single
        sampler = f"{'u' if entry.integer else ''}sampler2D{'MS' if several else ''}"
        which = "gl_SampleID" if several else "0"
        lines += [
            f"uniform {sampler} {name}_texture;",
            f"{entry.glsl} read_{name}(ivec2 pixel) {{"
            f" return texelFetch({name}_texture, pixel, {which}){swizzle}; }}",
            f"{entry.glsl} read_{name}() {{ return read_{name}(ivec2(gl_FragCoord.xy)); }}",
        ]
    return "\n".join(lines)


def _target(step: Pass, name: str, targets: Mapping[str, Target]) -> Target:
    if name not in targets:
        raise DeclarationError(f"{step.shader}: {unknown('target', name, targets)}")
    return targets[name]


def accessors(
    step: Pass, buffers: Mapping[str, Buffer], bindings: Bindings, samples: int = 1
) -> str:
    """Return the functions through which the pass touches its buffers."""
    lines: list[str] = []
    if step.buffers:
        lines += [
            f"#define TILE {TILE}u",
            "uint tile_index() {"
            " uvec2 tile = uvec2(gl_FragCoord.xy) / TILE;"
            " return tile.y * frame_tiles.x + tile.x; }",
            "uint pixel_index() { uvec2 pixel = uvec2(gl_FragCoord.xy);"
            " return pixel.y * frame_size.x + pixel.x; }",
        ]
        if step.draws is Draws.FRAGMENTS:
            # Otherwise a hidden fragment's side effects would happen before its depth test.
            early = "post_depth_coverage" if samples > 1 else "early_fragment_tests"
            lines.append(f"layout({early}) in;")
            covered = "uint(gl_SampleMaskIn[0]) & 0xFu" if samples > 1 else "0xFu"
            lines.append(f"uint coverage_mask() {{ return {covered}; }}")
        else:
            bit = "1u << uint(gl_SampleID)" if samples > 1 else "0xFu"
            lines.append(f"uint coverage_mask() {{ return {bit}; }}")
    if step.buffers and bindings.counters is not None:
        lines.append(
            f"layout(std430, binding = {bindings.counters})"
            " buffer CounterBlock { uint counters[]; };"
        )
    for name in step.buffers:
        if name not in buffers:
            raise DeclarationError(f"{step.shader}: {unknown('buffer', name, buffers)}")
        buffer = buffers[name]
        for field, kind in buffer.fields.items():
            lines += _field(name, field, kind, bindings)
        if buffer.items is Items.FRAGMENTS:
            lines += _allocator(name, bindings)
    return "\n".join(lines)


def _count(bindings: Bindings, name: str, field: str, kind: str) -> str:
    if bindings.counters is None:
        return ""
    slot = bindings.slots[name, field, kind]
    return f"atomicAdd(counters[tile_index() * {len(bindings.slots)}u + {slot}u], 1u); "


def _field(name: str, field: str, kind: str, bindings: Bindings) -> list[str]:
    full, data = f"{name}_{field}", f"{name}_{field}_data"
    read, write, atomic = (
        _count(bindings, name, field, access) for access in ("read", "write", "atomic")
    )
    lines = [
        f"layout(std430, binding = {bindings.fields[name, field]})"
        f" buffer {full}_block {{ {kind} {data}[]; }};",
        f"{kind} {full}(uint i) {{ {read}return {data}[i]; }}",
        f"void set_{full}(uint i, {kind} value) {{ {write}{data}[i] = value; }}",
    ]
    if kind == "uint":
        for verb, call in (
            ("exchange", "atomicExchange"),
            ("add", "atomicAdd"),
            ("min", "atomicMin"),
            ("max", "atomicMax"),
        ):
            lines.append(
                f"uint {verb}_{full}(uint i, uint value)"
                f" {{ {atomic}return {call}({data}[i], value); }}"
            )
    return lines


def _allocator(name: str, bindings: Bindings) -> list[str]:
    # A tile's words: the next free record, and the first one that is not the tile's.
    count = _count(bindings, name, "allocator", "atomic")
    return [
        f"layout(std430, binding = {bindings.allocators[name]})"
        f" buffer {name}_allocator_block {{ uint {name}_allocator[]; }};",
        f"uint allocate_{name}() {{ {count}uint tile = tile_index() * {ALLOCATOR_STRIDE}u;"
        f" uint i = atomicAdd({name}_allocator[tile], 1u);"
        f" return i < {name}_allocator[tile + 1u] ? i : NONE; }}",
    ]
