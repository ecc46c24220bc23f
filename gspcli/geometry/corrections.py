"""Readings to values and back, exactly: a value is its reading times 1 + scale, plus offset."""

from __future__ import annotations

from gspcli.geometry.numbers import Number

_INVERSE = {"+": "-", "-": "+", "*": "/", "/": "*"}


def value_of(
    reading: Number, scale: Number | None, offset: Number | None, added: str = "+"
) -> Number:
    """Return the value of a reading.

    Parameters
    ----------
    reading
        What a file, a table or an encoder says.
    scale, offset
        None stands for zero.
    added
        The operation that applies the offset: ``+`` or ``-``.
    """
    if scale is not None:
        reading = combined(reading, "*", _factor(scale))
    return reading if offset is None else combined(reading, added, offset)


def reading_of(
    value: Number, scale: Number | None, offset: Number | None, added: str = "+"
) -> Number:
    """Return the reading at which the machine has a value; arguments as for `value_of`."""
    if offset is not None:
        value = combined(value, _INVERSE[added], offset)
    return value if scale is None else combined(value, "/", _factor(scale))


def _factor(scale: Number) -> Number:
    return combined(Number.of(1), "+", scale)


def combined(number: Number, operation: str, other: Number) -> Number:
    """Return a number after an operation; an operation and its inverse cancel exactly."""
    if number.operation == _INVERSE[operation] and number.arguments[1] == other:
        undone: Number = number.arguments[0]
        return undone
    result = Number(operation, (number, other))
    return result if result.fraction is None else Number("rational", (result.fraction,))
