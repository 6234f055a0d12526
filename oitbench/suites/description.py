"""What a frozen suite fixes, and the file that holds it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final, Literal

import msgspec
from msgspec import Struct

from oitbench.atomic import replacing
from oitbench.errors import UsageError, unknown
from oitbench.parameters import Value, text
from oitbench.results.checksum import seal, unseal
from oitbench.results.schema import CellKey
from oitbench.shading import read_shading
from oitbench.views import seen

_VERSION: Final = 1
_FOLDER = Path(__file__).parent
_SUFFIX = ".json"


class SuiteScene(Struct, frozen=True, forbid_unknown_fields=True):
    """One view of a scene.

    Parameters
    ----------
    scene, view : str
    fingerprint : str
        Of its content, as seen from the view.
    effects : list of str
        Effects that it requests.
    ranked_by : str
        The truth that ranks its methods.
    exposure : float
        Stops.
    exact : list of float
        Mean radiance of exact compositing in red, green and blue.
    references : dict of str to str
        Digests of the pixels of the traced truths; it cannot be traced if there are none.
    """

    scene: str
    view: str
    fingerprint: str
    effects: list[str]
    ranked_by: str
    exposure: float
    exact: list[float]
    references: dict[str, str]

    @property
    def seen(self) -> str:
        """The label of the scene with its view, unless that is the main one."""
        return seen(self.scene, self.view)


class Suite(Struct, frozen=True, forbid_unknown_fields=True):
    """A frozen suite.

    Parameters
    ----------
    name : str
    size : (int, int)
        Width and height in pixels.
    ssaa, effects, truths, seed, permutations
        As those of a cell; see `oitbench.matrix.cell.Cell`.
    views : list of str
        From each of which all scenes are seen.
    shading : dict of str to object
        All settings of shared shading.
    rounds : int
        Largest number of timed rounds of a scene.
    budget : float
        Seconds of timing after which no further round begins.
    metrics : dict of str to float
        Values of the metrics for a fixed pair of pictures; see `digests.probe_metrics`.
    scenes : list of SuiteScene
    """

    name: str
    size: tuple[int, int]
    ssaa: int
    effects: str
    truths: list[str]
    seed: int
    permutations: int
    views: list[str]
    shading: dict[str, Value]
    rounds: int
    budget: float
    metrics: dict[str, float]
    scenes: list[SuiteScene]
    schema: Literal[1] = _VERSION

    @property
    def shading_texts(self) -> list[str]:
        """The settings of shared shading as the command line takes them."""
        return [f"{name}={text(value)}" for name, value in self.shading.items()]

    def key(self, scene: SuiteScene, method: str) -> CellKey:
        """Return the cell of a method in a scene."""
        label = read_shading(",".join(self.shading_texts)).label
        return CellKey(scene.scene, method, self.size, self.ssaa, self.effects, label, scene.view)


def known_suites() -> Mapping[str, Path]:
    """Return the files of all suites by name."""
    return {path.stem: path for path in sorted(_FOLDER.glob(f"*{_SUFFIX}"))}


def suite_file(name: str) -> Path:
    """Return the place of the file of a suite."""
    return _FOLDER / f"{name}{_SUFFIX}"


def read_suite(name: str) -> Suite:
    """Return a suite by its name, or from a file that ends in .json.

    Raises
    ------
    UsageError
        There is no such suite, or its file is damaged.
    """
    known = known_suites()
    if name not in known and not name.endswith(_SUFFIX):
        raise unknown("suite", name, known)
    path = known.get(name, Path(name))
    try:
        body = unseal(path.read_bytes().strip())
    except OSError as error:
        raise UsageError(f"{path} cannot be read ({error.strerror})") from error
    try:
        if body is None:
            raise ValueError("its checksum does not fit")
        return msgspec.json.decode(body, type=Suite)
    except (msgspec.MsgspecError, ValueError) as error:
        raise UsageError(
            f"{path} is no suite, or was changed ({error}); restore it, or freeze one of your own"
        ) from error


def write_suite(path: Path, suite: Suite) -> None:
    """Write the file of a suite, atomically."""
    content = msgspec.json.format(msgspec.json.encode(suite), indent=1)
    with replacing(path) as partial:
        partial.write_bytes(seal(content) + b"\n")
