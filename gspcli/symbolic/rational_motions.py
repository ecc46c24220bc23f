"""Exact rational rigid motions and linear algebra modulo a prime on points made from them.

Vectors and matrices are NumPy arrays of `fractions.Fraction` (dtype object).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.records import dataclass

Exact = NDArray[np.object_]
Residues = NDArray[np.int64]

#: Products of two residues stay exact in 64 bits.
PRIME = 2**31 - 1


@dataclass(frozen=True)
class RationalMotion:
    """A rigid motion ``x_base = R x_platform + T`` with rational entries.

    Attributes
    ----------
    rotation
        R, shape (3, 3).
    translation
        T, shape (3,).
    """

    rotation: Exact
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
    norm = 1 + a * a + b * b + c * c
    rows = [
        [1 + a * a - b * b - c * c, 2 * (a * b - c), 2 * (a * c + b)],
        [2 * (a * b + c), 1 - a * a + b * b - c * c, 2 * (b * c - a)],
        [2 * (a * c - b), 2 * (b * c + a), 1 - a * a - b * b + c * c],
    ]
    return np.array([[Fraction(entry) / norm for entry in row] for row in rows], dtype=object)


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
