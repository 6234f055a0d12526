"""Crops: parts of a scene's picture that readers should look at, by name, from the scene's file."""

from __future__ import annotations

from collections.abc import Mapping

from oitbench.views import MAIN, is_name

Crop = tuple[float, float, float, float]
"""Left, top, width and height in fractions of the picture, from its upper left corner."""
LEAST = 0.01
"""Smallest width and height of a crop."""


def check(crops: object) -> dict[str, Crop]:
    """Return the crops that a scene's file states.

    Parameters
    ----------
    crops : mapping of str to Crop
        By name, with small letters, digits and underscores. `NAME@VIEW` is a crop of another view
        than the main one.

    Raises
    ------
    ValueError
        A name cannot be used, or a crop is not inside of the picture.
    """
    if not isinstance(crops, Mapping):
        raise ValueError(f"crops is {crops!r}; map names to (left, top, width, height)")
    found: dict[str, Crop] = {}
    for name, box in crops.items():
        if not isinstance(name, str) or not all(map(is_name, name.split("@", 1))):
            raise ValueError(
                f"no crop can be named {name!r}; write NAME or NAME@VIEW with small letters,"
                " digits and underscores"
            )
        if not _inside(box):
            raise ValueError(
                f"crop {name} is {box!r}; give (left, top, width, height) as fractions of the"
                f" picture, inside of it and at least {LEAST:g} wide and high"
            )
        left, top, width, height = map(float, box)
        found[name] = (left, top, width, height)
    return found


def of_view(crops: Mapping[str, Crop], view: str) -> dict[str, Crop]:
    """Return the crops of one view by their plain names."""
    split = {name: name.partition("@") for name in crops}
    return {split[name][0]: box for name, box in crops.items() if (split[name][2] or MAIN) == view}


def _inside(box: object) -> bool:
    if not isinstance(box, tuple | list) or len(box) != 4:
        return False
    if not all(isinstance(value, int | float) for value in box):
        return False
    left, top, width, height = box
    # Sums of decimal fractions may round to a little more than 1. A comparison with NaN is false.
    fits = left + width <= 1 + 1e-9 and top + height <= 1 + 1e-9
    return bool(left >= 0 and top >= 0 and width >= LEAST and height >= LEAST and fits)
