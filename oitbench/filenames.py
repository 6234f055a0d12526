"""Names of files that stand for labels."""

from __future__ import annotations

import hashlib
import string

_PLAIN = frozenset(string.ascii_letters + string.digits + "_-.=,+@")
_LONGEST = 100


def file_name(label: str) -> str:
    """Return a name for a file that stands for `label`: safe, short, and another for each label.

    Letters, digits and a few signs stay; every other byte becomes `%XX`, as in a URL, so the label
    can be read back. A longer name is cut, and ends in `~` and a digest of the label.

    Examples
    --------
    >>> file_name("glass_bars[count=3]")
    'glass_bars%5Bcount=3%5D'
    """
    content = label.encode("utf-8", "surrogatepass")
    signs = [chr(byte) if chr(byte) in _PLAIN else f"%{byte:02X}" for byte in content]
    if signs[:1] == ["."]:
        signs[0] = "%2E"  # A name must not be hidden, nor mean a folder.
    name = "".join(signs)
    if name and len(name) <= _LONGEST:
        return name
    return f"{name[:_LONGEST]}~{hashlib.sha256(content).hexdigest()[:16]}"
