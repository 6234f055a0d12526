"""`oitbench.run`, `oitbench.open` and `oitbench.render`."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from oitbench.api import scenes as written
from oitbench.api.outcome import Outcome
from oitbench.image.files import Image
from oitbench.matrix import picture
from oitbench.matrix.plan import plan_matrix
from oitbench.matrix.run import run_matrix
from oitbench.results.records import Results
from oitbench.scene import Scene
from oitbench.suites.planning import FIXED, plan_suite, refuse_fixed


def run(
    scenes: Sequence[str | Scene] = (),
    methods: Sequence[str] = (),
    preset: str = "quick",
    size: tuple[int, int] | None = None,
    out: Path | str = "results",
    suite: str = "",
    **options: Any,
) -> Outcome:
    """Run cells that are not finished, as `oitbench run` does, and return all that were asked for.

    Parameters
    ----------
    scenes : sequence of str or Scene
        Selectors, and scenes that were built here. Those are written to the results folder, whose
        `run.toml` repeats the run.
    methods, preset, size, out
        See `oitbench.matrix.plan.plan_matrix`, as for all further options.
    suite : str
        A frozen suite, which fixes scenes, preset, size and more; see
        `oitbench.suites.planning.plan_suite`.

    Raises
    ------
    OitbenchError
        Something is unknown, out of range, or not available on this machine.
    """
    call = inspect.signature(plan_matrix).bind(scenes, methods, preset, size, out=out, **options)
    call.apply_defaults()
    given = call.arguments
    if suite:
        refuse_fixed(suite, _changed(given))
        given = {name: value for name, value in given.items() if name not in FIXED}
        matrix = plan_suite(suite, **given)
        given["suite"] = suite
    else:
        given["scenes"] = written.keep(scenes, Path(out))
        matrix = plan_matrix(**given)
    matrix = replace(matrix, config=_config(given))
    summary = run_matrix(matrix)
    stored = Results.load(matrix.out)
    newest = {record.key: record for record in (*stored.records, *summary.troubled)}
    results = replace(stored, records=tuple(newest[cell.key] for cell in matrix.cells))
    return Outcome(results, summary, tuple(given["collections"]))


def _changed(given: Mapping[str, Any]) -> list[str]:
    """Return the arguments of `plan_matrix` that are not left at their defaults."""
    defaults = inspect.signature(plan_matrix).parameters
    return [name for name, value in given.items() if value != defaults[name].default]


def _config(given: dict[str, Any]) -> str:
    """Return the file by which the command line repeats a run."""
    import click

    from oitbench.cli import config
    from oitbench.cli.run import command

    return config.text(click.Context(command), {**given, "out": Path(given["out"])})


def open(folder: Path | str, collections: Iterable[Path | str] = ()) -> Outcome:
    """Return what is stored in a results folder.

    Parameters
    ----------
    folder : path
    collections : iterable of path
        Folders of further collections, in which parameters of scenes are looked up.

    Raises
    ------
    UsageError
        The folder holds no results, those of several renderers, or of another version of the suite.
    """
    return Outcome(Results.load(folder), None, tuple(collections))


def render(
    scene: str | Scene, method: str, *positional: Any, **options: Any
) -> tuple[Image, float]:
    """Render one picture in a process of its own.

    Parameters
    ----------
    scene : str or Scene
        A selector, or a scene that was built here.
    method : str
    *positional, **options
        See `oitbench.matrix.picture.render`.

    Returns
    -------
    image : array, shape (h, w, 3), float32
        Linear Rec.709, top row first.
    exposure : float
        The scene's exposure in stops.

    Raises
    ------
    OitbenchError
        Something is unknown, out of range, or not available on this machine.
    """
    with written.temporary(scene) as selector:
        return picture.render(selector, method, *positional, **options)
