"""What a report reads: the cells of a results folder, their images, and the facts of the run."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from oitbench.errors import UsageError
from oitbench.image import files as images
from oitbench.image import metrics
from oitbench.image.files import Image
from oitbench.report import palette
from oitbench.report.palette import Style
from oitbench.results import store
from oitbench.results.store import CellKey, Record

if TYPE_CHECKING:
    import pandas as pd

EXACT = "exact"
PATH_TRACED = "path_traced"
TRUTHS: Mapping[str, str] = {EXACT: "exact compositing", PATH_TRACED: "path traced"}
"""Keys of the two truths in a record, and how a reader sees them."""

FINISHED = frozenset({"ok", "unstable"})
MEBIBYTE = 2**20
MEGABYTE = 10**6


@dataclass(frozen=True)
class Ablation:
    """A cell with all effects that its scene calls for, and the same with some left out.

    Parameters
    ----------
    complete, without : Record
    named : tuple of str
        The effects that were asked to be left out, as a reader sees them.
    implied : tuple of str
        Those that went with them, as they mean nothing without.
    """

    complete: Record
    without: Record
    named: tuple[str, ...]
    implied: tuple[str, ...]


@dataclass(frozen=True)
class Panel:
    """One scene at one size in one variant: the cells that share an axis.

    What leaves effects out of one of `cells` is among its `ablations`, and in no other panel.
    """

    scene: str
    size: tuple[int, int]
    variant: str
    title: str
    slug: str
    cells: tuple[Record, ...]
    ablations: tuple[Ablation, ...] = ()

    @property
    def finished(self) -> tuple[Record, ...]:
        """Cells that have an image and numbers."""
        return tuple(cell for cell in self.cells if cell["status"] in FINISHED)


@dataclass(frozen=True)
class Results:
    """A results folder, read once.

    Parameters
    ----------
    folder : Path
    records : tuple of Record
        The newest record of every cell.
    facts : mapping
        What `run.json` says.
    hdr : bool
        Whether reports show HDR-FLIP instead of FLIP of the displayed image.
    """

    folder: Path
    records: tuple[Record, ...]
    facts: Mapping[str, Any]
    hdr: bool = False
    _styles: Mapping[str, Style] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        names = {record["method"]: bare_name(record) for record in self.records}
        known = self.facts.get("methods") or ()
        object.__setattr__(self, "_styles", palette.styles(names, known))

    @classmethod
    def load(cls, folder: Path | str, *, hdr: bool = False) -> Results:
        """Read a results folder.

        Raises
        ------
        UsageError
            If there is no such folder or it holds no cells.
        """
        folder = Path(folder)
        if not (folder / store.CELLS).is_file():
            raise UsageError(f"{folder} holds no {store.CELLS}; give the folder of a run")
        records = tuple(store.read_cells(folder / store.CELLS).values())
        return cls(folder, records, store.read_run(folder / store.RUN), hdr)

    @property
    def flip(self) -> str:
        """Name of the FLIP metric that reports show."""
        return metrics.FLIP_HDR if self.hdr else metrics.FLIP_LDR

    @property
    def scenes(self) -> tuple[str, ...]:
        """Scene labels in order of first appearance."""
        return tuple(dict.fromkeys(record["scene"] for record in self.records))

    @property
    def methods(self) -> tuple[str, ...]:
        """Method labels, sorted so that 8 comes before 16."""
        return tuple(sorted({record["method"] for record in self.records}, key=palette.natural))

    @property
    def renderer(self) -> str:
        """The GL renderer's name, or "unknown renderer"."""
        gl = self.facts.get("gl")
        return str((gl or {}).get("renderer") or "unknown renderer")

    @property
    def software(self) -> bool:
        """Whether that renderer draws on the CPU."""
        return bool((self.facts.get("gl") or {}).get("software"))

    def style(self, method: str) -> Style:
        """Return the look of a method's variant, the same in every picture."""
        return self._styles[method]

    def panels(self) -> tuple[Panel, ...]:
        """Return the cells by scene, size and variant, methods in stable order."""
        groups: dict[tuple[str, tuple[int, int], str], list[Record]] = {}
        left: dict[tuple[str, tuple[int, int], str], list[Ablation]] = {}
        known = {CellKey.of(record): record for record in self.records}
        for record in self.records:
            counterpart = _counterpart(record)
            complete = None if counterpart is None else known.get(counterpart)
            key = CellKey.of(complete or record)
            place = (key.scene, key.size, key.variant)
            if complete is None:
                groups.setdefault(place, []).append(record)
            else:
                left.setdefault(place, []).append(_ablation(complete, record))
        scenes = self.scenes
        ordered = sorted(groups, key=lambda key: (scenes.index(key[0]), key[1], key[2]))
        # A title tells what differs between the panels, not what they all share.
        sizes, variants = ({key[place] for key in ordered} for place in (1, 2))
        return tuple(
            Panel(
                *key,
                title=_title(groups[key][0], len(sizes) > 1, len(variants) > 1),
                slug=f"{place:02d}-{_slug(key[0])}",
                cells=tuple(sorted(groups[key], key=_by_method)),
                ablations=tuple(sorted(left.get(key, ()), key=lambda a: _by_method(a.complete))),
            )
            for place, key in enumerate(ordered, start=1)
        )

    def image(self, record: Record, kind: str) -> Image | None:
        """Return an image of a cell (`color`, `exact`, `path_traced`), or None if it has none."""
        path = (record.get("images") or {}).get(kind)
        if not path or not (self.folder / path).is_file():
            return None
        return images.read_exr(self.folder / path)

    def frame(self) -> pd.DataFrame:
        """Return one row per cell with flat columns; numbers that do not exist are missing."""
        import pandas as pd

        return pd.DataFrame([flat(record) for record in self.records], columns=list(flat({})))


def bare_name(record: Mapping[str, Any]) -> str:
    """Return the method's name without its parameters."""
    return str(record.get("name") or str(record["method"]).partition("[")[0])


def metric(record: Mapping[str, Any], truth: str, name: str) -> float | None:
    """Return a metric of a cell against a truth, or None."""
    values = (record.get("metrics") or {}).get(truth) or {}
    return _number(values.get(name))


def noise_floor(record: Mapping[str, Any], name: str) -> float | None:
    """Return the metric between two halves of the path-traced reference, or None."""
    values = (record.get("metrics") or {}).get(PATH_TRACED) or {}
    return _number((values.get("noise_floor") or {}).get(name))


def largest_floor(cells: Iterable[Record], name: str) -> float | None:
    """Return the largest noise floor of the cells' path-traced truth, or None if none is known."""
    floors = [noise_floor(cell, name) for cell in cells]
    return max((floor for floor in floors if floor is not None), default=None)


def frame_time(record: Mapping[str, Any]) -> tuple[float, float, float] | None:
    """Return the median frame time and its 95 % interval in milliseconds, or None."""
    times = (record.get("time") or {}).get("frame_ms") or {}
    median = _number(times.get("median"))
    if median is None or median <= 0:
        return None
    low, high = _number(times.get("low")), _number(times.get("high"))
    return median, min(low or median, median), max(high or median, median)


def unstable_pixels(record: Mapping[str, Any]) -> int:
    """Return how many pixels were not finite or negative; one pixel may count twice."""
    counts = record.get("nonfinite") or {}
    return sum(int(counts.get(kind) or 0) for kind in ("nan", "inf", "negative"))


def effect_label(effect: str) -> str:
    """Return an effect's name as a reader sees it."""
    words = effect.lower().split("_")
    return " ".join("AO" if word == "ao" else word for word in words)


def called_effects(record: Mapping[str, Any]) -> list[str]:
    """Return the names of the effects that the scene calls for and that were not left out."""
    return list((record.get("effects") or {}).get("called") or [])


def fullest(cells: Iterable[Record], flip: str) -> Record | None:
    """Return the cell that misses the fewest effects; of several, the nearest to path tracing."""

    def shortcomings(cell: Record) -> tuple[int, float, Any]:
        error = metric(cell, PATH_TRACED, flip)
        return len(missing_effects(cell)), math.inf if error is None else error, _by_method(cell)

    return min(cells, key=shortcomings, default=None)


def missing_effects(record: Mapping[str, Any]) -> list[str]:
    """Return the effects that the scene calls for and the method cannot express."""
    return list((record.get("effects") or {}).get("missing") or [])


def terms(record: Mapping[str, Any], account: str) -> list[dict[str, Any]]:
    """Return the terms of a cell's `memory` or `traffic`."""
    return list((record.get(account) or {}).get("terms") or [])


def total(record: Mapping[str, Any], account: str, unit: float = 1) -> float | None:
    """Return the bytes of a cell's `memory` or `traffic` in that unit, or None."""
    count = _number((record.get(account) or {}).get("bytes"))
    return None if count is None else count / unit


def shaded_total(record: Mapping[str, Any], account: str, unit: float = 1) -> float | None:
    """Return what `total` does, with what the stages that all methods share add to it."""
    own, shared = total(record, account, unit), total(record.get("shading") or {}, account, unit)
    return None if own is None else own + (shared or 0.0)


def flat(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return a cell as one row; an empty record gives the columns."""
    size = record.get("size") or (None, None)
    variant = record.get("variant") or {}
    time = frame_time(record) or (None, None, None)
    row: dict[str, Any] = {
        "scene": record.get("scene"),
        "method": record.get("method"),
        "name": bare_name(record) if record else None,
        "width": size[0],
        "height": size[1],
        "variant": ", ".join(_told(variant)),
        "status": record.get("status"),
        "reason": record.get("reason"),
        "frame_ms": time[0],
        "frame_ms_low": time[1],
        "frame_ms_high": time[2],
        "memory_mib": total(record, "memory", MEBIBYTE),
        "bits_per_pixel": _number((record.get("memory") or {}).get("bits_per_pixel")),
        "traffic_mb": total(record, "traffic", MEGABYTE),
        "fragments": record.get("fragments"),
        "max_depth_complexity": record.get("max_depth_complexity"),
        "missing_effects": ", ".join(missing_effects(record)),
        "unstable_pixels": unstable_pixels(record),
    }
    for truth in TRUTHS:
        row |= {f"{truth}.{name}": metric(record, truth, name) for name in metrics.NAMES}
    for name in (metrics.TRANSMITTANCE, metrics.ORDER_SPREAD_MAX, metrics.ORDER_SPREAD_MEAN):
        row[f"{EXACT}.{name}"] = metric(record, EXACT, name)
    for name in (metrics.FLIP_LDR, metrics.FLIP_HDR, metrics.RMSE):
        row[f"noise_floor.{name}"] = noise_floor(record, name)
    return row


def _by_method(record: Record) -> tuple[tuple[int, str], ...]:
    return palette.natural(record["method"])


def _left_out(record: Mapping[str, Any]) -> list[str]:
    """Return the effects that a cell's variant was asked to leave out."""
    text = str(record["variant"].get("effects", ""))
    return [part.strip().removeprefix("-") for part in text.split(",") if text.startswith("-")]


def _counterpart(record: Record) -> CellKey | None:
    """Return the cell from which this one leaves effects out, or None if it leaves out none."""
    if not _left_out(record):
        return None
    return CellKey.of({**record, "variant": {**record["variant"], "effects": "called"}})


def _ablation(complete: Record, record: Record) -> Ablation:
    named = _left_out(record)
    gone = [effect.lower() for effect in called_effects(complete)]
    remaining = [effect.lower() for effect in called_effects(record)]
    implied = [effect for effect in gone if effect not in (*remaining, *named)]
    # A cell that did not finish tells no effects.
    finished = record["status"] in FINISHED
    return Ablation(
        complete,
        record,
        tuple(map(effect_label, named)),
        tuple(map(effect_label, implied if finished else ())),
    )


def _number(value: Any) -> float | None:
    return None if value is None or isinstance(value, bool) else float(value)


def _told(variant: Mapping[str, Any]) -> Iterable[str]:
    """Yield a variant's settings as words."""
    for key, value in variant.items():
        words = " ".join(map(str, value)) if isinstance(value, list | tuple) else value
        yield f"{key} {words}"


def _title(record: Mapping[str, Any], tell_size: bool, tell_variant: bool) -> str:
    width, height = record["size"]
    size = [f"{width} × {height}"] * tell_size
    return " · ".join([str(record["scene"]), *size, *list(_told(record["variant"])) * tell_variant])


def _slug(label: str) -> str:
    return "".join(letter if letter.isalnum() else "_" for letter in label).strip("_")
