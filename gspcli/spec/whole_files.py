"""Reads a file, up to a size limit."""

from __future__ import annotations

import sys
from pathlib import Path

#: The most bytes of a file that describes a platform or a search, and of a table.
LARGEST_SPEC, LARGEST_TABLE = 1 << 24, 1 << 30


def content_of(source: str | Path, largest: int) -> bytes:
    """Return the content of a file, or for ``-`` of standard input.

    Parameters
    ----------
    source
        The path.
    largest
        The most bytes; devices such as /dev/zero have no end.

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
