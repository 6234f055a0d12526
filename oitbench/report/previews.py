"""Small lossy copies of pictures inside of the page, which therefore shows them on its own."""

from __future__ import annotations

import base64
import io
import math

from oitbench.image.files import Image
from oitbench.report.pixels import display_codes

CHARACTERS = 16_000_000
"""Room for all previews of a page, so that the page stays below 25 MB."""
_SIDES = (256, 192, 128, 96, 64, 32)
_QUALITY = 80
_SLACK = 1.2
"""Factor of the side at which the same bytes for each pixel would fit: small copies lose noise."""


def room(count: int) -> int:
    """Return the characters that each of `count` previews may take."""
    return CHARACTERS // max(1, count)


def preview(srgb: Image, characters: int) -> str:
    """Return the address (`data:`) of a copy of a picture, as large as fits.

    Parameters
    ----------
    srgb : array, shape (h, w, 3)
        Display values in [0, 1].
    characters : int
        Length that the address should not exceed; the smallest copy may.
    """
    from PIL import Image as Picture

    picture = Picture.fromarray(display_codes(srgb))
    address, most = "", math.inf
    for side in _SIDES:
        if side > most and side != _SIDES[-1]:
            continue
        copy = picture.copy()
        # Smaller pictures stay as they are.
        copy.thumbnail((side, side))
        content = io.BytesIO()
        copy.save(content, "WEBP", quality=_QUALITY, method=2)
        address = "data:image/webp;base64," + base64.b64encode(content.getvalue()).decode()
        if len(address) <= characters:
            break
        most = max(copy.size) * math.sqrt(characters / len(address)) * _SLACK
    return address
