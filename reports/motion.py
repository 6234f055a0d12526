"""Methods along a path of cameras: flicker, popping, and the error of each frame.

Needs folders of `oitbench motion`, in the folder `motion` of the results folder.
"""

from __future__ import annotations

from pathlib import Path

from oitbench.errors import UsageError
from oitbench.filenames import file_name
from oitbench.motion import record
from oitbench.report import Artifact, Note, ReportContext
from oitbench.report.motion import Footage, write

title = "In motion"
order = 34


def build(context: ReportContext) -> list[Artifact]:
    """Draw the strip, the plot and the table of each folder."""
    place = context.results.folder / "motion"
    folders = record.find(context.results.folder)
    if not folders:
        command = f"oitbench motion SCENE --method NAME --out {place}/SCENE"
        return [Note(f"Not run yet; '{command}' adds it.")]
    return [artifact for folder in folders for artifact in _section(context, folder)]


def _section(context: ReportContext, folder: Path) -> list[Artifact]:
    out = context.out / "motion" / file_name(folder.name)
    out.mkdir(parents=True, exist_ok=True)
    try:
        return list(write(Footage.load(folder), out))
    except UsageError as error:
        return [Note(str(error))]
