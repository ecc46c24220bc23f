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
from gspcli.wording import named

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


#: What to do with files in other encodings.
_SAVE = "save it as UTF-8, in Excel as 'CSV UTF-8'"


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
    return utf8(content, file)


def utf8(content: bytes, file: str) -> str:
    """Return the text of a file in UTF-8.

    Raises
    ------
    SpecError
        With the place of what is not UTF-8, and what to do.
    """
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        message = f"found text in UTF-16, expected UTF-8: {_SAVE}"
        raise SpecError([Mistake(Location(file, 1, 1), "", message)])
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        column = error.start - content.rfind(b"\n", 0, error.start)
        byte = content[error.start : error.start + 1]
        said = byte.decode("cp1252", "replace")
        said = f" ({said} in Windows-1252)" if said.isprintable() and said != "\ufffd" else ""
        message = f"found the byte 0x{byte.hex()}{said}, expected text in UTF-8: {_SAVE}"
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


def text_of_table(path: str | Path, name: str) -> str:
    """Return the text of a table, or for ``-`` that of standard input.

    Raises
    ------
    SpecError
        If it cannot be read, is too large or not UTF-8.
    """
    try:
        content = content_of(path, LARGEST_TABLE)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        message = f"{named(name)}: cannot be read: {reason}"
        raise SpecError([Mistake(None, "", message)]) from error
    return utf8(content, name)
