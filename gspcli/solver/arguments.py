"""Checks of the arguments of the solver, before any work; a mistake is named with its place."""

from __future__ import annotations

import operator
import warnings
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


def warn_of_certify(certify: bool | None) -> None:
    """Warn a caller's caller that an argument is ignored, if it is given."""
    if certify is not None:
        message = "certify is ignored: every pose is proved"
        warnings.warn(message, DeprecationWarning, stacklevel=3)
