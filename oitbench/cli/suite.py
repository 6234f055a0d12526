"""The options of `oitbench run --suite`."""

from __future__ import annotations

from typing import Any

import click
from click.core import ParameterSource


def free_options(suite: str, context: click.Context) -> dict[str, Any]:
    """Return the options that a suite leaves free, by the names of click's parameters.

    Raises
    ------
    UsageError
        An option that the suite fixes was given, too.
    """
    from oitbench.suites.planning import FIXED, refuse_fixed

    sources = {name: context.get_parameter_source(name) for name in context.params}
    refuse_fixed(
        suite, [name for name, kind in sources.items() if kind is not ParameterSource.DEFAULT]
    )
    return {name: value for name, value in context.params.items() if name not in FIXED}
