"""The texts, numbers and names of an instance file; a `ValueError` states the mistake."""

from __future__ import annotations

from gspcli.errors import GspError
from gspcli.geometry.numbers import Number, parse_number
from gspcli.spec.document import Mapping, Scalar, Sequence, Value
from gspcli.wording import listed, shortened, shown

FORMAT_VERSION = 1
MAX_TEXT = 1000
MAX_NAME = 60


def found(value: Value) -> str:
    """Return the content of the file in the words of an error message."""
    if isinstance(value, Mapping):
        if not value:
            return "an empty mapping"
        return f"a mapping with {shortened(listed(value, 'and'))}"
    if isinstance(value, Sequence):
        return f"a list of {len(value)}"
    return shown(value) if value else "nothing"


def complain(value: Value, expected: str) -> ValueError:
    """Return the error of an unexpected value."""
    return ValueError(f"found {found(value)}, expected {expected}")


def scalar(value: Value, expected: str) -> str:
    """Return a scalar that is not empty."""
    if not isinstance(value, Scalar) or not value:
        raise complain(value, expected)
    return str(value)


def text(value: Value) -> str:
    """Return a text for people."""
    given = scalar(value, "a text")
    if len(given) > MAX_TEXT:
        message = f"found {len(given)} characters, expected at most {MAX_TEXT}"
        raise ValueError(message)
    if not all(character.isprintable() or character in " \t\n" for character in given):
        raise complain(value, "a printable text")
    return given


def optional_text(value: Value) -> str | None:
    """Return a text for people, or None."""
    return None if value == "" else text(value)


def number(value: Value) -> Number:
    """Return an exact number."""
    return parse_number(scalar(value, "a number or an expression like sqrt(3)/2"))


def number_or_home(value: Value) -> Number | None:
    """Return an exact number, or None for the word ``home``."""
    return None if value == "home" else number(value)


def version(value: Value) -> int:
    """Return the version of the file format."""
    if value != str(FORMAT_VERSION):
        raise complain(value, f"{FORMAT_VERSION}, the version of the file format")
    return FORMAT_VERSION


def nonzero(components: list[Number]) -> list[Number]:
    """Return a vector that is not zero."""
    if all(x.fraction == 0 for x in components):
        message = "found the zero vector, expected a direction: any nonzero vector"
        raise ValueError(message)
    return components


def turning(components: list[Number]) -> list[Number]:
    """Return a quaternion that is not zero."""
    if all(x.fraction == 0 for x in components):
        message = "found zero, expected a quaternion [w, x, y, z]: any but zero"
        raise ValueError(message)
    return components


def axes(value: Value) -> str:
    """Return the order of the axes of three angles, which a maker's name may stand for."""
    from gspcli.geometry.euler import named_order

    try:
        return named_order(scalar(value, "an order of axes such as ZYX"))
    except GspError as error:
        raise ValueError(str(error)) from None


def name(value: Value) -> str:
    """Return the name of a primitive."""
    return scalar(value, "the name of a primitive")


def proper_name(key: str) -> bool:
    """Whether a primitive may have this name."""
    return len(key) <= MAX_NAME and not any(c.isspace() or not c.isprintable() for c in key)
