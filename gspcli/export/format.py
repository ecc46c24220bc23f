"""What a format of `gsp export` states about itself.

Rational coefficients are exact everywhere. Irrational constants (square roots, cosines) are exact
for SymPy. For programs that have only rational numbers they are decimal fractions with as many
digits as are asked for. For programs that compute in doubles they are doubles.

The scripts for Macaulay2, Singular and HomotopyContinuation.jl print a line ``# dimension ..,
degree ..`` where they know it, and the solutions as CSV that `gsp certify` reads.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem
    from gspcli.geometry.instance import Instance
    from gspcli.solver import Solution


@dataclass(frozen=True)
class SystemFormat:
    """The input of a program that solves systems of polynomials.

    Attributes
    ----------
    write
        Its text for a system and a number of digits.
    irrational
        What it has for irrational constants: the constants themselves, decimal fractions of this
        many digits, or doubles.
    """

    write: Callable[[PolynomialSystem, int], str]
    irrational: Literal["exact", "decimals", "doubles"]


@dataclass(frozen=True)
class ModeFormat:
    """The input of a program that is given the platform in one real assembly mode.

    Attributes
    ----------
    write
        The texts of its files for an instance and a pose of it.
    what
        What that is, for the help.
    suffixes
        What the names of the files end with if there are two; the last is what `-o` names.
    """

    write: Callable[[Instance, Solution], tuple[str, ...]]
    what: str
    suffixes: tuple[str, ...] = ("",)


@dataclass(frozen=True)
class ControllerFormat:
    """A program for the controller of one platform: a header and a source.

    Attributes
    ----------
    write
        The function that writes their texts. It takes an instance, what names begin with, how many
        parts of a line of values are tried, and the name of the files. It also takes a pose for the
        header, or None, and by which part of its range a value may leave it.
    suffixes
        What the names of the two files end with.
    what
        What that is, for the help.
    """

    write: Callable[[Instance, str, int, str, Solution | None, float], tuple[str, str]]
    suffixes: tuple[str, str]
    what: str
