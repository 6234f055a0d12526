"""Pictures side by side with their error maps, as a notebook shows them."""

from __future__ import annotations

import base64
import html
import io
import math
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oitbench.atomic import replacing
from oitbench.errors import UsageError
from oitbench.image.files import Image
from oitbench.report import error_maps, figures, plates

_COLUMNS = 6
_LABEL_WIDTH = 24
# Inches of a picture, of the lines above and below it, and between two of them.
_PICTURE, _LABEL, _CAPTION, _GAP, _TITLE = 1.7, 0.36, 0.62, 0.12, 0.5
_STYLE = "image-rendering:pixelated;width:100%;display:block;margin:0 0 .2em"
_GRID = "display:grid;gap:.8em;grid-template-columns:repeat(auto-fill,minmax(12em,1fr))"
_TEXT = "overflow-wrap:anywhere;font:.8em sans-serif"


@dataclass(frozen=True, eq=False)
class Tile:
    """A picture with its error map.

    Parameters
    ----------
    label, caption : str
    picture : array, shape (h, w, 3), optional
        sRGB-encoded, in [0, 1]. None: there is none, and the caption says why.
    errors : array, shape (h, w), optional
    truth : bool
    """

    label: str
    caption: str
    picture: Image | None
    errors: Image | None
    truth: bool = False


@dataclass(frozen=True, eq=False)
class Gallery:
    """The tiles of a scene; error maps share one scale, which ends at their largest value.

    Parameters
    ----------
    title : str
    tiles : tuple of Tile
    metric : str
        What error maps show, for readers.
    """

    title: str
    tiles: tuple[Tile, ...]
    metric: str

    @property
    def largest(self) -> float:
        """The end of the scale of error maps; 0 if there are none."""
        return max((float(t.errors.max()) for t in self.tiles if t.errors is not None), default=0.0)

    @property
    def scale(self) -> str:
        """The scale of error maps in words."""
        return f"error maps: {self.metric}, black 0 to pale yellow {self.largest:.3g}"

    def __repr__(self) -> str:
        return f"<Gallery of {self.title}: {', '.join(tile.label for tile in self.tiles)}>"

    def save(self, path: Path | str) -> None:
        """Write the gallery to a file that ends in .html or .png.

        Raises
        ------
        UsageError
            The name has another end, or the file cannot be written.
        """
        path = Path(path)
        if path.suffix not in (".html", ".png"):
            raise UsageError(f"{path}: end the name in .html or .png")
        content = self._page() if path.suffix == ".html" else self._repr_png_()
        with replacing(path) as partial:
            partial.write_bytes(content)

    def _page(self) -> bytes:
        head = f'<!doctype html><meta charset="utf-8"><title>{html.escape(self.title)}</title>'
        return (head + self._repr_html_()).encode(errors="backslashreplace")

    def _repr_html_(self) -> str:
        """Return the gallery for a notebook; pictures are part of the text, lossless at 8 bits."""
        figures_ = "".join(map(self._figure, self.tiles))
        title = f"<b>{html.escape(self.title)}</b><br>{html.escape(self.scale)}"
        return f'<div style="{_TEXT}"><p>{title}</p><div style="{_GRID}">{figures_}</div></div>'

    def _figure(self, tile: Tile) -> str:
        label, caption = html.escape(tile.label), html.escape(tile.caption)
        images = [] if tile.picture is None else [(label, tile.picture)]
        if tile.errors is not None:
            images.append((f"error map of {label}", self._colored(tile.errors)))
        shown = "".join(
            f'<img alt="{text}" style="{_STYLE}" src="data:image/png;base64,{_base64(image)}">'
            for text, image in images
        )
        name = f"<b>{label}</b>" if tile.truth else label
        return f'<figure style="margin:0">{name}{shown}<figcaption>{caption}</figcaption></figure>'

    def _colored(self, errors: Image) -> Image:
        return error_maps.magma(errors / (self.largest or 1.0))

    def _repr_png_(self) -> bytes:
        """Return the gallery as one picture."""
        known = next((tile.picture for tile in self.tiles if tile.picture is not None), None)
        size = (1, 1) if known is None else (known.shape[1], known.shape[0])
        width, height = plates.fitted(size, _PICTURE)
        columns = min(_COLUMNS, max(1, len(self.tiles)))
        tile_height = _LABEL + 2 * height + _CAPTION
        rows = math.ceil(len(self.tiles) / columns)
        whole = max(columns * (width + _GAP) + _GAP, 6.0)
        content = io.BytesIO()
        with figures.canvas(whole, _TITLE + rows * tile_height, by_hand=True) as canvas:
            plates.write(canvas, f"{self.title}\n{self.scale}", _GAP, 0.05, 7.5, below=True)
            for place, tile in enumerate(self.tiles):
                left = _GAP + place % columns * (width + _GAP)
                top = _TITLE + place // columns * tile_height + _LABEL
                heading = _broken(tile.label)
                plates.write(canvas, heading, left, top - 0.04, 7.5, bold=tile.truth)
                below = top
                if tile.picture is not None:
                    plates.draw_picture(canvas, tile.picture, left, top, width)
                    below += height
                if tile.errors is not None:
                    plates.draw_picture(canvas, self._colored(tile.errors), left, below, width)
                    below += height
                caption = textwrap.fill(tile.caption, _LABEL_WIDTH)
                plates.write(canvas, caption, left, below + 0.04, 7, below=True)
            canvas.savefig(content, format="png", metadata={"Software": None})
        return content.getvalue()


def _broken(label: str) -> str:
    """Return a long label in several lines; its parameters begin a new one."""
    if len(label) <= _LABEL_WIDTH:
        return label
    name, bracket, parameters = label.partition("[")
    return "\n".join(textwrap.fill(part, _LABEL_WIDTH) for part in (name, bracket + parameters))


def _base64(image: Image) -> str:
    """Return a picture of 8 bits as a PNG file in text."""
    from PIL import Image as Picture

    content = io.BytesIO()
    levels = np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8)
    Picture.fromarray(levels).save(content, format="PNG")
    return base64.b64encode(content.getvalue()).decode("ascii")
