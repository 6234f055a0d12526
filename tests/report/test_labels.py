"""Labels beside crowded points."""

from __future__ import annotations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from oitbench.report import labels


def test_labels_do_not_overlap() -> None:
    figure = Figure(figsize=(6, 4))
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.set_xlim(0, 10)
    axes.set_ylim(0, 10)
    random = np.random.default_rng(2)
    crowd = [
        labels.Label(x, y, f"method {place}", "#000000", x, x)
        for place, (x, y) in enumerate(random.normal(5, 0.8, (14, 2)))
    ]
    labels.place(axes, crowd)
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 14
    for place, box in enumerate(boxes):
        assert axes.bbox.contains(*box.min)
        for other in boxes[:place]:
            width = min(box.x1, other.x1) - max(box.x0, other.x0)
            height = min(box.y1, other.y1) - max(box.y0, other.y0)
            assert width <= 0 or height <= 0
