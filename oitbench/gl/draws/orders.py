"""The draw orders of a frame, and sorting as every frame must repeat it."""

from __future__ import annotations

from collections.abc import Hashable, Iterable

import moderngl

from oitbench.gl.batches import IndexOrder
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.method.passes import Gather, Objects, Order, Pass


class DrawOrders(Owner):
    """Every order of transparent geometry that the passes of a frame draw.

    Parameters
    ----------
    context : moderngl.Context
    geometry : Geometry
        Owns the order of submission, which all frames share.
    passes : iterable of Gather or Resolve

    Attributes
    ----------
    uploaded : dict to IndexOrder
        By order and objects, the key that a gather pass asks for.
        Empty before `arrange`.
    """

    def __init__(
        self,
        context: moderngl.Context,
        geometry: Geometry,
        passes: Iterable[Pass],
    ) -> None:
        super().__init__()
        self._context, self._geometry = context, geometry
        self._buffers: dict[Hashable, moderngl.Buffer] = {}
        wanted = {(item.order, item.objects) for item in passes if isinstance(item, Gather)}
        self._wanted = sorted(wanted, key=str)
        self.uploaded: dict[Hashable, IndexOrder] = {}

    @property
    def sorts(self) -> bool:
        """Whether an order depends on the camera, so that every frame sorts again."""
        return any(order is not Order.SUBMISSION for order, _ in self._wanted)

    def arrange(self, permutation: int | None = None) -> None:
        """Arrange and upload all orders.

        Parameters
        ----------
        permutation : int, optional
            Seed that shuffles the draws, within the freedom that each order leaves.
        """
        for order, objects in self._wanted:
            self._upload(order, objects, permutation)

    def sort(self) -> None:
        """Arrange and upload the orders that depend on the camera."""
        for order, objects in self._wanted:
            if order is not Order.SUBMISSION:
                self._upload(order, objects, None)

    def _upload(self, order: Order, objects: Objects, permutation: int | None) -> None:
        key, batch = (order, objects), self._geometry.batches[objects]
        if order is Order.SUBMISSION and permutation is None:
            self.uploaded[key] = self._geometry.in_submission_order(batch)
            return
        triangles, units = batch.arrange(order, permutation)
        buffer = self._buffers.get(key)
        arranged = IndexOrder.upload(self._context, triangles, units, buffer)
        if buffer is None:
            self._buffers[key] = self.own(arranged.indices)
        self.uploaded[key] = arranged
