"""Cells of tables for people: numbers with as many digits as there is room for."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from gspcli.cli.output.tables import DIGITS, Column, Table

#: Numbers of a column have the same number of decimals if the largest lies between these; others
#: need exponents.
_SMALLEST, _LARGEST = 1e-3, 1e5
#: Decimals that an aligned column has at least at full width.
_FEWEST_DECIMALS = 2
#: Components of a vector below this part of its size are rounding errors.
_NOTHING = 1e-9
#: Numbers of a column below this part of its size are rounding errors.
_ROUNDING = 1e-12
#: Characters that control a terminal: control characters, changes of direction.
_OBEYED = re.compile("[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def printable(text: str) -> str:
    """Return a text with the characters that control a terminal escaped.

    Line breaks stay.
    """
    return _OBEYED.sub(_written_out, text)


def _written_out(match: re.Match[str]) -> str:
    character = match[0]
    return character if character == "\n" else character.encode("unicode_escape").decode("ascii")


def cell_text(value: object, digits: int = DIGITS) -> str:
    """Return a value as people read it in a table.

    Parameters
    ----------
    value
        A number, a text, a list of them, or None for nothing.
    digits
        Significant digits of numbers that are not whole.
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        # Zero has one sign.
        return f"{value + 0.0:.{digits}g}"
    if isinstance(value, complex):
        return f"{value.real:.{digits}g}{value.imag:+.{digits}g}i"
    if isinstance(value, (list, tuple)):
        return " ".join(cell_text(item, digits) for item in value)
    return printable(str(value).replace("\n", " "))


def vector_text(numbers: Sequence[float], digits: int = DIGITS, *, size: float = 1.0) -> str:
    """Return components as people read them, one after the other.

    Parameters
    ----------
    numbers, digits
        The components, and their significant digits.
    size
        A typical component. A component below `_NOTHING` times it is a rounding error, and shown as
        zero.
    """
    shown = (x if abs(x) > _NOTHING * size else 0.0 for x in numbers)
    return ", ".join(f"{x:.{digits}g}" for x in shown)


def column_texts(table: Table, column: Column, digits: int = DIGITS) -> list[str]:
    """Return the cells of a column as text, numbers with this many digits."""
    values = [_cleared(row.get(column.key), column.size) for row in table.rows]
    decimals = column.decimals
    if decimals is None and column.aligned:
        decimals = _decimals([v for v in values if isinstance(v, float)], digits)
    if decimals is None:
        return [cell_text(value, digits) for value in values]
    return [_fixed(value, decimals, digits) for value in values]


def _cleared(value: object, size: float) -> object:
    """Return zero for a float that is a rounding error of numbers of a size, else the value."""
    return 0.0 if isinstance(value, float) and abs(value) < _ROUNDING * size else value


def _fixed(value: object, decimals: int, digits: int) -> str:
    """Return a number with this many decimals, any other value unchanged."""
    if isinstance(value, float) and math.isfinite(value):
        return _without_negative_zero(f"{value:.{decimals}f}")
    if isinstance(value, complex):
        real = _without_negative_zero(f"{value.real:.{decimals}f}")
        return f"{real}{value.imag:+.{decimals}f}i"
    return cell_text(value, digits)


def _decimals(values: Sequence[float], digits: int) -> int | None:
    """Return how many decimals give the largest number this many digits; None if none does."""
    # Rounded, so that 0.9999999999 and 1 have the same decimals.
    largest = float(f"{max(map(abs, values), default=0.0):.{digits}g}")
    if largest == 0:
        return 0
    if not _SMALLEST <= largest < _LARGEST:
        return None
    fewest = max(_FEWEST_DECIMALS - (DIGITS - digits), 0)
    return max(digits - 1 - math.floor(math.log10(largest)), fewest)


def _without_negative_zero(text: str) -> str:
    return text.removeprefix("-") if not text.strip("-0.") else text
