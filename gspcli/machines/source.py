"""Files of machines as text of limited size, with the places of mistakes."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import Location, Mistake, SpecError
from gspcli.spec.document import content_of
from gspcli.wording import named, shown

Array = NDArray[np.float64]

#: Bytes of a file that is read.
LARGEST = 1 << 23
#: Lengths, angles and masses are smaller.
LARGEST_NUMBER = 1e15
_DECIMAL = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")


class SourceLine:
    """A line of a file, for errors.

    Parameters
    ----------
    file
        The name of the file.
    line, column
        From 1.
    what
        The part of the file that a message is about, such as ``joint 'slide_1'``.
    """

    def __init__(self, file: str, line: int = 1, column: int = 1, what: str = "") -> None:
        self.location = Location(file, line, column)
        self.what = what

    def error(self, message: str) -> SpecError:
        """Return an error with this place."""
        return SpecError([Mistake(self.location, self.what, message)])

    def number(self, text: str) -> float:
        """Return a decimal number.

        Raises
        ------
        SpecError
            If it is no number, or too large.
        """
        if not _DECIMAL.fullmatch(text.strip()):
            raise self.error(f"found {shown(text)}, expected a number")
        value = float(text)
        if not abs(value) < LARGEST_NUMBER:
            raise self.error(f"found {shown(text)}, expected a number below {LARGEST_NUMBER:g}")
        return value

    def numbers(self, text: str, count: int) -> Array:
        """Return the given number of numbers, which are separated by blanks.

        Raises
        ------
        SpecError
            If there are more or fewer.
        """
        words = text.split()
        if len(words) != count:
            raise self.error(f"found {shown(text)}, expected {count} numbers")
        return np.array([self.number(word) for word in words])

    def limit(self, text: str | None, otherwise: float) -> float:
        """Return an end of a range, `otherwise` if it is not given; of 1e15 on it is infinite."""
        if text is None or not text.strip():
            return otherwise
        word = text.strip().lower()
        if word.lstrip("+-") in ("inf", "infinity"):
            return -math.inf if word.startswith("-") else math.inf
        if not _DECIMAL.fullmatch(word):
            raise self.error(f"found {shown(text)}, expected a number")
        value = float(word)
        return value if abs(value) < LARGEST_NUMBER else math.copysign(math.inf, value)


def text_of(path: Path) -> str:
    """Return the text of a file.

    Raises
    ------
    OSError
        If it cannot be read.
    SpecError
        If it is too large, or no text.
    """
    place = SourceLine(str(path))
    try:
        content = content_of(path, LARGEST)
    except ValueError as error:
        raise place.error(str(error)) from None
    for encoding in ("utf-16", "utf-32") if content[:2] in (b"\xff\xfe", b"\xfe\xff") else ():
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in content:
            message = f"{named(path.name)} is no text"
            raise place.error(message) from None
        # Comments in the encoding of Western Europe are common, and every byte is a letter there.
        return content.decode("latin-1")
