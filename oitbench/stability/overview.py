"""A table of methods, measured on random stacks of layers: the one in the README."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from oitbench.effects import Effect
from oitbench.errors import CapabilityError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure import accounting
from oitbench.measure.oracle import composite
from oitbench.method.declaration import Method, Request, plan_of
from oitbench.method.passes import Gather, Order
from oitbench.method.steps import all_passes
from oitbench.parameters import text
from oitbench.scene import FragmentLists
from oitbench.stability.layers import BACKGROUND, SIDE, random_lists, scene_of
from oitbench.stability.suite import PRECISION_AXES
from oitbench.stability.tolerance import tolerance

DEPTH = 8
"""Layers per pixel at which passes and bytes are counted."""
DEEPEST = 64
"""Largest number of layers that is tested."""
OPTICAL_DEPTH = 6.0
"""Largest sum of the coverages of a stack of many layers."""
HEADINGS = (
    "method", "order independent", "exact layers", "colored transmission",
    f"geometry passes at {DEPTH} layers", f"bytes per pixel at {DEPTH} layers", "known failure",
)  # fmt: skip


@dataclass(frozen=True)
class Overview:
    """Properties of a method with its defaults.

    Parameters
    ----------
    method : str
    order_independent : bool
        Whether the method promises it.
    exact_layers : int or None
        Largest n up to `DEEPEST` for which random stacks of 1 to n layers, submitted in random
        order, are exact within the rounding of the method's finest format. None for a method with
        random pixels, which can be exact only in the mean.
    sorts : bool
        Whether the method sorts its draws. If so, the layers have one order in all pixels; other
        methods get a different order in each pixel.
    colored : str
        "yes" if the method expresses colored transmission, the parameter that makes it do so, or
        "no".
    passes : int
        Draws of all transparent geometry in a frame of `DEPTH` layers.
    bytes : float
        Memory per pixel in a frame of `DEPTH` layers.
    failure : str
        The first known failure of the docstring.
    """

    method: str
    order_independent: bool
    exact_layers: int | None
    sorts: bool
    colored: str
    passes: int
    bytes: float
    failure: str

    @property
    def cells(self) -> tuple[str, ...]:
        """The texts of a table's row, in the order of `HEADINGS`."""
        layers = "in the mean" if self.exact_layers is None else str(self.exact_layers)
        if self.exact_layers == DEEPEST:
            layers = f"≥ {DEEPEST}"
        if self.sorts:
            layers += " if sortable"
        return (
            f"`{self.method}`",
            "yes" if self.order_independent else "no",
            layers,
            self.colored,
            str(self.passes),
            f"{self.bytes:.4g}",
            self.failure,
        )


def measure(device: Device, methods: Sequence[Method]) -> list[Overview]:
    """Return the overview of each method that the driver can render."""
    found = []
    with UploadedScene(device, scene_of(random_lists(DEPTH))) as uploaded:
        methods = [method for method in methods if _renders(uploaded, method)]
        exact = _exact_layers(device, [method for method in methods if not method.noisy])
        for method in methods:
            with _frame(uploaded, method) as frame:
                frame.render()
                runs = frame.measure().passes
                found.append(
                    Overview(
                        method.label,
                        "order_independent" in method.promised,
                        exact.get(method.label),
                        _sorts(method),
                        _colored(method),
                        sum(
                            record.runs
                            for item, record in zip(frame.plan.passes, runs, strict=True)
                            if isinstance(item, Gather)
                        ),
                        accounting.memory(frame).bits_per_pixel / 8,
                        first_failure(method),
                    )
                )
    return found


def _exact_layers(device: Device, methods: Sequence[Method]) -> Mapping[str, int]:
    """Return the largest number of layers that each method composites exactly."""
    exact = {method.label: DEEPEST for method in methods}
    with UploadedScene(device, scene_of(random_lists(1))) as uploaded:
        finest = {method.label: _finest(uploaded, method) for method in methods}
    for count in range(1, DEEPEST + 1):
        for sortable in (True, False):
            left = {
                label: method
                for label, method in finest.items()
                if exact[label] == DEEPEST and _sorts(method) == sortable
            }
            if not left:
                continue
            lists = _translucent_lists(count, sortable)
            truth = composite(lists, BACKGROUND)
            with UploadedScene(device, scene_of(lists)) as uploaded:
                for label, method in left.items():
                    with _frame(uploaded, method) as frame:
                        frame.render()
                        error = float(np.abs(frame.image() - truth).max())
                    if not error <= tolerance(method, count, 1.0):
                        exact[label] = count - 1
    return exact


def _finest(uploaded: UploadedScene, method: Method) -> Method:
    """Return the variant of a method with the least rounding that this machine can render."""
    axes = [
        (name, parameter.choices or (method.values[name],))
        for name, parameter in method.parameters.items()
        if name in PRECISION_AXES
    ]
    candidates = [
        type(method)(
            **{**method.values, **dict(zip((name for name, _ in axes), values, strict=True))}
        )
        for values in product(*(choices for _, choices in axes))
    ]
    possible = [item for item in (method, *candidates) if _renders(uploaded, item)]
    return min(possible, key=lambda item: tolerance(item, 1, 1.0))


def _renders(uploaded: UploadedScene, method: Method) -> bool:
    """Return whether the driver has the capabilities that the method requires."""
    try:
        _frame(uploaded, method).release()
    except CapabilityError:
        return False
    return True


def _translucent_lists(count: int, sortable: bool) -> FragmentLists:
    """Return random lists that often have faint near layers.

    If they are `sortable`, the layers have one order in all pixels.
    """
    lists = random_lists(count)
    random = np.random.default_rng(count)
    coverage = (0.02 + 0.98 * random.random(lists.z.shape) ** 2) * min(1.0, OPTICAL_DEPTH / count)
    z = lists.z if sortable else random.permuted(lists.z, axis=0)
    return replace(lists, z=z, coverage=coverage.astype(np.float32))


def _frame(uploaded: UploadedScene, method: Method) -> Frame:
    return Frame(uploaded, method, (SIDE, SIDE), uploaded.scene.effects & method.shows)


def _colored(method: Method) -> str:
    """Return "yes", "no", or the parameter under which a method expresses colored transmission."""
    if Effect.COLORED_TRANSMISSION in method.shows:
        return "yes"
    for name, parameter in method.parameters.items():
        for choice in parameter.choices:
            if Effect.COLORED_TRANSMISSION in type(method)(**{name: choice}).shows:
                return f"with `{name}={text(choice)}`"
    return "no"


def _sorts(method: Method) -> bool:
    """Return whether the method sorts its draws."""
    passes = all_passes(plan_of(method, Request(method.shows, particles=True)).passes)
    return any(isinstance(item, Gather) and item.order is not Order.SUBMISSION for item in passes)


def first_failure(method: Method) -> str:
    """Return the first sentence after "Known failures:" in the docstring; "" if there is none."""
    text = " ".join((method.__doc__ or "").split())
    found = re.search(r"Known failures: (.+?)\.(?: |$)", text)
    return found[1] if found else ""


def table(rows: Sequence[Overview]) -> str:
    """Return the overview as a Markdown table."""
    lines = [HEADINGS, ("---",) * len(HEADINGS), *(row.cells for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
