"""The account of all paths, which every method of solution returns."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

from gspcli.records import dataclass

Verdict = Literal["complete", "infinite", "incomplete"]


class Basis(StrEnum):
    """The basis of an account."""

    PATHS = "paths"
    """Every path was followed to its end."""
    COUNT = "count"
    """Nothing was followed: at infinity are the expected less those that were counted."""


@dataclass(frozen=True, kw_only=True)
class PathAccount:
    """The ends of the expected solutions of one system or of several.

    Accounts of different systems add: ``sum(accounts, PathAccount(expected=0))``. An account times
    n is that of n equal systems. The basis of a sum is `Basis.COUNT` if that of a part is.

    Attributes
    ----------
    expected
        The generic count: the number of paths.
    found
        Paths that end at finite isolated solutions: the sum of their multiplicities.
    at_infinity
        Paths that end at infinity.
    on_curves
        Paths that end on positive-dimensional solution sets.
    spurious
        Paths that end at a solution of the equations that violates a constraint: the lines of a
        DLL are parallel, at another distance.
    lost
        Paths whose end is not known.
    basis
        The basis of the account.

    Raises
    ------
    ValueError
        If a number is negative, or the five do not add up to the expected ones.

    Examples
    --------
    >>> account = PathAccount(expected=40, found=28, at_infinity=12)
    >>> account.verdict
    'complete'
    >>> (account + PathAccount(expected=8, found=7, lost=1)).verdict
    'incomplete'
    """

    expected: int
    found: int = 0
    at_infinity: int = 0
    on_curves: int = 0
    spurious: int = 0
    lost: int = 0
    basis: Basis = Basis.PATHS

    def __post_init__(self) -> None:
        parts = (self.found, self.at_infinity, self.on_curves, self.spurious, self.lost)
        if min(parts) < 0 or sum(parts) != self.expected:
            raise ValueError(f"an account must add up, of parts that are not negative: {self}")

    @property
    def verdict(self) -> Verdict:
        """`infinite` if paths end on curves, else `incomplete` if any are lost."""
        if self.on_curves:
            return "infinite"
        return "incomplete" if self.lost else "complete"

    def __add__(self, other: PathAccount) -> PathAccount:
        """Return the account of both systems."""
        counted = Basis.COUNT in (self.basis, other.basis)
        return PathAccount(
            expected=self.expected + other.expected,
            found=self.found + other.found,
            at_infinity=self.at_infinity + other.at_infinity,
            on_curves=self.on_curves + other.on_curves,
            spurious=self.spurious + other.spurious,
            lost=self.lost + other.lost,
            basis=Basis.COUNT if counted else Basis.PATHS,
        )

    def __mul__(self, times: int) -> PathAccount:
        """Return the account of several equal systems."""
        return PathAccount(
            expected=self.expected * times,
            found=self.found * times,
            at_infinity=self.at_infinity * times,
            on_curves=self.on_curves * times,
            spurious=self.spurious * times,
            lost=self.lost * times,
            basis=self.basis,
        )
