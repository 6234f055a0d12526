"""JSON that is nested too deeply, or holds numbers that are not finite, is refused."""

from __future__ import annotations

import pytest

from oitbench import json_text


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[" * 100_000, "nested too deeply"),
        ('{"a":' * 100_000, "nested too deeply"),
        ("[NaN]", "NaN is not a finite number"),
        ("[-Infinity]", "-Infinity is not a finite number"),
        ("[1e999]", "1e999 is not a finite number"),
        ("[1", "Expecting"),
        (b"\xff\xfe\xff", "decode"),
    ],
)
def test_damaged_text_is_refused(text: str | bytes, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        json_text.loads(text)


def test_other_text_is_read() -> None:
    assert json_text.loads(b'{"a": [1, 2.5e-3, null, "x"]}') == {"a": [1, 0.0025, None, "x"]}
