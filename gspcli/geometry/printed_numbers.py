"""Condition numbers and residuals in files: the digits that rounding errors cannot change.

Both are computed in double precision, and another processor rounds differently. The numbers of
results keep all their digits; these are the ones of JSON, CSV and tables of poses.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Digits of a condition number: this many at most, and one less for each power of ten of the number
#: from where rounding errors, some 1e-15 of it times itself, come near the last digit.
_DIGITS, _KNOWN = 6, 12
#: Residuals below this part of the length of a platform are rounding errors of measuring it.
_ROUNDING = 64 * float(np.finfo(np.float64).eps)


def printed_condition(condition: float) -> float:
    """Return a condition number with the digits that are known; infinity and NaN unchanged."""
    if not math.isfinite(condition) or condition <= 0:
        return condition
    digits = min(_DIGITS, max(1, _KNOWN - math.ceil(math.log10(condition))))
    return float(f"{condition:.{digits}g}")


def printed_conditions(conditions: ArrayLike) -> NDArray[np.float64]:
    """Return `printed_condition` of each number, in the same shape."""
    given = np.asarray(conditions, np.float64)
    return np.array([printed_condition(x) for x in given.ravel().tolist()]).reshape(given.shape)


def printed_residual(residual: float, length: float) -> float:
    """Return an upper bound of a residual with one digit, which rounding errors do not change.

    Parameters
    ----------
    residual
        The largest residual of a pose, in the units of the instance.
    length
        Of the platform. A residual below `_ROUNDING` of it may be a rounding error.
    """
    if not math.isfinite(residual):
        return residual
    return one_digit(max(residual, _ROUNDING * length))


def one_digit(bound: float) -> float:
    """Return the next number of one digit that is not less: 1.4e-14 becomes 2e-14."""
    power = math.floor(math.log10(bound)) if bound else 0
    digit = math.ceil(bound / 10.0**power) if bound else 0
    return float(f"{digit}e{power}")


def printed_residuals(residuals: ArrayLike, length: float) -> NDArray[np.float64]:
    """Return `printed_residual` of each number, in the same shape."""
    given = np.asarray(residuals, np.float64)
    found = [printed_residual(x, length) for x in given.ravel().tolist()]
    return np.array(found).reshape(given.shape)
