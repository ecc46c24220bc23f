"""Clearance: the change of the values within which an assembly mode meets no singularity.

The distance of two sets of values is the largest difference of a value, divided by its weight. A
clearance of r means that all values together may change by up to r times their weights, in any
combination.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.certification.poses.parallel_poses import nearly_parallel
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.ranges import value_range
from gspcli.motion.following.branch_follower import MovingPlatform, Stop, apart
from gspcli.motion.following.row_instances import over_rows
from gspcli.motion.following.tracks import Event
from gspcli.motion.following.trajectories import track_from
from gspcli.motion.poses.inverse_kinematics import value_slopes, values_at
from gspcli.motion.singularities.neighbourhoods import Neighbourhood
from gspcli.progress import Progress, silent
from gspcli.records import dataclass
from gspcli.ties import definite_signs, definite_vectors, first_smallest

Array = NDArray[np.float64]

#: Halvings of the interval in which the clearance is sought, after a first estimate.
_HALVINGS = 7
_REFINEMENTS = 7
#: Straight lines of values are followed up to this many weights.
_FARTHEST = 1e3
#: The part of the way to the end of a range up to which a mode is followed.
_SHORT = 1 - 1e-6
#: First directions of the search for the nearest singularity, and rounds that improve each.
_STARTS, _MANY_STARTS, _ROUNDS = 6, 30, 6


def clearances(
    instance: Instance, R: ArrayLike, T: ArrayLike, *, weights: ArrayLike | None = None
) -> Array:
    """Return proved lower bounds of the clearance of poses, shape (n,); zero if there is no proof.

    For all values within the clearance the pose has exactly one continuation, which is regular.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    weights
        The unit of each value's changes, in the units of the instance, shape (6,); ones if None.
    """
    R, T = np.asarray(R, float), np.asarray(T, float)
    # The distance of parallel lines jumps when they tilt.
    parallel = nearly_parallel(instance, R.astype(complex)).any(axis=1)
    if parallel.any():
        proved = np.zeros(len(R))
        if not parallel.all():
            proved[~parallel] = clearances(instance, R[~parallel], T[~parallel], weights=weights)
        return proved
    platform = MovingPlatform(apart(instance))
    widths = platform.internal(_weights(weights))
    values = platform.internal(values_at(instance, R, T))
    near = Neighbourhood(platform, platform.points(R, T), values)
    scale = _estimate(near, widths)
    low, high = np.zeros_like(scale), scale
    for k in range(_HALVINGS):
        middle = high * 0.9 if k == 0 else (low + high) / 2
        good = near.box(middle[:, None] * widths).measure < 1
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return low


def range_weights(instance: Instance) -> Array | None:
    """Return half the ranges of the values, shape (6,); None unless each constraint has one."""
    limits = [constraint.limits for constraint in instance.constraints]
    spans = [(high.value - low.value) / 2 for low, high in (pair for pair in limits if pair)]
    return np.array(spans) if len(spans) == len(limits) and min(spans) > 0 else None


def _weights(given: ArrayLike | None) -> Array:
    weights = np.ones(6) if given is None else np.asarray(given, float)
    if weights.shape != (6,) or not (np.isfinite(weights) & (weights > 0)).all():
        message = f"found {weights.tolist()}, expected six positive numbers"
        raise ArgumentError(message, "weights")
    return weights


def _estimate(near: Neighbourhood, widths: Array) -> Array:
    """Return about twice the largest changes that can be proved, shape (n,)."""
    size = np.full(len(near.points), 1e-6)
    for _ in range(3):
        box = near.box(size[:, None] * widths)
        # q grows with the size, the other term with its square root.
        a, b = box.q / size, box.root / np.sqrt(size)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            size = (2 / (b + np.sqrt(b**2 + 4 * a))) ** 2
        size = np.where(np.isfinite(size), np.clip(size, 1e-15, 1e6), 1e-15)
    return 1.5 * size


@dataclass(frozen=True, eq=False)
class Clearance:
    """Bounds of the clearance of one mode.

    Attributes
    ----------
    lower
        Proved lower bound: nothing singular is nearer.
    upper
        The distance of a fold of this mode, or of the end of the range of a value; infinite if
        neither was found.
    values
        The values there, shape (6,), or None.
    fold
        The fold, the last point of the straight line of values to there; None if there is none.
    end
        The index of the constraint whose value is at an end of its range, such as a distance of
        zero; None for a fold.
    """

    lower: float
    upper: float
    values: Array | None
    fold: Event | None
    end: int | None = None

    @property
    def ratio(self) -> float:
        """Upper bound by lower bound."""
        return self.upper / self.lower if self.lower > 0 else np.inf


def clearance(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    refine: bool = False,
    seed: int = SEED,
) -> Clearance:
    """Return proved bounds of the clearance of a pose, as `each_clearance` of several."""
    R, T = np.asarray(R, float)[None], np.asarray(T, float)[None]
    (found,) = each_clearance(instance, R, T, weights=weights, refine=refine, seed=seed)
    return found


def each_clearance(
    instance: Instance,
    R: Array,
    T: Array,
    *,
    weights: ArrayLike | None = None,
    refine: bool = False,
    seed: int = SEED,
    progress: Progress = silent,
) -> list[Clearance]:
    """Return proved bounds of the clearance of each of some poses.

    For the upper bound the mode is followed along straight lines of values until it ends in a
    fold, or until a value reaches the end of its range, such as a distance of zero. At the nearest
    fold the change of the values has the signs of the left null vector of the Jacobian matrix. So
    each fold gives a better direction; several first directions are tried.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    weights
        As for `clearances`.
    refine
        Whether to prove the box in 64 parts and to try more directions, which takes some seconds
        a pose.
    seed
        The seed of the random directions.
    progress
        Receives each pose that is done.

    Notes
    -----
    One call of the kernel follows the lines of all poses. Only the modes that do not reach the end
    of a line are followed one by one.
    """
    if not len(R):
        return []
    units = _weights(weights)
    lowers = clearances(instance, R, T, weights=units)
    starts = _MANY_STARTS if refine else _STARTS
    searches = [
        _search(instance, R[k], T[k], units, float(lowers[k]), starts, seed) for k in range(len(R))
    ]
    found: dict[int, Clearance] = {}
    # What is sent to each search next: None first, then whether the mode reaches the end of a line.
    answers: dict[int, bool | None] = dict.fromkeys(range(len(R)))
    steps = iter(progress(range(len(R)), total=len(R), label="poses"))
    while answers:
        lines: dict[int, Array] = {}
        for k, answer in answers.items():
            try:
                lines[k] = searches[k].send(answer)
            except StopIteration as end:
                found[k] = end.value
                if refine:
                    found[k] = _refined(instance, R[k], T[k], units, found[k])
                next(steps, None)
        answers = dict(zip(lines, _reach_ends(instance, R, T, lines), strict=True))
    next(steps, None)
    return [found[k] for k in range(len(R))]


def _reach_ends(
    instance: Instance, R: Array, T: Array, lines: dict[int, Array]
) -> list[bool | None]:
    """Return whether modes reach the ends of lines of values, by the indices of their poses."""
    if not lines:
        return []
    ends, chosen = np.array(list(lines.values())), list(lines)
    platform = MovingPlatform(over_rows(instance, ends.reshape(-1, 6)))
    followed = platform.follow(
        platform.internal(ends), np.arange(len(ends)), platform.points(R[chosen], T[chosen])
    )
    return [bool(stop == Stop.END) for stop in followed.stop]


def _refined(instance: Instance, R: Array, T: Array, units: Array, found: Clearance) -> Clearance:
    if not np.isfinite(found.upper) or found.lower == 0:
        return found
    values = values_at(instance, R, T)
    better = _in_octants(instance, values, R, T, units, found.lower, found.upper)
    return replace(found, lower=better)


def _search(
    instance: Instance, R: Array, T: Array, units: Array, lower: float, starts: int, seed: int
) -> Generator[Array, bool | None, Clearance]:
    """Look for the nearest fold of one pose; return it with the bounds.

    The generator yields lines of values (2, 6), and receives whether the mode reaches the end.
    """
    values = values_at(instance, R, T)
    best = _range_end(instance, values, units, lower)
    room = best.upper * _SHORT
    if lower == 0:
        # No branch leads away from a singular pose.
        return best
    seen: set[tuple[int, ...]] = set()
    for signs in _directions(instance, R, T, units, starts, seed):
        for _ in range(_ROUNDS):
            key = tuple(signs.astype(int).tolist())
            if key in seen:
                break
            seen.add(key)
            most = min(best.upper, room)
            first = min(most, max(8 * lower, 1e-6)) if best.fold is None else most
            found = yield from _along(instance, values, R, T, signs * units, first, most)
            if found is None:
                break
            size, fold, following = found
            if size < best.upper:
                best = Clearance(lower, size, values + size * signs * units, fold)
            signs = following
    return best


def _in_octants(
    instance: Instance, values: Array, R: Array, T: Array, units: Array, low: float, high: float
) -> float:
    """Return a better lower bound: the box is proved as 64 boxes with a corner at the values.

    The mode is followed with proof to the centre of each small box, within this box. A small box
    has one regular solution for all its values, and it is the mode at the centre. Regular solutions
    that agree at one point agree along the whole way, so it is the mode at the common corner, too.
    For the same reason small boxes have the same solutions on common faces.
    """
    platform = MovingPlatform(apart(instance))
    signs = np.array(list(product((1.0, -1.0), repeat=6)))
    widths = platform.internal(units)
    centre = platform.internal(values)
    pose = platform.points(R[None], T[None])
    for _ in range(_REFINEMENTS):
        size = (low + high) / 2
        ends = np.stack(
            (np.broadcast_to(centre, signs.shape), centre + size / 2 * signs * widths), axis=1
        )
        followed = platform.follow(ends, np.arange(len(signs)), np.repeat(pose, len(signs), axis=0))
        proved = bool((followed.stop == Stop.END).all())
        if proved:
            near = Neighbourhood(platform, followed.points[:, -1], ends[:, 1])
            proved = bool((near.box(size / 2 * widths * (1 + 1e-12)).measure < 1).all())
        low, high = (size, high) if proved else (low, size)
    return low


def _directions(
    instance: Instance, R: Array, T: Array, units: Array, starts: int, seed: int
) -> Iterator[Array]:
    """Yield corners of the box of values to go to first, vectors of signs, shape (6,)."""
    arrangement = Arrangement.of(instance)
    rows = value_slopes(arrangement, R, T) / units[:, None]
    rows[:, :3] /= arrangement.length
    left, sizes, _ = np.linalg.svd(rows)
    left = definite_vectors(sizes, left)
    rng = np.random.default_rng(seed)
    for k in range(starts):
        vector = left[:, -1 - k // 2] if k < 6 else rng.normal(size=6)
        sense = 1 if k % 2 else -1
        yield definite_signs(vector) * sense
        # Where an entry is zero, as for symmetric platforms, the other sign is tried, too.
        yield -definite_signs(-vector) * sense


def _range_end(instance: Instance, values: Array, units: Array, lower: float) -> Clearance:
    """Return the largest change of values: up to the nearest end of the range of a kind."""
    ranges = [value_range(row.kind, instance.units.angle) for row in instance.constraints]
    ends = np.array(ranges)
    rooms = np.abs(ends - values[:, None]) / units[:, None]
    k, which = np.unravel_index(int(first_smallest(rooms.ravel())), rooms.shape)
    size = float(rooms[k, which])
    if np.isinf(size):
        return Clearance(lower, np.inf, None, None)
    there = values.copy()
    there[k] = ends[k, which]
    return Clearance(lower, size, there, None, int(k))


def _along(
    instance: Instance, values: Array, R: Array, T: Array, step: Array, reach: float, most: float
) -> Generator[Array, bool | None, tuple[float, Event, Array] | None]:
    """Return the distance of the fold on a line of values, the fold, and the next signs to try.

    The search goes up to ``reach`` first, and then up to ``most`` if nothing was found. It yields
    lines of values as `_search` does.
    """
    while True:
        ends = np.stack((values, values + reach * step))
        reaches_end = yield ends
        if not reaches_end:
            found = track_from(instance, ends, R[None], T[None])
            if found.events:
                break
        if reach == most or reach > _FARTHEST:
            return None
        reach = min(8 * reach, most)
    (event,) = found.events
    if event.kind != "fold":
        return None
    rows = value_slopes(Arrangement.of(instance), event.R, event.T)
    normal = np.linalg.svd(rows)[0][:, -1]
    outward = normal * np.sign(normal @ step)
    return (event.high - 1) * reach, event, definite_signs(outward)
