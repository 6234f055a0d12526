"""A method as data: parameters, promises, and a plan of targets, buffers and passes.

The engine derives textures, framebuffers, clears, blend and depth state, the GLSL prelude, memory
and traffic from the plan. A method makes no OpenGL call and counts no byte.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from oitbench.effects import SHADING, Effect
from oitbench.errors import DeclarationError, locate, unknown
from oitbench.method.families import FAMILIES, OTHER
from oitbench.method.passes import Gather, Interleaved, Loop, Resolve, Step
from oitbench.method.promises import ALWAYS
from oitbench.method.steps import nameable
from oitbench.method.storage import Buffer, Target
from oitbench.method.views import View
from oitbench.parameters import AnyParameter, Parameter, Value, label


@dataclass(frozen=True)
class Request:
    """The part of a frame's conditions that a plan may depend on.

    Parameters
    ----------
    effects : Effect
        Running effects: requested by the scene and expressed by the method.
    particles, others : bool
        Whether the scene has transparent objects that are marked as particles, and others.
    """

    effects: Effect = Effect.NONE
    particles: bool = False
    others: bool = True


@dataclass(frozen=True)
class Plan:
    """Everything that a method allocates and issues for a frame.

    Parameters
    ----------
    targets : mapping of str to Target
        Textures by name; see `color`.
    passes : tuple of Gather, Resolve, Loop or Interleaved
        In the order in which they are issued.
    buffers : mapping of str to Buffer
    """

    targets: Mapping[str, Target] = field(default_factory=dict)
    passes: tuple[Step, ...] = ()
    buffers: Mapping[str, Buffer] = field(default_factory=dict)

    @property
    def color(self) -> Target:
        """The image, which is rgba16f unless `targets` states another format."""
        return self.targets.get("color", Target("rgba16f"))

    @property
    def declared(self) -> dict[str, Target]:
        """All targets that passes can name, including those of the frame itself."""
        return nameable(self.targets, self.color, self.passes)


_MEMBERS = (
    "expresses", "family", "frame_count", "loop_steps", "may_be_negative", "no_msaa", "noisy",
    "plan", "promises", "quick", "record_step", "requires", "sample_count", "truth", "views",
)  # fmt: skip
"""Members of a method that its class can override."""

MSAA = Parameter(1, choices=(1, 4), help="samples per pixel")
"""The parameter `msaa` of most methods; see `Method.sample_count`."""


class Method:
    """Base class of all methods.

    A subclass in `methods/NAME/method.py` assigns a `Parameter` to each attribute that users can
    set, and overrides the members below as class attributes or, where they depend on a parameter,
    as properties. On an instance, the attribute holds the parameter's value. Shaders see parameters
    as macros: `weight` is `WEIGHT`; a parameter with text choices gives `NODE` and one macro
    `NODE_CHOICE` per choice to compare it with.

    Parameters
    ----------
    **values : bool, int, float or str
        Values of parameters. Default: the parameters' own.

    Raises
    ------
    UsageError
        A parameter is unknown, or its value is not allowed.
    """

    name: ClassVar[str] = ""
    """Name of the method's folder; set by the loader."""
    folders: ClassVar[tuple[Path, ...]] = ()
    """Folders in which shaders are looked up, the method's own first; set by the loader."""
    parameters: ClassVar[Mapping[str, AnyParameter]] = {}
    """Parameters by name, collected from the class attributes; those of base classes come last."""
    truth: ClassVar[Mapping[str, Value] | None] = None
    """Parameters under which the suite's own exact method is the truth; None for all others."""
    noisy: ClassVar[bool] = False
    """Whether the image is a random estimate that is exact in the mean over many pixels."""
    family: ClassVar[str] = OTHER
    """One of `FAMILIES`; reports give each family its color and marker."""
    quick: ClassVar[bool] = True
    """Whether the quick preset includes the method."""
    no_msaa: ClassVar[str] = ""
    """Why the method has one sample per pixel; empty if it has a parameter `msaa`."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        own = {key: item for key, item in vars(cls).items() if isinstance(item, Parameter)}
        for key in own:
            if key in vars(Method):
                raise DeclarationError(f"parameter '{key}' hides a member of Method; rename it")
        for key in vars(cls).keys() - own.keys() - vars(Method).keys():
            near = difflib.get_close_matches(key, _MEMBERS, n=1, cutoff=0.8)
            if near and not key.startswith("_"):
                raise DeclarationError(f"unknown member {key}; did you mean {near[0]}?")
        cls.parameters = {**own, **{k: v for k, v in cls.parameters.items() if k not in own}}
        if cls.family not in FAMILIES:
            raise DeclarationError(f"family is {cls.family!r}; choose from {', '.join(FAMILIES)}")
        if cls.no_msaa and "msaa" in cls.parameters:
            raise DeclarationError("there is a parameter msaa; delete no_msaa")

    def __init__(self, **values: Value) -> None:
        for key in values:
            if key not in self.parameters:
                raise unknown(f"parameter of {self.name}", key, self.parameters)
        self.values: dict[str, Value] = {
            key: parameter.check(self.name, key, values.get(key, parameter.default))
            for key, parameter in self.parameters.items()
        }
        vars(self).update(self.values)

    @property
    def label(self) -> str:
        """The name with the parameters that differ from their defaults."""
        return label(self.name, self.values, self.parameters)

    @property
    def promises(self) -> frozenset[str]:
        """Identities that the method keeps, of `oitbench.method.promises.PROMISES`."""
        return frozenset()

    @property
    def promised(self) -> frozenset[str]:
        """The method's own promises and the one that every method makes."""
        return self.promises | {ALWAYS}

    @property
    def expresses(self) -> Effect:
        """Effects of compositing that the method can show; see `shows`."""
        return Effect.NONE

    @property
    def shows(self) -> Effect:
        """Effects that a picture by this method can show: its own and all shading."""
        return self.expresses | SHADING

    @property
    def requires(self) -> tuple[str, ...]:
        """Required capabilities, of `oitbench.gl.capabilities.CAPABILITIES`."""
        return ()

    @property
    def sample_count(self) -> int:
        """Samples per pixel: 1, or several in a multisampled frame, which averages its `color`.

        A parameter `msaa` sets it. Targets have that many samples unless they are `single`, and
        passes over pixels run once per sample.
        """
        return int(self.values.get("msaa", 1))

    @property
    def frame_count(self) -> int:
        """Frames whose mean is the image: 1, or several with random numbers of their own.

        A parameter `frames` sets it. All passes run once per frame, and shaders read the frame as
        the uniform `frame_number`. Colors are added up in `accumulated`, in 32-bit floats.
        """
        return int(self.values.get("frames", 1))

    @property
    def record_step(self) -> float:
        """Distance of adjacent values in [0, 1] that shaders pack colors and opacities to.

        For example 1/255 for records of 8 bits; 0 if only the declared formats round.
        """
        return 0.0

    @property
    def may_be_negative(self) -> bool:
        """Whether the method's own formula can give negative pixels, which are then no fault."""
        return False

    @property
    def views(self) -> Mapping[str, View]:
        """Quantities that targets hold, by names that no target has."""
        return {}

    def loop_steps(self, fragments: int) -> float:
        """Return the loop steps of the longest shader invocation at a pixel of `fragments`.

        Some drivers end all loops of an invocation after a fixed number of steps without an error.
        The engine refuses deeper frames on them. 0 means a number that does not grow.
        """
        return 0

    def plan(self, request: Request) -> Plan:
        """Return everything that a frame allocates and issues.

        Parameters
        ----------
        request : Request
            Running effects and kinds of objects; most plans do not depend on them.
        """
        return Plan()


def plan_of(method: Method, request: Request) -> Plan:
    """Return the plan of a method, checked for types.

    Raises
    ------
    DeclarationError
        The method's own code fails, or returns anything but a plan. The message names the file.
    """
    file = method.folders[0] / "method.py" if method.folders else Path(method.name)
    try:
        plan = method.plan(request)
    except Exception as error:
        raise DeclarationError(locate(error, file)) from error
    if not isinstance(plan, Plan):
        raise DeclarationError(f"{file}: plan returns {plan!r}; return an oit.Plan")
    for step in plan.passes:
        if not isinstance(step, Gather | Resolve | Interleaved | Loop):
            raise DeclarationError(f"{file}: passes hold {step!r}; a pass is Gather or Resolve")
    return plan
