"""From an instance to quadrics on the Study quadric, which is what path tracking solves.

Times N, an angle, a one-sided DPH or DHP, the mutual moment of two lines and a DPP are each one
quadric in the Study parameters (e, f). DPL, DLP and DLL are products of two quadrics of one
family, ``G H = tau N^2``: with orthonormal a, b perpendicular to the line, and A, B the
distances to the planes through it with these normals, ``(A + iB)(A - iB) = d^2 N^2``; with the
mutual moment M and the cosine C of two lines, ``(M + idC)(M - idC) = d^2 N^2``.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.continuation.quadrics import (
    BODY_TRANSLATION,
    MOMENT,
    NORM,
    RHO,
    ROTATION,
    TRANSLATION,
)
from gspcli.continuation.systems import Structure, TargetSystem
from gspcli.geometry.poses import cross, dot
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
    values = arrangement.targets.copy()
    values[arrangement.angles] = arrangement.cosines(arrangement.values)
    return target_system(
        [
            equation(kind, *geometry)
            for kind, *geometry in zip(
                arrangement.kinds,
                arrangement.y,
                arrangement.x,
                arrangement.u,
                arrangement.v,
                np.where(sides < 0, -values, values),
                strict=True,
            )
        ]
    )


class Equation(NamedTuple):
    """A constraint as ``G = 0`` or, if there is a second factor, ``G H = tau N^2``."""

    letter: str
    """The family of the quadrics."""
    g: Array | Complex
    """Shape (..., 27)."""
    h: Complex | None
    tau: Array


def target_system(equations: Sequence[Equation]) -> TargetSystem:
    """Return the system of six equations without leading axes."""
    letters, g, h, tau = zip(*equations, strict=True)
    products = tuple(second is not None for second in h)
    return TargetSystem(
        Structure("".join(letters), products),
        np.array(g),
        np.array([np.zeros(len(NORM)) if second is None else second for second in h]),
        np.array(tau),
    )


def equation(kind: Kind, y: Array, x: Array, u: Array, v: Array, value: Array) -> Equation:
    """Return the equation of a constraint, or of many of one kind along leading axes.

    Parameters
    ----------
    kind
        The kind.
    y, x
        A point of the platform's and of the base's primitive, shape (..., 3).
    u, v
        Their unit directions, shape (..., 3); those of points do not matter.
    value
        The distance, signed if the kind has sides, or for an angle the value of ``R u . v``;
        shape (...). Lines at a distance of zero have one quadric, so all of them or none.
    """
    zero = np.zeros_like(value)
    if kind is DPP:
        return Equation("s", _point_point(y, x, value), None, zero)
    if kind is DPH:
        return Equation("p", _point_plane(y, x, v) - _constant(value), None, zero)
    if kind is DHP:
        return Equation("q", _plane_point(y, x, u) - _constant(value), None, zero)
    if kind is DPL:
        a, b = _across(v)
        return _factors("p", _point_plane(y, x, a), _point_plane(y, x, b), value)
    if kind is DLP:
        a, b = _across(u)
        return _factors("q", _plane_point(y, x, a), _plane_point(y, x, b), value)
    if kind is DLL:
        moment = _mutual_moment(y, x, u, v)
        if not np.any(value):
            return Equation("l", moment, None, zero)
        return _factors("l", moment, value[..., None] * _turned(u, v), value)
    return Equation("a", _turned(u, v) - _constant(value), None, zero)


def _factors(letter: str, a: Array, b: Array, distance: Array) -> Equation:
    return Equation(letter, a + 1j * b, a - 1j * b, distance**2)


def _constant(value: Array) -> Array:
    """Return the quadric of a constant, shape (..., 27)."""
    return np.asarray(value[..., None] * NORM)


def _across(direction: Array) -> tuple[Array, Array]:
    """Return two unit vectors that complete a unit vector to an orthonormal basis."""
    basis = np.linalg.svd(direction[..., None, :])[2]
    return basis[..., 1, :], basis[..., 2, :]


def _turned(a: Array, b: Array) -> Array:
    """Return the quadric of ``R a . b``."""
    quadric: Array = np.einsum("...i,...j,ijk->...k", b, a, ROTATION)
    return quadric


def _point_plane(y: Array, x: Array, v: Array) -> Array:
    """Return the quadric of ``v . (R y + T - x)``."""
    quadric: Array = _turned(y, v) + v @ TRANSLATION - _constant(dot(v, x))
    return quadric


def _plane_point(y: Array, x: Array, u: Array) -> Array:
    """Return the quadric of ``R u . (x - R y - T) = u . (R^T x - y - U)``."""
    quadric: Array = _turned(u, x) - u @ BODY_TRANSLATION - _constant(dot(u, y))
    return quadric


def _mutual_moment(y: Array, x: Array, u: Array, v: Array) -> Array:
    """Return the quadric of ``(R y + T - x) . (R u x v)``."""
    turning: Array = np.einsum("...i,...j,ijk->...k", v, u, MOMENT)
    quadric: Array = turning + _turned(cross(y, u), v) - _turned(u, cross(v, x))
    return quadric


def _point_point(y: Array, x: Array, d: Array) -> Array:
    """Return the quadric of ``|R y + T - x|^2 - d^2``."""
    linear = 2 * (y @ BODY_TRANSLATION - x @ TRANSLATION - _turned(y, x))
    return np.asarray(RHO + linear + _constant(dot(y, y) + dot(x, x) - d**2))
