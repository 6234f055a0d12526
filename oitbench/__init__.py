"""A benchmark of order-independent transparency against exact and path-traced references."""

from __future__ import annotations

from oitbench.declare import (
    ADD,
    ATTENUATE,
    COMPOSITE,
    MODULATE,
    OVER,
    REPLACE,
    Blend,
    Buffer,
    Draws,
    Equation,
    Factor,
    Interleaved,
    Items,
    Method,
    Order,
    Pass,
    Step,
    Target,
)
from oitbench.effects import Effect
from oitbench.selector import Parameter

__version__ = "0.1.0"

__all__ = [
    "ADD",
    "ATTENUATE",
    "COMPOSITE",
    "MODULATE",
    "OVER",
    "REPLACE",
    "Blend",
    "Buffer",
    "Draws",
    "Effect",
    "Equation",
    "Factor",
    "Interleaved",
    "Items",
    "Method",
    "Order",
    "Parameter",
    "Pass",
    "Step",
    "Target",
    "__version__",
]
