"""The cases of Section 6 for which `gsp derive` has a triangular set."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from gspcli.errors import GspError
from gspcli.symbolic.angles import derive_angles, derive_example_6_2
from gspcli.symbolic.surface_intersections import (
    INTERSECTIONS,
    derive_example_6_8,
    derive_intersection,
)
from gspcli.symbolic.triangular import TriangularSet
from gspcli.wording import shown

_OTHERS: dict[str, Callable[[], TriangularSet]] = {
    "AAA": derive_angles,
    "6.2": derive_example_6_2,
    "6.8": derive_example_6_8,
}
_NEVER_EXPANDED = ("CCC", "SCC")
#: All cases, the intersections first.
CASES = (*INTERSECTIONS, *_OTHERS)


def parse_case(text: str) -> str:
    """Return the case that a word means: letters in any order and case, ``Example 6.2``.

    Raises
    ------
    GspError
        If it is none of `CASES`.
    """
    word = text.strip().upper().removeprefix("EXAMPLE").strip(" -")
    for case in CASES:
        if sorted(word) == sorted(case) and (case not in _OTHERS or word == case):
            return case
    message = f"{shown(text)} is not a case; the cases are {', '.join(CASES)}"
    raise GspError(message)


@cache
def derive(case: str) -> TriangularSet:
    """Derive the triangular set of one of the `CASES`."""
    return _OTHERS[case]() if case in _OTHERS else derive_intersection(case)


def expand_case(case: str) -> TriangularSet:
    """Return the triangular set of a case with the coefficients in the parameters alone.

    Raises
    ------
    GspError
        For CCC and SCC: the coefficient of x⁸ in h1 is k1³ times the resultant of three general
        ternary quadrics, which has 21894 terms, and those of lower powers have more.
    """
    if case in _NEVER_EXPANDED:
        message = (
            f"{case} is not written out in the parameters: for three quadrics the coefficient of "
            "x^8 alone has 21894 terms\nthe hierarchical form, without --expand, is complete"
        )
        raise GspError(message)
    return derive(case).expanded()
