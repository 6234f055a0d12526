"""The plan of a frame: everything that is allocated and issued, before any OpenGL object exists."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from oitbench.effects import Effect
from oitbench.errors import DeclarationError
from oitbench.gl.capabilities import FETCH, SPIN_LOCK
from oitbench.gl.program.bindings import Bindings
from oitbench.gl.program.prelude import parameter_macros
from oitbench.method.blending import ADD, REPLACE
from oitbench.method.declaration import Method, Request, plan_of
from oitbench.method.demands import NOTHING, Demands, demands_of
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
from oitbench.method.steps import (
    all_passes,
    check_pass,
    is_counter,
    is_programmable,
    is_single,
    nameable,
    passes_of,
)
from oitbench.method.storage import Buffer, Items, Target

Size = tuple[int, int]
ACCUMULATED = "accumulated"
"""The target that holds the sum of all frames so far."""
_ACCUMULATION = (
    Resolve("oitbench/accumulate.glsl", reads=("color",), writes={ACCUMULATED: ADD}),
    Resolve("oitbench/mean.glsl", reads=(ACCUMULATED,), writes={"color": REPLACE}),
)


@dataclass(frozen=True, eq=False)
class FramePlan:
    """Targets, buffers and steps of one frame.

    `FramePlan.of` makes one from a method's declaration.

    Parameters
    ----------
    label : str
        Name of the method with its parameters, for messages.
    size : (int, int)
        Width and height in pixels, including sub-pixels.
    effects : Effect
        Running effects.
    mechanism : str or None
        Way of programmable blending and of counting; None for a method that uses neither.
    targets : mapping of str to Target
        Targets that are allocated for the method; `color` is not one of them.
    color : Target
        The image, which starts as the opaque picture.
    buffers : mapping of str to Buffer
    steps : tuple of Step
    bindings : Bindings
    samples : int
        Samples per pixel.
    folders : tuple of Path
        Folders of the method's shaders; empty for the engine's own.
    macros : str
        Parameters of the method as `#define`s.
    demands : Demands
        What the declaration demands of any platform.
    frames : int
        Frames whose mean is the image; each issues all steps.
    """

    label: str
    size: Size
    effects: Effect
    mechanism: str | None
    targets: Mapping[str, Target]
    color: Target
    buffers: Mapping[str, Buffer]
    steps: tuple[Step, ...]
    bindings: Bindings
    samples: int = 1
    folders: tuple[Path, ...] = ()
    macros: str = ""
    demands: Demands = NOTHING
    frames: int = 1

    @classmethod
    def of(
        cls,
        method: Method,
        size: Size,
        effects: Effect = Effect.NONE,
        *,
        particles: bool = False,
        others: bool = True,
        mechanism: str | Callable[[int], str] = FETCH,
        counted: bool = False,
    ) -> FramePlan:
        """Plan a frame of `method`.

        Parameters
        ----------
        method : Method
        size : (int, int)
        effects : Effect
        particles, others : bool
            See `Request`.
        mechanism : str or callable
            Way of programmable blending and of counting, or a function that returns it for a number
            of samples; it is only asked if the method uses one of them.
        counted : bool
            Whether buffer accesses are counted.

        Raises
        ------
        DeclarationError
            A pass does not fit the targets and buffers; the message names its shader.
        """
        declared = plan_of(method, Request(effects, particles, others))
        targets = {name: item for name, item in declared.targets.items() if name != "color"}
        passes = tuple(all_passes(declared.passes))
        programmable, blending = any(map(is_programmable, passes)), None
        if programmable or any(map(is_counter, passes)):
            samples = method.sample_count if programmable else 1
            blending = mechanism if isinstance(mechanism, str) else mechanism(samples)
        if programmable and blending == SPIN_LOCK:
            targets["lock"] = Target("r32ui")
        steps, frames = declared.passes, method.frame_count
        if frames > 1:
            if ACCUMULATED in targets:
                raise DeclarationError(f"{method.name}: rename the target '{ACCUMULATED}'")
            targets[ACCUMULATED] = Target("rgba32f")
            steps = (*steps, *_ACCUMULATION)
        plan = cls(
            method.label, size, effects, blending, targets, declared.color,
            declared.buffers, steps, Bindings.of(declared.buffers, counted),
            method.sample_count, method.folders, parameter_macros(method), frames=frames,
        )  # fmt: skip
        try:
            plan.check()
        except DeclarationError as error:
            raise DeclarationError(f"{method.name}: {error}") from error
        return replace(plan, demands=demands_of(method, declared))

    def check(self) -> None:
        """Raise `DeclarationError` if the passes do not fit the targets and buffers."""
        written = {name for item in self.passes for name in (*item.writes, item.depth)}
        swapped = {
            name
            for step in self.steps
            if isinstance(step, Loop)
            for pair in step.swaps
            for name in pair
        }
        for item in self.passes:
            check_pass(item, self.declared, self.buffers)
            if isinstance(item, Gather) and item.masked_by_alpha and self.samples == 1:
                raise DeclarationError(
                    f"{item.shader}: masked_by_alpha needs several samples per pixel; set msaa"
                )
            if item.depth == OPAQUE_DEPTH:
                raise DeclarationError(f"{item.shader}: the opaque depth cannot be written")
            for name in item.reads:
                if name in self.targets and name not in written | swapped:
                    raise DeclarationError(f"{item.shader}: reads '{name}', but no pass writes it")

        for loop in (step for step in self.steps if isinstance(step, Loop) and step.within):
            written = {name for item in loop.passes for name in item.writes}
            if self.samples > 1 or loop.within not in written:
                raise DeclarationError(
                    f"{loop.passes[0].shader}: the loop is within '{loop.within}', which one of its"
                    " passes must write, with one sample per pixel"
                )

    @cached_property
    def declared(self) -> Mapping[str, Target]:
        """All targets that passes can name, including those of the frame itself."""
        return nameable(self.targets, self.color, self.steps)

    @cached_property
    def passes(self) -> tuple[Pass, ...]:
        """All passes in order; a measured frame has one record for each."""
        return tuple(all_passes(self.steps))

    @property
    def reads_mask(self) -> bool:
        """Whether a pass reads the mask of blue noise."""
        return any(BLUE_NOISE in item.reads for item in self.passes)

    def clears(self, target: str) -> int:
        """Return how often a target is cleared: in each frame, or before the first one."""
        return 1 if target == ACCUMULATED else self.frames

    @property
    def listed(self) -> list[str]:
        """Names of the buffers that hold one record per fragment."""
        return [name for name, item in self.buffers.items() if item.items is Items.FRAGMENTS]

    @property
    def subsamples(self) -> set[int]:
        """Downsampling factors of the targets."""
        return {1, *(target.subsample for target in self.targets.values())}

    @property
    def copies_depth(self) -> bool:
        """Whether a pass over fragments reads the opaque depth that it also tests."""
        return any(isinstance(p, Gather) and OPAQUE_DEPTH in p.reads for p in self.passes)

    @property
    def copies_color(self) -> bool:
        """Whether the passes need a copy of the opaque picture: they read it and blend over it.

        A pass over pixels that replaces `color` can write to another texture instead.
        """
        first = next((item for item in self.passes if "color" in item.writes), None)
        replaces = isinstance(first, Resolve) and not first.writes["color"].reads
        return not replaces and any(OPAQUE_COLOR in item.reads for item in self.passes)

    @property
    def peels(self) -> bool:
        """Whether the geometry is drawn until nothing is left: once for each layer, or for two."""
        loops = (step for step in self.steps if isinstance(step, Loop) and step.times is None)
        return any(isinstance(item, Gather) for loop in loops for item in loop.passes)

    @property
    def in_order_of_arrival(self) -> bool:
        """Whether fragments of a pixel come in the order of their arrival, which GPUs do not fix.

        Lists and a spin lock take them so. Blending, framebuffer fetch and interlocks keep the
        order of the draws.
        """
        lists = any(buffer.items is Items.FRAGMENTS for buffer in self.buffers.values())
        return lists or self.mechanism == SPIN_LOCK

    @property
    def parts(self) -> dict[int, str]:
        """Names of the parts in which a frame is timed, by the place of their first pass.

        A part is a pass. Interleaved passes take turns with each unit, and are one part.
        """
        named: dict[int, str] = {}
        place = 0
        for step in self.steps:
            passes = passes_of(step)
            if isinstance(step, Interleaved):
                named[place] = " and ".join(item.name for item in passes)
            else:
                named |= {place + k: item.name for k, item in enumerate(passes)}
            place += len(passes)
        return named

    @cached_property
    def digest(self) -> str:
        """A digest of everything that the method declares: frames of one cell must agree in it."""
        declared = (
            self.label, self.effects, self.targets, self.color, self.buffers, self.steps,
            self.samples, self.macros, self.frames,
        )  # fmt: skip
        return hashlib.sha256(repr(declared).encode()).hexdigest()[:16]

    @property
    def needs_depth_at_centers(self) -> bool:
        """Whether a multisampled frame has passes that rasterize pixel centers, or read there."""
        users = (
            item for item in self.passes if isinstance(item, Gather) or OPAQUE_DEPTH in item.reads
        )
        return self.samples > 1 and any(is_single(item, self.declared) for item in users)

    def samples_of(self, target: str) -> int:
        """Return the samples per pixel of a target."""
        return 1 if self.declared[target].single else self.samples

    def texels(self, target: str) -> int:
        """Return the number of texels of a target, samples included."""
        return math.prod(self.declared[target].size(self.size)) * self.samples_of(target)

    def target_bytes(self) -> list[tuple[str, int]]:
        """Return (target, bytes) of all targets that the method allocates."""
        return [
            (name, target.texel.bytes * self.texels(name)) for name, target in self.targets.items()
        ]
