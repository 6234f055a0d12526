"""The input of a report: results, the folder to write to, and the look of methods and FLIP."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from oitbench import crops
from oitbench.catalog.messages import Portrait
from oitbench.crops import Crop
from oitbench.filenames import file_name
from oitbench.image import metrics
from oitbench.image.files import Image
from oitbench.report import palette
from oitbench.report.citing import Citation, citation
from oitbench.report.palette import Style
from oitbench.results.records import Panel, Results
from oitbench.results.schema import Record

METHODS = "methods"
"""Name of the report that writes the pages of methods."""


@dataclass(frozen=True)
class ReportContext:
    """The argument of a report's `build`.

    Parameters
    ----------
    results : Results
    out : Path
        Existing folder that the report writes to.
    hdr : bool
        Show HDR-FLIP instead of FLIP of the displayed image, and keep linear radiance in the
        viewer.
    crops : mapping of str to mapping of str to Crop
        Parts of pictures by the name of a scene, as its file states them.
    variants : mapping of str to str
        Methods that figures of this page show instead of others, by the labels of those.
    portraits : mapping of str to Portrait or str
        Methods as their files describe them, by bare name; else the reason why they do not.
    bibliographies : tuple of Path
        BibTeX files with the sources of methods and claims.
    sections : frozenset of str
        Names of the reports on the page, to which others may link.
    single_file : bool
        Whether these pages are parts of the page, and not files.
    sheets : bool
        Draw the pictures of a scene as one figure, too, which the page does not show.
    """

    results: Results
    out: Path
    hdr: bool = False
    crops: Mapping[str, Mapping[str, Crop]] = field(default_factory=dict)
    variants: Mapping[str, str] = field(default_factory=dict)
    portraits: Mapping[str, Portrait | str] = field(default_factory=dict)
    bibliographies: tuple[Path, ...] = ()
    sections: frozenset[str] = frozenset()
    single_file: bool = False
    sheets: bool = False

    @property
    def pages(self) -> bool:
        """Whether a report writes pages of methods, to which names of methods link."""
        return METHODS in self.sections

    @property
    def flip(self) -> str:
        """Key of the FLIP metric that is shown."""
        return metrics.FLIP_HDR if self.hdr else metrics.FLIP_LDR

    @property
    def flip_name(self) -> str:
        """Name of that metric for readers."""
        return "HDR-FLIP" if self.hdr else "FLIP"

    def flip_map(self, record: Record, truth: str) -> Image | None:
        """Return the map of that metric against a truth, shape (h, w); None if there is none."""
        maps = self.results.flip_maps(record, truth)
        return None if maps is None else maps[int(self.hdr)]

    def crops_of(self, panel: Panel) -> dict[str, Crop]:
        """Return the named parts of the pictures of a panel."""
        cell = panel.cells[0]
        return crops.of_view(self.crops.get(cell.scene.partition("[")[0], {}), cell.view)

    def style(self, label: str) -> Style:
        """Return the look of a method, the same in every picture.

        Color and marker are those of the method's family.
        """
        return self._styles[label]

    @cached_property
    def citation(self) -> Citation:
        """How to cite the results, and how to repeat them."""
        return citation(self.results)

    @cached_property
    def names(self) -> Mapping[str, str]:
        """The bare names of methods by their labels."""
        return {record.method: record.name for record in self.results.records}

    def page(self, name: str) -> Path:
        """Return the file of the page of a method, by its bare name."""
        return self.out / "methods" / f"{file_name(name)}.html"

    def method_table(self, name: str, kind: str) -> Path:
        """Return the CSV file of a table of that page; `kind` is its name."""
        return self.out / "methods" / "tables" / file_name(name) / f"{kind}.csv"

    @cached_property
    def _styles(self) -> Mapping[str, Style]:
        return palette.styles(self.names, self.families)

    @cached_property
    def families(self) -> Mapping[str, str]:
        """The family of each method that has a result, by its bare name."""
        records = self.results.records
        return {record.name: record.outcome.family for record in records if record.outcome}
