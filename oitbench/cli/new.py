"""`oitbench new`: files of a method, a scene or a report to begin with."""

from __future__ import annotations

import keyword
import shlex
from pathlib import Path
from string import Template

import click

from oitbench.catalog.messages import Kind
from oitbench.cli import options
from oitbench.errors import StorageError, UsageError
from oitbench.places import own_folder

_SKELETONS = Path(__file__).parents[1] / "skeletons"
_SUFFIX = ".txt"


@click.command()
@options.kind(("method", "scene", "report"))
@click.argument("name")
@click.option(
    "-o",
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("."),
    show_default=True,
    help="The collection, a folder that has or gets a folder for each kind of plugin.",
)
def command(kind: Kind, name: str, out: Path) -> None:
    """Write a method, a scene or a report that works, to be changed.

    The last line is a command that uses it.
    """
    if not name.isidentifier() or keyword.iskeyword(name) or name != name.lower():
        raise UsageError(f"'{name}' is no name of a plugin; write it as depth_average")
    target = _target(kind, name, out)
    if target.exists():
        raise UsageError(f"{target} exists; give another name")
    words = name.replace("_", " ")
    texts = {"name": name, "title": words.title().replace(" ", ""), "words": words.capitalize()}
    for source, path in _files(kind, target):
        _write(path, Template(source.read_text(encoding="utf-8")).substitute(texts))
        click.echo(path)
    click.echo(f"next: {shlex.join(_next(kind, name, out))}")


def _target(kind: Kind, name: str, out: Path) -> Path:
    return out / f"{kind}s" / (name if kind == "method" else f"{name}.py")


def _files(kind: Kind, target: Path) -> list[tuple[Path, Path]]:
    """Return the skeletons of a kind, and the files that they become."""
    if kind != "method":
        return [(_SKELETONS / f"{kind}.py{_SUFFIX}", target)]
    sources = sorted((_SKELETONS / kind).iterdir(), reverse=True)
    return [(source, target / source.name.removesuffix(_SUFFIX)) for source in sources]


def _write(path: Path, text: str) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise StorageError(f"{path} cannot be written: {error.strerror}") from error


def _next(kind: Kind, name: str, out: Path) -> list[str]:
    """Return a command that uses the new plugin."""
    own = out.resolve() == own_folder()
    here = [] if own else ["--collection", str(out)]
    if kind == "report":
        return ["oitbench", "report", "results", *here]
    return ["oitbench", "run", f"--{kind}", name, *here]
