"""The messages between a catalog and its worker."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from msgspec import Struct

from oitbench.catalog.needs import Need
from oitbench.catalog.outline import Outline
from oitbench.crops import Crop
from oitbench.method.demands import Demands
from oitbench.parameters import AnyParameter

Kind = Literal["method", "scene", "report"]


class Nothing(Struct, frozen=True):
    """The settings of the worker: none, since each request names the files that it needs."""


class Resolve(Struct, frozen=True, tag=True):
    """Asks for the folder of an installed collection, `MODULE:NAME`."""

    value: str


class Describe(Struct, frozen=True, tag=True):
    """Asks for the entry of a plugin.

    Unless it is to be checked, a report is only parsed, and no scene is built.
    """

    kind: Kind
    name: str
    path: Path
    check: bool = False


class Axes(Struct, frozen=True, tag=True):
    """Asks for the values of "each" on the axis of effects, for methods in a scene.

    Labels select them, and `paths` are their files by name.
    """

    scene: str
    methods: list[str]
    scene_path: Path
    method_paths: dict[str, Path]


class Demand(Struct, frozen=True, tag=True):
    """Asks what a method demands; `label` selects it, and `path` is its file."""

    label: str
    path: Path


class Portray(Struct, frozen=True, tag=True):
    """Asks for the portrait of a method; `label` selects it, and `path` is its file."""

    label: str
    path: Path


class Inspect(Struct, frozen=True, tag=True):
    """Asks whether a file can be imported as a scene, with the values of parameters of a label."""

    scene: str
    path: Path


class Resolved(Struct, frozen=True, tag=True):
    """The folder of an installed collection."""

    folder: Path


class Entry(Struct, frozen=True, tag=True):
    """A plugin.

    Parameters
    ----------
    name : str
    title : str
        The first line of its docstring.
    parameters : dict of str to Parameter
    quick : bool
        Whether the quick preset includes it.
    promises, expresses : list of str
        Of a method with its default parameters.
    no_msaa : str
        Why a method has one sample per pixel.
    views : list of str
        Names of the views of a scene, if it was checked and can be built.
    crops : dict of str to Crop
        Parts of a scene's picture by name.
    needs : list of Need
        Cells that a report shows, if it was checked.
    error : str
        Why the plugin cannot be used, in one line; then nothing else is known.
    """

    name: str
    title: str = ""
    parameters: dict[str, AnyParameter] = {}
    quick: bool = True
    promises: list[str] = []
    expresses: list[str] = []
    no_msaa: str = ""
    views: list[str] = []
    crops: dict[str, Crop] = {}
    needs: list[Need] = []
    error: str = ""


class AxesFound(Struct, frozen=True, tag=True):
    """The axis of each method, in the order of the request."""

    axes: list[list[str]]


class DemandsFound(Struct, frozen=True, tag=True):
    """What a method demands in a scene that requests all effects that it shows."""

    demands: Demands


class Portrait(Struct, frozen=True, tag=True):
    """A method as its file describes it.

    Parameters
    ----------
    label : str
    doc : str
        The docstring.
    family : str
    parameters : dict of str to (str, str, str)
        The value, the choices if there are some, and the meaning.
    promises, expresses : list of str
    demands : Demands
        In a scene that requests all effects that the method shows.
    outline : Outline
        Of what it declares for such a scene.
    fingerprint : str
        Of its parameters and sources.
    """

    label: str
    doc: str
    family: str
    parameters: dict[str, tuple[str, str, str]]
    promises: list[str]
    expresses: list[str]
    demands: Demands
    outline: Outline
    fingerprint: str


class Inspected(Struct, frozen=True, tag=True):
    """The file can be imported.

    Parameters
    ----------
    notes : list of str
        What the scene shows differently from its file, in one line each.
    files : dict of str to Path
        Files beside it that it needs, by their paths relative to its folder.
    """

    notes: list[str]
    files: dict[str, Path]


Request = Resolve | Describe | Axes | Demand | Portray | Inspect
Reply = Resolved | Entry | AxesFound | DemandsFound | Portrait | Inspected
