"""Clearance of poses: the distance to poses whose six screws are dependent.

Distances of poses are root mean squares of the displacements of the platform's points, the
extrinsic metric of G. Nawratil, Singularity distance for parallel manipulators of Stewart Gough
type, Advances in Mechanism and Machine Science (2019).

About a pose whose platform points have the centre c, other poses are displacements
``x -> c + t + Q (x - c)``. With the quaternion (w, v) of Q, w not negative, the mean of the squared
displacements of the points is ``|t|^2 + 4 v . I v``, I being the second moments of the points about
axes through c. So the coordinates

    s = (t, 2 I^(1/2) v)

have the distance of poses as their norm. All poses within a distance are a ball, for any distance.

Over a ball or box of poses the rows of the matrix of screws are enclosed. With approximate factors
of that in the middle, ``M = U S V^T``, let b be bounds of the moduli of the entries of
``S^-1 U^T M' V - 1`` for all M' there. If ``b p < p`` for a positive vector p, then all M' are
regular, by the norm ``max |x_k| / p_k``, and their determinants have the sign of ``det U det V``.
The best p is the eigenvector of b of Perron and Frobenius.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.enclosures import Enclosure, above, roundings, size
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.quaternions import (
    apply,
    dot,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from gspcli.motion.bisection import bisected
from gspcli.motion.screws import screw
from gspcli.records import dataclass
from gspcli.ties import ascending, definite_pairs, definite_vectors

Array = NDArray[np.float64]

#: Moments smaller than this part of the greatest are those of points on a line.
_LINE = 1e-9
#: Squarings of the matrix of bounds on the way to its positive eigenvector.
_SQUARINGS = 5
#: A small step, by which derivatives are scaled.
_STEP = 1e-6
#: The weight of the length of a side beside its share.
_SIDE = 1e-9
#: Halvings of the interval of a radius, and the ratio of its ends that suffices.
_HALVINGS, _CLOSE = 40, 1.01
#: Numbers of rays, normally and refined; rounds in which they are turned; nodes on a ray.
_RAYS, _MANY_RAYS, _ROUNDS, _NODES = 24, 96, 30, 48
#: Parts of the turn of a ray towards the normal, and the turn below which it has converged.
_PARTS, _SETTLED = np.array([1.0, 0.5, 0.2]), 1e-5
#: The sine of half the angle of nearly half a turn; the beginning of rays, relatively, and their
#: end, in typical lengths; halvings of them while they turn, and at the end.
_FULL, _NEAREST, _FARTHEST, _ROUGH, _FINE = 0.999, 1e-3, 10.0, 20, 45
#: Relative half width of the segment on which the determinant is proved to change its sign.
_SEGMENT = 1e-9
#: Boxes judged at a time and in all; the ratio of the bounds that suffices; the largest one; the
#: smallest side of a box, relatively, which is exact in doubles beside the largest.
_PIECE, _BOXES, _NEAR, _WIDEST, _SMALLEST = 512, 60_000, 1.1, 64, 1e-7
#: Bounds of distances are moved by this part: the coordinates themselves are rounded.
_MOVED = 1e-9


class Displacements:
    """Displacements from home poses, by the coordinates s.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used.
    R, T
        The home poses, shapes (n, 3, 3) and (n, 3).
    points
        The points of the platform, in its frame, whose displacements define the distance, (m, 3);
        by default those of the distance constraints, one for each.

    Raises
    ------
    ArgumentError
        If the points lie on a line.
    """

    def __init__(
        self, instance: Instance, R: ArrayLike, T: ArrayLike, points: ArrayLike | None = None
    ) -> None:
        self.arrangement = arrangement = Arrangement.of(instance)
        given = arrangement.y[arrangement.distances] if points is None else points
        self.points = np.asarray(given, float).reshape(-1, 3)
        self.centre = self.points.mean(axis=0)
        self.R = rotation_from_quaternion(quaternion_from_rotation(np.asarray(R, float)))
        self.T = np.asarray(T, float)
        offsets = self.points - self.centre
        square = offsets.T @ offsets / len(self.points)
        moments, axes = np.linalg.eigh(np.trace(square) * np.eye(3) - square)
        axes = definite_vectors(moments, axes)
        if not moments[0] > _LINE * moments[2]:
            raise ArgumentError(
                "the points of the platform lie on a line, expected three that do not", "points"
            )
        #: Columns: the principal axes in the base, shape (n, 3, 3); square roots of the moments.
        self.axes = self.R @ axes
        self.radii = np.sqrt(moments)

    @property
    def farthest(self) -> float:
        """The least distance at which half a turn is reached."""
        return float(2 * self.radii[0])

    @cached_property
    def centres(self) -> Array:
        """The centres of the points at home, in the base, shape (n, 3)."""
        return np.asarray(self.T + apply(self.R, self.centre))

    def turns(self, s: Array) -> Array:
        """Return the sines of half the angles, ``(..., 6) -> (...)``; at most one."""
        return np.asarray(np.linalg.norm(s[..., 3:] / (2 * self.radii), axis=-1))

    def poses(self, s: Array) -> tuple[Array, Array]:
        """Return poses (R, T) by their coordinates, ``(n, 6) -> (n, 3, 3), (n, 3)``."""
        Q = rotation_from_quaternion(self.quaternions(s))
        R = Q @ self.R
        T = self.centres + s[..., :3] - apply(R, self.centre)
        return R, T

    def quaternions(self, s: Array) -> Array:
        """Return the turns (w, v), ``(..., 6) -> (..., 4)``; NaN where there is none."""
        v = apply(self.axes, s[..., 3:] / (2 * self.radii))
        with np.errstate(invalid="ignore"):
            w = np.sqrt(1 - dot(v, v)[..., None])
        return np.concatenate((w, v), axis=-1)

    def determinants(self, s: Array) -> Array:
        """Return determinants of the Jacobian matrices, 0 where there is none, ``(n, 6) -> (n,)``.

        In the units of the instance; numbers, not proofs.
        """
        with np.errstate(all="ignore"):
            rows = jacobian(self.arrangement, *self.poses(s))
            regular = np.asarray(np.isfinite(rows).all(axis=(1, 2)))
            return np.asarray(np.linalg.det(np.where(regular[:, None, None], rows, 0.0)))


@dataclass(frozen=True, eq=False)
class Regular:
    """Proofs about n sets of poses."""

    #: The sign of the determinant of all matrices, 0 if they are not proved to be regular, shape
    #: (n,).
    sign: Array
    #: The contribution of each coordinate to the bound, shape (n, 6).
    shares: Array


class Screws:
    """The screws of a platform over sets of poses about home poses.

    Parameters
    ----------
    home
        The home poses, and the platform.
    """

    def __init__(self, home: Displacements) -> None:
        self.home = home
        self.arrangement = home.arrangement

    def matrices(self, s: Array) -> Array:
        """Return matrices of screws about the centres, of any positive strength, (n, 6, 6)."""
        with np.errstate(all="ignore"):
            return self.rows(s, np.zeros_like(s), cube=True).mid[..., 0]

    def derivatives(self, s: Array) -> Array:
        """Return derivatives of `matrices` by the coordinates, ``(n, 6) -> (n, 6, 6, 6)``."""
        with np.errstate(all="ignore"):
            found = self.rows(s, np.full_like(s, _STEP), cube=True)
            return np.asarray(found.lin[..., 0, :] / _STEP)

    def judge(self, s: Array, half: Array, *, cube: bool) -> Regular:
        """Prove that no pose of a set is singular.

        Parameters
        ----------
        s
            The middles, shape (n, 6).
        half
            Half sides of boxes, or semi-axes of ellipsoids, shape (n, 6).
        cube
            Whether the sets are boxes; otherwise they are ellipsoids.
        """
        with np.errstate(all="ignore"):
            found = self.rows(s, half, cube=cube)
            rows, linear, rest = found.mid[..., 0], found.lin[..., 0, :], found.rad
            finite = [np.isfinite(part).reshape(len(s), -1) for part in (rows, linear, rest)]
            safe = np.concatenate(finite, axis=1).all(axis=1).reshape(-1, 1, 1)
            rows, rest = np.where(safe, rows, np.eye(6)), np.where(safe, rest, np.inf)
            linear = np.where(safe[..., None], linear, 0.0)
            sign, shares = regular(rows, linear, rest, cube=cube)
        # Without a bound the longest side counts.
        return Regular(sign, np.where(safe[:, 0], np.nan_to_num(shares), 0.0) + _SIDE * half)

    def rows(self, s: Array, half: Array, *, cube: bool) -> Enclosure:
        """Enclose the matrices of screws entry by entry: numbers, shape (n, 6, 6).

        Columns are moments about the principal axes in units of the radii, then forces.
        """
        count, kinds = len(s), self.arrangement.kinds
        given = self._vectors(s, half, cube=cube)
        mid, rad = np.zeros((count, 6, 6, 1)), np.zeros((count, 6, 6))
        lin = np.zeros((count, 6, 6, 1, 6))
        axes = np.broadcast_to(self.home.axes, (count, 3, 3)) / self.home.radii
        columns = [np.swapaxes(axes, 1, 2)[:, None], np.eye(3)[None, None]]
        for kind in set(kinds):
            k = [i for i, other in enumerate(kinds) if other is kind]
            parts = screw(kind, *(one.take(slice(None), k) for one in given))
            for at, part, along in zip((0, 3), parts, columns, strict=True):
                if part is not None:
                    each = part.take(slice(None), slice(None), None).dot(Enclosure.rounded(along))
                    mid[:, k, at : at + 3], rad[:, k, at : at + 3] = each.mid, each.rad
                    if each.lin.shape[-1]:
                        lin[:, k, at : at + 3] = each.lin
        return Enclosure(mid, rad, lin, cube=cube)

    def _vectors(
        self, s: Array, half: Array, *, cube: bool
    ) -> tuple[Enclosure, Enclosure, Enclosure, Enclosure]:
        """Enclose arms and r less these, (n, 6, 3), and directions of the platform and the base."""
        at, a = self.home, self.arrangement
        e = at.quaternions(s)
        R = rotation_from_quaternion(e) @ at.R
        # The derivatives of t and v.
        half = above(half)
        shift, turn = np.zeros((2, len(s), 1, 3, 6))
        shift[:, 0, range(3), range(3)] = half[:, :3]
        turn[:, 0, :, 3:] = at.axes * (half[:, 3:] / (2 * at.radii))[:, None]
        v = _turn(e[:, None], Enclosure(np.zeros((len(s), 1, 3)), 0.0, turn, cube=cube))
        w = Enclosure.between(1 - v.most**2, np.ones_like(v.most)).sqrt()

        def turned(vectors: Array, sizes: Array) -> Enclosure:
            fixed = Enclosure.rounded(apply(R[:, None], vectors), sizes)
            across = v.cross(fixed)
            return fixed + 2.0 * (across * w + v.cross(across))

        centre = size(at.centre)
        far = size(at.T)[:, None] + centre + size(a.x)
        homes = np.broadcast_to(at.centres, (len(s), 3))[:, None]
        moved = Enclosure(s[:, None, :3], 0.0, shift, cube=cube)
        arms = turned(a.y - at.centre, size(a.y) + centre) + moved
        offsets = Enclosure.rounded(homes - a.x, far)
        fixed = Enclosure.rounded(np.broadcast_to(a.v, (len(s), 6, 3)))
        return arms, offsets, turned(a.u, np.ones(6)), fixed


def _turn(e: Array, change: Enclosure) -> Enclosure:
    """Return the vector part of the turns from those by quaternions e when v changes.

    It is ``w dv - v dw - dv x v`` with dw, the change of ``w = (1 - v . v)^(1/2)``. The middle is
    what e is exactly.
    """
    w, v = Enclosure.rounded(e[..., :1]), Enclosure.rounded(e[..., 1:])
    there = v + change
    one = Enclosure(np.ones_like(e[..., :1]))
    return change * w - v * ((one - there.dot(there)).sqrt() - w) - change.cross(v)


def regular(rows: Array, linear: Array, rest: Array, *, cube: bool) -> tuple[Array, Array]:
    """Return the proved signs of determinants of matrices, 0 without a proof, and shares.

    Parameters
    ----------
    rows, linear, rest
        Entries are within ``rest`` of ``rows + linear . x``, shapes (n, 6, 6), (n, 6, 6, 6) and
        (n, 6, 6).
    cube
        Whether x is in the cube, else in the unit ball.
    """
    sizes = np.linalg.norm(rows, axis=2, keepdims=True)
    scales = 1 / np.where(sizes > 0, sizes, 1.0)
    u, s, vt = np.linalg.svd(rows * scales)
    # At symmetric poses any basis for equal singular values is right; bounds depend on it.
    u, vt = definite_pairs(u, s, vt)
    inverse = np.swapaxes(u, 1, 2) / s[:, :, None] * np.swapaxes(scales, 1, 2)
    basis = np.swapaxes(vt, 1, 2)
    moved = np.einsum("njm,nmli,nlk->njki", inverse, linear, basis, optimize=True)
    # Both products with factors are rounded.
    errors = rest + roundings(2, np.abs(rows) + np.abs(linear).sum(axis=3))
    left_out = np.abs(inverse) @ errors @ np.abs(basis)
    left_out += np.abs(inverse @ rows @ basis - np.eye(6))
    bound = np.linalg.norm(moved, ord=1 if cube else 2, axis=3) + left_out
    bound = np.where(np.isfinite(bound), bound, 1e30)
    power = bound + 1e-300
    for _ in range(_SQUARINGS):
        power = power @ power
        power /= power.max(axis=(1, 2), keepdims=True)
    p = power.sum(axis=2) + 1e-9
    ratio = (bound @ p[..., None])[..., 0] / p
    proved = above(ratio.max(axis=1)) < 1
    sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    worst = ratio.argmax(axis=1)
    each = np.arange(len(p))
    parts = np.abs(moved[each, worst]) * p[:, :, None]
    return np.where(proved, sign, 0.0), parts.sum(axis=1) / p[each, worst, None]


@dataclass(frozen=True, eq=False)
class Clearance:
    """Bounds of the clearance of one pose: in the drives, or the distance from singular poses."""

    #: Proved lower bound: up to here there is exactly one continuation, and no singularity.
    lower: float
    #: Of drives the distance of the nearest singularity that was found on the lines to the corners
    #: of the box, or of the end of the range of a value; infinite if neither was found. A fold is
    #: proved. Of poses it is proved: a nearer pose is singular.
    upper: float = np.inf
    #: The singular pose, of poses one within a billionth of `upper` from it; shapes (3, 3) and
    #: (3,). None if there is none.
    R: Array | None = None
    T: Array | None = None
    #: Of drives: the numbers there, lengths and radians, shape (m,); None if infinite.
    numbers: Array | None = None
    #: ``fold``, proved, ``end of range`` or ``singular pose``; None if there is none.
    by: str | None = None
    #: The index of the constraint whose value is at an end of its range, such as a distance of
    #: zero; None for a singular pose.
    end: int | None = None
    #: Of drives, proved: up to here no drive comes to a dead point; at most ``lower``.
    working_modes: float = 0.0
    #: The change at the nearest dead point that was found; infinite if there is none.
    dead_point: float = np.inf
    #: The index of the drive that is at it, or None.
    drive: int | None = None

    @property
    def ratio(self) -> float:
        """Upper bound by lower bound."""
        return self.upper / self.lower if self.lower > 0 else np.inf


def pose_clearances(
    instance: Instance, R: ArrayLike, T: ArrayLike, *, points: ArrayLike | None = None
) -> Array:
    """Return proved lower bounds of the distance of poses from singular ones, shape (n,).

    In length units; zero if there is no proof.

    Parameters
    ----------
    instance, R, T, points
        As for `Displacements`; n poses.

    Raises
    ------
    ArgumentError
        If the points lie on a line.
    """
    R, T = np.asarray(R, float).reshape(-1, 3, 3), np.asarray(T, float).reshape(-1, 3)
    parts = [
        _balls(Displacements(instance, R[k : k + _PIECE], T[k : k + _PIECE], points))
        for k in range(0, max(len(R), 1), _PIECE)
    ]
    return np.concatenate(parts)


def _balls(home: Displacements) -> Array:
    """Return radii of balls about the homes that one test proves to be free, (n,)."""
    screws = Screws(home)
    middle = np.zeros((len(home.T), 6))

    def free(size: Array) -> NDArray[np.bool_]:
        half = np.broadcast_to(size[:, None], middle.shape)
        return np.asarray(screws.judge(middle, half, cube=False).sign != 0)

    low, high = np.zeros(len(middle)), np.full(len(middle), home.farthest)
    # Clearances can have any order of magnitude; it is found first.
    return bisected(free, low, high, _HALVINGS, close=_CLOSE, first=0.25)[0] * (1 - _MOVED)


def pose_clearance(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    points: ArrayLike | None = None,
    refine: bool = False,
    seed: int = SEED,
) -> Clearance:
    """Return proved bounds of the distance of a pose from the nearest singular one.

    For the upper bound the determinant is searched for a change of its sign along rays, which are
    turned towards the normal of the singular poses. For the lower bound the ball of poses is
    divided into boxes, the nearest first, until each box is proved to be free.

    Parameters
    ----------
    instance, points
        As for `Displacements`.
    R, T
        The pose, shapes (3, 3) and (3,).
    refine
        Whether to take more rays and boxes, which takes some seconds.
    seed
        The seed of the rays.
    """
    R, T = np.asarray(R, float)[None], np.asarray(T, float)[None]
    home = Displacements(instance, R, T, points)
    screws = Screws(home)
    lower = float(_balls(home)[0])
    if lower == 0:
        return Clearance(0.0)
    found = _nearest(screws, _MANY_RAYS if refine else _RAYS, seed)
    upper = np.inf if found is None else float(np.linalg.norm(found)) * (1 + _MOVED)
    if refine:
        lower = _divided(screws, lower, min(upper, _WIDEST * lower))
    if found is None:
        return Clearance(lower)
    at, shift = home.poses(found[None])
    return Clearance(lower, upper, at[0], shift[0], by="singular pose")


def _divided(screws: Screws, proved: float, size: float) -> float:
    """Return a better lower bound, at most a size: boxes not proved to be free are halved."""
    # Few digits: all corners of boxes are exact.
    size = float(np.nextafter(np.float32(size), np.float32(0)))
    centres, halves = np.zeros((1, 6)), np.full((1, 6), size)
    judged = 0
    while True:
        least = np.maximum(np.abs(centres) - halves, 0.0)
        most = np.abs(centres) + halves
        distance: Array = np.linalg.norm(least, axis=1)
        keep = (distance < size) & (np.linalg.norm(most, axis=1) > proved)
        # Beyond half a turn there are no more poses.
        keep &= screws.home.turns(least) <= 1
        centres, halves, distance = centres[keep], halves[keep], distance[keep]
        lower = max(proved, float(distance.min(initial=size)) * (1 - _MOVED))
        if lower * _NEAR > size or judged >= _BOXES or halves.min() < _SMALLEST * size:
            return lower
        order = np.argpartition(distance, min(_PIECE, len(distance)) - 1)
        now, later = order[:_PIECE], order[_PIECE:]
        found = screws.judge(centres[now], halves[now], cube=True)
        judged += len(now)
        left = now[found.sign == 0]
        axis = found.shares[found.sign == 0].argmax(axis=1)
        half, each = halves[left], np.arange(len(left))
        half[each, axis] /= 2
        step = np.zeros_like(half)
        step[each, axis] = half[each, axis]
        centres = np.concatenate((centres[later], centres[left] - step, centres[left] + step))
        halves = np.concatenate((halves[later], half, half))


def _nearest(screws: Screws, rays: int, seed: int) -> Array | None:
    """Return the end of the shortest ray found with a proved singular pose before it, (6,)."""
    directions = _units(np.random.default_rng(seed).normal(size=(rays, 6)))
    lengths = _first(screws.home, directions, np.full(rays, np.inf), _ROUGH)
    for _ in range(_ROUNDS):
        some = np.isfinite(lengths)
        if not some.any():
            return None
        directions, lengths = directions[some], lengths[some]
        normals = _normals(screws, directions * lengths[:, None])
        tries = _units(directions + _PARTS[:, None, None] * (normals - directions))
        most = np.tile(lengths, len(_PARTS))
        found = _first(screws.home, tries.reshape(-1, 6), most, _ROUGH).reshape(tries.shape[:2])
        best, each = found.argmin(axis=0), np.arange(len(lengths))
        better = found[best, each] < lengths
        directions = np.where(better[:, None], tries[best, each], directions)
        before, lengths = lengths, np.where(better, found[best, each], lengths)
        if (lengths > before * (1 - _SETTLED)).all():
            break
    lengths = _first(screws.home, directions, lengths * (1 + _SETTLED), _FINE)
    for k in ascending(lengths, _SETTLED):
        ends = directions[k] * lengths[k] * np.array([[1 - _SEGMENT], [1 + _SEGMENT]])
        signs = screws.judge(ends, np.zeros_like(ends), cube=True).sign
        if signs[0] * signs[1] < 0:
            return np.asarray(ends[1])
    return None


def _first(home: Displacements, directions: Array, most: Array, halvings: int) -> Array:
    """Return where the determinant first changes its sign on rays up to ``most``, or infinity."""
    far = _FARTHEST * home.arrangement.length
    limit = np.minimum(_FULL / np.maximum(home.turns(directions), _FULL / far), most)
    nodes = limit[:, None] * np.geomspace(_NEAREST, 1, _NODES)
    sign = np.sign(home.determinants(np.zeros((1, 6))))[0]

    def differs(lengths: Array) -> NDArray[np.bool_]:
        s = lengths[..., None] * directions.reshape(-1, *[1] * (lengths.ndim - 1), 6)
        signs = np.sign(home.determinants(s.reshape(-1, 6))).reshape(lengths.shape)
        return np.asarray(signs * sign < 0)

    beyond = differs(nodes)
    k, each = beyond.argmax(axis=1), np.arange(len(beyond))
    high, low = nodes[each, k], np.where(k > 0, nodes[each, k - 1], 0.0)
    high = bisected(lambda middle: ~differs(middle), low, high, halvings)[1]
    return np.where(beyond.any(axis=1), high, np.inf)


def _normals(screws: Screws, s: Array) -> Array:
    """Return unit normals of the singular poses near some poses, away from home, (n, 6)."""
    u, _, vt = np.linalg.svd(screws.matrices(s))
    normals = np.einsum("nm,nmki,nk->ni", u[:, :, -1], screws.derivatives(s), vt[:, -1])
    return _units(normals * np.sign(np.sum(normals * s, axis=1, keepdims=True)))


def _units(vectors: Array) -> Array:
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(sizes > 0, sizes, 1.0)
