"""The varieties of rigid motions in each set of coordinates (Section 3).

`equations` generates a prime ideal. The rotations, given by ``RᵀR = RRᵀ = I`` and ``R = cof R``
(together they imply det R = 1), form a smooth irreducible group scheme. A further block that is a
polynomial in R and T adds the graph of a map on this scheme times the space of T. The block T×R
alone is given by equations linear in it: a vector bundle over the rotations. So the affine Hilbert
function of the ideal is the dimension of the space of polynomials up to a degree, restricted to the
motions. `sampled_hilbert_function` finds it from motions only, without a Gröbner basis.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import comb
from random import Random
from typing import Any

import sympy

from gspcli.symbolic.coordinate_systems import (
    MOTIONS,
    CoordinateSystem,
)
from gspcli.symbolic.rational_motions import (
    RationalMotion,
    Residues,
    monomials,
    random_motion,
    rank,
    residues,
)


@cache
def _evaluator(coordinates: CoordinateSystem) -> Any:
    blocks = MOTIONS.expressions
    entries = [entry for block in coordinates.blocks for entry in blocks[block]]
    return sympy.lambdify(MOTIONS.symbols, entries, modules=[{}], cse=True)


def coordinates_at(coordinates: CoordinateSystem, motions: Sequence[RationalMotion]) -> Residues:
    """Return the coordinates of exact motions modulo `PRIME`, shape (motions, coordinates)."""
    evaluate = _evaluator(coordinates)
    return residues([evaluate(*m.rotation.flat, *m.translation) for m in motions])


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


def sampled_hilbert_function(coordinates: CoordinateSystem, degree: int, points: int) -> int:
    """Return the rank of all monomials up to a degree at random rational motions.

    It is a proved lower bound of the Hilbert function (a rank modulo a prime, at points of the
    variety), and equal to it for random motions as soon as `points` exceeds it.
    """
    random = Random(0)
    motions = [random_motion(random) for _ in range(points)]
    return rank(monomials(coordinates_at(coordinates, motions), degree))
