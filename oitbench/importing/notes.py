"""What an imported scene shows differently from its file: one line for each kind."""

from __future__ import annotations

from oitbench.importing.limits import short

_MOST = 40


class Notes:
    """Collects the kinds of content that are not shown as the file says, and where they are."""

    def __init__(self) -> None:
        self._places: dict[str, dict[str, None]] = {}

    def add(self, kind: str, place: str = "") -> None:
        """Note that a kind of content was left out or approximated.

        Parameters
        ----------
        kind : str
            A whole line, without a full stop.
        place : str
            Where it is, as in "material glass".
        """
        places = self._places.setdefault(short(kind) if len(kind) > 400 else kind, {})
        if place:
            places[short(place)] = None

    @property
    def lines(self) -> tuple[str, ...]:
        """One line for each kind, with the first place and the number of others."""
        return tuple(f"{kind}{_where(list(places))}" for kind, places in self._places.items())[
            :_MOST
        ]


def _where(places: list[str]) -> str:
    if not places:
        return ""
    others = f" and {len(places) - 1} more" if len(places) > 1 else ""
    return f" ({places[0]}{others})"
