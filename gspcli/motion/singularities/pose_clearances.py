"""Clearance of poses: the distance to poses whose six screws are dependent.

Distances of poses are root mean squares of the displacements of the platform's points, the
extrinsic metric of G. Nawratil, Singularity distance for parallel manipulators of Stewart Gough
type, Advances in Mechanism and Machine Science (2019).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from gspcli.motion.singularities.displacements import Displacements
from gspcli.motion.singularities.screw_forms import ScrewForms
from gspcli.records import dataclass

Array = NDArray[np.float64]

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
#: Boxes judged at a time and in all; the ratio of the bounds that suffices; the largest one.
_PIECE, _BOXES, _NEAR, _WIDEST = 512, 60_000, 1.1, 64
_DOWN, _UP = 1 - 2.0**-30, 1 + 2.0**-30


@dataclass(frozen=True, eq=False)
class PoseClearance:
    """Bounds of the distance of one pose from singular poses, in length units.

    Attributes
    ----------
    lower
        Proved lower bound: no nearer pose is singular.
    upper
        Proved upper bound: a pose nearer than this is singular; infinite if none was found.
    R, T
        A pose within a billionth of `upper` from a singular one, shapes (3, 3) and (3,), or None.
    """

    lower: float
    upper: float
    R: Array | None
    T: Array | None

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
    forms = ScrewForms(home)
    middle = np.zeros((len(home.T), 6))
    low, high = np.zeros(len(middle)), np.full(len(middle), home.farthest)
    for _ in range(_HALVINGS):
        # Clearances can have any order of magnitude; it is found first.
        size = np.where(low > 0, (low + high) / 2, high / 4)
        half = np.broadcast_to(size[:, None], middle.shape)
        good = forms.judge(middle, half, cube=False).sign != 0
        low, high = np.where(good, size, low), np.where(good, high, size)
        if (high <= low * _CLOSE).all():
            break
    return low * _DOWN


def pose_clearance(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    points: ArrayLike | None = None,
    refine: bool = False,
    seed: int = SEED,
) -> PoseClearance:
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
    forms = ScrewForms(home)
    lower = float(_balls(home)[0])
    if lower == 0:
        return PoseClearance(0.0, np.inf, None, None)
    found = _nearest(forms, _MANY_RAYS if refine else _RAYS, seed)
    upper = np.inf if found is None else float(np.linalg.norm(found)) * _UP
    if refine:
        lower = _divided(forms, lower, min(upper, _WIDEST * lower))
    if found is None:
        return PoseClearance(lower, np.inf, None, None)
    at, shift = home.poses(found[None])
    return PoseClearance(lower, upper, at[0], shift[0])


def _divided(forms: ScrewForms, proved: float, size: float) -> float:
    """Return a better lower bound, at most a size: boxes not proved to be free are halved."""
    centres, halves = np.zeros((1, 6)), np.full((1, 6), size)
    judged = 0
    while True:
        least = np.maximum(np.abs(centres) - halves, 0.0)
        most = np.abs(centres) + halves
        distance: Array = np.linalg.norm(least, axis=1)
        keep = (distance < size) & (np.linalg.norm(most, axis=1) > proved)
        # Beyond half a turn there are no more poses.
        keep &= forms.home.turns(least) <= 1
        centres, halves, distance = centres[keep], halves[keep], distance[keep]
        lower = max(proved, float(distance.min(initial=size)) * _DOWN)
        if lower * _NEAR > size or judged >= _BOXES:
            return lower
        order = np.argpartition(distance, min(_PIECE, len(distance)) - 1)
        now, later = order[:_PIECE], order[_PIECE:]
        found = forms.judge(centres[now], halves[now], cube=True)
        judged += len(now)
        left = now[found.sign == 0]
        axis = found.shares[found.sign == 0].argmax(axis=1)
        half, each = halves[left], np.arange(len(left))
        half[each, axis] /= 2
        step = np.zeros_like(half)
        step[each, axis] = half[each, axis]
        centres = np.concatenate((centres[later], centres[left] - step, centres[left] + step))
        halves = np.concatenate((halves[later], half, half))


def _nearest(forms: ScrewForms, rays: int, seed: int) -> Array | None:
    """Return the end of the shortest ray found with a proved singular pose before it, (6,)."""
    directions = _units(np.random.default_rng(seed).normal(size=(rays, 6)))
    lengths = _first(forms.home, directions, np.full(rays, np.inf), _ROUGH)
    for _ in range(_ROUNDS):
        some = np.isfinite(lengths)
        if not some.any():
            return None
        directions, lengths = directions[some], lengths[some]
        normals = _normals(forms, directions * lengths[:, None])
        tries = _units(directions + _PARTS[:, None, None] * (normals - directions))
        most = np.tile(lengths, len(_PARTS))
        found = _first(forms.home, tries.reshape(-1, 6), most, _ROUGH).reshape(tries.shape[:2])
        best, each = found.argmin(axis=0), np.arange(len(lengths))
        better = found[best, each] < lengths
        directions = np.where(better[:, None], tries[best, each], directions)
        before, lengths = lengths, np.where(better, found[best, each], lengths)
        if (lengths > before * (1 - _SETTLED)).all():
            break
    lengths = _first(forms.home, directions, lengths * (1 + _SETTLED), _FINE)
    for k in np.argsort(lengths):
        ends = directions[k] * lengths[k] * np.array([[1 - _SEGMENT], [1 + _SEGMENT]])
        signs = forms.judge(ends, np.zeros_like(ends), cube=True).sign
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
    for _ in range(halvings):
        middle = (low + high) / 2
        there = differs(middle)
        low, high = np.where(there, low, middle), np.where(there, middle, high)
    return np.where(beyond.any(axis=1), high, np.inf)


def _normals(forms: ScrewForms, s: Array) -> Array:
    """Return unit normals of the singular poses near some poses, away from home, (n, 6)."""
    u, _, vt = np.linalg.svd(forms.matrices(s))
    normals = np.einsum("nm,nmki,nk->ni", u[:, :, -1], forms.derivatives(s), vt[:, -1])
    return _units(normals * np.sign(np.sum(normals * s, axis=1, keepdims=True)))


def _units(vectors: Array) -> Array:
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(sizes > 0, sizes, 1.0)
