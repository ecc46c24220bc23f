"""The values of a file, with their places in it.

Only the structure of YAML is used: every scalar is the text as written. So ``1_000``, ``yes`` or
``1:30`` are never converted, and decimals are exact. `ordinary` reads files in the ordinary form,
`any_yaml` all others and those with mistakes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, TypeVar

from gspcli.errors import Location, Mistake, SpecError

MAX_BYTES = 100_000
MAX_DEPTH = 12
#: Words for an absent value.
NULLS = ("", "~", "null", "Null", "NULL")


class Scalar(str):
    """A scalar as written; empty if the file has no value or null."""

    location: Location
    path: str


class Sequence(list[Any]):
    """A list of located values."""

    location: Location
    path: str


class Mapping(dict[Scalar, Any]):
    """A mapping from located keys to located values, in the order of the file."""

    location: Location
    path: str


Value = Scalar | Sequence | Mapping


class Missing(Scalar):
    """The mark of a missing or unusable value, which has been reported already."""


Located = TypeVar("Located", Scalar, Sequence, Mapping)


def locate(value: Located, location: Location, path: str) -> Located:
    """Return the value with its place."""
    value.location, value.path = location, path
    return value


def decode(content: bytes, file: str) -> str:
    """Return the text of a file.

    Raises
    ------
    SpecError
        If the file is too large, not UTF-8 or not text.
    """
    if len(content) > MAX_BYTES:
        message = f"found {len(content)} bytes, expected an instance file of at most {MAX_BYTES}"
        raise SpecError([Mistake(Location(file, 1, 1), "", message)])
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        column = error.start - content.rfind(b"\n", 0, error.start)
        message = f"found the byte 0x{content[error.start]:02x}, expected text in UTF-8"
        raise SpecError([Mistake(Location(file, line, column), "", message)]) from error


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
