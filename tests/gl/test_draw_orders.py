"""The order of submission lies on the device once, and shuffled draws leave it alone."""

from __future__ import annotations

import numpy as np

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from tests.helpers import collection, method

SIZE = (16, 16)


def test_frames_share_the_order_of_submission(device: Device) -> None:
    scene = collection().build_scene("layer_stack[count=6]")
    blend, average, sort = map(method, ("alpha_blend", "weighted_average", "sorted_over"))
    with UploadedScene(device, scene, rows=SIZE[1]) as uploaded:
        frames = [Frame(uploaded, chosen, SIZE) for chosen in (blend, average, sort)]
        for frame in frames:
            frame.render()
        orders = [list(frame.orders.uploaded.values()) for frame in frames]
        one, other, own = (found.indices for (found,) in orders)
        assert one is other
        assert own is not one
        first, before = frames[0], one.read()
        picture = first.image()
        first.render(permutation=3)
        assert not np.array_equal(first.image(), picture)
        assert one.read() == before
        first.render()
        assert np.array_equal(first.image(), picture)
        for frame in frames:
            frame.release()
