"""Parameters, and the `NAME[param=v,w]` notation that selects plugins from the command line."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from oitbench.errors import UsageError, unknown

Value = bool | int | float | str
_PATTERN = re.compile(r"^(?P<name>[^\[\]]+?)(?:\[(?P<body>[^\[\]]*)\])?$")


@dataclass(frozen=True)
class Parameter:
    """One knob of a method or a scene.

    Parameters
    ----------
    default : bool, int, float or str
        The value when nothing is said; its type is the parameter's type.
    choices : tuple, optional
        The only values allowed.
    low, high : float, optional
        Inclusive bounds of a number.
    grid : tuple, optional
        The values that the larger presets run; the default alone without.
    help : str
        Meaning and unit, in one line.
    """

    default: Value
    choices: tuple[Value, ...] = ()
    low: float | None = None
    high: float | None = None
    grid: tuple[Value, ...] = ()
    help: str = ""

    def parse(self, owner: str, name: str, text: str) -> Value:
        """Turn `text` from the command line into a checked value."""
        kind = type(self.default)
        try:
            value: Value = (
                {"true": True, "false": False}[text.lower()] if kind is bool else kind(text)
            )
        except (ValueError, KeyError):
            raise UsageError(f"{owner}: {name} takes {kind.__name__}, not '{text}'") from None
        return self.check(owner, name, value)

    def check(self, owner: str, name: str, value: Value) -> Value:
        """Return `value` in the parameter's type; raise `UsageError` if it is not allowed."""
        kind = type(self.default)
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
        return value


@dataclass(frozen=True)
class Selector:
    """A plugin's name with lists of parameter texts, as written by the user."""

    name: str
    grid: Mapping[str, tuple[str, ...]]


def parse(text: str) -> Selector:
    """Parse `NAME` or `NAME[param=v,w][…]`; several parameters are split by commas too.

    Examples
    --------
    >>> parse("painter[node=precise,compact,resolve=sorted]").grid
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
            raise UsageError(f"cannot read '{text}'; '{part}' stands before any 'param='")
        else:
            current.append(part)
    return Selector(match["name"], {key: tuple(values) for key, values in grid.items()})


def expand(selector: Selector, parameters: Mapping[str, Parameter]) -> Iterator[dict[str, Value]]:
    """Yield every complete assignment that `selector` stands for, defaults filled in."""
    axes: list[list[tuple[str, Value]]] = []
    for name in selector.grid:
        if name not in parameters:
            raise unknown(f"parameter of {selector.name}", name, parameters)
    for name, parameter in parameters.items():
        texts = selector.grid.get(name)
        values = (
            [parameter.default]
            if texts is None
            else [parameter.parse(selector.name, name, text) for text in texts]
        )
        axes.append([(name, value) for value in values])
    for combination in itertools.product(*axes):
        yield dict(combination)


def variant(name: str, values: Mapping[str, Value], parameters: Mapping[str, Parameter]) -> str:
    """Return the canonical label: the name, and only those parameters that differ from default."""
    told = [
        f"{key}={text(value)}" for key, value in values.items() if value != parameters[key].default
    ]
    return f"{name}[{','.join(told)}]" if told else name


def text(value: Value) -> str:
    """Return `value` as it is written in `NAME[param=value]`."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and float(f"{value:g}") == value:
        return f"{value:g}"
    return str(value)
