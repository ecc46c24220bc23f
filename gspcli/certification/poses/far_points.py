"""Poses far away near the ends of paths with fewer unknowns, by Newton's method with more digits.

Where a platform is special but for the rounding of its numbers, N = e.e nearly vanishes at its
poses far away. Solved for ``w = e ^ f`` and ``h = f.f``, the equations are regular there
(`gspcli.continuation.reduced_homotopy`). The unknowns are e, w and h. The equations are six, linear
in w and h, with ``e ^ w = 0`` and ``w.w = N h``. So paths in double precision arrive, and e is
right to all its digits. They do not suffice for ``N f``, the product of e and w. Newton's method on
the exact numbers gives the others, ten at each step: the Jacobian matrix in doubles is enough.

Paths with 32 digits, or eigenvectors where numbers are in floating point, took a third of the time
of a first solution and four fifths (`tools.verify.realistic`, hexapods with six joints a body).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, log10

import numpy as np
from flint import acb, acb_mat, arb_mat, ctx
from numpy.typing import NDArray

from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.mirror_images import has_mirror_images, mirrored
from gspcli.certification.numbers.balls import sums_of_doubles
from gspcli.certification.poses.locator import Locator
from gspcli.geometry.instance import Instance

Complex = NDArray[np.complex128]

#: Bits of the numbers; 96 digits suffice for machines in floating point, where N is 1e-64.
_BITS = 320
#: Bits of N that a point needs, and a part below which N counts as zero.
_NEEDED, _NULL = 2.0**-50, 2.0**-250
#: The least N that is sought is this power of the rounding of coordinates.
_POWER = 6
#: A Newton step at first, and the part of it that the next one may be.
_FIRST, _SMALLER = 1e-3, 1e-3
_STEPS = 12
#: Ends that agree to this are those of conjugates.
_ALIKE = 1e-8
#: Coordinates of w: the first two of each are indices of e and f.
_PAIRS = ((0, 1), (0, 2), (0, 3), (2, 3), (3, 1), (1, 2))
#: The terms of ``e ^ w``: the row, the coordinates of w and of e, and the sign.
_WEDGE = (
    *((0, 3, 1, 1), (0, 4, 2, 1), (0, 5, 3, 1), (1, 2, 2, 1), (1, 3, 0, -1), (1, 1, 3, -1)),
    *((2, 0, 3, 1), (2, 4, 0, -1), (2, 2, 1, -1), (3, 1, 1, 1), (3, 5, 0, -1), (3, 0, 2, -1)),
)
_SQUARES = [(i, j) for i in range(4) for j in range(i, 4)]


def far_points(locator: Locator, sides: tuple[int, ...], e: Complex) -> Complex:
    """Return Study points of poses with given quaternions.

    Conjugates and mirror images of others are left out.

    Parameters
    ----------
    locator, sides
        The equations, and the index of that of each constraint (`BallSystem.equations`): planes,
        angles and points at a distance.
    e
        The quaternions, of norm 1 and any phase, right in double precision, shape (n, 4).

    Returns
    -------
    Complex
        Points as sums of four doubles, in the frames of the instance and its length scale, shape
        (k, 4, 8).
    """
    chosen = _one_of_each_orbit(e, has_images=has_mirror_images(locator.instance))
    found: list[Complex] = []
    if chosen:
        with ctx.workprec(_BITS):
            least = max(_least_norm(locator.instance), _NULL)
            points = _Equations(locator.system(_BITS), sides).solved(e[chosen], least)
            found = [sums_of_doubles(point) for point in points if point is not None]
    return np.array(found, np.complex128).reshape(-1, 4, 8)


def _one_of_each_orbit(e: Complex, *, has_images: bool) -> list[int]:
    """Return which quaternions (n, 4) are not those of conjugates or mirror images of others."""
    images = [e.conj()]
    if has_images:
        images += [mirrored(e), mirrored(e).conj()]
    alike = np.any(1 - np.abs(np.array(images).conj() @ e.T) <= _ALIKE, axis=0)
    kept: list[int] = []
    for k in range(len(e)):
        if not any(alike[j, k] for j in kept):
            kept.append(k)
    return kept


def _least_norm(instance: Instance) -> float:
    """Return a number that N is hardly below at poses, for quaternions of norm 1.

    A platform that is special up to the rounding eps of its numbers has poses where N is of size
    eps^4.
    """
    numbers = (
        number.fraction
        for primitive in instance.primitives
        for number in (*primitive.position, *getattr(primitive, "vector", ()))
    )
    sizes = (inf if x is None else max(abs(x.numerator), x.denominator) for x in numbers)
    return float(10 ** (-_POWER * log10(max(sizes))))


class _Equations:
    """The equations of a choice of sides, solved for w and h where that is possible.

    Parameters
    ----------
    system, sides
        The equations, and the index of that of each constraint.
    """

    def __init__(self, system: BallSystem, sides: tuple[int, ...]) -> None:
        chosen = [each[k].main for each, k in zip(system.equations, sides, strict=True)]
        rows = system.monomial_rows.tolist()
        #: Of the squares and products of e; of w and h.
        self._forms = [
            [*row[:10], *(row[10 + 4 * i + j] for i, j in _PAIRS), row[26]]
            for row in (rows[k] for k in chosen)
        ]
        self._matrix = acb_mat(arb_mat(self._forms))
        self._doubles = np.array([[float(x) for x in row] for row in self._forms])
        self._has_h = bool(self._doubles[:, 16].any())

    def solved(self, near: Complex, least: float) -> list[list[acb] | None]:
        """Return the Study point of a solution near each quaternion (n, 4), or None."""
        starts = np.concatenate((near, self._quantities(near)), axis=1)
        inverses = _left_inverses(self._jacobians(starts))
        return [self._solved(*each, least) for each in zip(starts, inverses, strict=True)]

    def _solved(self, start: Complex, inverse: Complex, least: float) -> list[acb] | None:
        """Return the Study point of a solution near e, w and h; None if there is none."""
        point = [acb(x.real, x.imag) for x in start.tolist()]
        last = _FIRST * np.abs(start).max()
        for _ in range(_STEPS):
            step = inverse @ self._residual(point)
            size = np.abs(step).max()
            point = [x - acb(d.real, d.imag) for x, d in zip(point, step.tolist(), strict=True)]
            N = sum((x * x for x in point[:4]), acb(0))
            norm = abs(complex(N))
            if norm < least or not size <= last:
                return None
            # The next step is smaller by the same part, or by more.
            if size * min(size / last, 1) * _SMALLER < _NEEDED * norm:
                return _study_point([x.mid() for x in point], N.mid())
            last = size * _SMALLER
        return None

    def _quantities(self, e: Complex) -> Complex:
        """Return w, and h if there is one, at quaternions (n, 4), by least squares."""
        i, j = np.transpose(_SQUARES)
        right = -(e[:, i] * e[:, j]) @ self._doubles[:, :10].T
        rows = np.zeros((len(e), 10, 6 + self._has_h), complex)
        rows[:, :6] = self._doubles[:, 10 : 16 + self._has_h]
        rows[:, 6:, :6] = _wedge(e)
        found: Complex = (_left_inverses(rows)[:, :, :6] @ right[:, :, None])[..., 0]
        return found

    def _jacobians(self, at: Complex) -> Complex:
        """Return the derivatives of the equations, and of what fixes the multiple of e."""
        e, w = at[:, :4], at[:, 4:10]
        rows = np.zeros((len(at), 11 + self._has_h, at.shape[1]), complex)
        for k, (i, j) in enumerate(_SQUARES):
            rows[:, :6, i] += self._doubles[:, k] * e[:, j, None]
            rows[:, :6, j] += self._doubles[:, k] * e[:, i, None]
        rows[:, :6, 4:] = self._doubles[:, 10 : 6 + at.shape[1]]
        rows[:, 6:10, :4], rows[:, 6:10, 4:10] = _turn(w), _wedge(e)
        if self._has_h:
            rows[:, 10, :4], rows[:, 10, 4:10] = -2 * at[:, 10:] * e, 2 * w
            rows[:, 10, 10] = -(e * e).sum(axis=1)
        rows[:, -1, :4] = e.conj()
        return rows

    def _residual(self, point: Sequence[acb]) -> Complex:
        """Return the equations, rounded to doubles."""
        e, w, h = point[:4], point[4:10], point[10:]
        vector = [*(e[i] * e[j] for i, j in _SQUARES), *w, *(h or [acb(0)])]
        values = (self._matrix * acb_mat(17, 1, vector)).entries()
        products = [e[k] * w[column] * sign for _, column, k, sign in _WEDGE]
        values += [a + b + c for a, b, c in zip(*(products[k::3] for k in range(3)), strict=True)]
        if h:
            norm = vector[0] + vector[4] + vector[7] + vector[9]
            values.append(sum((x * x for x in w), -norm * h[0]))
        return np.array([*map(complex, values), 0])


def _left_inverses(matrices: Complex) -> Complex:
    """Return the left inverses of matrices of full rank, (..., m, n) to (..., n, m)."""
    # Normal equations would lose twice as many digits: too many for couplings.
    Q, R = np.linalg.qr(matrices)
    return np.asarray(np.linalg.solve(R, Q.conj().swapaxes(-1, -2)))


def _wedge(e: Complex) -> Complex:
    """Return the matrices of ``e ^ w``, linear in w, shape (n, 4, 6)."""
    found = np.zeros((len(e), 4, 6), complex)
    for row, column, k, sign in _WEDGE:
        found[:, row, column] = sign * e[:, k]
    return found


def _turn(w: Complex) -> Complex:
    """Return the matrices of ``e ^ w``, linear in e, shape (n, 4, 4)."""
    found = np.zeros((len(w), 4, 4), complex)
    for row, column, k, sign in _WEDGE:
        found[:, row, k] = sign * w[:, column]
    return found


def _study_point(point: Sequence[acb], norm: acb) -> list[acb]:
    """Return the Study point with some e and ``w = e ^ f``."""
    (a, b, c, d), (p, q, r, x, y, z) = point[:4], point[4:10]
    return [
        *(norm * t for t in (a, b, c, d)),
        -(b * p + c * q + d * r),
        a * p - c * z + d * y,
        a * q + b * z - d * x,
        a * r - b * y + c * x,
    ]
