"""`oitbench import`: keep a file of a user as a scene of a collection."""

from __future__ import annotations

import shlex
import shutil
from pathlib import Path
from typing import Any

import click

from oitbench import parameters as selectors
from oitbench.catalog.catalog import Catalog
from oitbench.errors import SceneError, StorageError, UsageError, printable
from oitbench.places import IMPORTED

_MODULE = '''{doc!r}

from pathlib import Path
from typing import Any

from oitbench.importing import read_scene, with_defaults
from oitbench.scene import Scene

FILE = Path(__file__).with_name({name!r}) / {file!r}
parameters = with_defaults({defaults})


def build(*, name: str, **values: Any) -> Scene:
    """Return the scene of the file; `dataclasses.replace` changes what you like."""
    return read_scene(FILE, name, **values).scene
'''


@click.command("import", short_help="Keep a glTF, OBJ or PLY file as a scene of a collection.")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    required=True,
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder of the collection; it is made if it is missing.",
)
@click.option("--name", help="Name of the scene.  [default: that of the file]")
@click.option("--light", metavar="auto|file|sun|none", help="auto: a sun if the file has no light.")
@click.option(
    "--environment",
    metavar="FILE|auto|none",
    help="An .hdr, .exr, .png or .jpg by latitude and longitude; auto: a soft sky.",
)
@click.option("--ground", metavar="auto|yes|no", help="auto: a ground if the file has none.")
@click.option("--exposure", type=float, help="Stops, beside those that suit the file's lights.")
@click.option("--unit", type=float, help="Length of the file's unit, in meters.")
@click.option("--up", metavar="y|z", help="Axis of the file that points up.")
@click.option("--limit", type=float, help="Factor on the limits of size, for files you trust.")
def command(file: Path, out: Path, name: str | None, **options: Any) -> None:
    """Check FILE, and keep it with all files that it needs as a scene of the collection OUT.

    FILE is .glb, .gltf, .obj or .ply. What its scene shows differently is printed, one line for
    each kind. `oitbench run --scene FILE` does the same check and keeps nothing.
    """
    given = {key: value for key, value in options.items() if value is not None}
    if file.suffix.lower() not in IMPORTED:
        raise UsageError(f"{file}: unknown format; give one of {', '.join(IMPORTED)}")
    with Catalog() as catalog:
        stem = catalog.places.add_scene(file)
        texts = {key: (selectors.text(value),) for key, value in given.items()}
        (choice,) = catalog.expand_scenes([selectors.selector(str(file), texts)])
        if choice.error:
            raise SceneError(choice.error)
        needed = catalog.inspect(choice).files
    title = name or stem
    module = out / "scenes" / f"{title}.py"
    if not _is_name(title):
        raise UsageError(f"a scene cannot have the name '{title}'; give another one by --name")
    if module.exists():
        raise UsageError(f"{module} exists; give another name by --name, or remove it")
    _keep(file, needed, module, given)
    click.echo(f"{module}: kept with {1 + len(needed)} files")
    again = ["oitbench", "run", "--collection", str(out), "--scene", title]
    click.echo(f"next: {shlex.join(again)}")


def _is_name(title: str) -> bool:
    """Return whether a scene of a collection can have a name."""
    plain = Path(title).name == title == printable(title)
    return plain and not title.startswith(("_", ".")) and not set(title) & set("[],=@\\")


def _keep(file: Path, needed: dict[str, Path], module: Path, given: dict[str, Any]) -> None:
    """Copy a file and what it needs, and write the module of its scene.

    An environment is named by its copy from then on.

    Raises
    ------
    UsageError
        The environment has the name of another file.
    StorageError
        The folder cannot be written.
    """
    from oitbench.importing.scene import AUTO, environment_file

    folder = module.with_suffix("")
    copies = {file.name: file, **needed}
    sky = environment_file(file, given.get("environment", AUTO))
    if sky is not None:
        given["environment"] = sky.name
        if copies.setdefault(sky.name, sky).resolve() != sky.resolve():
            raise UsageError(f"{sky}: another file of the scene has this name; rename one")
    # Texts of users stay literals, since the module is code.
    text = _MODULE.format(
        doc=f"{module.stem}, imported from {file.name}.",
        name=module.stem,
        file=file.name,
        defaults=", ".join(f"{key}={value!r}" for key, value in given.items()),
    )
    try:
        for name, source in copies.items():
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
        module.write_text(text, encoding="utf-8")
    except OSError as error:
        raise StorageError(f"{module} cannot be kept: {error.strerror}") from error
