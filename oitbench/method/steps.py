"""Pure functions about the passes of a plan, and the checks that they must pass."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Literal

from oitbench.errors import DeclarationError, unknown
from oitbench.method.blue_noise import MASK
from oitbench.method.passes import (
    BLUE_NOISE,
    OPAQUE_COLOR,
    OPAQUE_DEPTH,
    Gather,
    Interleaved,
    Loop,
    Pass,
    Resolve,
    Step,
)
from oitbench.method.storage import Buffer, Target


def passes_of(step: Step) -> tuple[Pass, ...]:
    """Return the passes of a step, in order."""
    return step.passes if isinstance(step, Interleaved | Loop) else (step,)


def all_passes(steps: Iterable[Step]) -> Iterator[Pass]:
    """Yield the passes of all steps, in order."""
    for step in steps:
        yield from passes_of(step)


def nameable(
    targets: Mapping[str, Target], color: Target, steps: Iterable[Step]
) -> dict[str, Target]:
    """Return all targets that passes can name, with those of the frame, and the mask if it is read.

    Parameters
    ----------
    targets : mapping of str to Target
    color : Target
        Of the frame.
    steps : iterable of Step
    """
    frame = {"color": color, OPAQUE_COLOR: color, OPAQUE_DEPTH: Target("depth32f")}
    mask = {BLUE_NOISE: MASK} if any(BLUE_NOISE in item.reads for item in all_passes(steps)) else {}
    return {**targets, **frame, **mask}


def accesses_of(item: Pass) -> Iterator[tuple[str, Literal["read", "blend", "write"]]]:
    """Yield the targets that one output of a pass accesses, and how.

    `blend` is the read that blending, or a depth test that writes, implies.
    """
    for name in item.reads:
        yield name, "read"
    if item.depth is not None and (isinstance(item, Resolve) or item.depth_writes):
        if isinstance(item, Gather):
            yield item.depth, "blend"
        yield item.depth, "write"
    for name, blend in item.writes.items():
        if blend.reads:
            yield name, "blend"
        yield name, "write"


def is_programmable(item: Pass) -> bool:
    """Return whether the pass has a target that its shader blends."""
    return any(blend.programmable for blend in item.writes.values())


def is_counter(item: Pass) -> bool:
    """Return whether the pass counts in its target."""
    return any(blend.counts for blend in item.writes.values())


def is_single(item: Pass, targets: Mapping[str, Target]) -> bool:
    """Return whether the pass writes targets that keep one sample per pixel.

    A pass that counts does not: it needs no framebuffer of one sample, and sees all fragments.
    """
    single = bool(item.writes) and all(targets[name].single for name in item.writes)
    return single and not is_counter(item)


def read_per_sample(passes: Iterable[Pass], targets: Mapping[str, Target]) -> frozenset[str]:
    """Return the targets of a multisampled frame whose samples gather passes read one by one."""
    names = {name for item in passes if isinstance(item, Gather) for name in item.reads}
    return frozenset(name for name in names if not targets[name].single)


def shades_samples(item: Gather, per_sample: frozenset[str]) -> bool:
    """Return whether a pass of a multisampled frame shades each sample of a fragment for itself.

    A pass that reads samples one by one does, and so does a shader that blends. Its fragments have
    the depths of the samples. All that it reads must come from fragments with the same depths, so
    a pass that writes one of these targets, which are `per_sample`, does too.
    """
    return is_programmable(item) or not per_sample.isdisjoint((*item.reads, *item.writes))


def subsample_of(item: Pass, targets: Mapping[str, Target]) -> int:
    """Return the downsampling factor of the targets that the pass writes."""
    names = [*item.writes, *([item.depth] if item.depth else [])]
    return next((targets[name].subsample for name in names), 1)


def indexed_families(names: Iterable[str]) -> dict[str, int]:
    """Return the base name and the number of targets that are numbered from 0, as `slice0`."""
    numbered: dict[str, set[int]] = {}
    for name in names:
        match = re.fullmatch(r"(\D+)(\d+)", name)
        if match is not None:
            numbered.setdefault(match[1], set()).add(int(match[2]))
    return {base: len(found) for base, found in numbered.items() if found == {*range(len(found))}}


def check_pass(item: Pass, targets: Mapping[str, Target], buffers: Mapping[str, Buffer]) -> None:
    """Check a pass against the targets and buffers of its frame.

    Raises
    ------
    DeclarationError
        A name is not declared, or the targets of the pass do not fit together.
    """
    depths = [item.depth] if item.depth else []
    for kind, names, known in (
        ("target", (*item.reads, *item.writes, *item.clears, *depths), targets),
        ("buffer", item.buffers, buffers),
    ):
        for name in names:
            if name not in known:
                raise DeclarationError(f"{item.shader}: {unknown(kind, name, known)}")
    for name in sorted({*item.reads} & {*item.writes}):
        raise DeclarationError(f"{item.shader}: reads and writes '{name}' in one pass")
    for name in sorted({*item.reads} & {*depths}):
        raise DeclarationError(f"{item.shader}: reads and tests '{name}' in one pass")
    for name in depths:
        if not targets[name].texel.depth:
            raise DeclarationError(f"{item.shader}: depth '{name}' is {targets[name].format}")
    _check_blending(item)
    _check_counting(item, targets)
    _check_sizes(item, targets)
    if isinstance(item, Gather) and item.masked_by_alpha:
        first = next((targets[name] for name in item.writes), None)
        if first is None or first.texel.components < 4 or first.single:
            raise DeclarationError(
                f"{item.shader}: masked_by_alpha needs a first target with an alpha, and with"
                " several samples per pixel"
            )


def _check_blending(item: Pass) -> None:
    for name, blend in item.writes.items():
        if blend.dual and len(item.writes) > 1:
            raise DeclarationError(
                f"{item.shader}: {name} blends two sources, so it must be the only target of its"
                " pass"
            )
    if len({blend.programmable for blend in item.writes.values()}) > 1:
        raise DeclarationError(f"{item.shader}: all targets or none must blend programmably")


def _check_counting(item: Pass, targets: Mapping[str, Target]) -> None:
    for name, blend in item.writes.items():
        if blend.counts and (targets[name].format != "r32ui" or len(item.writes) > 1):
            raise DeclarationError(
                f"{item.shader}: {name} counts, so it must be r32ui and the only target of its pass"
            )
        if blend.counts and isinstance(item, Resolve):
            raise DeclarationError(f"{item.shader}: {name} counts fragments, not pixels")


def _check_sizes(item: Pass, targets: Mapping[str, Target]) -> None:
    if len({targets[name].single for name in item.writes}) > 1:
        raise DeclarationError(f"{item.shader}: all targets or none must be single")
    names = [*item.writes, *([item.depth] if item.depth else [])]
    if isinstance(item, Gather) and item.depth is None and OPAQUE_DEPTH in targets:
        names.append(OPAQUE_DEPTH)
    sizes = {name: targets[name].subsample for name in names}
    if len({*sizes.values()}) > 1:
        found = ", ".join(f"{name} 1/{size}" for name, size in sizes.items())
        raise DeclarationError(f"{item.shader}: all targets of a pass must have one size: {found}")
    if item.buffers and any(size > 1 for size in sizes.values()):
        raise DeclarationError(f"{item.shader}: a pass with buffers must have the frame's size")
