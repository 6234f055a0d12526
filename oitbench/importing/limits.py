"""How much the file of a user may ask for, so that a damaged one cannot take everything."""

from __future__ import annotations

from dataclasses import dataclass, field

from oitbench.errors import SceneError, printable

LIMITS = {
    "bytes": 1 << 30,
    "bytes of text": 1 << 28,
    "entries of JSON": 3_000_000,
    "nodes": 200_000,
    "cameras": 256,
    "lights": 64,
    "numbers of arrays": 100_000_000,
    "vertices": 12_000_000,
    "triangles": 4_000_000,
    "steps of cutting": 2_000_000,
    "texels of a picture": 17_000_000,
    "texels of pictures": 68_000_000,
    "texels of textures": 51_000_000,
}
"""What all files of one scene may hold together; `Budget` multiplies it by a factor."""
_LONGEST = 80


@dataclass
class Budget:
    """What is left of the limits while a file is read.

    Parameters
    ----------
    factor : float
        On all limits.
    """

    factor: float = 1.0
    _taken: dict[str, int] = field(default_factory=dict)

    def left(self, kind: str) -> int:
        """Return how much of a kind may still be taken."""
        return max(0, int(LIMITS[kind] * self.factor) - self._taken.get(kind, 0))

    def require(self, kind: str, count: int) -> None:
        """Raise `SceneError` if there is too much of something; count nothing."""
        if count > self.left(kind):
            allowed = int(LIMITS[kind] * self.factor)
            raise SceneError(
                f"the file has more than {allowed:,} {kind}; if it can be trusted, raise the"
                f" limits by [limit={2 * self.factor:g}]"
            )

    def take(self, kind: str, count: int) -> None:
        """Count something before memory is used for it.

        Raises
        ------
        SceneError
            There is too much of it.
        """
        self.require(kind, count)
        self._taken[kind] = self._taken.get(kind, 0) + count


def short(text: object) -> str:
    """Return a text of a file as a message shows it: one line of printable signs, cut if long."""
    line = printable(str(text)[: 4 * _LONGEST])
    return line if len(line) <= _LONGEST else f"{line[:_LONGEST]}…"
