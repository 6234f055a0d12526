"""`oitbench doctor`: check this machine."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from oitbench.cli import options
from oitbench.errors import OitbenchError


@click.command()
@options.collections
def command(collections: tuple[Path, ...]) -> None:
    """Check OpenGL, the path tracer and the plugins; exit with 1 if something is missing."""
    well = [_gl(), _path_tracer(), _plugins(collections)]
    sys.exit(0 if all(well) else 1)


def _report(name: str, value: object, well: bool = True) -> bool:
    click.echo(f"{'ok  ' if well else 'FAIL'}  {name}: {value}")
    return well


def _gl() -> bool:
    from oitbench.gl.capabilities import CAPABILITIES
    from oitbench.gl.device import Device

    try:
        device = Device()
    except OitbenchError as error:
        return _report("OpenGL", error, well=False)
    _report("OpenGL", f"{device.renderer}, {device.version}")
    kind = "software: timed by wall clock" if device.software else "hardware: timed by timestamps"
    _report("renderer", kind)
    _report("largest storage block", f"{device.max_block_bytes / 2**20:g} MiB")
    for capability in CAPABILITIES:
        _report(f"capability {capability}", "yes" if device.has(capability) else "no")
    device.release()
    return True


def _path_tracer() -> bool:
    from oitbench.path_traced import llvm

    facts = llvm.describe()
    well = facts.get("variant") is not None
    return _report("path tracer", ", ".join(f"{k} {v}" for k, v in facts.items() if v), well)


def _plugins(collections: tuple[Path, ...]) -> bool:
    from oitbench.plugins import Collection

    try:
        collection = Collection.load(collections)
    except OitbenchError as error:
        return _report("collections", error, well=False)
    well = True
    for plugins in (collection.methods, collection.scenes, collection.reports):
        broken = []
        for name in plugins:
            try:
                plugins[name]
            except OitbenchError as error:
                broken.append(str(error))
        found = "; ".join(broken) or f"{len(plugins)}: {', '.join(plugins)}"
        well = _report(f"{plugins.kind}s", found, not broken) and well
    return well
