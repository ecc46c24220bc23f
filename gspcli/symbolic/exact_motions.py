"""Rigid motions with rational entries, and polynomials on them modulo a prime."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import chain
from math import comb
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry import study
from gspcli.records import dataclass

Exact = NDArray[np.object_]
Residues = NDArray[np.int64]

#: Products of two residues stay exact in 64 bits.
PRIME = 2**31 - 1
#: The places of the blocks of coordinates among the forms of a motion.
PLACES: dict[str, Sequence[int]] = {
    "R": [*chain(*study.ROTATION)],
    "T": study.TRANSLATION,
    "U": study.BODY,
    "rho": [study.RHO],
    "TxR": [*chain(*study.MOMENT)],
}


@dataclass(frozen=True)
class RationalMotion:
    """A rigid motion ``x_base = R x_platform + T`` with rational entries."""

    #: R, shape (3, 3).
    rotation: Exact
    #: T, shape (3,).
    translation: Exact


def random_fraction(random: Random) -> Fraction:
    """Return a random fraction with numerator and denominator of at most 9."""
    return Fraction(random.randint(-9, 9), random.randint(1, 9))


def random_vector(random: Random) -> Exact:
    """Return a random rational vector, shape (3,)."""
    return np.array([random_fraction(random) for _ in range(3)], dtype=object)


def cayley(a: Fraction, b: Fraction, c: Fraction) -> Exact:
    """Return the rotation of the quaternion (1, a, b, c): Cayley's parametrization.

    >>> print(cayley(Fraction(0), Fraction(0), Fraction(1)).astype(int))
    [[ 0 -1  0]
     [ 1  0  0]
     [ 0  0  1]]
    """
    norm, rotation, _ = study.motion([Fraction(1), a, b, c, *[Fraction(0)] * 4])
    return np.asarray(np.array(rotation, dtype=object) / norm)


def random_rotation(random: Random) -> Exact:
    """Return a random rational rotation, shape (3, 3)."""
    a, b, c = (random_fraction(random) for _ in range(3))
    return cayley(a, b, c)


def random_motion(random: Random) -> RationalMotion:
    """Return a random rational rigid motion."""
    return RationalMotion(random_rotation(random), random_vector(random))


def residues(values: Sequence[Sequence[Any]]) -> Residues:
    """Return a table of rationals modulo `PRIME`."""
    return np.array(
        [
            [int(x.numerator) * pow(int(x.denominator), -1, PRIME) % PRIME for x in row]
            for row in values
        ],
        dtype=np.int64,
    )


def monomials(points: Residues, degree: int) -> Residues:
    """Return every monomial up to a degree at each point.

    Parameters
    ----------
    points
        Shape (points, variables).
    degree
        The highest total degree.

    Returns
    -------
    Residues
        Shape (points, monomials), the constant first.
    """
    count, variables = points.shape
    columns = [np.ones((count, 1), dtype=np.int64)]
    # Each monomial once: multiply by a variable not before its last one.
    starting = [columns[0]] + [np.empty((count, 0), dtype=np.int64)] * (variables - 1)
    for _ in range(degree):
        grown = []
        so_far = np.empty((count, 0), dtype=np.int64)
        for variable, block in enumerate(starting):
            so_far = np.hstack([so_far, block])
            grown.append(so_far * points[:, variable : variable + 1] % PRIME)
        columns += grown
        starting = grown
    return np.hstack(columns)


def rank(matrix: Residues) -> int:
    """Return the rank of a matrix modulo `PRIME`."""
    work = matrix % PRIME
    done = 0
    for column in range(work.shape[1]):
        below = np.flatnonzero(work[done:, column])
        if not below.size:
            continue
        pivot = done + int(below[0])
        work[[done, pivot]] = work[[pivot, done]]
        inverse = pow(int(work[done, column]), -1, PRIME)
        work[done, column:] = work[done, column:] * inverse % PRIME
        rows = done + below[below > 0]
        factors = work[rows, column : column + 1]
        work[rows, column:] = (work[rows, column:] - factors * work[done, column:]) % PRIME
        done += 1
        if done == work.shape[0]:
            break
    return done


def coordinates_at(name: str, motions: Sequence[RationalMotion]) -> Residues:
    """Return coordinates such as ``R,T,U`` of exact motions modulo `PRIME`, a motion a row."""
    places = [place for block in name.split(",") for place in PLACES[block]]
    forms = (study.forms_of_pose(m.rotation, m.translation) for m in motions)
    return residues([[entries[place] for place in places] for entries in forms])


def hilbert_function(numerator: Sequence[int], dimension: int, degree: int) -> int:
    """Return the dimension of the polynomials up to a degree restricted to a variety.

    Parameters
    ----------
    numerator
        Coefficients of h in the Hilbert series h(t) / (1 - t)^(dimension + 1) of the
        projective closure.
    dimension
        Dimension of the variety.
    degree
        The highest total degree of the polynomials.
    """
    terms = (
        coefficient * comb(degree - power + dimension, dimension)
        for power, coefficient in enumerate(numerator[: degree + 1])
    )
    return sum(terms)


def sampled_hilbert_function(name: str, degree: int, points: int) -> int:
    """Return the rank of all monomials up to a degree at random rational motions.

    It is a proved lower bound of the Hilbert function (a rank modulo a prime, at points of the
    variety), and equal to it for random motions as soon as `points` exceeds it.
    """
    random = Random(0)
    motions = [random_motion(random) for _ in range(points)]
    return rank(monomials(coordinates_at(name, motions), degree))
