"""The archive of a results folder that is sent."""

from __future__ import annotations

import zipfile
from pathlib import Path

from oitbench.atomic import replacing
from oitbench.results.records import Results
from oitbench.results.store import CELLS, CONFIG, RUN


def pack(folder: Path) -> Path:
    """Write the cells, pictures and facts of a results folder to an archive beside it.

    Returns
    -------
    Path
        Of the archive, which only depends on the content of these files.

    Raises
    ------
    StorageError
        It cannot be written.
    """
    folder = folder.resolve()
    named = {
        image.path
        for record in Results.load(folder).records
        if record.outcome
        for image in record.outcome.images.values()
    }
    names = [name for name in (CELLS, RUN, CONFIG) if (folder / name).is_file()]
    path = folder.with_name(f"{folder.name}.zip")
    with replacing(path) as partial, zipfile.ZipFile(partial, "w") as archive:
        for name in (*names, *sorted(named)):
            # Pictures are compressed, and a date would differ between equal archives.
            entry = zipfile.ZipInfo(f"{folder.name}/{name}")
            archive.writestr(entry, (folder / name).read_bytes())
    return path
