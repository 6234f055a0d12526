"""The GLSL functions through which a pass accesses its buffers."""

from __future__ import annotations

from collections.abc import Mapping

from oitbench.gl.program.bindings import AccessKind, Bindings
from oitbench.gl.tiling import ALLOCATOR_STRIDE, TILE
from oitbench.method.passes import Gather, Pass
from oitbench.method.storage import Buffer, Items

_ATOMICS = {
    "exchange": "atomicExchange",
    "add": "atomicAdd",
    "min": "atomicMin",
    "max": "atomicMax",
}
_INDICES = (
    f"#define TILE {TILE}u",
    "uint tile_index() {"
    " uvec2 tile = uvec2(gl_FragCoord.xy) / TILE;"
    " return tile.y * frame_tiles.x + tile.x; }",
    "uint pixel_index() { uvec2 pixel = uvec2(gl_FragCoord.xy);"
    " return pixel.y * frame_size.x + pixel.x; }",
)


def accessors(
    item: Pass, buffers: Mapping[str, Buffer], bindings: Bindings, samples: int = 1
) -> str:
    """Return the access functions of all buffers of a pass; empty for a pass with none."""
    if not item.buffers:
        return ""
    lines = [*_INDICES, *_coverage(item, samples)]
    if bindings.counters is not None:
        lines.append(
            f"layout(std430, binding = {bindings.counters})"
            " buffer CounterBlock { uint counters[]; };"
        )
    for name in item.buffers:
        buffer = buffers[name]
        for field, kind in buffer.fields.items():
            lines += _field(name, field, kind, bindings)
        if buffer.items is Items.FRAGMENTS:
            lines += _allocator(name, bindings)
    return "\n".join(lines)


def _coverage(item: Pass, samples: int) -> list[str]:
    """Return `coverage_mask()`, the samples that the invocation covers."""
    if isinstance(item, Gather):
        # Otherwise the side effects of a hidden fragment would precede its depth test.
        early = "post_depth_coverage" if samples > 1 else "early_fragment_tests"
        covered = "uint(gl_SampleMaskIn[0]) & 0xFu" if samples > 1 else "0xFu"
        return [f"layout({early}) in;", f"uint coverage_mask() {{ return {covered}; }}"]
    bit = "1u << uint(gl_SampleID)" if samples > 1 else "0xFu"
    return [f"uint coverage_mask() {{ return {bit}; }}"]


def _count(bindings: Bindings, name: str, field: str, kind: AccessKind) -> str:
    if bindings.counters is None:
        return ""
    slot = bindings.slots[name, field, kind]
    return f"atomicAdd(counters[tile_index() * {len(bindings.slots)}u + {slot}u], 1u); "


def _field(name: str, field: str, kind: str, bindings: Bindings) -> list[str]:
    full, data = f"{name}_{field}", f"{name}_{field}_data"
    read = _count(bindings, name, field, "read")
    write = _count(bindings, name, field, "write")
    atomic = _count(bindings, name, field, "atomic")
    lines = [
        f"layout(std430, binding = {bindings.fields[name, field]})"
        f" buffer {full}_block {{ {kind} {data}[]; }};",
        f"{kind} {full}(uint i) {{ {read}return {data}[i]; }}",
        f"void set_{full}(uint i, {kind} value) {{ {write}{data}[i] = value; }}",
    ]
    for verb, call in _ATOMICS.items() if kind == "uint" else ():
        lines.append(
            f"uint {verb}_{full}(uint i, uint value) {{ {atomic}return {call}({data}[i], value); }}"
        )
    return lines


def _allocator(name: str, bindings: Bindings) -> list[str]:
    # The words of a tile: its next free record, and the first record beyond its share.
    count = _count(bindings, name, "allocator", "atomic")
    return [
        f"layout(std430, binding = {bindings.allocators[name]})"
        f" buffer {name}_allocator_block {{ uint {name}_allocator[]; }};",
        f"uint allocate_{name}(uint n) {{ {count}uint tile = tile_index() * {ALLOCATOR_STRIDE}u;"
        f" uint i = atomicAdd({name}_allocator[tile], n);"
        f" return i + n <= {name}_allocator[tile + 1u] ? i : NONE; }}",
        f"uint allocate_{name}() {{ return allocate_{name}(1u); }}",
    ]
