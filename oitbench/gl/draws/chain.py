"""A chain of draws into textures of its own: what shading needs before a frame can be drawn."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import moderngl

from oitbench.gl.device import Device
from oitbench.gl.draws.steps import PassRecord
from oitbench.gl.geometry import Batch
from oitbench.gl.program.passes import Blueprint, CompiledPass, attach, compile_pass
from oitbench.method.declaration import Order, Pass, Target

Moved = tuple[str, str, str, int, int]
"""Pass, resource, kind, items, bytes of each: what `oitbench.accounting` makes a term of."""


@dataclass(frozen=True)
class _Link:
    """One compiled pass with what it draws: a batch's indices, or the screen."""

    label: str
    compiled: CompiledPass
    indices: moderngl.Buffer | None
    writes: tuple[str, ...]
    reads: Mapping[str, int]
    clears: bool


class Chain:
    """Draws that are issued in order, and measured if asked to.

    Parameters
    ----------
    device : Device
    targets : mapping of str to Target
    sizes : mapping of str to (int, int)
        Width and height of each target.
    view : moderngl.Buffer
        The uniform block `View`; released with the chain.

    Attributes
    ----------
    textures : dict of str to moderngl.Texture
    """

    def __init__(
        self,
        device: Device,
        targets: Mapping[str, Target],
        sizes: Mapping[str, tuple[int, int]],
        view: moderngl.Buffer,
    ) -> None:
        self._device, self._targets, self._sizes, self._view = device, targets, sizes, view
        self.textures = {k: device.texture(sizes[k], t.texel) for k, t in targets.items()}
        self._framebuffers = {
            name: attach(device, texture, targets[name].texel)
            for name, texture in self.textures.items()
        }
        self._links: list[_Link] = []

    def add(
        self,
        label: str,
        blueprint: Blueprint,
        step: Pass,
        writes: tuple[str, ...],
        reads: Mapping[str, int] | None = None,
        batch: Batch | None = None,
        clears: bool = False,
        textures: Mapping[str, moderngl.Texture] | None = None,
    ) -> None:
        """Append a draw; nothing, if its batch is empty and it clears nothing.

        Parameters
        ----------
        label : str
            Of its record; several may share one.
        blueprint : Blueprint
        step : Pass
        writes : tuple of str
            Targets that it fills.
        reads : mapping of str to int
            Texels of each target that one output needs.
        batch : Batch, optional
            What is drawn; the screen without.
        clears : bool
            Whether its targets are cleared just before.
        textures : mapping of str to moderngl.Texture
            What the names in `step` stand for, where they are not the targets' own.
        """
        indices = None
        if batch is not None:
            triangles = batch.arrange(Order.SUBMISSION)[0]
            if not len(triangles) and not clears:
                return
            # What is read must have been cleared: a triangle without area draws nothing.
            indices = self._device.context.buffer(triangles.tobytes() or bytes(12))
        compiled = compile_pass(blueprint, step, textures or self.textures)
        self._links.append(_Link(label, compiled, indices, writes, reads or {}, clears))

    def issue(self) -> None:
        """Issue all draws."""
        for link in self._links:
            self._begin(link)
            self._draw(link)

    def measure(self, records: dict[str, PassRecord]) -> list[Moved]:
        """Do the same, waiting for every draw; return what was moved.

        Parameters
        ----------
        records : dict of str to PassRecord
            Gains or adds to one record a label.
        """
        moved: list[Moved] = []
        for link in self._links:
            start = time.perf_counter()
            query = self._device.context.query(samples=True)
            self._begin(link)
            with query:
                self._draw(link)
            self._device.finish()
            items = int(query.samples)
            record = records.setdefault(link.label, PassRecord(link.label))
            record.runs += 1
            record.fragments += items
            record.milliseconds += 1e3 * (time.perf_counter() - start)
            moved += self._moved(link, items)
        return moved

    def _moved(self, link: _Link, items: int) -> list[Moved]:
        moved: list[Moved] = []
        for name, texels in link.reads.items():
            size = self._targets[name].texel.bytes
            moved.append((link.label, name, "read", texels * items, size))
        for name in link.writes:
            size, (width, height) = self._targets[name].texel.bytes, self._sizes[name]
            if link.clears:
                moved.append((link.label, name, "clear", width * height, size))
            if link.indices is not None:
                moved.append((link.label, name, "blend", items, size))
            moved.append((link.label, name, "write", items, size))
        return moved

    def _begin(self, link: _Link) -> None:
        for name in link.writes if link.clears else ():
            self._framebuffers[name].use()
            self._framebuffers[name].scissor = (0, 0, *self._sizes[name])
            self._device.clear(0, self._targets[name].texel, self._targets[name].clear)
        link.compiled.begin(self._view, (0, 0, *self._sizes[link.writes[0]]))

    @staticmethod
    def _draw(link: _Link) -> None:
        if link.indices is None:
            link.compiled.draw_screen()
        else:
            link.compiled.draw(link.indices, 0, link.indices.size // 12)

    def memory(self) -> list[tuple[str, int]]:
        """Return (target, bytes)."""
        return [
            (name, width * height * self._targets[name].texel.bytes)
            for name, (width, height) in self._sizes.items()
        ]

    def release(self) -> None:
        """Free the device's memory."""
        for link in self._links:
            link.compiled.release()
            if link.indices is not None:
                link.indices.release()
        for framebuffer in self._framebuffers.values():
            framebuffer.release()
        for texture in self.textures.values():
            texture.release()
        self._view.release()
