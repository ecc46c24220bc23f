"""From an instance to quadrics on the Study quadric, which is what path tracking solves.

Times N, an angle, a one-sided DPH or DHP, the mutual moment of two lines and a DPP are each one
quadric in the Study parameters (e, f). DPL, DLP and DLL are products of two quadrics of one
family, ``G H = tau N^2``: with orthonormal a, b perpendicular to the line, and A, B the
distances to the planes through it with these normals, ``(A + iB)(A - iB) = d^2 N^2``; with the
mutual moment M and the cosine C of two lines, ``(M + idC)(M - idC) = d^2 N^2``.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.continuation.quadrics import (
    BODY_TRANSLATION,
    MOMENT,
    NORM,
    RHO,
    ROTATION,
    TRANSLATION,
)
from gspcli.continuation.systems import Structure, TargetSystem
from gspcli.geometry.residuals import Arrangement

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def target_systems(arrangement: Arrangement) -> list[TargetSystem]:
    """Return a system for each combination of sides asked for, all of one structure.

    The arrangement should be `Arrangement.normalised`: lengths of order one, points near the
    origins.
    """
    free = [
        i
        for i, kind in enumerate(arrangement.kinds)
        if kind.has_sides and arrangement.signs[i] == 0
    ]
    systems = []
    for choice in product((1, -1), repeat=len(free)):
        sides = arrangement.signs.copy()
        sides[free] = choice
        systems.append(_system(arrangement, sides))
    return systems


def _system(arrangement: Arrangement, sides: NDArray[np.int64]) -> TargetSystem:
    equations = [_equation(arrangement, i, int(side)) for i, side in enumerate(sides)]
    letters, g, h, tau = zip(*equations, strict=True)
    products = tuple(second is not None for second in h)
    return TargetSystem(
        Structure("".join(letters), products),
        np.array(g),
        np.array([np.zeros(len(NORM)) if second is None else second for second in h]),
        np.array(tau),
    )


def _equation(
    arrangement: Arrangement, i: int, side: int
) -> tuple[str, Array | Complex, Complex | None, float]:
    """Return the family letter of a constraint, its factors (the second may be None), and tau."""
    kind = arrangement.kinds[i]
    y, x, u, v = (part[i] for part in (arrangement.y, arrangement.x, arrangement.u, arrangement.v))
    d = float(arrangement.values[i])
    if kind is DPP:
        return "s", _point_point(y, x, d), None, 0.0
    if kind is DPH:
        return "p", _point_plane(y, x, v) - side * d * NORM, None, 0.0
    if kind is DHP:
        return "q", _plane_point(y, x, u) - side * d * NORM, None, 0.0
    if kind is DPL:
        a, b = _across(v)
        return "p", *_conjugate_factors(_point_plane(y, x, a), _point_plane(y, x, b)), d**2
    if kind is DLP:
        a, b = _across(u)
        return "q", *_conjugate_factors(_plane_point(y, x, a), _plane_point(y, x, b)), d**2
    if kind is DLL:
        moment = _mutual_moment(y, x, u, v)
        if d == 0:
            return "l", moment, None, 0.0
        return "l", *_conjugate_factors(moment, d * _turned(u, v)), d**2
    cosine = float(arrangement.cosines(arrangement.values)[list(arrangement.angles).index(i)])
    return "a", _turned(u, v) - cosine * NORM, None, 0.0


def _conjugate_factors(a: Array, b: Array) -> tuple[Complex, Complex]:
    return a + 1j * b, a - 1j * b


def _across(direction: Array) -> tuple[Array, Array]:
    """Return two unit vectors that complete a unit vector to an orthonormal basis."""
    basis = np.linalg.svd(direction[None])[2]
    return basis[1], basis[2]


def _turned(a: Array, b: Array) -> Array:
    """Return the quadric of ``R a . b``."""
    quadric: Array = np.einsum("i,j,ijk->k", b, a, ROTATION)
    return quadric


def _point_plane(y: Array, x: Array, v: Array) -> Array:
    """Return the quadric of ``v . (R y + T - x)``."""
    quadric: Array = _turned(y, v) + v @ TRANSLATION - (v @ x) * NORM
    return quadric


def _plane_point(y: Array, x: Array, u: Array) -> Array:
    """Return the quadric of ``R u . (x - R y - T) = u . (R^T x - y - U)``."""
    quadric: Array = _turned(u, x) - u @ BODY_TRANSLATION - (u @ y) * NORM
    return quadric


def _mutual_moment(y: Array, x: Array, u: Array, v: Array) -> Array:
    """Return the quadric of ``(R y + T - x) . (R u x v)``."""
    turning = np.einsum("i,j,ijk->k", v, u, MOMENT)
    quadric: Array = turning + _turned(np.cross(y, u), v) - _turned(u, np.cross(v, x))
    return quadric


def _point_point(y: Array, x: Array, d: float) -> Array:
    """Return the quadric of ``|R y + T - x|^2 - d^2``."""
    linear = 2 * (y @ BODY_TRANSLATION - x @ TRANSLATION - _turned(y, x))
    quadric: Array = RHO + linear + (y @ y + x @ x - d**2) * NORM
    return quadric
