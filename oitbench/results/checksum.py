"""A checksum inside a JSON object, so that damage of a file is noticed and never believed."""

from __future__ import annotations

import hashlib
import re

CHECKSUM = "checksum"
_DIGITS = 16
_SEALED = re.compile(rb'(?P<body>.*), "checksum": "(?P<digest>[0-9a-f]{16})"}', re.DOTALL)


def seal(text: bytes) -> bytes:
    """Return the text of a JSON object that has a field, with `checksum` as its last one."""
    body = text.rstrip().removesuffix(b"}").rstrip()
    return body + f', "{CHECKSUM}": "{_digest(body)}"}}'.encode()


def unseal(text: bytes) -> bytes | None:
    """Return the text of a JSON object without its checksum; None if they do not agree."""
    match = _SEALED.fullmatch(text)
    if match is None or _digest(match["body"]) != match["digest"].decode():
        return None
    return match["body"] + b"}"


def _digest(body: bytes) -> str:
    return hashlib.sha256(body).hexdigest()[:_DIGITS]
