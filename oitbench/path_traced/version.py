"""The version of the path tracer: references of another version are rendered anew.

Raise it with every change that changes a picture of some scene; `tests/path_traced/test_version.py`
fails if that was forgotten.
"""

from __future__ import annotations

TRACER = 3
