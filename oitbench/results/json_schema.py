"""The JSON Schema of records and of the facts of a run: `record.schema.json` beside this file.

    python -m oitbench.results.json_schema

writes it anew.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from oitbench.results.checksum import CHECKSUM
from oitbench.results.schema import Record, RunFacts

SCHEMA_FILE = Path(__file__).with_name("record.schema.json")


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a line of `cells.jsonl` and of `run.json`."""
    (record, facts), definitions = msgspec.json.schema_components(
        (Record, RunFacts), ref_template="#/$defs/{name}"
    )
    for definition in definitions.values():
        definition["description"] = " ".join(definition["description"].split())
    for kind in (Record, RunFacts):
        # Both have a checksum in their file, which is no field of theirs; see `checksum.py`.
        definitions[kind.__name__]["properties"][CHECKSUM] = {"type": "string"}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Results of oitbench",
        "oneOf": [record, facts],
        "$defs": definitions,
    }


def schema_text() -> str:
    """Return the content of `record.schema.json`."""
    return msgspec.json.format(msgspec.json.encode(json_schema()), indent=1).decode() + "\n"


if __name__ == "__main__":
    SCHEMA_FILE.write_text(schema_text(), encoding="utf-8")
