"""Parameters, and the notation `NAME[param=v,w]` that selects plugins on the command line."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, overload

from oitbench.errors import UsageError, unknown

Value = bool | int | float | str
V = TypeVar("V", bool, int, float, str)
_PATTERN = re.compile(r"^(?P<name>[^\[\]]+?)(?:\[(?P<body>[^\[\]]*)\])?$")


@dataclass(frozen=True)
class Parameter(Generic[V]):
    """A parameter of a method or of a scene.

    As a class attribute of a method, it has the type of its value on instances.

    Parameters
    ----------
    default : bool, int, float or str
        Its type is the type of the parameter.
    choices : tuple, optional
        The only allowed values.
    low, high : float, optional
        Inclusive bounds of a number.
    grid : tuple, optional
        Values that the preset `paper` runs. Default: only `default`.
    sweep : bool
        The grid trades cost for accuracy: `standard` runs it, too, and the report joins its values
        to a curve.
    help : str
        Meaning and unit, in one line.
    """

    default: V
    choices: tuple[V, ...] = ()
    low: float | None = None
    high: float | None = None
    grid: tuple[V, ...] = ()
    sweep: bool = False
    help: str = ""

    def __post_init__(self) -> None:
        for value in (self.default, *self.choices, *self.grid):
            finite = not isinstance(value, float) or math.isfinite(value)
            if type(value) not in (bool, int, float, str) or not finite:
                allowed = "a finite number, true, false or text"
                raise UsageError(f"a value of a parameter is {value!r}; it must be {allowed}")
        if self.sweep and self.default not in self.grid:
            raise UsageError(f"a parameter sweeps {self.grid}, but its default is {self.default}")

    @overload
    def __get__(self, instance: None, owner: type) -> Parameter[V]: ...

    @overload
    def __get__(self, instance: object, owner: type) -> V: ...

    def __get__(self, instance: object | None, owner: type) -> Parameter[V] | V:
        """Return the parameter itself: instances store its value under the same name."""
        return self

    def parse(self, owner: str, name: str, text: str) -> V:
        """Convert `text` from the command line to a checked value."""
        kind: Any = type(self.default)
        try:
            value = {"true": True, "false": False}[text.lower()] if kind is bool else kind(text)
        except (ValueError, KeyError):
            raise UsageError(f"{owner}: {name} takes {kind.__name__}, not '{text}'") from None
        return self.check(owner, name, value)

    def check(self, owner: str, name: str, value: Any) -> V:
        """Return `value` in the parameter's type; raise `UsageError` if it is not allowed."""
        kind: Any = type(self.default)
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if type(value) is not kind:
            raise UsageError(f"{owner}: {name} takes {kind.__name__}, not {value!r}")
        if self.choices and value not in self.choices:
            allowed = ", ".join(str(choice) for choice in self.choices)
            raise UsageError(f"{owner}: {name} cannot be {value}; choose from {allowed}")
        if isinstance(value, int | float) and not isinstance(value, bool):
            # Written so that NaN fails as well.
            if self.low is not None and not value >= self.low:
                raise UsageError(f"{owner}: {name} is {value}; it must be at least {self.low}")
            if self.high is not None and not value <= self.high:
                raise UsageError(f"{owner}: {name} is {value}; it must be at most {self.high}")
        checked: V = value
        return checked


AnyParameter = Parameter[Any]


@dataclass(frozen=True)
class Selector:
    """Name of a plugin with the values of its parameters as text, as the user wrote them."""

    name: str
    grid: Mapping[str, tuple[str, ...]]


def parse(text: str) -> Selector:
    """Parse `NAME` or `NAME[param=v,w,other=x]`.

    Examples
    --------
    >>> parse("lists[node=precise,compact,resolve=sorted]").grid
    {'node': ('precise', 'compact'), 'resolve': ('sorted',)}
    """
    match = _PATTERN.match(text.strip())
    if match is None:
        raise UsageError(f"cannot read '{text}'; write NAME or NAME[param=value,value,...]")
    grid: dict[str, list[str]] = {}
    current: list[str] | None = None
    for part in filter(None, (piece.strip() for piece in (match["body"] or "").split(","))):
        if "=" in part:
            key, _, value = part.partition("=")
            current = grid.setdefault(key.strip(), [])
            current.append(value.strip())
        elif current is None:
            raise UsageError(f"cannot read '{text}': '{part}' comes before the first 'param='")
        else:
            current.append(part)
    return Selector(match["name"], {key: tuple(values) for key, values in grid.items()})


def selector(name: str, grid: Mapping[str, Sequence[Value]]) -> str:
    """Return the text `NAME[param=v,w]` that selects lists of values of some parameters."""
    axes = [f"{key}={','.join(map(text, values))}" for key, values in grid.items()]
    return f"{name}[{','.join(axes)}]" if axes else name


def without(label: str, key: str) -> str:
    """Return a label without one of its parameters.

    Examples
    --------
    >>> without("lists[node=compact,size=4]", "size")
    'lists[node=compact]'
    """
    parsed = parse(label)
    kept = {name: values for name, values in parsed.grid.items() if name != key}
    return selector(parsed.name, kept)


def grids(parameters: Mapping[str, AnyParameter]) -> dict[str, tuple[Value, ...]]:
    """Return the grids of all parameters that have one."""
    return {key: parameter.grid for key, parameter in parameters.items() if parameter.grid}


def sweeps(parameters: Mapping[str, AnyParameter]) -> dict[str, tuple[Value, ...]]:
    """Return the grids of all parameters that trade cost for accuracy."""
    return {key: parameter.grid for key, parameter in parameters.items() if parameter.sweep}


def expand(parsed: Selector, parameters: Mapping[str, AnyParameter]) -> Iterator[dict[str, Value]]:
    """Yield all combinations of values that a selector selects, with defaults filled in."""
    axes: list[list[tuple[str, Value]]] = []
    for name in parsed.grid:
        if name not in parameters:
            raise unknown(f"parameter of {parsed.name}", name, parameters)
    for name, parameter in parameters.items():
        texts = parsed.grid.get(name)
        values = (
            [parameter.default]
            if texts is None
            else [parameter.parse(parsed.name, name, text) for text in texts]
        )
        axes.append([(name, value) for value in values])
    for combination in itertools.product(*axes):
        yield dict(combination)


def label(name: str, values: Mapping[str, Value], parameters: Mapping[str, AnyParameter]) -> str:
    """Return the canonical label: the name with the parameters that differ from their defaults."""
    changed = [
        f"{key}={text(value)}" for key, value in values.items() if value != parameters[key].default
    ]
    return f"{name}[{','.join(changed)}]" if changed else name


def text(value: Value) -> str:
    """Return `value` as it is written in `NAME[param=value]`."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and float(f"{value:g}") == value:
        return f"{value:g}"
    return str(value)


def natural(label: str) -> tuple[tuple[int, str], ...]:
    """Return a sort key of a label that puts 8 before 16."""
    return tuple(
        (int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", label)
    )
