"""Checks of the arguments of the solver, before any work; a mistake is named with its place."""

from __future__ import annotations

import operator
from typing import Any

from gspcli.errors import ArgumentError
from gspcli.wording import shortened


def whole(value: Any, where: str, *, least: int) -> int:
    """Return an argument that is a whole number.

    Raises
    ------
    ArgumentError
        If it is none, or below the least one.
    """
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if number < least or isinstance(value, bool):
        message = f"found {shortened(repr(value))}, expected a whole number of at least {least}"
        raise ArgumentError(message, where)
    return number
