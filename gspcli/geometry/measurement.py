"""The measured value of each constraint at a pose, and its derivatives by the pose.

The quantities are those of the paper's Section 4, in floating point and also at complex poses:
a distance is the complex square root of the complex square. Poses have any leading batch axes; the
constraints are the last axis of values and the first of each derivative. All derivatives follow by
the chain rule from the polynomials of `gspcli.geometry.constraint_polynomials`.

A twist (omega, tau) moves the pose to ``exp([s omega]x) R`` and ``T + s tau``: a rotation in
the axes of the base about the origin of the platform, and a translation.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from gspcli.catalogue.kinds import DLL, DPL, Kind, Law, Primitive
from gspcli.geometry.arrangement import Arrangement, Bodies, Placed
from gspcli.geometry.constraint_polynomials import COSINE, Gradient, polynomial
from gspcli.geometry.quaternions import Field, apply, cross, dot
from gspcli.geometry.tolerances import PARALLEL_SINE

#: A complex unit vector with a larger entry is long: its entries cancel in double precision.
_LONG = 2.0
#: Lines nearer than this part of the typical length meet up to rounding.
_MEETING = 1e-12
_IDENTITY = np.eye(3)


def measured(bodies: Bodies, R: Field, T: Field) -> Field:
    """Return what each constraint measures, ``(..., 3, 3), (..., 3) -> (..., n)``.

    Distances to planes are signed by the normal; line-line distances are signed by the
    orientation of the lines; angles are in radians. A complex distance is one of two square
    roots, a complex angle one branch of the inverse function.
    """
    r, w, _ = bodies.placed(R, T)
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
    turned, w_moves = cross(omega, arm), cross(omega, w)
    r_moves, r_bends = turned + twists[..., None, 3:], cross(omega, turned)
    if slip is not None:
        r_moves, r_bends = r_moves + slip[0], r_bends + slip[1]
    w_bends = cross(omega, w_moves)
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
    (a, b), (p, q) = moves, bends
    first, second = form.gradient(*vectors), form.hessian(*vectors)
    change, bent = dot(first.r, a), dot(first.r, p) + dot(a, apply(second.rr, a))
    if kind is None or kind.platform is not Primitive.POINT:
        change = change + dot(first.w, b)
        bent = bent + 2 * dot(a, apply(second.rw, b)) + dot(b, apply(second.ww, b))
        bent = bent + dot(first.w, q)
    return change, bent


def _times(factor: Field, gradient: Gradient) -> Gradient:
    return Gradient(*(factor[..., None] * part for part in gradient))


def _plus(a: Gradient, b: Gradient) -> Gradient:
    return Gradient(*(p + q for p, q in zip(a, b, strict=True)))
