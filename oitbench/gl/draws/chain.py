"""A chain of the engine's own passes into textures: shadow maps, occlusion, opaque surfaces."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace

import moderngl

from oitbench.gl.batches import Batch, IndexOrder
from oitbench.gl.device import Device
from oitbench.gl.draws.executor import CompiledStep, Executor
from oitbench.gl.draws.records import Lap, PassRecord, Term, no_lap, terms_of
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.program.passes import Blueprint, attach, compile_pass
from oitbench.gl.tiling import Scissor
from oitbench.method.passes import Gather, Pass
from oitbench.method.storage import Target

Size = tuple[int, int]


@dataclass
class Measurement:
    """Counts of the passes of one or more chains.

    Parameters
    ----------
    records : dict of str to PassRecord
        One record per label.
    terms : list of Term
        Traffic.
    """

    records: dict[str, PassRecord] = field(default_factory=dict)
    terms: list[Term] = field(default_factory=list)


@dataclass(frozen=True)
class _Link:
    """The inputs of one pass's accounts."""

    label: str
    step: Pass
    names: Mapping[str, str]
    taps: Mapping[str, int]


class Chain(Owner):
    """Passes of the engine that are issued in order, and counted on request.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    targets : mapping of str to Target
    sizes : mapping of str to (int, int)
        Width and height of each target.
    view : moderngl.Buffer
        The uniform block `View`; it belongs to the caller.
    textures : mapping of str to moderngl.Texture, optional
        Existing textures for some of the targets; they belong to the caller.

    Attributes
    ----------
    textures : dict of str to moderngl.Texture
    framebuffers : dict of str to moderngl.Framebuffer
        One per target.
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        targets: Mapping[str, Target],
        sizes: Mapping[str, Size],
        view: moderngl.Buffer,
        textures: Mapping[str, moderngl.Texture] | None = None,
    ) -> None:
        super().__init__()
        self._device, self._geometry = device, geometry
        self._targets, self._sizes = targets, sizes
        self.textures = dict(textures or {})
        self._allocated = [name for name in targets if name not in self.textures]
        with self.building():
            for name in self._allocated:
                self.textures[name] = self.own(device.texture(sizes[name], targets[name].texel))
            self.framebuffers = {
                name: self.own(attach(device, self.textures[name], target.texel))
                for name, target in targets.items()
            }
        self._executor = Executor(device, {1: view})
        self._steps: list[CompiledStep] = []
        self._links: list[_Link] = []
        self._orders: dict[Hashable, IndexOrder] = {}

    def add(
        self,
        step: Pass,
        blueprint: Blueprint,
        label: str = "",
        batch: Batch | None = None,
        taps: Mapping[str, int] | None = None,
        names: Mapping[str, str] | None = None,
    ) -> None:
        """Append a pass. A gather pass over an empty batch is kept only for its clears.

        Parameters
        ----------
        step : Gather or Resolve
        blueprint : Blueprint
            Without targets: they are those of the chain.
        label : str
            Name of its record, which several passes can share.
        batch : Batch, optional
            Triangles that a gather pass draws.
        taps : mapping of str to int, optional
            Texels of each read target that one output needs, by the names in `step`.
        names : mapping of str to str, optional
            Target of each name in `step` that differs from the target's own.
        """
        if isinstance(step, Gather) and not batch and not step.clears:
            return
        aliases = {name: name for name in self._targets} | dict(names or {})
        textures = {alias: self.textures[name] for alias, name in aliases.items()}
        named = replace(blueprint, targets=self._named(aliases))
        compiled = compile_pass(self._device, self._geometry, named, step, textures, batch)
        self._steps.append(CompiledStep(step, ((self.own(compiled),),)))
        self._links.append(_Link(label, step, aliases, taps or {}))
        if batch is not None:
            self._orders[batch] = self._geometry.in_submission_order(batch)

    def issue(self, scissor: Scissor | None = None, lap: Lap = no_lap) -> None:
        """Issue all passes; `lap` is called with the label of each after it."""

        def ended(place: int) -> None:
            lap(self._links[place].label)

        self._executor.issue(self._steps, self._orders, scissor, lap=ended)

    def measure(self, into: Measurement) -> None:
        """Issue all passes, and add their counts to `into`."""
        records = [PassRecord(link.label) for link in self._links]
        self._executor.issue(self._steps, self._orders, records=records)
        for link, record in zip(self._links, records, strict=True):
            into.terms += self._terms(link, record)
            total = into.records.setdefault(link.label, PassRecord(link.label))
            total.runs += record.runs
            total.fragments += record.fragments

    def _named(self, aliases: Mapping[str, str]) -> dict[str, Target]:
        return {alias: self._targets[name] for alias, name in aliases.items()}

    def _terms(self, link: _Link, record: PassRecord) -> list[Term]:
        def texels(alias: str) -> int:
            return math.prod(self._sizes[link.names[alias]])

        terms = terms_of(link.step, record, self._named(link.names), texels, {}, link.taps)
        return [replace(term, resource=link.names[term.resource]) for term in terms]

    def memory(self) -> list[tuple[str, int]]:
        """Return (target, bytes) of the chain's own textures."""
        return [
            (name, width * height * self._targets[name].texel.bytes)
            for name, (width, height) in self._sizes.items()
            if name in self._allocated
        ]
