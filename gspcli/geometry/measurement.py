"""What each constraint measures at a pose: its polynomial, value, derivatives and residual.

The ten kinds are stated here for floating point; in the functions of a motion, over any numbers,
they are stated in `gspcli.geometry.study`. This statement, and that of `tools.atlas.groebner`
modulo a prime, are evidence that does not use it. The polynomials are those of the paper's
Section 4, in three vectors: ``r = R y + T - x`` from the primitive of the base to that of the
platform; the direction or normal of the platform, ``w = R u``; and that of the base, v. The vectors
w and v are unit vectors. Values, residuals and their derivatives follow from them. A distance is
the complex square root of the complex square.

All functions take leading batch axes and complex poses; the constraints are the last axis of values
and the first of each derivative. A twist (omega, tau) moves the pose to ``exp([s omega]x) R`` and
``T + s tau``: a rotation in the axes of the base about the origin of the platform, and a
translation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind, Law, Primitive
from gspcli.geometry.arrangement import Arrangement, Bodies, Placed
from gspcli.geometry.enclosures import roundings
from gspcli.geometry.quaternions import Field, apply, cross, dot
from gspcli.geometry.tolerances import NEARLY_PARALLEL_SINE_SQUARE, PARALLEL_SINE

_IDENTITY = np.eye(3)


class Gradient(NamedTuple):
    """Derivatives by the three vectors, each of shape (..., 3)."""

    r: Field
    w: Field
    v: Field


class ConstraintPolynomial(NamedTuple):
    """A polynomial p in (r, w, v), all of shape (..., 3)."""

    value: Callable[[Field, Field, Field], Field]
    """Shape (...)."""
    gradient: Callable[[Field, Field, Field], Gradient]
    bend: Callable[[Field, Field, Field, Field, Field], Field]
    """The second derivative where r and w move along the last two, shape (...)."""


def polynomial(kind: Kind) -> ConstraintPolynomial:
    """Return the polynomial of a kind.

    It is the square of a DPP, DPL or DLP distance, and the signed distance of a DPH or DHP. For a
    DLL it is the mutual moment ``r . (w x v)``: the signed distance times the sine of the angle of
    the lines. For an angle it is ``w . v``.

    Raises
    ------
    KeyError
        If the kind is not one of the ten.
    """
    return _POLYNOMIALS[kind] if kind.is_distance else COSINE


def perpendicular(r: Field, axis: Field) -> Field:
    """Return the part of r perpendicular to a unit vector, ``(..., 3), (..., 3) -> (..., 3)``."""
    across: Field = r - dot(r, axis)[..., None] * axis
    return across


def _straight(r: Field, w: Field, v: Field, a: Field, b: Field) -> Field:
    return np.zeros(a.shape[:-1], a.dtype)


def _point_point() -> ConstraintPolynomial:
    """``r . r``."""
    return ConstraintPolynomial(
        lambda r, w, v: dot(r, r),
        lambda r, w, v: Gradient(2 * r, np.zeros_like(r), np.zeros_like(r)),
        lambda r, w, v, a, b: 2 * dot(a, a),
    )


def _point_line() -> ConstraintPolynomial:
    """``r . r - (r . v)^2``, without the cancellation."""

    def value(r: Field, w: Field, v: Field) -> Field:
        across = perpendicular(r, v)
        return dot(across, across)

    def gradient(r: Field, w: Field, v: Field) -> Gradient:
        by_v = -2 * dot(r, v)[..., None] * r
        return Gradient(2 * perpendicular(r, v), np.zeros_like(r), by_v)

    return ConstraintPolynomial(
        value, gradient, lambda r, w, v, a, b: 2 * (dot(a, a) - dot(a, v) ** 2)
    )


def _line_point() -> ConstraintPolynomial:
    """``r . r - (r . w)^2``, without the cancellation."""

    def value(r: Field, w: Field, v: Field) -> Field:
        across = perpendicular(r, w)
        return dot(across, across)

    def gradient(r: Field, w: Field, v: Field) -> Gradient:
        by_w = -2 * dot(r, w)[..., None] * r
        return Gradient(2 * perpendicular(r, w), by_w, np.zeros_like(r))

    def bend(r: Field, w: Field, v: Field, a: Field, b: Field) -> Field:
        along, turned = dot(a, w), dot(r, b)
        bent: Field = dot(a, a) - (along + turned) ** 2 - 2 * dot(r, w) * dot(a, b)
        return 2 * bent

    return ConstraintPolynomial(value, gradient, bend)


def _point_plane() -> ConstraintPolynomial:
    """``r . v``."""
    return ConstraintPolynomial(
        lambda r, w, v: dot(r, v), lambda r, w, v: Gradient(v, np.zeros_like(r), r), _straight
    )


def _plane_point() -> ConstraintPolynomial:
    """``-r . w``."""
    return ConstraintPolynomial(
        lambda r, w, v: -dot(r, w),
        lambda r, w, v: Gradient(-w, -r, np.zeros_like(r)),
        lambda r, w, v, a, b: -2 * dot(a, b),
    )


def _line_line() -> ConstraintPolynomial:
    """``r . (w x v)``."""
    return ConstraintPolynomial(
        lambda r, w, v: dot(r, cross(w, v)),
        lambda r, w, v: Gradient(cross(w, v), cross(v, r), cross(r, w)),
        lambda r, w, v, a, b: -2 * dot(a, cross(v, b)),
    )


def _directions() -> ConstraintPolynomial:
    """``w . v``."""
    return ConstraintPolynomial(
        lambda r, w, v: dot(w, v), lambda r, w, v: Gradient(np.zeros_like(w), v, w), _straight
    )


#: The cosine of two directions: the polynomial of all angles, and in the distance of two lines.
COSINE = _directions()
_POLYNOMIALS = {
    DPP: _point_point(),
    DPL: _point_line(),
    DLP: _line_point(),
    DPH: _point_plane(),
    DHP: _plane_point(),
    DLL: _line_line(),
}


#: A complex unit vector with a larger entry is long: its entries cancel in double precision.
_LONG = 2.0
#: Lines nearer than this part of the typical length meet up to rounding.
_MEETING = 1e-12


def measured(bodies: Bodies, R: Field, T: Field) -> Field:
    """Return what each constraint measures, ``(..., 3, 3), (..., 3) -> (..., n)``.

    Distances to planes are signed by the normal; line-line distances are signed by the
    orientation of the lines; angles are in radians. A complex distance is one of two square
    roots, a complex angle one branch of the inverse function.
    """
    return measured_between(bodies, bodies.placed(R, T))


def measured_between(bodies: Bodies, placed: Placed) -> Field:
    """Return what constraints measure, as `measured`, of vectors between their primitives."""
    r, w, _ = placed
    v = np.broadcast_to(bodies.v, w.shape)
    values: Field = np.zeros(r.shape[:-1], dtype=r.dtype)
    for kind, k in _alike(bodies.kinds):
        values[..., k] = _value(kind, r[..., k, :], w[..., k, :], v[..., k, :])
    return values


def jacobian(bodies: Bodies, R: Field, T: Field) -> Field:
    """Return the derivatives of `measured` with respect to a twist, ``(..., n, 6)``.

    At a distance or sine of zero the measured value has no derivative, and the row is not
    finite. The distance of parallel lines has the derivative of that of a point and a line.
    """
    placed = bodies.placed(R, T)
    return by_twist(gradients(bodies, placed), placed.arm, placed.w)


def value_signs(arrangement: Arrangement, R: Field, T: Field) -> Field:
    """Return the signs that convert measured numbers to values of `measure`, shape (..., 6).

    A distance of two lines is the modulus of a distance with the sign of their orientation; this
    sign is returned. Where the lines meet the modulus has no derivative, and 1 is returned. All
    other signs are 1.
    """
    signs = np.ones((*T.shape[:-1], len(arrangement.kinds)))
    skew = [kind is DLL for kind in arrangement.kinds]
    if any(skew):
        away = measured(arrangement, R, T)[..., skew] < -_MEETING * arrangement.length
        signs[..., skew] = np.where(away, -1.0, 1.0)
    return signs


def value_slopes(arrangement: Arrangement, R: Field, T: Field) -> Field:
    """Return the derivatives of the values of `measure` by a twist, shape (..., 6, 6).

    In lengths and radians. Not finite where a value has no derivative.
    """
    return np.asarray(value_signs(arrangement, R, T)[..., None] * jacobian(arrangement, R, T))


def gradients(bodies: Bodies, placed: Placed) -> Gradient:
    """Return the derivatives of `measured` by r, w and v, each ``(..., n, 3)``.

    By the vectors between the primitives and their directions; not finite where the value has no
    derivative.
    """
    r, w, _ = placed
    v = np.broadcast_to(bodies.v, w.shape)
    found = Gradient(*(np.zeros(r.shape, dtype=r.dtype) for _ in range(3)))
    for kind, k in _alike(bodies.kinds):
        gradient = _gradient(kind, r[..., k, :], w[..., k, :], v[..., k, :])
        for all_of_them, part in zip(found, gradient, strict=True):
            all_of_them[..., k, :] = part
    return found


def curvature(
    bodies: Bodies, R: Field, T: Field, twists: Field, slip: tuple[Field, Field] | None = None
) -> Field:
    """Return the second derivatives of `measured` along constant twists, ``(..., 6) -> (..., n)``.

    Poses are broadcast with them. Not finite at a distance or sine of zero and for parallel lines,
    which have none.

    Parameters
    ----------
    slip
        The velocity of r and its derivative when points move in their bodies, too, each of shape
        (..., n, 3).
    """
    r, w, arm = bodies.placed(R, T)
    v = np.broadcast_to(bodies.v, w.shape)
    omega = twists[..., None, :3]
    turned, w_moves, w_bends = cross(omega, arm), w, w
    if any(kind.platform is not Primitive.POINT for kind in bodies.kinds):
        w_moves = cross(omega, w)
        w_bends = cross(omega, w_moves)
    r_moves, r_bends = turned + twists[..., None, 3:], cross(omega, turned)
    if slip is not None:
        r_moves, r_bends = r_moves + slip[0], r_bends + slip[1]
    found: Field = np.zeros(r_moves.shape[:-1], dtype=r.dtype)
    for kind, k in _alike(bodies.kinds):
        vectors, moves, bends = (
            [part[..., k, :] for part in parts]
            for parts in ((r, w, v), (r_moves, w_moves), (r_bends, w_bends))
        )
        found[..., k] = _bent(kind, vectors, moves, bends)
    return found


def by_twist(gradient: Gradient, arm: Field, w: Field) -> Field:
    """Return the derivative by a twist of a function of r and w, ``(..., 3) -> (..., 6)``.

    Parameters
    ----------
    gradient
        Its derivatives by r and w.
    arm, w
        The turning vectors ``R y`` and ``R u``.
    """
    turning = cross(arm, gradient.r) + cross(w, gradient.w)
    return np.concatenate((turning, gradient.r), axis=-1)


def velocities(arm: Field, w: Field) -> tuple[Field, Field]:
    """Return the derivatives of r and of w by a twist, each ``(..., 3) -> (..., 3, 6)``.

    These are ``omega x arm + tau`` and ``omega x w``.
    """
    turns = (
        np.stack([cross(np.broadcast_to(axis, a.shape), a) for axis in _IDENTITY], axis=-1)
        for a in (arm, w)
    )
    r, w = (np.concatenate((turn, np.zeros_like(turn)), axis=-1) for turn in turns)
    r[..., 3:] = _IDENTITY
    return r, w


@cache
def _alike(kinds: tuple[Kind, ...]) -> list[tuple[Kind, slice | list[int]]]:
    """Return each kind with the index of its constraints: a slice where possible, for speed."""
    groups = {kind: [i for i, k in enumerate(kinds) if k is kind] for kind in kinds}
    return [
        (kind, slice(k[0], k[-1] + 1) if k[-1] - k[0] < len(k) else k) for kind, k in groups.items()
    ]


def _root(square: Field) -> Field:
    """Return a square root, real for real squares (rounding may make those negative)."""
    root: Field = np.sqrt(square if np.iscomplexobj(square) else np.maximum(square, 0.0))
    return root


def _value(kind: Kind, r: Field, w: Field, v: Field) -> Field:
    if kind.law is Law.SQUARE:
        return _root(polynomial(kind).value(r, w, v))
    if kind.law is Law.SIGNED:
        return polynomial(kind).value(r, w, v)
    if kind.law is Law.MOMENT:
        square, parallel = _sine_square(w, v)
        skew = polynomial(kind).value(r, w, v) / np.sqrt(np.where(parallel, 1.0, square))
        return np.where(parallel, _value(DPL, r, w, v), skew)
    return _angle(kind.law, w, v)


def _sine_square(w: Field, v: Field) -> tuple[Field, Field]:
    """Return the squared sine of the angle of directions, and whether they are parallel."""
    normal = cross(w, v)
    square = dot(normal, normal)
    return square, np.abs(square) < PARALLEL_SINE**2


def _angle(law: Law, w: Field, v: Field) -> Field:
    """Return the angle of directions from half angles, accurate also near 0 and 180 degrees."""
    w = -w if law.sign < 0 else w
    near, far = w - v, w + v
    sine, cosine = dot(near, near), dot(far, far)
    if np.iscomplexobj(sine):
        # The squares of long complex vectors cancel.
        long, product = np.abs(w).max(axis=-1) > _LONG, 2 * dot(w, v)
        sine, cosine = np.where(long, 2 - product, sine), np.where(long, 2 + product, cosine)
    sine, cosine = _root(sine), _root(cosine)
    if np.iscomplexobj(sine):
        # arctan of the smaller quotient; its two forms differ by a quarter turn.
        small = np.abs(sine) <= np.abs(cosine)
        a, b = np.where(small, sine, cosine), np.where(small, cosine, sine)
        half = np.arctan(a / b)
        half = np.where(small, half, np.pi / 2 - half)
    else:
        half = np.arctan2(sine, cosine)
    return 2 * half if law.is_cosine else np.pi / 2 - 2 * half


def _gradient(kind: Kind, r: Field, w: Field, v: Field) -> Gradient:
    """Return the derivatives of what is measured by r, w and v."""
    gradient = polynomial(kind).gradient(r, w, v)
    if kind.law is Law.SQUARE:
        return _times(0.5 / _root(polynomial(kind).value(r, w, v)), gradient)
    if kind.law is Law.SIGNED:
        return gradient
    if kind.law is Law.MOMENT:
        # The moment m over the sine s = (1 - c^2)^(1/2), whose inverse has the derivative c / s^3.
        m, turning = polynomial(kind).value(r, w, v), COSINE.gradient(r, w, v)
        square, parallel = _sine_square(w, v)
        s = np.sqrt(np.where(parallel, 1.0, square))
        skew = _plus(_times(1 / s, gradient), _times(m * COSINE.value(r, w, v) / s**3, turning))
        flat = polynomial(DPL)
        distance = _root(flat.value(r, w, v))
        beside = _times(0.5 / np.where(distance == 0, 1.0, distance), flat.gradient(r, w, v))
        chosen = parallel[..., None]
        return Gradient(*(np.where(chosen, b, s) for b, s in zip(beside, skew, strict=True)))
    return _times(_falling(kind.law) / _root(_sine_square(w, v)[0]), gradient)


def _falling(law: Law) -> float:
    """Return the sign of the derivative of an angle by ``w . v``: an arc cosine of it falls."""
    return -law.sign if law.is_cosine else law.sign


def _bent(
    kind: Kind, vectors: Sequence[Field], moves: Sequence[Field], bends: Sequence[Field]
) -> Field:
    """Return the second derivative of what is measured, where r and w move and bend so."""
    p, (first, second) = polynomial(kind).value(*vectors), _along(kind, vectors, moves, bends)
    if kind.law is Law.SQUARE:
        # The root f of p: f'' = p'' / 2f - p'^2 / 4f^3.
        f = _root(p)
        return np.asarray(second / (2 * f) - first**2 / (4 * f**3))
    if kind.law is Law.SIGNED:
        return second
    _, w, v = vectors
    c, (square, parallel) = COSINE.value(*vectors), _sine_square(w, v)
    if kind.law is not Law.MOMENT:
        s = _root(square)
        return np.asarray(_falling(kind.law) * (second / s + c * first**2 / s**3))
    # The moment m over the sine s = (1 - c^2)^(1/2): with k = 1 / s by c, k' = c / s^3 and
    # k'' = (1 + 2 c^2) / s^5.
    s = np.sqrt(np.where(parallel, np.nan, square))
    turning, bending = _along(None, vectors, moves, bends)
    mixed = c * (2 * first * turning + p * bending)
    bent: Field = second / s + mixed / s**3 + p * (1 + 2 * c**2) * turning**2 / s**5
    return bent


def _along(
    kind: Kind | None, vectors: Sequence[Field], moves: Sequence[Field], bends: Sequence[Field]
) -> tuple[Field, Field]:
    """Return two derivatives of the polynomial of a kind, or of the cosine, where r and w move."""
    form = COSINE if kind is None else polynomial(kind)
    (r, w, v), (a, b), (p, q) = vectors, moves, bends
    first = form.gradient(r, w, v)
    change, bent = dot(first.r, a), dot(first.r, p) + form.bend(r, w, v, a, b)
    if kind is None or kind.platform is not Primitive.POINT:
        change, bent = change + dot(first.w, b), bent + dot(first.w, q)
    return change, bent


def _times(factor: Field, gradient: Gradient) -> Gradient:
    return Gradient(*(factor[..., None] * part for part in gradient))


def _plus(a: Gradient, b: Gradient) -> Gradient:
    return Gradient(*(p + q for p, q in zip(a, b, strict=True)))


Array = NDArray[np.float64]

_DIGITS = 60
#: A singular value of a 6x6 matrix of doubles below this part of the largest may be zero.
_ROUNDING = 6 * float(np.finfo(np.float64).eps)
#: Poses in one block: their matrices fit into the cache, and larger blocks take twice the time.
_TOGETHER = 1024


def residuals(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Return measured minus stated value of each constraint, in the units of the instance.

    The distance or angle itself counts, not its square or cosine:
    ``(..., 3, 3), (..., 3) -> (..., n)``. Where a measured distance has no sign, or both sides are
    allowed, the nearer sign is taken. An arrangement with values of shape (..., n) serves poses
    of many sets of values.
    """
    values = measured(arrangement, R, T)
    targets = arrangement.targets
    difference = np.abs(values - targets)
    free = np.array([kind.is_distance for kind in arrangement.kinds]) & (arrangement.signs == 0)
    opposite = np.where(free, np.abs(values + targets), np.inf)
    signed = np.abs(values - np.where(arrangement.signs < 0, -targets, targets))
    result = np.where(free, np.minimum(difference, opposite), signed)
    result[..., arrangement.angles] /= arrangement.in_radians
    return np.asarray(result)


def relative_residuals(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Return `residuals` without units: lengths by that of the platform, angles in radians."""
    units = np.full(len(arrangement.kinds), arrangement.length)
    units[arrangement.angles] = 1 / arrangement.in_radians
    return np.asarray(residuals(arrangement, R, T) / units)


def proved_residuals(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Return residuals at poses for which the constraints are proved to hold as stated.

    Nearly parallel lines of a DLL are measured as skew lines with more digits. Where rounding alone
    may separate them from parallel ones they are measured as parallel, too, and the smaller
    residual counts. The doubles of a pose are taken as exact: lines at an angle of s lose as many
    digits of their distance as s has zeros. ``(b, 3, 3), (b, 3) -> (b, n)``.
    """
    result = residuals(arrangement, R, T)
    lines = [k for k, kind in enumerate(arrangement.kinds) if kind is DLL]
    if not lines:
        return result
    w = arrangement.placed(R, T).w[:, lines]
    normals = cross(w, np.broadcast_to(arrangement.v[lines], w.shape))
    squares = np.abs(dot(normals, normals))
    targets = np.broadcast_to(arrangement.targets, result.shape)
    for pose, line in zip(*np.nonzero(squares < NEARLY_PARALLEL_SINE_SQUARE), strict=True):
        k = lines[line]
        distance = _skew_distance(arrangement, R[pose], T[pose], k)
        if distance is not None:
            skew = min(abs(distance - targets[pose, k]), abs(distance + targets[pose, k]))
            result[pose, k] = min(skew, result[pose, k])
    return result


def _skew_distance(arrangement: Arrangement, R: Field, T: Field, k: int) -> complex | None:
    """Return the distance of two lines that are not exactly parallel, else None."""
    # Few poses need mpmath, and its import takes as long as a solve.
    from mpmath import MPContext

    context = MPContext()
    context.dps = _DIGITS

    def exactly(numbers: Field) -> list[Any]:
        return [context.mpmathify(x) for x in numbers.tolist()]

    y, x, u, v = (
        exactly(a[k]) for a in (arrangement.y, arrangement.x, arrangement.u, arrangement.v)
    )
    rows, place = [exactly(row) for row in R], exactly(T)
    w = [context.fdot(row, u) for row in rows]
    r = [context.fdot(row, y) + t - b for row, t, b in zip(rows, place, x, strict=True)]
    normal = [w[i - 2] * v[i - 1] - w[i - 1] * v[i - 2] for i in range(3)]
    square = context.fdot(normal, normal)
    return complex(context.fdot(r, normal) / context.sqrt(square)) if square else None


def sides_of(arrangement: Arrangement, R: Field, T: Field) -> NDArray[np.int64]:
    """Return on which side each DPH and DHP point lies: 1, -1, or 0 for other kinds."""
    values = measured(arrangement, R, T).real
    sign = np.where(values < 0, -1, 1)
    return np.where(arrangement.sided, np.where(arrangement.signs == 0, sign, arrangement.signs), 0)


def known_sides(arrangement: Arrangement, R: Field, T: Field) -> NDArray[np.int64]:
    """Return the sides of `sides_of`, but 0 where rounding may change the sign of a height.

    For poses ``(n, 3, 3), (n, 3)`` rounded to doubles, the error of a height is some units in the
    last place of the largest length in its sum.
    """
    small = np.abs(arrangement.targets) <= _doubt(arrangement, R, T)
    return np.where(small & (arrangement.signs == 0), 0, sides_of(arrangement, R, T))


def without_derivative(arrangement: Arrangement, R: Field, T: Field) -> NDArray[np.bool_]:
    """Return which constraints measure a distance to a point or line that may be zero, (..., n).

    There the distance has no derivative: what is computed has the direction of rounding errors.
    """
    roots = np.array([kind.law is Law.SQUARE for kind in arrangement.kinds])
    if not roots.any():
        return np.zeros((*T.shape[:-1], len(roots)), np.bool_)
    values = np.abs(measured(arrangement, R, T))
    return np.asarray(roots & (values <= _doubt(arrangement, R, T)))


def _doubt(arrangement: Arrangement, R: Field, T: Field) -> Array:
    """Bound what values at poses err by because of the rounding of the poses, shape (..., 1)."""
    extent = max(np.abs(arrangement.y).max(initial=0), np.abs(arrangement.x).max(initial=0))
    lengths = (1 + np.abs(R).max(axis=(-1, -2))) * extent + np.abs(T).max(axis=-1)
    return np.asarray(roundings(8, lengths)[..., None])


def condition_numbers(
    arrangement: Arrangement, R: Field, T: Field, length: float | Array | None = None
) -> Array:
    """Return the condition number of each pose, free of units, ``(..., 3, 3) -> (...)``.

    It is the ratio of the largest to the smallest singular value of the 6x6 Jacobian matrix.
    Twists turn about the centre of the platform points, columns of rotations are divided by the
    typical length (that of the arrangement for None, else shape (...)), and rows are scaled to
    norm one. The number depends neither on frames nor on units. It is infinite at a singular
    pose and at a pose that doubles cannot distinguish from one.
    """
    lengths = np.broadcast_to(arrangement.length if length is None else length, T.shape[:-1])
    if R.ndim > 2 and len(R) > _TOGETHER:
        parts = [slice(first, first + _TOGETHER) for first in range(0, len(R), _TOGETHER)]
        return np.concatenate(
            [condition_numbers(arrangement.part(k), R[k], T[k], lengths[k]) for k in parts]
        )
    unit = lengths[..., None, None]
    # The row of a value without a derivative (parallel lines, distance or angle zero) is not
    # finite.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rows = jacobian(arrangement, R, T)
        # About the centre c of the platform: T + s (omega x R c moved back) leaves R c + T alone.
        offset = apply(R, arrangement.platform_centre)[..., None, :]
        rows[..., :3] -= cross(np.broadcast_to(offset, rows[..., 3:].shape), rows[..., 3:])
        rows[..., :3] /= unit
        norms = np.linalg.norm(rows, axis=-1, keepdims=True)
        defined = np.isfinite(norms).all(axis=(-1, -2)) & (norms > 0).all(axis=(-1, -2))
        defined &= ~without_derivative(arrangement, R, T).any(axis=-1)
        rows = np.where(defined[..., None, None], rows / np.where(norms > 0, norms, 1.0), 0.0)
        values = np.linalg.svd(rows, compute_uv=False)
        condition = values[..., 0] / values[..., -1]
    regular = values[..., -1] > _ROUNDING * values[..., 0]
    return np.where(defined & regular, condition, np.inf)


#: Digits of a condition number: this many at most, and one less for each power of ten of the number
#: from where rounding errors, some 1e-15 of it times itself, come near the last digit.
_PRINTED, _KNOWN_DIGITS = 6, 12
#: Residuals below this part of the length of a platform are rounding errors of measuring it.
_PRINTED_ROUNDING = 64 * float(np.finfo(np.float64).eps)


def printed_condition(condition: float) -> float:
    """Return a condition number with the digits that are known; infinity and NaN unchanged."""
    if not math.isfinite(condition) or condition <= 0:
        return condition
    digits = min(_PRINTED, max(1, _KNOWN_DIGITS - math.ceil(math.log10(condition))))
    return float(f"{condition:.{digits}g}")


def printed_conditions(conditions: ArrayLike) -> NDArray[np.float64]:
    """Return `printed_condition` of each number, in the same shape."""
    given = np.asarray(conditions, np.float64)
    return np.array([printed_condition(x) for x in given.ravel().tolist()]).reshape(given.shape)


def printed_residual(residual: float, length: float) -> float:
    """Return an upper bound of a residual with one digit, which rounding errors do not change.

    Parameters
    ----------
    residual
        The largest residual of a pose, in the units of the instance.
    length
        Of the platform. A residual below `_PRINTED_ROUNDING` of it may be a rounding error.
    """
    if not math.isfinite(residual):
        return residual
    return one_digit(max(residual, _PRINTED_ROUNDING * length))


def one_digit(bound: float) -> float:
    """Return the next number of one digit that is not less: 1.4e-14 becomes 2e-14."""
    power = math.floor(math.log10(bound)) if bound else 0
    digit = math.ceil(bound / 10.0**power) if bound else 0
    return float(f"{digit}e{power}")


def printed_residuals(residuals: ArrayLike, length: float) -> NDArray[np.float64]:
    """Return `printed_residual` of each number, in the same shape."""
    given = np.asarray(residuals, np.float64)
    found = [printed_residual(x, length) for x in given.ravel().tolist()]
    return np.array(found).reshape(given.shape)
