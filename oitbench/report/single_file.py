"""A page with all its files inside, so that it can be sent as one."""

from __future__ import annotations

import base64
import html
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from urllib.parse import unquote_to_bytes

_LINK = re.compile(r' (src|href)="([^"#:][^":]*)"')
_MARK = "<!-- pixels -->"
"""The place in the page where the scripts go."""
_KINDS = {
    ".bib": "text/x-bibtex",
    ".csv": "text/csv",
    ".gif": "image/gif",
    ".pdf": "application/pdf",
    ".png": "image/png",
    ".tex": "text/x-tex",
    ".webp": "image/webp",
}


def joined(page: str, folder: Path, scripts: Mapping[str, Path]) -> Iterator[str]:
    """Yield the text of a page with all files that it links to.

    Parameters
    ----------
    page : str
        HTML whose links are relative to `folder`.
    folder : Path
    scripts : mapping of str to Path
        Scripts that the viewer loads later, by the names that it knows.
    """
    shown = {target for kind, target in _LINK.findall(page) if kind == "src"}

    def replaced(link: re.Match[str]) -> str:
        kind, target = link.groups()
        if kind == "href" and target in shown:
            return ""  # Readers can save the picture itself.
        path = folder / os.fsdecode(unquote_to_bytes(html.unescape(target)))
        if not path.is_file():
            return link[0]
        form = _KINDS.get(path.suffix, "application/octet-stream")
        data = f"data:{form};base64,{base64.b64encode(path.read_bytes()).decode()}"
        name = "" if kind == "src" else f' download="{html.escape(path.name)}"'
        return f' {kind}="{data}"{name}'

    before, mark, after = page.partition(_MARK)
    yield _LINK.sub(replaced, before)
    for name, path in scripts.items():
        yield f'<script type="text/plain" data-pixels="{html.escape(name)}">'
        yield path.read_text(encoding="utf-8")
        yield "</script>\n"
    yield mark + after
