"""The GLSL that is generated from declarations, as text."""

from __future__ import annotations

from typing import Any

import pytest

from oitbench import (
    ADD,
    COMPOSITE,
    COUNT,
    OVER,
    PROGRAMMABLE,
    Buffer,
    Effect,
    Gather,
    Items,
    Method,
    Parameter,
    Resolve,
)
from oitbench.errors import DeclarationError
from oitbench.gl.capabilities import ATOMICS, FETCH, INTERLOCK, SPIN_LOCK
from oitbench.gl.program import accessors as buffers
from oitbench.gl.program import prelude
from oitbench.gl.program.bindings import Bindings
from oitbench.method.formats import FORMATS, GLSL_BYTES
from oitbench.method.passes import Pass
from oitbench.method.steps import check_pass, indexed_families
from oitbench.method.storage import Target

TARGETS = {
    "color": Target("rgba16f"),
    "accum": Target("rgba16f"),
    "reveal": Target("r8"),
    "bounds": Target("rg32f"),
    "mask": Target("r32ui"),
}
BUFFERS = {
    "heads": Buffer({"first": "uint"}, Items.PIXELS, clear=0),
    "nodes": Buffer({"next": "uint", "front": "vec4"}, Items.FRAGMENTS),
}


class Knobs(Method):
    node = Parameter("big-one", choices=("small", "big-one"))
    count = Parameter(4)
    scale = Parameter(0.5)
    fast = Parameter(True)


def gather(**more: Any) -> Gather:
    return Gather("gather.glsl", **more)


def accessors(step: Pass, counted: bool = False) -> str:
    return buffers.accessors(step, BUFFERS, Bindings.of(BUFFERS, counted))


def test_written_targets_are_outputs_in_order() -> None:
    step = gather(writes={"accum": ADD, "reveal": ADD, "mask": ADD})
    assert prelude.outputs(step, TARGETS).splitlines() == [
        "layout(location = 0) out vec4 accum;",
        "layout(location = 1) out float reveal;",
        "layout(location = 2) out uint mask;",
    ]


@pytest.mark.parametrize(
    ("mechanism", "expected"),
    [
        (FETCH, "layout(location = 0) inout uint mask;"),
        (INTERLOCK, "return imageAtomicAdd(mask_image, ivec2(gl_FragCoord.xy), 1u);"),
        (ATOMICS, "layout(early_fragment_tests) in;"),
    ],
)
def test_a_target_counts_by_framebuffer_fetch_or_atomics(mechanism: str, expected: str) -> None:
    step = gather(writes={"mask": COUNT})
    text = prelude.outputs(step, TARGETS, mechanism)
    assert "uint count_mask()" in text
    assert expected in text
    assert ("image" in text) == (mechanism != FETCH)
    fetches = "GL_EXT_shader_framebuffer_fetch" in prelude.extensions(step, mechanism, 1)
    assert fetches == (mechanism == FETCH)


def test_dual_source_blending_gives_two_outputs_at_one_location() -> None:
    assert prelude.outputs(gather(writes={"color": COMPOSITE}), TARGETS).splitlines() == [
        "layout(location = 0, index = 0) out vec4 color;",
        "layout(location = 0, index = 1) out vec4 color_factor;",
    ]


def test_dual_source_blending_allows_no_other_target() -> None:
    step = gather(writes={"color": COMPOSITE, "accum": ADD})
    with pytest.raises(DeclarationError, match=r"gather\.glsl: color blends two sources"):
        check_pass(step, TARGETS, {})


def test_functions_that_read_return_the_type_of_the_texel() -> None:
    text = prelude.reads(gather(reads=("accum", "reveal", "bounds", "mask")), TARGETS)
    for name, kind, swizzle, sampler in (
        ("accum", "vec4", "", "sampler2D"),
        ("reveal", "float", ".r", "sampler2D"),
        ("bounds", "vec2", ".rg", "sampler2D"),
        ("mask", "uint", ".r", "usampler2D"),
    ):
        assert f"uniform {sampler} {name}_texture;" in text
        assert f"{kind} read_{name}(ivec2 pixel)" in text
        texel = f"texelFetch({name}_texture, pixel, 0){swizzle}"
        if TARGETS[name].texel.half:
            texel = f"clamp({texel}, -65504.0, 65504.0)"
        assert f"return {texel}; }}" in text
        assert f"{kind} read_{name}() " in text


def test_only_declared_resources_have_functions() -> None:
    step = gather(writes={"color": OVER})
    assert prelude.reads(step, TARGETS) == ""
    assert accessors(step) == ""
    only_heads = accessors(gather(buffers=("heads",)))
    assert "heads_first" in only_heads
    assert "nodes" not in only_heads


def test_each_field_of_a_buffer_is_a_block() -> None:
    text = accessors(gather(buffers=("heads", "nodes")))
    for binding, field, kind in (
        (0, "heads_first", "uint"),
        (1, "nodes_next", "uint"),
        (2, "nodes_front", "vec4"),
    ):
        assert f"binding = {binding}) buffer {field}_block {{ {kind} {field}_data[]; }};" in text
        assert f"{kind} {field}(uint i)" in text
        assert f"void set_{field}(uint i, {kind} value)" in text


def test_only_unsigned_fields_have_atomics() -> None:
    text = accessors(gather(buffers=("nodes",)))
    for verb in ("exchange", "add", "min", "max"):
        call = f"{{ return atomic{verb.capitalize()}(nodes_next_data[i], value); }}"
        assert f"uint {verb}_nodes_next(uint i, uint value) {call}" in text
        assert f"{verb}_nodes_front" not in text


def test_only_buffers_of_fragments_have_an_allocator() -> None:
    text = accessors(gather(buffers=("heads", "nodes")))
    assert "uint allocate_nodes()" in text
    assert "uint allocate_nodes(uint n)" in text
    assert "binding = 3) buffer nodes_allocator_block" in text
    assert "allocate_heads" not in text


def test_gather_passes_with_buffers_test_depth_early() -> None:
    early = "layout(early_fragment_tests) in;"
    assert early in accessors(gather(buffers=("heads",)))
    assert early not in accessors(Resolve("resolve.glsl", buffers=("heads",)))


def test_counted_programs_count_every_access() -> None:
    step = gather(buffers=("heads", "nodes"))
    plain, counted = accessors(step), accessors(step, counted=True)
    assert "counters" not in plain
    slots = Bindings.of(BUFFERS, True).slots
    for slot in slots.values():
        assert f"+ {slot}u], 1u);" in counted or slot == slots["nodes", "front", "atomic"]
    stripped = [line for line in counted.splitlines() if "CounterBlock" not in line]
    for before, after in zip(plain.splitlines(), stripped, strict=True):
        assert before == after or "atomicAdd(counters[" in after


def test_parameters_and_effects_are_macros() -> None:
    effects = prelude.effect_macros(Effect.COVERAGE | Effect.VOLUME)
    assert effects.splitlines() == ["#define EFFECT_COVERAGE 1", "#define EFFECT_VOLUME 1"]
    assert prelude.parameter_macros(Knobs(scale=1.0)).splitlines() == [
        "#define NODE_SMALL 0",
        "#define NODE_BIG_ONE 1",
        "#define NODE 1",
        "#define COUNT 4",
        "#define SCALE 1.0",
        "#define FAST 1",
    ]


def test_errors_about_unknown_names_suggest_the_nearest() -> None:
    near = r"gather\.glsl: unknown target 'acum'; did you mean accum"
    with pytest.raises(DeclarationError, match=near):
        check_pass(gather(writes={"acum": ADD}), TARGETS, {})
    with pytest.raises(DeclarationError, match=near):
        check_pass(gather(reads=("acum",)), TARGETS, {})
    with pytest.raises(DeclarationError, match="unknown buffer 'node'; did you mean nodes"):
        check_pass(gather(buffers=("node",)), TARGETS, BUFFERS)
    with pytest.raises(DeclarationError, match="unknown texture format 'rgb16f'; did you mean"):
        _ = Target("rgb16f").texel


def test_a_target_cannot_be_read_while_it_is_written() -> None:
    with pytest.raises(DeclarationError, match="reads and writes 'accum' in one pass"):
        check_pass(gather(reads=("accum",), writes={"accum": ADD}), TARGETS, {})


def test_sizes_of_formats_agree_with_their_names() -> None:
    for name, entry in FORMATS.items():
        digits = int("".join(c for c in name if c.isdigit()))
        assert 8 * entry.bytes == digits * entry.components, name
    assert all(size == 4 * int(kind[-1]) for kind, size in GLSL_BYTES.items() if "vec" in kind)


def test_numbered_targets_are_accessed_by_index() -> None:
    slices = {f"slice{i}": Target("rg32f") for i in range(2)}
    written = prelude.indexed(gather(writes=dict.fromkeys(slices, ADD)), slices)
    assert "vec2 get_slice(int i) { if (i == 1) return slice1; return slice0; }" in written
    assert "if (i == 0) slice0 = value; if (i == 1) slice1 = value;" in written
    read = prelude.indexed(gather(reads=tuple(slices)), slices)
    assert "vec2 read_slice(int i) { if (i == 1) return read_slice1(); return read_slice0(); }" in (
        read
    )


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (["slice0", "slice1", "color"], {"slice": 2}),
        (["slice1", "slice0", "front0"], {"slice": 2, "front": 1}),
        (["slice1", "slice2"], {}),
    ],
)
def test_only_targets_numbered_from_zero_are_a_family(
    names: list[str], found: dict[str, int]
) -> None:
    assert indexed_families(names) == found


@pytest.mark.parametrize("mechanism", [INTERLOCK, SPIN_LOCK])
@pytest.mark.parametrize(("samples", "kind"), [(1, "image2D "), (4, "image2DMS ")])
def test_shaders_blend_in_images_of_as_many_samples(
    mechanism: str, samples: int, kind: str
) -> None:
    text = prelude.outputs(gather(writes={"accum": PROGRAMMABLE}), TARGETS, mechanism, samples)
    assert f" {kind}accum_image;" in text
    assert ("gl_SampleID" in text) == (samples > 1)
    if mechanism == INTERLOCK:
        unit = "sample" if samples > 1 else "pixel"
        assert f"layout({unit}_interlock_ordered) in;" in text
    else:
        assert f"u{kind}lock_image;" in text
