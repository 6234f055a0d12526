"""What a method is made of: targets, buffers and passes, as data.

From these the engine derives textures, framebuffers, clears, blend and depth state, the GLSL
prelude, the memory and the traffic. A method makes no OpenGL call and counts no byte.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar

from oitbench.effects import SHADING, Effect
from oitbench.errors import DeclarationError, UsageError, unknown
from oitbench.method.formats import GLSL_BYTES, Format, find
from oitbench.parameters import Parameter, Value, variant


class Factor(enum.IntEnum):
    """OpenGL's blend factors."""

    ZERO = 0
    ONE = 1
    SOURCE_COLOR = 0x0300
    ONE_MINUS_SOURCE_COLOR = 0x0301
    ONE_MINUS_SOURCE_ALPHA = 0x0303
    ONE_MINUS_TARGET_ALPHA = 0x0305
    SECOND_SOURCE_COLOR = 0x88F9


class Equation(enum.IntEnum):
    """OpenGL's blend equations."""

    SUM = 0x8006
    MINIMUM = 0x8007
    MAXIMUM = 0x8008


@dataclass(frozen=True)
class Blend:
    """How a shader's output meets a target: source × `source` (equation) target × `target`.

    Parameters
    ----------
    source, target : Factor
        Factors of red, green and blue, and of alpha unless given apart.
    equation : Equation
    source_alpha, target_alpha : Factor, optional
        Factors of the alpha channel.
    dual : bool
        Whether the shader has a second output `NAME_factor` for this target, which then must be the
        only one of its pass.
    programmable : bool
        Whether the shader itself combines: the output's name holds the target's value when
        `gather` begins, and what it holds in the end is stored; see `PROGRAMMABLE`.
    """

    source: Factor
    target: Factor
    equation: Equation = Equation.SUM
    source_alpha: Factor | None = None
    target_alpha: Factor | None = None
    dual: bool = False
    programmable: bool = False

    @property
    def reads(self) -> bool:
        """Whether blending reads the target."""
        return (
            self.programmable or self.equation is not Equation.SUM or self.target is not Factor.ZERO
        )


REPLACE = Blend(Factor.ONE, Factor.ZERO)
"""target ← source"""
ADD = Blend(Factor.ONE, Factor.ONE)
"""target ← target + source"""
OVER = Blend(Factor.ONE, Factor.ONE_MINUS_SOURCE_ALPHA)
"""target ← source + (1 − source alpha)·target, premultiplied (Porter and Duff 1984)"""
UNDER = Blend(Factor.ONE_MINUS_TARGET_ALPHA, Factor.ONE)
"""target ← target + (1 − target alpha)·source, premultiplied: `OVER` from near to far"""
ATTENUATE = Blend(Factor.ZERO, Factor.ONE_MINUS_SOURCE_COLOR)
"""target ← (1 − source)·target, per channel"""
MODULATE = Blend(Factor.ZERO, Factor.SOURCE_COLOR)
"""target ← source·target, per channel"""
COMPOSITE = Blend(Factor.ONE, Factor.SECOND_SOURCE_COLOR, dual=True)
"""target ← source + factor·target, per channel, by dual-source blending"""
MINIMUM = Blend(Factor.ONE, Factor.ONE, Equation.MINIMUM)
"""target ← min(source, target), per channel"""
MAXIMUM = Blend(Factor.ONE, Factor.ONE, Equation.MAXIMUM)
"""target ← max(source, target), per channel"""
PROGRAMMABLE = Blend(Factor.ONE, Factor.ZERO, programmable=True)
"""target ← what `gather` makes of it, one fragment of a pixel at a time.

Done by framebuffer fetch, fragment-shader interlock, or a spin lock, whichever the driver offers;
all targets of such a pass must be programmable. `Frame.mechanism` names the one that was used.
"""


@dataclass(frozen=True)
class Target:
    """A texture of the frame's size that passes write and read.

    Parameters
    ----------
    format : str
        A name of `oitbench.formats.FORMATS`.
    clear : tuple of float
        One value a component, set at the start of each frame.
    when : Effect
        Allocated only if one of these effects runs; NONE for always.
    instead : mapping of Effect to str
        Formats to have instead while one of these effects runs.
    single : bool
        Whether the target has one sample a pixel also in a multisampled frame. A pass that writes
        such targets writes no others, and rasterizes pixel centers.
    subsample : int
        Every which pixel of the frame has a texel, along each axis; a block of pixels that the
        frame's edge cuts has one too. A pass that writes such targets writes no others, and the
        block `View` tells it the size of what it writes.
    """

    format: str
    clear: tuple[float, ...] = (0.0,)
    when: Effect = Effect.NONE
    single: bool = False
    instead: Mapping[Effect, str] = field(default_factory=dict)
    subsample: int = 1

    def __post_init__(self) -> None:
        if self.subsample < 1:
            raise DeclarationError(f"a target cannot have every {self.subsample}th pixel")

    def size(self, frame: tuple[int, int]) -> tuple[int, int]:
        """Return the target's (width, height) in a frame of that many pixels."""
        width, height = (math.ceil(side / self.subsample) for side in frame)
        return width, height

    def under(self, effects: Effect) -> Target:
        """Return the target as it is while `effects` run."""
        chosen = [name for effect, name in self.instead.items() if effect & effects]
        return replace(self, format=chosen[0], instead={}) if chosen else self

    @property
    def texel(self) -> Format:
        """The format's entry in the table."""
        return find(self.format)


class Items(enum.Enum):
    """What a buffer holds one record of, and so what its size scales with."""

    PIXELS = "pixel"
    FRAGMENTS = "fragment"


@dataclass(frozen=True)
class Buffer:
    """Records that shaders read and write freely.

    Each field is a storage block of its own, so that a driver's limit on one block (128 MiB on
    some) holds a field and not a record. The prelude gives `NAME_FIELD(i)`, `set_NAME_FIELD(i, v)`,
    and for uint fields `exchange_`, `add_`, `min_` and `max_NAME_FIELD(i, v)`. One of fragments
    also gives `allocate_NAME()`: the index of a fresh record, or NONE when memory has run out (the
    engine then redoes the frame with enough).

    Parameters
    ----------
    fields : mapping of str to str
        GLSL type of each field.
    items : Items
    clear : int, optional
        Value of every 32-bit word at the start of each frame; left as it is without.
    when : Effect
        Allocated only if one of these effects runs; NONE for always.
    """

    fields: Mapping[str, str]
    items: Items
    clear: int | None = None
    when: Effect = Effect.NONE

    @property
    def record_bytes(self) -> int:
        """Bytes of one record."""
        return sum(GLSL_BYTES[kind] for kind in self.fields.values())


class Draws(enum.Enum):
    """What a pass rasterizes."""

    FRAGMENTS = "fragments"
    """All transparent geometry; the shader defines `void gather(Fragment fragment)`."""
    PIXELS = "pixels"
    """One triangle over the frame; the shader defines `void resolve()`."""


class Objects(enum.Enum):
    """Which of the transparent objects a pass is for; it is left out where a scene has none."""

    ALL = "all"
    PARTICLES = "particles"
    OTHERS = "others"


class Order(enum.Enum):
    """In which order geometry is submitted."""

    SUBMISSION = "submission"
    OBJECTS = "object"
    """Objects by view distance of their bounding box's center, far first."""
    TRIANGLES = "triangle"
    """Triangles by view distance of their centroid, far first, over all objects."""


@dataclass(frozen=True)
class Pass:
    """One draw of all geometry, or of the whole screen, with one shader.

    Parameters
    ----------
    shader : str
        File in the method's folder.
    draws : Draws
    reads : tuple of str
        Targets that the shader reads with `read_NAME()`; also `opaque_color`, `opaque_depth`.
    writes : mapping of str to Blend
        Targets that the shader writes by name; `color` is the frame's image and begins as the
        opaque picture.
    buffers : tuple of str
        Buffers that the shader may touch.
    order : Order
    when : Effect
        Runs only if one of these effects runs; NONE for always.
    depth : str, optional
        A target of format depth32f that this pass tests (nearer passes) and writes, in place of
        the opaque depth, which is otherwise tested and never written. A pass over pixels tests
        nothing and stores what its shader assigns to `gl_FragDepth`.
    tests : str, optional
        A target of format depth32f that a pass of fragments tests in place of the opaque depth,
        and does not write.
    clears : tuple of str
        Targets that are cleared just before this pass, besides at the start of the frame.
    defines : mapping of str to int
        Macros for this pass, so that one shader can serve several.
    objects : Objects
        Which transparent objects are drawn, or whose results a pass over pixels serves.
    """

    shader: str
    draws: Draws
    reads: tuple[str, ...] = ()
    writes: Mapping[str, Blend] = field(default_factory=dict)
    buffers: tuple[str, ...] = ()
    order: Order = Order.SUBMISSION
    when: Effect = Effect.NONE
    depth: str | None = None
    clears: tuple[str, ...] = ()
    defines: Mapping[str, int] = field(default_factory=dict)
    tests: str | None = None
    objects: Objects = Objects.ALL

    @property
    def name(self) -> str:
        """The shader's name without its ending, and what it was defined to be."""
        told = [f"{key.lower()}={value}" for key, value in self.defines.items()]
        return " ".join([self.shader.removesuffix(".glsl"), *told])


@dataclass(frozen=True)
class Interleaved:
    """Several fragment passes that are all issued for one unit before the next unit.

    The unit is the object under `Order.SUBMISSION` and `Order.OBJECTS`, else the triangle.
    """

    passes: tuple[Pass, ...]
    order: Order


@dataclass(frozen=True)
class Loop:
    """Passes that are issued again and again; shaders see the round as the uniform `iteration`.

    Parameters
    ----------
    passes : tuple of Pass
    times : int
        Rounds at most.
    until_empty : str, optional
        A pass by name: the loop ends after the first round in which it passed no sample.
    swaps : tuple of (str, str)
        Pairs of targets of one format that trade places after each round, so that a pass can read
        what the round before wrote. After an even number of rounds they are back in place.
    """

    passes: tuple[Pass, ...]
    times: int
    until_empty: str | None = None
    swaps: tuple[tuple[str, str], ...] = ()
    order: Order = Order.SUBMISSION


Step = Pass | Interleaved | Loop


class Method:
    """Base of all methods: a description, not a program.

    A subclass in `methods/NAME/method.py` states the members below, as class attributes or, where
    they depend on a parameter, as properties. Parameters become attributes of the instance and
    GLSL macros: `weight` is `WEIGHT`; a parameter with text choices gives `NODE` and one macro
    `NODE_CHOICE` a choice to compare it with.
    """

    name: ClassVar[str] = ""
    """Set by the loader: the folder's name."""
    parameters: ClassVar[Mapping[str, Parameter]] = {}
    truth: ClassVar[Mapping[str, Value] | None] = None
    """Parameters under which the method is the suite's exact truth; None for all but one."""
    noisy: ClassVar[bool] = False
    """Whether the image is a random estimate, right in the mean over many pixels."""
    quick: ClassVar[bool] = True
    """Whether the preset that should take two minutes runs the method when none is named."""

    def __init__(self, **values: Value) -> None:
        for key in values:
            if key not in self.parameters:
                raise unknown(f"parameter of {self.name}", key, self.parameters)
        self.values: dict[str, Value] = {
            key: parameter.check(self.name, key, values.get(key, parameter.default))
            for key, parameter in self.parameters.items()
        }

    @property
    def label(self) -> str:
        """The name with those parameters that differ from their defaults."""
        return variant(self.name, self.values, self.parameters)

    @property
    def holds(self) -> frozenset[str]:
        """Identities that the method promises; see CONVENTIONS.md."""
        return frozenset()

    @property
    def expresses(self) -> Effect:
        """Effects of compositing that the method can show; see `shows`."""
        return Effect.NONE

    @property
    def shows(self) -> Effect:
        """What a picture by this method can show: what it expresses, and all shading."""
        return self.expresses | SHADING

    @property
    def requires(self) -> tuple[str, ...]:
        """Capabilities of `oitbench.gl.device.CAPABILITIES` without which cells are skipped."""
        return ()

    @property
    def samples(self) -> int:
        """Samples a pixel: 1, or 4 for a multisampled frame whose `color` is averaged at its end.

        Targets then have that many samples, unless they are `single`, and passes over pixels run
        once a sample.
        """
        return 1

    @property
    def record_step(self) -> float:
        """Distance of neighboring colors and opacities in [0, 1] where shaders pack them.

        As 1/255 for records of 8 bits; zero if all rounding is that of the declared formats.
        """
        return 0.0

    @property
    def may_be_negative(self) -> bool:
        """Whether the method's own formula gives negative pixels, so that they are no fault."""
        return False

    @property
    def deepest(self) -> int | None:
        """Fragments a pixel up to which llvmpipe renders the method right; None for any number.

        It ends all loops of an invocation together after 65,535 steps, without a word. Deeper
        frames are refused there and rendered elsewhere.
        """
        return None

    @property
    def targets(self) -> Mapping[str, Target]:
        """Textures by name. `color` is rgba16f unless stated here."""
        return {}

    @property
    def buffers(self) -> Mapping[str, Buffer]:
        """Buffers by name."""
        return {}

    @property
    def passes(self) -> tuple[Step, ...]:
        """What is issued each frame, in order."""
        return ()

    def text(self, parameter: str) -> str:
        """Return the value of a text parameter."""
        value = self.values[parameter]
        if not isinstance(value, str):
            raise UsageError(f"{self.name}: parameter {parameter} is no text")
        return value
