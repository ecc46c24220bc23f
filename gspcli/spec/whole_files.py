"""Files that are read whole, but not without end."""

from __future__ import annotations

import sys
from pathlib import Path

#: Bytes of a file that describes a platform or a search, and of one with rows.
LARGEST_SPEC, LARGEST_TABLE = 1 << 24, 1 << 30


def content_of(source: str | Path, largest: int) -> bytes:
    """Return the content of a file, or for ``-`` of standard input.

    Parameters
    ----------
    source
        Where it is.
    largest
        How many bytes it may have: devices such as /dev/zero never end.

    Raises
    ------
    OSError, ValueError
        If it cannot be read, or has more.
    """
    if str(source) == "-":
        content = sys.stdin.buffer.read(largest + 1)
    else:
        with Path(source).open("rb") as file:
            content = file.read(largest + 1)
    if len(content) > largest:
        message = f"it has more than {largest >> 20} MB"
        raise ValueError(message)
    return content
