"""Labels such as `NAME[param=v,w]`: their meaning, and errors in them."""

from __future__ import annotations

import math

import pytest

from oitbench.errors import UsageError
from oitbench.parameters import AnyParameter, Parameter, Value, expand, label, parse, text, without

PARAMETERS: dict[str, AnyParameter] = {
    "node": Parameter("precise", choices=("precise", "compact")),
    "count": Parameter(4, low=1, high=8),
    "alpha": Parameter(0.5, low=0.0, high=1.0),
    "radiance": Parameter(1.0, low=0.0),
    "tinted": Parameter(False),
}


def assignments(given: str) -> list[dict[str, Value]]:
    return list(expand(parse(given), PARAMETERS))


def test_a_bare_name_has_the_default_values() -> None:
    defaults = {"node": "precise", "count": 4, "alpha": 0.5, "radiance": 1.0, "tinted": False}
    assert assignments("thing") == [defaults]
    assert assignments("thing[]") == [defaults]


def test_lists_of_values_are_multiplied() -> None:
    found = assignments("thing[node=precise,compact,count=1,2,3]")
    assert [(a["node"], a["count"]) for a in found] == [
        (node, count) for node in ("precise", "compact") for count in (1, 2, 3)
    ]


def test_spaces_are_ignored_and_repeated_keys_are_combined() -> None:
    assert parse(" thing[ count = 1 , 2, node=compact, count=3 ] ").grid == {
        "count": ("1", "2", "3"),
        "node": ("compact",),
    }


def test_a_path_can_be_a_name() -> None:
    assert parse("../my-methods/x.y[count=1]").name == "../my-methods/x.y"


@pytest.mark.parametrize("given", ["", "[count=1]", "thing[count=1", "thing]", "a[b=1][c=2]"])
def test_a_label_that_cannot_be_read_is_quoted(given: str) -> None:
    with pytest.raises(UsageError, match="cannot read") as caught:
        parse(given)
    assert f"'{given}'" in str(caught.value)


def test_a_value_before_any_parameter_is_refused() -> None:
    with pytest.raises(UsageError, match="'4' comes before the first 'param='"):
        parse("thing[4]")


def test_the_error_for_an_unknown_parameter_suggests_the_nearest() -> None:
    with pytest.raises(UsageError, match="parameter of thing 'alhpa'; did you mean alpha"):
        assignments("thing[alhpa=1]")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("thing[node=tiny]", "node cannot be tiny; choose from precise, compact"),
        ("thing[node=]", "node cannot be ; choose"),
        ("thing[count=0]", "count is 0; it must be at least 1"),
        ("thing[count=9]", "count is 9; it must be at most 8"),
        ("thing[count=2.5]", "count takes int, not '2.5'"),
        ("thing[count=]", "count takes int, not ''"),
        ("thing[alpha=nan]", "alpha is nan"),
        ("thing[alpha=inf]", "alpha is inf"),
        ("thing[radiance=nan]", "radiance is nan; it must be at least 0.0"),
        ("thing[alpha=half]", "alpha takes float, not 'half'"),
        ("thing[tinted=yes]", "tinted takes bool, not 'yes'"),
    ],
)
def test_the_error_for_a_wrong_value_states_the_allowed_values(given: str, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        assignments(given)
    assert str(caught.value).startswith(f"thing: {message}")


def test_values_from_python_are_checked_too() -> None:
    assert PARAMETERS["alpha"].check("thing", "alpha", 1) == 1.0
    for wrong in (True, "0.5", math.nan):
        with pytest.raises(UsageError, match="alpha"):
            PARAMETERS["alpha"].check("thing", "alpha", wrong)


def test_a_label_has_only_values_that_differ_from_the_defaults() -> None:
    values: dict[str, Value] = {"node": "precise", "count": 2, "alpha": 0.5, "tinted": True}
    assert label("thing", values, PARAMETERS) == "thing[count=2,tinted=true]"


@pytest.mark.parametrize("value", [0.1, 1 / 3, 0.123456789, 1e-7, 1.0, 123456789.0])
def test_numbers_in_labels_are_exact(value: float) -> None:
    assert float(text(value)) == value


def test_a_label_without_a_parameter() -> None:
    assert without("lists[node=compact,size=4]", "size") == "lists[node=compact]"
    assert without("lists[size=4]", "size") == "lists"
    assert without("lists", "size") == "lists"


def test_a_sweep_contains_its_default() -> None:
    assert Parameter(4, grid=(2, 4), sweep=True).sweep
    with pytest.raises(UsageError, match=r"sweeps \(2, 8\), but its default is 4"):
        Parameter(4, grid=(2, 8), sweep=True)
