"""A benchmark of order-independent transparency against exact and path-traced references."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from oitbench.effects import Effect
from oitbench.image.values import Show
from oitbench.method.blending import (
    ADD,
    ATTENUATE,
    COMPOSITE,
    COUNT,
    MAXIMUM,
    MINIMUM,
    MODULATE,
    OVER,
    PROGRAMMABLE,
    REPLACE,
    UNDER,
    Blend,
    Equation,
    Factor,
)
from oitbench.method.declaration import MSAA, Method, Plan, Request
from oitbench.method.formats import float_format
from oitbench.method.passes import Gather, Interleaved, Loop, Objects, Order, Resolve, Step
from oitbench.method.promises import promise
from oitbench.method.storage import Buffer, Items, Target
from oitbench.method.views import View
from oitbench.parameters import Parameter

if TYPE_CHECKING:
    from oitbench.api.running import open as open
    from oitbench.api.running import render, run
    from oitbench.results.comparison import compare

__version__ = "0.1.0"

# The functions behind the command line are imported when they are first used.
_FUNCTIONS = {
    "run": "oitbench.api.running",
    "open": "oitbench.api.running",
    "render": "oitbench.api.running",
    "compare": "oitbench.results.comparison",
}


def __getattr__(name: str) -> Any:
    if name in _FUNCTIONS:
        return getattr(importlib.import_module(_FUNCTIONS[name]), name)
    raise AttributeError(f"module 'oitbench' has no attribute '{name}'")


__all__ = [
    "ADD",
    "ATTENUATE",
    "COMPOSITE",
    "COUNT",
    "MAXIMUM",
    "MINIMUM",
    "MODULATE",
    "MSAA",
    "OVER",
    "PROGRAMMABLE",
    "REPLACE",
    "UNDER",
    "Blend",
    "Buffer",
    "Effect",
    "Equation",
    "Factor",
    "Gather",
    "Interleaved",
    "Items",
    "Loop",
    "Method",
    "Objects",
    "Order",
    "Parameter",
    "Plan",
    "Request",
    "Resolve",
    "Show",
    "Step",
    "Target",
    "View",
    "__version__",
    "compare",
    "float_format",
    "promise",
    "render",
    "run",
]
