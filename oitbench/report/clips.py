"""Animated pictures of methods in motion, for slides."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from oitbench.filenames import file_name
from oitbench.image.files import Image
from oitbench.report.error_maps import magma
from oitbench.report.motion import CHANGE, Footage

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

_MILLISECONDS = 80
"""Time of each frame."""
_LEAST_WIDTH = 256
"""Pixels of each panel; smaller frames are enlarged by a whole number."""
_BAND = 18
"""Height of the text in pixels."""
_GAP = 4


def write(footage: Footage, folder: Path, kind: str) -> list[Path]:
    """Write one clip for each track: exact compositing, the method, and its excess change.

    Parameters
    ----------
    footage : Footage
    folder : Path
        Created if it does not exist.
    kind : str
        "webp", which is exact, or "gif", which has 256 colors.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for track in footage.found.tracks:
        path = folder / f"{file_name(track.label)}.{kind}"
        shown = [footage.shown(image) for image in track.frames]
        first, *others = [_panels(footage, track.label, shown, k) for k in range(len(shown))]
        # The format of GIF ignores what it does not know.
        first.save(
            path,
            save_all=True,
            append_images=others,
            duration=_MILLISECONDS,
            loop=0,
            lossless=True,
        )
        written.append(path)
    return written


def _panels(footage: Footage, label: str, shown: Sequence[Image], number: int) -> Picture:
    """Return one frame of a clip."""
    from PIL import Image as Pictures
    from PIL import ImageDraw

    height, width = footage.exact[0].shape[:2]
    scale = max(1, -(-_LEAST_WIDTH // width))
    change = np.zeros((height, width), np.float32)
    if number:
        change = footage.change(number - 1, shown[number - 1 : number + 1])
    panels = (
        ("exact compositing", footage.exact[number]),
        (label, shown[number]),
        ("excess change", magma(change / CHANGE)),
    )
    step = scale * width + _GAP
    picture = Pictures.new("RGB", (3 * step - _GAP, scale * height + _BAND), "white")
    pen = ImageDraw.Draw(picture)
    for place, (text, panel) in enumerate(panels):
        picture.paste(Pictures.fromarray(_levels(panel, scale)), (place * step, _BAND))
        pen.text((place * step + 2, 3), text, fill="black")
    return picture


def _levels(panel: Image, scale: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return 8-bit levels, each pixel enlarged to a square."""
    levels = np.rint(np.clip(panel, 0, 1) * 255).astype(np.uint8)
    return levels.repeat(scale, axis=0).repeat(scale, axis=1)
