"""A benchmark of order-independent transparency against exact and path-traced references."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from oitbench.effects import Effect
from oitbench.method.declaration import (
    ADD,
    ATTENUATE,
    COMPOSITE,
    MAXIMUM,
    MINIMUM,
    MODULATE,
    OVER,
    PROGRAMMABLE,
    REPLACE,
    UNDER,
    Blend,
    Buffer,
    Draws,
    Equation,
    Factor,
    Interleaved,
    Items,
    Loop,
    Method,
    Objects,
    Order,
    Pass,
    Step,
    Target,
)
from oitbench.parameters import Parameter

if TYPE_CHECKING:
    from oitbench.matrix.picture import render
    from oitbench.matrix.run import execute as run
    from oitbench.results.comparison import compare

__version__ = "0.1.0"

# The verbs of the command line; what renders is imported when it is called.
_VERBS = {
    "run": ("oitbench.matrix.run", "execute"),
    "render": ("oitbench.matrix.picture", "render"),
    "compare": ("oitbench.results.comparison", "compare"),
}


def __getattr__(name: str) -> Any:
    if name in _VERBS:
        module, function = _VERBS[name]
        return getattr(importlib.import_module(module), function)
    raise AttributeError(f"module 'oitbench' has no attribute '{name}'")


__all__ = [
    "ADD",
    "ATTENUATE",
    "COMPOSITE",
    "MAXIMUM",
    "MINIMUM",
    "MODULATE",
    "OVER",
    "PROGRAMMABLE",
    "REPLACE",
    "UNDER",
    "Blend",
    "Buffer",
    "Draws",
    "Effect",
    "Equation",
    "Factor",
    "Interleaved",
    "Items",
    "Loop",
    "Method",
    "Objects",
    "Order",
    "Parameter",
    "Pass",
    "Step",
    "Target",
    "__version__",
    "compare",
    "render",
    "run",
]
