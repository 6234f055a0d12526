"""The publications that describe the methods here, or of which the claims are.

Please cite those of the methods that you compare.
"""

from __future__ import annotations

from pathlib import Path

from oitbench.catalog.messages import Portrait
from oitbench.claims import ledger
from oitbench.report import Artifact, ReportContext, bibliography
from oitbench.report.artifacts import Reference, References

title = "References"
order = 70

_CLAIMS = Path(__file__).with_name("claims")


def build(context: ReportContext) -> list[Artifact]:
    """List all sources that methods of these results or claims cite, and write a BibTeX file."""
    sources = bibliography.read(context.bibliographies)
    cited = dict.fromkeys(sources, ())
    for name, portrait in context.portraits.items():
        if isinstance(portrait, Portrait):
            for key in bibliography.keys(portrait.doc):
                if key in cited:
                    cited[key] += (name,)
    for source in ledger.read(_CLAIMS):
        if source.key in cited:
            cited[source.key] += ("claims",)
    entries = tuple(
        Reference(key, sources[key].text, names, sources[key].bibtex)
        for key, names in cited.items()
        if names
    )
    if not entries:
        return []
    path = context.out / bibliography.NAME
    text = bibliography.text(sources[entry.key] for entry in entries)
    path.write_text(text, encoding="utf-8", newline="")
    return [References(entries, path)]
