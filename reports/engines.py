"""Algorithms of other engines beside the methods of the suite that come nearest.

`oitbench run --engine vtk,pygfx` makes these rows. Both pictures of a row are compared with the
same truth and with each other. A ratio is the time of a whole frame over that of the peer's, of
frames drawn in turns in shuffled rounds. Engines of another renderer only have ratios, since their
times share no axis with those of methods.
"""

from __future__ import annotations

from oitbench.engines import record
from oitbench.engines.record import EngineRow, Picture
from oitbench.report import Artifact, Column, Note, ReportContext, columns, write_table
from oitbench.truths import EXACT

title = "Other engines"
order = 75

_COLUMNS = (
    columns.SCENE,
    Column("engine", "Engine", kind="text"),
    Column("peer", "Peer", kind="text", help="the method of the suite that comes nearest"),
    Column("status", "Status", kind="status"),
    Column("flip", "FLIP", decimals=4, help="of the engine's picture against exact compositing"),
    Column("flip_peer", "FLIP of the peer", decimals=4, help="against exact compositing"),
    Column("flip_between", "Between", decimals=4, help="FLIP of the engine against its peer"),
    Column("ratio", "Time ratio", help="median time of a frame over that of the peer"),
    Column("ratio_low", "Low", help="lower end of its interval of at least 95 %"),
    Column("ratio_high", "High", help="upper end of its interval of at least 95 %"),
    Column("renderer", "Renderer", kind="text"),
    Column("version", "Version", kind="text"),
    Column("remark", "Differences", kind="text", help="from its peer, and limits of the engine"),
    Column("reason", "Reason", kind="text", help="why there is no picture or no time"),
)


def build(context: ReportContext) -> list[Artifact]:
    """Write one table of all rows."""
    rows = record.read(context.results.folder)
    if not rows:
        return [Note("No other engine ran; 'oitbench run --engine vtk,pygfx' asks for two.")]
    return [
        write_table(
            context.out / "engines.csv",
            _COLUMNS,
            [_cells(row, context.flip) for row in rows],
            title=title,
            caption=f"{context.flip_name} against exact compositing, and ratios of time to that "
            "of the peer.",
        )
    ]


def _cells(row: EngineRow, metric: str) -> tuple[str | float | None, ...]:
    low, high = (row.ratio and row.ratio.ends) or (None, None)
    return (
        row.place.seen,
        row.label,
        row.peer,
        row.status,
        _score(row.drawn, EXACT, metric),
        _score(row.peer_drawn, EXACT, metric),
        _score(row.drawn, record.PEER, metric),
        row.ratio.median if row.ratio else None,
        low,
        high,
        row.renderer if row.same_renderer or not row.renderer else f"{row.renderer} (another)",
        row.version,
        row.remark,
        row.reason,
    )


def _score(drawn: Picture | None, against: str, metric: str) -> float | None:
    return None if drawn is None else drawn.scores.get(against, {}).get(metric)
