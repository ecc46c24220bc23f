"""Poses far away near the ends of paths with fewer unknowns, by Newton's method with more digits.

Where a platform is special but for the rounding of its numbers, N = e.e nearly vanishes at its
poses far away. Solved for ``w = e ^ f`` and ``h = f.f``, the equations are regular there
(`gspcli.continuation.reduced_homotopy`). The unknowns are e, w and h. The equations are six, linear
in w and h, with ``e ^ w = 0`` and ``w.w = N h``. So paths in double precision arrive, and e is
right to all its digits. They do not suffice for ``N f``, the product of e and w. Newton's method on
the exact numbers gives the others, ten at each step: the Jacobian matrix in doubles is enough.

A point at a distance d from a line has heights over two complex planes through it. Times N these
are linear in w: G and H. The equation ``G H = d^2 N^2`` is taken as ``G = d^2 N^2 / H``. Where N
nearly vanishes, so does one of them, and often both as the root of N. There two solutions may be so
near each other that paths get lost before both. From these ends Newton's method leads to both, too.

Paths with 32 digits, or eigenvectors where numbers are in floating point, took a third of the time
of a first solution and four fifths (`tools.verify.realistic`, hexapods with six joints a body).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, log10

import numpy as np
from flint import acb, acb_mat, arb, arb_mat, ctx
from numpy.typing import NDArray

from gspcli.certification.equations.ball_system import BallSystem, heights, monomials
from gspcli.certification.equations.mirror_images import has_mirror_images, mirrored
from gspcli.certification.equations.statement import Statement
from gspcli.certification.numbers.balls import largest
from gspcli.certification.poses.locator import LAST_PRECISION, Complex, Locator
from gspcli.geometry import study
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import Field

#: Points that agree to this part of their largest entry are alike.
_PAIR = 1e-13
#: Points with 32 digits and more that agree to this part are conjugates.
_CONJUGATE = 1e-24
#: Points with smaller imaginary parts may be real.
_NEARLY_REAL = 1e-6


def is_nearly_real(point: Field) -> bool:
    """Whether a Study point, shape (8,), may be one of a real pose."""
    unit, size = _in_patch(point)
    return bool(np.abs(unit.imag / size).max() < _NEARLY_REAL)


def conjugate_sources(points: Field, low: Field | None = None) -> NDArray[np.intp]:
    """Return for each Study point the index of an earlier conjugate, else its own, shape (k,).

    NaN end points have no conjugate. Points that differ in double precision are no conjugates: near
    many a pose there is another one, where directions are nearly parallel, and its conjugate. The
    same holds for points that differ in further digits, doubles to add, ``low`` (k, m, 8).
    """
    source = np.arange(len(points))
    for i, point in enumerate(points):
        if is_nearly_real(point):
            continue
        k = np.abs(point[:4]).argmax()
        others = points[:i].conj()
        with np.errstate(divide="ignore", invalid="ignore"):
            unit, size = _in_patch(point)
            gaps = np.abs((others / others[:, k : k + 1] - unit) / size).max(axis=1, initial=0.0)
        for j in np.flatnonzero(gaps < _PAIR).tolist():
            if low is None or not low.shape[1] or are_conjugates(points[[i, j]], low[[i, j]]):
                source[i] = source[j]
                break
    return source


def _in_patch(point: Field) -> tuple[Field, NDArray[np.float64]]:
    """Return a point whose largest coordinate of e is 1, and the sizes of its parts."""
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = point / point[np.abs(point[:4]).argmax()]
        return unit, np.repeat([1.0, np.abs(unit[4:]).max()], 4)


def are_conjugates(points: Complex, low: Complex) -> bool:
    """Whether two points that are conjugates in doubles agree in further digits.

    Parameters
    ----------
    points, low
        The points and doubles to add to them, shapes (2, 8) and (2, k, 8).
    """
    one, other = np.concatenate((points[:, None], low), axis=1)
    k = int(np.abs(one[0, :4]).argmax())
    with ctx.workprec(LAST_PRECISION):
        sums = (Locator.exact_sum(part) for part in (one, other.conj()))
        first, second = ([x / part[k] for x in part] for part in sums)
        gaps = [x - y for x, y in zip(first, second, strict=True)]
        return bool(
            largest(gaps[:4]) < _CONJUGATE and largest(gaps[4:]) < _CONJUGATE * largest(first[4:])
        )


Index = NDArray[np.int64]

#: Bits of the numbers; 96 digits suffice for machines in floating point, where N is 1e-64. Where H
#: is the root of N, more are needed.
_BITS, _PRODUCT_BITS = 320, 512
#: Bits of N that a point needs, or of G, which is as small as the root of N^3. Below such a part N
#: counts as zero.
_NEEDED, _NULL = 2.0**-50, 2.0**-250
#: The least N that is sought is this power of the rounding of coordinates.
_POWER = 6
#: A Newton step at first, and the part of it that the next one may be.
_FIRST, _SMALLER = 1e-3, 1e-3
_STEPS = 12
#: Newton's method near two solutions near each other takes so many steps, none longer than this. At
#: first it halves the distance from both. Then steps are taken so many times.
_PAIR_STEPS, _LONGEST, _RELAXED = 36, 1e-4, 1.8
#: After so many failures one after the other no more pairs are tried: these are at infinity.
_FAILURES = 2
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


def far_points(
    locator: Locator, sides: tuple[int, ...], e: Complex, planes: Index | None = None
) -> list[list[acb]]:
    """Return Study points of poses with given quaternions.

    Conjugates and mirror images of others are left out.

    Parameters
    ----------
    locator, sides
        The equations, and the index of that of each constraint (`BallSystem.equations`): all but
        distances of lines.
    e
        The quaternions, of norm 1 and any phase, right in double precision, shape (n, 4).
    planes
        For each quaternion and constraint which height is G: 1 if it is A + iB, -1 if A - iB, with
        the heights A, B of `heights`; 0 without points and lines, shape (n, 6). None if there are
        none of these.

    Returns
    -------
    list[list[acb]]
        Points, in the frames of the instance and its length scale.
    """
    signs = np.zeros((len(e), 6), np.int64) if planes is None else planes
    chosen = _one_of_each_orbit(e, signs, has_images=has_mirror_images(locator.instance))
    if not chosen:
        return []
    bits = _PRODUCT_BITS if signs.any() else _BITS
    with ctx.workprec(bits):
        least = max(_least_norm(locator.instance), _NULL)
        points = _Equations(locator.system(bits), sides).solved(e[chosen], signs[chosen], least)
    return [point for point in points if point is not None]


def _one_of_each_orbit(e: Complex, planes: Index, *, has_images: bool) -> list[int]:
    """Return which quaternions (n, 4) are not those of conjugates or mirror images of others.

    A conjugate has the other planes. There are mirror images without lines only.
    """
    images = [e.conj()]
    if has_images:
        images += [mirrored(e), mirrored(e).conj()]
    near = 1 - np.abs(np.array(images).conj() @ e.T) <= _ALIKE
    alike = np.any(near & (planes[:, None] == -planes).all(axis=2), axis=0)
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
        known, first, second = system.monomial_rows.tolist(), [], []
        #: The products, with the squares of their distances.
        self._squares: dict[int, arb] = {}
        chosen = zip(system.statements, system.equations, sides, strict=True)
        for k, (given, equations, side) in enumerate(chosen):
            if equations[side].squares:
                A, B = _heights(given)
                second.append(_reduced(B))
                self._squares[k] = given.value * given.value
            else:
                A = known[equations[side].main]
            first.append(_reduced(A))
        #: Of the squares and products of e, of w and of h: of each equation or A, then of each B.
        self._matrix = acb_mat(arb_mat(first + second))
        self._power = 1.5 if self._squares else 1
        self._failures = 0
        forms = np.array([[float(x) for x in row] for row in first + second])
        self._doubles, self._second = forms[:6], np.zeros((6, 17))
        self._second[list(self._squares)] = forms[6:]
        self._has_h = bool(self._doubles[:, 16].any())

    def solved(self, near: Complex, planes: Index, least: float) -> list[list[acb] | None]:
        """Return the Study point of a solution near each quaternion (n, 4), or None."""
        starts = np.concatenate((near, self._quantities(near, planes)), axis=1)
        inverses = _left_inverses(self._jacobians(starts, planes))
        each = zip(starts, inverses, planes.tolist(), strict=True)
        return [self._solved(*given, least) for given in each]

    def _solved(
        self, start: Complex, inverse: Complex, planes: list[int], least: float
    ) -> list[acb] | None:
        """Return the Study point of a solution near e, w and h; None if there is none."""
        point = [acb(x.real, x.imag) for x in start.tolist()]
        if self._squares:
            # In doubles N^2 / H is rounding alone.
            point = _moved(point, inverse @ self._residual(point, planes, are_far=True))
        last = _FIRST * np.abs(start).max()
        for _ in range(_STEPS):
            step = inverse @ self._residual(point, planes)
            size = np.abs(step).max()
            point = _moved(point, step)
            N = sum((x * x for x in point[:4]), acb(0))
            norm = abs(complex(N))
            if norm < least:
                return None
            if not size <= last:
                if not self._squares or self._failures >= _FAILURES:
                    return None
                found = self._among_two(start, planes, least)
                self._failures = self._failures + 1 if found is None else 0
                return found
            # The next step is smaller by the same part, or by more.
            if size * min(size / last, 1) * _SMALLER < _NEEDED * norm**self._power:
                return _study_point([x.mid() for x in point], N.mid())
            last = size * _SMALLER
        return None

    def _among_two(self, start: Complex, planes: list[int], least: float) -> list[acb] | None:
        """Return the Study point of a solution near e, w and h that has another one beside it.

        Each step has its own Jacobian matrix, with all digits.
        """
        point, last = [acb(x.real, x.imag) for x in start.tolist()], _LONGEST
        factor = 1.0
        for _ in range(_PAIR_STEPS):
            jacobian, values = self._linearized(point, planes)
            adjoint = jacobian.conjugate().transpose()
            try:
                step = (adjoint * jacobian).solve(adjoint * values, algorithm="approx").mid()
            except ZeroDivisionError:
                return None
            size = float(largest(step.entries()))
            # What a step leaves of the distance from both, while they look like one.
            left, part = 1 - factor / 2, size / last
            factor = _RELAXED if abs(part - left) < left / 5 else 1.0
            point = [(x - factor * d).mid() for x, d in zip(point, step.entries(), strict=True)]
            N = sum((x * x for x in point[:4]), acb(0)).mid()
            norm = abs(complex(N))
            if norm < least or not size < _LONGEST:
                return None
            # The number of digits doubles.
            if factor == 1 and size * part < _NEEDED * norm**2:
                return _study_point(point, N)
            last = size
        return None

    def _linearized(self, point: list[acb], planes: list[int]) -> tuple[acb_mat, acb_mat]:
        """Return the Jacobian matrix, and the equations, with all digits."""
        e, w, h = point[:4], point[4:10], point[10:]
        norm, width = sum((x * x for x in e), acb(0)), len(point)
        squares = acb_mat(10, 4)
        for k, (i, j) in enumerate(_SQUARES):
            squares[k, i] += e[j]
            squares[k, j] += e[i]
        forms = self._matrix.tolist()
        by_e = (acb_mat([form[:10] for form in forms]) * squares).tolist()
        rows = [[*a, *form[10 : 6 + width]] for a, form in zip(by_e, forms, strict=True)]
        vector = [*(e[i] * e[j] for i, j in _SQUARES), *w, *(h or [acb(0)])]
        values = (self._matrix * acb_mat(17, 1, vector)).entries()
        for r, (k, square) in enumerate(self._squares.items(), 6):
            turn = acb(0, planes[k])
            G, H = values[k] + turn * values[r], values[k] - turn * values[r]
            part = norm / H
            rows[k] = [
                a + turn * b + square * part**2 * (a - turn * b)
                for a, b in zip(rows[k], rows[r], strict=True)
            ]
            for i in range(4):
                rows[k][i] -= 4 * square * part * e[i]
            values[k] = G - square * part * norm
        wedge = [[acb(0)] * width for _ in range(4)]
        for row, column, k, sign in _WEDGE:
            wedge[row][4 + column] += sign * e[k]
            wedge[row][k] += sign * w[column]
        # The equations are of degree two: half their derivatives times the point are their values.
        sums = [sum((a * x for a, x in zip(row, point, strict=True)), acb(0)) / 2 for row in wedge]
        rows, values = rows[:6] + wedge, values[:6] + sums
        if h:
            rows.append([*(-2 * h[0] * x for x in e), *(2 * x for x in w), -norm])
            values.append(sum((x * x for x in w), -norm * h[0]))
        rows.append([x.conjugate() for x in e] + [acb(0)] * (width - 4))
        return acb_mat(rows), acb_mat(len(rows), 1, [*values, acb(0)])

    def _quantities(self, e: Complex, planes: Index) -> Complex:
        """Return w, and h if there is one, at quaternions (n, 4), by least squares."""
        i, j = np.transpose(_SQUARES)
        forms = self._factors(planes)
        right = -forms[:, :, :10] @ (e[:, i] * e[:, j])[:, :, None]
        rows = np.zeros((len(e), 10, 6 + self._has_h), complex)
        rows[:, :6] = forms[:, :, 10 : 16 + self._has_h]
        rows[:, 6:, :6] = _wedge(e)
        found: Complex = (_left_inverses(rows)[:, :, :6] @ right)[..., 0]
        return found

    def _factors(self, planes: Index) -> Complex:
        """Return the forms of equations, and G of products, shape (n, 6, 17)."""
        return np.asarray(self._doubles + 1j * planes[:, :, None] * self._second)

    def _jacobians(self, at: Complex, planes: Index) -> Complex:
        """Return the derivatives of the equations, and of what fixes the multiple of e."""
        e, w = at[:, :4], at[:, 4:10]
        rows = np.zeros((len(at), 11 + self._has_h, at.shape[1]), complex)
        forms = self._factors(planes)
        for k, (i, j) in enumerate(_SQUARES):
            rows[:, :6, i] += forms[:, :, k] * e[:, j, None]
            rows[:, :6, j] += forms[:, :, k] * e[:, i, None]
        rows[:, :6, 4:] = forms[:, :, 10 : 6 + at.shape[1]]
        rows[:, 6:10, :4], rows[:, 6:10, 4:10] = _turn(w), _wedge(e)
        if self._has_h:
            rows[:, 10, :4], rows[:, 10, 4:10] = -2 * at[:, 10:] * e, 2 * w
            rows[:, 10, 10] = -(e * e).sum(axis=1)
        rows[:, -1, :4] = e.conj()
        return rows

    def _residual(
        self, point: Sequence[acb], planes: Sequence[int], *, are_far: bool = False
    ) -> Complex:
        """Return the equations, rounded to doubles; with G = 0 for products if they are far."""
        e, w, h = point[:4], point[4:10], point[10:]
        vector = [*(e[i] * e[j] for i, j in _SQUARES), *w, *(h or [acb(0)])]
        norm = vector[0] + vector[4] + vector[7] + vector[9]
        found = (self._matrix * acb_mat(17, 1, vector)).entries()
        values = found[:6]
        for (k, square), B in zip(self._squares.items(), found[6:], strict=True):
            G, H = (values[k] + acb(0, sign) * B for sign in (planes[k], -planes[k]))
            values[k] = G if are_far else G - square * norm**2 / H
        products = [e[k] * w[column] * sign for _, column, k, sign in _WEDGE]
        values += [a + b + c for a, b, c in zip(*(products[k::3] for k in range(3)), strict=True)]
        if h:
            values.append(sum((x * x for x in w), -norm * h[0]))
        return np.array([*map(complex, values), 0])


def _heights(given: Statement) -> list[list[arb]]:
    """Return the heights A, B over planes through a line, in `BallSystem.monomial_rows`."""
    rows = [
        [form.get(k, arb(0)) for k in range(study.COUNT)]
        for form in heights(given.a, given.b, given.u, given.v)
    ]
    found: list[list[arb]] = (arb_mat(rows) * arb_mat(monomials())).tolist()
    return found


def _reduced(row: list[arb]) -> list[arb]:
    """Return the coefficients of the squares and products of e, of w and of h."""
    return [*row[:10], *(row[10 + 4 * i + j] for i, j in _PAIRS), row[26]]


def _moved(point: list[acb], step: Complex) -> list[acb]:
    return [x - acb(d.real, d.imag) for x, d in zip(point, step.tolist(), strict=True)]


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
