"""Proof that no polynomial of lower degree describes a constraint.

Consider the monomials up to degree s in some coordinates. Their rank on all motions is the Hilbert
function of the variety. Suppose that a polynomial of degree s vanishes at all motions that satisfy
a constraint, but not on all motions. Then the rank of the monomials at motions that satisfy the
constraint is lower than that on all motions. So equal ranks exclude such a polynomial. The rank is
computed at exact rational motions modulo a prime, which can only lower it: a full rank is a proof.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from gspcli.catalogue.kinds import Kind
from gspcli.symbolic.exact_motions import RationalMotion, coordinates_at, monomials, rank
from tools.equations.constraint_equations import CoordinateSystem
from tools.equations.exact_constraints import sample

#: Points beyond the rank that is expected; random motions need hardly any.
SPARE_POINTS = 8


def constrained_motions(
    kind: Kind, count: int, *, one_sided: bool = False, seed: int = 0
) -> list[RationalMotion]:
    """Return exact motions that satisfy one random instance of a kind of constraint."""
    random = Random(seed)
    instance = sample(kind, random)
    return [instance.motion(random, side=1 if one_sided else None) for _ in range(count)]


def excludes_degree(
    coordinates: CoordinateSystem,
    motions: Sequence[RationalMotion],
    degree: int,
    hilbert_value: int,
) -> bool:
    """Return whether every polynomial up to a degree that vanishes at the motions is trivial.

    Parameters
    ----------
    coordinates
        The coordinates of the polynomials.
    motions
        At least `hilbert_value` of them.
    degree
        The highest total degree.
    hilbert_value
        The Hilbert function of the variety of all motions at that degree.
    """
    points = coordinates_at(coordinates.name, motions[: hilbert_value + SPARE_POINTS])
    return rank(monomials(points, degree)) == hilbert_value
