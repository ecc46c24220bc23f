"""The measured value of each constraint at a pose, and its derivatives by the pose.

The quantities are those of the paper's Section 4, in floating point and also at complex poses:
a distance is the complex square root of the complex square. Poses have any leading batch axes; the
constraints are the last axis of values and the first of each derivative. All derivatives follow by
the chain rule from the polynomials of `gspcli.geometry.constraint_polynomials`.

A twist (omega, tau) moves the pose to ``exp([s omega]x) R`` and ``T + s tau``: a rotation in
the axes of the base about the origin of the platform, and a translation.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from gspcli.catalogue.kinds import DPL, Kind, Law
from gspcli.geometry.arrangement import Bodies, Placed
from gspcli.geometry.constraint_polynomials import COSINE, Gradient, Hessian, polynomial
from gspcli.geometry.quaternions import Field, apply, cross, dot
from gspcli.geometry.tolerances import PARALLEL_SINE

#: A complex unit vector with a larger entry is long: its entries cancel in double precision.
_LONG = 2.0
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


def hessian(bodies: Bodies, R: Field, T: Field) -> Field:
    """Return the second derivatives of `measured` with respect to a twist, ``(..., n, 6, 6)``.

    H is the symmetric matrix such that ``t.H t`` is the second derivative by s for each twist t.
    It is not finite where the value has no second derivative: at a distance or sine of zero and
    for parallel lines.
    """
    r, w, arm = bodies.placed(R, T)
    v = np.broadcast_to(bodies.v, w.shape)
    matrices: Field = np.zeros((*r.shape[:-1], 6, 6), dtype=r.dtype)
    for kind, k in _alike(bodies.kinds):
        vectors = r[..., k, :], w[..., k, :], v[..., k, :]
        first, second = _gradient(kind, *vectors), _hessian(kind, *vectors)
        matrices[..., k, :, :] = by_twist_twice(first, second, arm[..., k, :], vectors[1])
    return matrices


def curvature(
    bodies: Bodies, R: Field, T: Field, twists: Field, slip: Field | None = None
) -> Field:
    """Return the second derivatives of `measured` along constant twists, ``(..., 6) -> (..., n)``.

    Parameters
    ----------
    slip
        The velocity of r and its derivative when points move in their bodies, too, shape
        (2, ..., n, 3). Without it these are ``t.H t`` with the matrices of `hessian`, in a seventh
        of the time.
    """
    r, w, arm = bodies.placed(R, T)
    v = np.broadcast_to(bodies.v, w.shape)
    omega = np.broadcast_to(twists[..., None, :3], arm.shape)
    turned, w_moves = cross(omega, arm), cross(omega, w)
    r_moves, r_bends = turned + twists[..., None, 3:], cross(omega, turned)
    if slip is not None:
        r_moves, r_bends = r_moves + slip[0], r_bends + slip[1]
    w_bends = cross(omega, w_moves)
    found: Field = np.zeros(r.shape[:-1], dtype=r.dtype)
    for kind, k in _alike(bodies.kinds):
        vectors = r[..., k, :], w[..., k, :], v[..., k, :]
        first, second = _gradient(kind, *vectors), _hessian(kind, *vectors)
        a, b = r_moves[..., k, :], w_moves[..., k, :]
        bent = dot(a, apply(second.rr, a) + 2 * apply(second.rw, b)) + dot(b, apply(second.ww, b))
        found[..., k] = bent + dot(first.r, r_bends[..., k, :]) + dot(first.w, w_bends[..., k, :])
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


def by_twist_twice(gradient: Gradient, hessian: Hessian, arm: Field, w: Field) -> Field:
    """Return the second derivative by a twist of a function of r and w, shape (..., 6, 6)."""
    r_moves, w_moves = velocities(arm, w)
    mixed = _between(r_moves, hessian.rw, w_moves)
    matrix = _between(r_moves, hessian.rr, r_moves) + _between(w_moves, hessian.ww, w_moves)
    matrix = matrix + mixed + np.swapaxes(mixed, -1, -2)
    # The acceleration of r is omega x (omega x arm), that of w is omega x (omega x w).
    for a, f in ((arm, gradient.r), (w, gradient.w)):
        outer = a[..., :, None] * f[..., None, :]
        bent = (outer + np.swapaxes(outer, -1, -2)) / 2 - dot(a, f)[..., None, None] * _IDENTITY
        matrix[..., :3, :3] += bent
    return matrix


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


def _between(a: Field, matrix: Field, b: Field) -> Field:
    product: Field = np.swapaxes(a, -1, -2) @ matrix @ b
    return product


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


def _hessian(kind: Kind, r: Field, w: Field, v: Field) -> Hessian:
    """Return the second derivatives of what is measured by r and w."""
    gradient = polynomial(kind).gradient(r, w, v)
    hessian = polynomial(kind).hessian(r, w, v)
    if kind.law is Law.SQUARE:
        # The root f of p: f' = p' / 2f, f'' = p'' / 2f - p' p' / 4f^3.
        f = _root(polynomial(kind).value(r, w, v))
        return _sum(_times_all(0.5 / f, hessian), _squared(-0.25 / f**3, gradient, gradient))
    if kind.law is Law.SIGNED:
        return hessian
    if kind.law is Law.MOMENT:
        # The moment m over the sine s = (1 - c^2)^(1/2): with k = 1 / s by c, k' = c / s^3 and
        # k'' = (1 + 2 c^2) / s^5.
        m, c = polynomial(kind).value(r, w, v), COSINE.value(r, w, v)
        square, parallel = _sine_square(w, v)
        s = np.sqrt(np.where(parallel, np.nan, square))
        turning = COSINE.gradient(r, w, v)
        both = _squared(c / s**3, gradient, turning), _squared(c / s**3, turning, gradient)
        last = _squared(m * (1 + 2 * c**2) / s**5, turning, turning)
        return _sum(_times_all(1 / s, hessian), *both, last)
    c, s = COSINE.value(r, w, v), _root(_sine_square(w, v)[0])
    return _squared(_falling(kind.law) * c / s**3, gradient, gradient)


def _times(factor: Field, gradient: Gradient) -> Gradient:
    return Gradient(*(factor[..., None] * part for part in gradient))


def _plus(a: Gradient, b: Gradient) -> Gradient:
    return Gradient(*(p + q for p, q in zip(a, b, strict=True)))


def _times_all(factor: Field, hessian: Hessian) -> Hessian:
    return Hessian(*(factor[..., None, None] * part for part in hessian))


def _squared(factor: Field, a: Gradient, b: Gradient) -> Hessian:
    """Return the part of second derivatives that is a multiple of ``a b^T``."""
    pairs = ((a.r, b.r), (a.r, b.w), (a.w, b.w))
    return Hessian(*(factor[..., None, None] * p[..., :, None] * q[..., None, :] for p, q in pairs))


def _sum(*parts: Hessian) -> Hessian:
    return Hessian(*(sum(blocks[1:], blocks[0]) for blocks in zip(*parts, strict=True)))
