"""The publications that describe the methods here, or of which the claims are.

Please cite those of the methods that you compare.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from oitbench.catalog.messages import Portrait
from oitbench.claims import ledger
from oitbench.report import Artifact, ReportContext, bibliography
from oitbench.report.artifacts import Reference, References

title = "References"
order = 70

METRICS = (("Andersson2020", "FLIP"), ("Andersson2021", "HDR-FLIP"))
_CLAIMS = Path(__file__).with_name("claims")


def build(context: ReportContext) -> list[Artifact]:
    """List all sources that methods of these results or claims cite, and write a BibTeX file."""
    sources = bibliography.read(context.bibliographies)
    cited: dict[str, list[str]] = {key: [] for key in sources}
    for key, who in _citations(context):
        if key in cited and who not in cited[key]:
            cited[key].append(who)
    entries = tuple(
        Reference(key, sources[key].text, tuple(those), sources[key].bibtex)
        for key, those in cited.items()
        if those
    )
    if not entries:
        return []
    path = context.out / bibliography.NAME
    text = bibliography.text(sources[entry.key] for entry in entries)
    path.write_text(text, encoding="utf-8", newline="")
    return [References(entries, path)]


def _citations(context: ReportContext) -> Iterator[tuple[str, str]]:
    """Yield the keys that methods, metrics and claims cite, each with its owner."""
    for name, portrait in context.portraits.items():
        if isinstance(portrait, Portrait):
            yield from ((key, name) for key in bibliography.keys(portrait.doc))
    yield from METRICS
    yield from ((source.key, "claims") for source in ledger.read(_CLAIMS))
