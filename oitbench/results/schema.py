"""The record of a cell and the facts of a run: every field, its type and its unit.

`json_schema.py` writes both as a JSON Schema.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal, Protocol

import msgspec
from msgspec import Meta, Struct

from oitbench.effects import effects_of
from oitbench.image.stored import StoredImage
from oitbench.image.ties import Errors
from oitbench.method.demands import Demands
from oitbench.method.families import OTHER
from oitbench.parameters import Value
from oitbench.results.custom import CustomMetric
from oitbench.results.statistics import Count, SceneStatistics
from oitbench.results.times import Processor, Time
from oitbench.truths import ranking_truth
from oitbench.views import MAIN, seen

VERSION: Final = 6
"""Version of the schema; a change of any field raises it."""

Size = tuple[int, int]
Status = Literal["ok", "unstable", "suspect", "failed", "skipped", "timeout"]
FINISHED: frozenset[Status] = frozenset({"ok", "unstable", "suspect"})
"""Statuses of cells that have an image and numbers."""
TROUBLED: frozenset[Status] = frozenset({"unstable", "suspect", "failed", "timeout"})
"""Statuses of cells that a user should look at; a run that has one exits with 1."""

WHOLE = "whole"
"""Key of the scores and images of a cell that leaves effects out, against the ranking truth with
all effects that the scene requests."""
COMPLEXITY = "complexity"
"""Key of `Outcome.images` for the map of depth complexity."""
TRANSMITTANCE = "transmittance"
"""Key of `Outcome.images` for the total transmittance of exact compositing."""


class _Typed(Struct, frozen=True, forbid_unknown_fields=True):
    """Base of all parts of a record."""


class MemoryTerm(_Typed, frozen=True):
    """Bytes of one resource."""

    resource: str
    bytes: Count


class Memory(_Typed, frozen=True):
    """Bytes that a method allocates."""

    bytes: Count
    bits_per_pixel: float
    terms: list[MemoryTerm]


class TrafficTerm(_Typed, frozen=True, rename={"pass_": "pass"}):
    """Bytes that one pass moves in one way: `clear`, `read`, `write`, `blend` or `atomic`."""

    pass_: str
    resource: str
    kind: Literal["clear", "read", "write", "blend", "atomic"]
    items: Count
    bytes_per_item: Count
    bytes: Count


class Traffic(_Typed, frozen=True):
    """Bytes that a frame moves, without caches and compression."""

    bytes: Count
    terms: list[TrafficTerm]


class SharedShading(_Typed, frozen=True):
    """Accounts and settings of the stages that all methods share.

    These are shadow maps and ambient occlusion.
    """

    memory: Memory
    traffic: Traffic
    settings: dict[str, Value] = {}


class PassRuns(_Typed, frozen=True):
    """Number of draws of one pass in a frame."""

    name: str
    runs: Count


class Nonfinite(_Typed, frozen=True):
    """Number of pixels with a channel that is NaN, infinite or negative."""

    nan: Count = 0
    inf: Count = 0
    negative: Count = 0

    @property
    def total(self) -> int:
        """Sum of all three; a pixel can count twice."""
        return self.nan + self.inf + self.negative


class EffectNames(_Typed, frozen=True):
    """Effects that the scene requests, that ran, and that the method cannot express."""

    requested: list[str]
    expressed: list[str]
    missing: list[str]


class ReferenceFacts(_Typed, frozen=True):
    """How a traced truth was rendered: its sub-pixel grid, samples, parts and wall-clock seconds.

    `spp` counts samples of each sub-pixel in each part. `random` says whether it has noise.
    """

    ssaa: Annotated[int, Meta(ge=1)]
    spp: Count
    parts: Count
    random: bool
    seconds: float


class Scores(_Typed, frozen=True):
    """Metrics against one truth; null where a metric has no finite value.

    `noise_floor` holds the metrics that the noise of the truth alone causes, and `reference` how a
    traced truth was rendered. `jackknife` has, for a truth with noise in several parts, the FLIP of
    the displayed image against the mean of all parts but each one. `transparent` and `opaque` are
    the means of FLIP over pixels with a transparent fragment and over the others; null if there are
    none. `faults` says, by the name of a user's metric, why it failed. `reason` says why there are
    no metrics, and `message` is a remark on the truth for readers.
    """

    metrics: dict[str, float | None] = {}
    noise_floor: dict[str, float | None] = {}
    jackknife: dict[str, list[float]] = {}
    transparent: dict[str, float | None] = {}
    opaque: dict[str, float | None] = {}
    reference: ReferenceFacts | None = None
    reason: str = ""
    message: str = ""
    faults: dict[str, str] = {}


class Outcome(_Typed, frozen=True):
    """Everything measured of a cell that has an image, except times.

    `scores` has an entry for each truth. A cell that leaves effects out also has `whole`: the truth
    that ranks the scene with all of them. `images` are files below the results folder: `color`,
    `color_reduced` (see `pictures.py`), the truths, and for each truth `flip_TRUTH`, the maps of
    FLIP (channel `ldr`) and HDR-FLIP (`hdr`). `complexity` holds the transparent fragments of each
    pixel (channel `fragments`), which `statistics` sums up, and `transmittance` that of all layers
    of a pixel under exact compositing. `transparent_pixels` counts pixels of accuracy images with a
    transparent fragment in any sub-pixel. `exposure` is in stops. `demands` are those of the method
    with the effects that ran. `plan` is a digest of declared targets, buffers and passes.
    The method belongs to a `family` of `oitbench.method.families`, and the scene has a `subject`.
    `custom` describes the metrics of users' files, whose values are in `scores` beside the suite's.
    """

    parameters: dict[str, Value]
    effects: EffectNames
    statistics: SceneStatistics
    transparent_pixels: Count
    passes: list[PassRuns]
    memory: Memory
    traffic: Traffic
    shading: SharedShading
    nonfinite: Nonfinite
    scores: dict[str, Scores]
    images: dict[str, StoredImage]
    exposure: float
    demands: Demands
    plan: str = ""
    family: str = OTHER
    subject: str = ""
    custom: dict[str, CustomMetric] = {}


class CellKey(_Typed, frozen=True):
    """The fields that distinguish one cell from another."""

    scene: str
    method: str
    size: Size
    ssaa: int
    effects: str
    shading: str = ""
    view: str = MAIN


class Fingerprints(_Typed, frozen=True):
    """Digests of the content that determines a cell.

    `engine` covers the suite's own sources that can change what is measured, and `metrics` those
    of the metrics. `truths` has a digest for each truth that the cell is scored against.
    """

    scene: str
    method: str
    engine: str
    metrics: str
    truths: dict[str, str]


class _Device(Protocol):
    renderer: str
    vendor: str
    version: str
    software: bool


class Renderer(_Typed, frozen=True):
    """The OpenGL renderer; `software` renderers run on the CPU."""

    renderer: str
    vendor: str = ""
    version: str = ""
    software: bool = False

    @classmethod
    def of(cls, device: _Device) -> Renderer:
        """Return the renderer of a device of OpenGL."""
        return cls(device.renderer, device.vendor, device.version, device.software)


class Record(_Typed, frozen=True):
    """One cell of the matrix of scenes and methods.

    `scene` and `method` are labels with the parameters that differ from their defaults, and `name`
    is the method's bare name. `view` names the scene's camera. `size` is in pixels, `ssaa` the side
    of the sub-pixel grid of accuracy images, `effects` the requested set of effects, `shading` the
    settings of shared shading that differ from their defaults, and `permutations` the number of
    random orders of the draws. `truths` were asked for. `seconds` is the wall-clock time of
    rendering and scoring. `gl` and `fingerprints` are null if they were not known when the cell
    failed. Where more than `most_layers` lie at a pixel, a method that peels them is skipped; null
    for no limit.
    """

    scene: str
    method: str
    name: str
    size: Size
    ssaa: Annotated[int, Meta(ge=1)]
    effects: str
    seed: int
    permutations: Count
    truths: list[str]
    status: Status
    reason: str = ""
    seconds: float = 0.0
    gl: Renderer | None = None
    fingerprints: Fingerprints | None = None
    outcome: Outcome | None = None
    time: Time | None = None
    shading: str = ""
    view: str = MAIN
    most_layers: int | None = None
    schema: Literal[6] = VERSION

    @property
    def seen(self) -> str:
        """The label of the scene with its view, unless that is the main one."""
        return seen(self.scene, self.view)

    @property
    def key(self) -> CellKey:
        """The cell that the record belongs to."""
        return CellKey(
            scene=self.scene,
            method=self.method,
            size=self.size,
            ssaa=self.ssaa,
            effects=self.effects,
            shading=self.shading,
            view=self.view,
        )

    @property
    def finished(self) -> bool:
        """Whether there is an image and numbers."""
        return self.status in FINISHED and self.outcome is not None

    def suspect(self, reason: str) -> Record:
        """Return this record of a finished cell with a reason to distrust it."""
        if reason in self.reason:
            return self
        status: Status = "suspect" if self.status == "ok" else self.status
        reasons = [item for item in (self.reason, reason) if item]
        return msgspec.structs.replace(self, status=status, reason="; ".join(reasons))

    def metric(self, truth: str, name: str) -> float | None:
        """Return a metric against a truth, or None."""
        scores = self.outcome.scores.get(truth) if self.outcome else None
        return scores.metrics.get(name) if scores else None

    def errors(self, truth: str, name: str) -> Errors | None:
        """Return a FLIP metric against a truth with what its noise does to it, or None."""
        scores = self.outcome.scores.get(truth) if self.outcome else None
        value = scores.metrics.get(name) if scores else None
        if scores is None or value is None:
            return None
        return Errors(value, scores.jackknife.get(name, ()))

    def noise_floor(self, truth: str, name: str) -> float | None:
        """Return a metric that the noise of a truth alone causes, or None."""
        scores = self.outcome.scores.get(truth) if self.outcome else None
        return scores.noise_floor.get(name) if scores else None

    @property
    def whole_truth(self) -> str:
        """The key of the scores against the ranking truth with all effects of the scene."""
        left_out = self.outcome is not None and WHOLE in self.outcome.scores
        return WHOLE if left_out else self.ranking_truth

    @property
    def ranking_truth(self) -> str:
        """The truth that ranks the methods of the scene with the effects of this cell."""
        return ranking_truth(effects_of(self.requested_effects))

    @property
    def missing_effects(self) -> list[str]:
        """Effects that the scene requests and the method cannot express."""
        return self.outcome.effects.missing if self.outcome else []

    @property
    def requested_effects(self) -> list[str]:
        """Effects that the scene requests and that were not left out."""
        return self.outcome.effects.requested if self.outcome else []


class Commit(_Typed, frozen=True):
    """The state of the checkout."""

    commit: str
    modified: bool


class RunFacts(_Typed, frozen=True):
    """The machine and the command of a run, and its wall-clock seconds by kind of work."""

    gl: Renderer | None
    seed: int | None
    argv: list[str] = []
    methods: list[str] = []
    mesa: str | None = None
    cpu: Processor | None = None
    os: str = ""
    python: str = ""
    packages: dict[str, str | None] = {}
    llvm: str | None = None
    git: Commit | None = None
    date: str = ""
    wall: dict[str, float] = {}
    schema: Literal[6] = VERSION

    @property
    def renderer(self) -> str:
        """The name of the OpenGL renderer, or ""."""
        return self.gl.renderer if self.gl else ""


def flip_image(truth: str) -> str:
    """Return the key of `Outcome.images` for the maps of FLIP against a truth."""
    return f"flip_{truth}"
