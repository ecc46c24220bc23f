"""The ends of all paths of one system, and the test that all are regular."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from random import Random

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.paths import PathAccount
from gspcli.continuation.quadrics import NORM, ComplexArray, FloatArray, evaluate
from gspcli.continuation.start import StartSystem
from gspcli.continuation.systems import EQUATIONS, System
from gspcli.continuation.tracker import (
    CAREFUL,
    ROUNDING,
    PathResults,
    PathStatus,
    TrackerOptions,
    track,
)
from gspcli.records import dataclass


@dataclass(frozen=True)
class EndgameOptions:
    """Settings of the Cauchy endgame.

    Near t = 1 a path is a power series in ``(1 - t)^(1/w)`` with the winding number w. After one
    round about t = 1 it arrives at another of the w paths of its cycle, after w rounds at itself.
    The end is the mean of the points on the way; in a fixed affine chart also at infinity.
    """

    samples: int = 8
    """Points on the circle, an even number. The error of their mean falls with this power of the
    radius, that of every other one with half of it: so the difference estimates the error of the
    latter, and eight are enough for the square of it to be rounding."""
    max_winding: int = 16
    """Rounds after which a path that has not returned is given up: each costs as many steps as the
    first, and a path that is given up is lost, not misjudged."""
    shrink: float = 4.0
    """By how much a circle is made smaller if its mean is not yet the end."""
    rounds: int = 15
    """How many circles are tried: from a radius of 1e-3 to 4e-12, where doubles end."""
    accuracy: float = 1e-8
    """Difference of the two means at which the larger set is accurate to rounding."""
    residual: float = 1e-12
    """Largest residual of an end; the mean over a circle around two branch points has any."""
    closure: float = 1e-5
    """A path has returned if it is nearer to where it began than this part of the extent of its
    circle: other paths of the cycle are further away by about the extent itself, ..."""
    rounding: float = 1e-10
    """... and besides this, which rounding does to a path once around."""


ENDGAME = EndgameOptions()


@dataclass(frozen=True, eq=False)
class WindingEnds:
    """The ends of k paths."""

    points: ComplexArray
    """Shape (k, 8), norm 1; NaN where unknown."""
    winding: NDArray[np.int64]
    """Winding numbers, shape (k,); 0 where no loop closed."""
    error: FloatArray
    """How much the mean of every other point differs, shape (k,); the error of `points` is far
    smaller, with eight points its square. Infinite where unknown or no solution."""


def find_ends(
    start: System,
    target: System,
    points: ComplexArray,
    radius: float,
    tracker: TrackerOptions = CAREFUL,
    options: EndgameOptions = ENDGAME,
) -> WindingEnds:
    """Find the ends of paths from their points at ``t = 1 - radius``.

    The circle is made smaller until the end from all its points and the end from every other point
    agree. They agree if no other branch point is inside the circle or near it.

    Parameters
    ----------
    start, target
        The systems at t = 0 and t = 1.
    points
        Shape (k, 8); the end of a point that is NaN stays unknown.
    radius
        The distance of the points from t = 1.
    tracker, options
        Settings.
    """
    count = len(points)
    best = WindingEnds(
        np.full((count, 8), np.nan, dtype=np.complex128),
        np.zeros(count, dtype=np.int64),
        np.full(count, np.inf),
    )
    todo = np.arange(count)
    for _ in range(options.rounds):
        ends = _circle(start, target, points, radius, tracker, options)
        better = ends.error < best.error[todo]
        for name in ("points", "winding", "error"):
            getattr(best, name)[todo[better]] = getattr(ends, name)[better]
        keep = ~(ends.error < options.accuracy)
        todo, points = todo[keep], points[keep]
        if not len(todo):
            break
        nearer = radius / options.shrink
        here, there = (start.towards(target, 1 - r) for r in (radius, nearer))
        results = track(here, there, points, options=tracker)
        arrived = results.status[0] == PathStatus.REGULAR
        todo, points, radius = todo[arrived], results.points[0][arrived], nearer
    return best


def _circle(
    start: System,
    target: System,
    points: ComplexArray,
    radius: float,
    tracker: TrackerOptions,
    options: EndgameOptions,
) -> WindingEnds:
    """Follow paths around t = 1 until they return, and average."""
    count = len(points)
    ends = np.full((count, 8), np.nan, dtype=np.complex128)
    winding = np.zeros(count, dtype=np.int64)
    error = np.full(count, np.inf)
    turns = np.arange(options.samples) / options.samples
    corners = [start.towards(target, 1 - radius * np.exp(2j * np.pi * turn)) for turn in turns]
    charts = points.conj()
    under_way = np.arange(count)
    samples = [points]
    for rounds in range(1, options.max_winding + 1):
        for here, there in pairwise([*corners, corners[0]]):
            results = track(here, there, samples[-1], options=tracker)
            # A path that fails has a NaN sample and never returns.
            arrived = (results.status[0] == PathStatus.REGULAR)[:, None]
            moved = np.where(arrived, results.points[0], np.nan)
            with np.errstate(invalid="ignore"):
                samples.append(moved / (moved * charts).sum(axis=1, keepdims=True))
        spread = np.max([np.linalg.norm(s - samples[0], axis=1) for s in samples], axis=0)
        returned = (
            np.linalg.norm(samples[-1] - samples[0], axis=1)
            < options.rounding + options.closure * spread
        )
        if returned.any():
            circle = np.array(samples[:-1])[:, returned]
            mean = circle.mean(axis=0)
            halves = np.linalg.norm(mean - circle[::2].mean(axis=0), axis=1)
            size = np.linalg.norm(mean, axis=1)
            index = under_way[returned]
            ends[index] = mean / size[:, None]
            winding[index] = rounds
            # If another branch point is inside the circle, the mean is no solution at all.
            solved = target.residuals(ends[index]) < options.residual
            error[index] = np.where(solved, halves / size, np.inf)
        going = ~returned & np.isfinite(samples[-1]).all(axis=1)
        under_way, charts = under_way[going], charts[going]
        samples = [s[going] for s in samples]
        if not len(under_way):
            break
    return WindingEnds(ends, winding, error)


SINGULAR_ERROR = 1e-7
"""Error of ends found by the endgame; solutions that are nearer to each other count as one."""
# Any vector v suffices: |z.v| is a function of the point that does not depend on its phase.
_KEY = np.exp(1j * np.arange(8) ** 2) / np.sqrt(8)


def regular_error(correction: FloatArray) -> FloatArray:
    """Return the errors of regular ends from the lengths of their last Newton corrections."""
    return 1e-13 + 100 * correction


def infinite(points: ComplexArray, error: FloatArray) -> NDArray[np.bool_]:
    """Return which points (..., 8) are at infinity: N = e.e is below a twentieth of their errors.

    The errors are larger than needed, so that two ends at one solution are never counted as two.
    With the whole error, solutions at 1e5 times the size of the platform would count as infinite.
    """
    e, error = points[..., :4], error / 20
    size = np.sqrt((e.real**2 + e.imag**2).sum(axis=-1))
    return np.asarray(np.abs((e**2).sum(axis=-1)) <= error * (size + error))


def may_coincide(
    points: ComplexArray, error: FloatArray
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Sort points (B, P, 8) by a continuous invariant; return which neighbours may be the same.

    Returns
    -------
    order, near
        Shapes (B, P) and (B, P - 1).
    """
    keys = np.abs(points @ _KEY)
    order = keys.argsort(axis=1)
    rows = np.arange(len(keys))[:, None]
    keys, error = keys[rows, order], error[rows, order]
    return order, keys[:, 1:] - keys[:, :-1] < np.maximum(error[:, 1:], error[:, :-1])


def distances(points: ComplexArray, point: ComplexArray) -> FloatArray:
    """Return the sines of the angles between points (n, 8) and a point, all of norm 1."""
    # The cosine is not used: its rounding hides angles below 1e-8.
    return np.asarray(np.linalg.norm(points - np.outer(points @ point.conj(), point), axis=1))


def clusters(points: ComplexArray, error: FloatArray) -> list[NDArray[np.intp]]:
    """Return the indices of points (n, 8), grouped by being the same within their errors (n,)."""
    order, near = may_coincide(points[None], error[None])
    groups = []
    for run in np.split(order[0], np.flatnonzero(~near[0]) + 1):
        if len(run) == 1:
            groups.append(run)
            continue
        rest = run
        while len(rest):
            first = rest[0]
            together = distances(points[rest], points[first]) < np.maximum(
                error[rest], error[first]
            )
            together[0] = True
            groups.append(np.sort(rest[together]))
            rest = rest[~together]
    return groups


@dataclass(frozen=True)
class AccountOptions:
    """Settings of the account of all paths."""

    attempts: int = 4
    """Sets of random paths that are tried until nothing is lost."""
    end_error: float = 1e-6
    """Largest difference of the two means of the endgame at which its end is known: the error of
    the end is the square of it (`EndgameOptions.samples`), far below `SINGULAR_ERROR`."""
    split: float = 1e-4
    """Two simple solutions are those that a double end stands for if they are not further from it:
    the square root of the error in the values that the endgame leaves, generously."""
    endgame: EndgameOptions = ENDGAME


ACCOUNTS = AccountOptions()
#: Options if the number of solutions is known, so that a lost path is noticed.
COUNTED = AccountOptions(attempts=2)
#: Options for systems with infinitely many solutions: only simple isolated solutions are searched
#: for, and completeness is not claimed.
BESIDE_CURVES = AccountOptions(attempts=2, endgame=EndgameOptions(max_winding=6))


@dataclass(frozen=True, eq=False)
class SolutionCurve:
    """A positive-dimensional part of the solution set that paths ended on.

    The evidence is numerical: the Jacobian matrix has a kernel, and a move along it with a
    correction on a slice arrives at other solutions.
    """

    dimension: int
    """Local dimension of the solution set at `points`."""
    points: ComplexArray
    """The ends of paths on it, shape (k, 8)."""
    motion: ComplexArray
    """Consecutive points along it, shape (m, 8); real (zero imaginary parts) if `real`."""
    real: bool
    """Whether real points were found, so that the motion is a self-motion of the mechanism."""


@dataclass(frozen=True, eq=False)
class SystemSolutions:
    """The solutions of one system, with an account of every path."""

    points: ComplexArray
    """Distinct finite isolated solutions, shape (n, 8), of norm 1 or as `scaled_to_one` says. Real
    solutions have small but in general not zero imaginary parts."""
    multiplicity: NDArray[np.int64]
    """How many paths end at each, shape (n,)."""
    condition: FloatArray
    """Condition number of each, shape (n,): Frobenius norm of the inverse of the Jacobian matrix,
    in coordinates scaled to norm 1, the equations divided by the size of the terms that cancel
    in them. A relative change of the coefficients moves the solution by about as much times
    this. Infinite where the matrix is numerically singular."""
    account: PathAccount
    """Where all paths end; as many are expected as the generic count of the structure says,
    2^products times I."""
    suspect: bool = False
    """Winding numbers and multiplicities contradict each other."""
    curves: tuple[SolutionCurve, ...] = ()
    """The positive-dimensional solution sets found."""

    @property
    def singular(self) -> NDArray[np.bool_]:
        """Whether the Jacobian matrix at each is numerically singular, shape (n,)."""
        return ~np.isfinite(self.condition)

    @property
    def doubts(self) -> tuple[int, bool]:
        """How many paths are lost, and whether counts contradict each other: less is better."""
        return self.account.lost, self.suspect

    def scaled_to_one(self, scale: float) -> SystemSolutions:
        """Return all points scaled to N = e.e = 1, where `scale` was the unit of f.

        The sign is such that the largest entry of e has a positive real part.
        """
        curves = (
            replace(
                curve,
                points=_scaled_to_one(curve.points, scale),
                motion=_scaled_to_one(curve.motion, scale),
            )
            for curve in self.curves
        )
        return replace(self, points=_scaled_to_one(self.points, scale), curves=tuple(curves))


def _scaled_to_one(points: ComplexArray, scale: float) -> ComplexArray:
    points = points / np.sqrt((points[:, :4] ** 2).sum(axis=1, keepdims=True))
    points[:, 4:] *= scale
    largest = points[np.arange(len(points)), np.abs(points[:, :4]).argmax(axis=1)]
    return points * np.where(largest.real < 0, -1.0, 1.0)[:, None]


@lru_cache(maxsize=256)
def random_start(start: StartSystem, seed: int, attempt: int) -> System:
    """Return the start system with its factors multiplied by random phases: another path."""
    # The import of NumPy's generator takes longer than the solution of most systems.
    draws = Random(f"{seed} {attempt}")
    turns = np.array([[draws.random() for _ in range(EQUATIONS)] for _ in range(2)])
    g, h = np.exp(2j * np.pi * turns)
    return start.system.scaled(g, h)


def all_regular(results: PathResults) -> NDArray[np.bool_]:
    """Return for which targets (B,) all paths end at distinct finite regular solutions."""
    error = regular_error(results.correction)
    good = np.asarray((results.is_simple & ~infinite(results.points, error)).all(axis=1))
    near = may_coincide(results.points, error)[1].any(axis=1)
    for i in np.flatnonzero(good & near):
        good[i] = len(clusters(results.points[i], error[i])) == results.points.shape[1]
    return good


def regular_ends(results: PathResults, i: int) -> SystemSolutions:
    """Return the ends of the paths to a target for which `all_regular` holds."""
    count = results.points.shape[1]
    return SystemSolutions(
        results.points[i],
        np.ones(count, dtype=np.int64),
        results.condition[i],
        PathAccount(expected=count, found=count),
    )


#: Largest ratio of second to first order of a simple solution, for estimates (`ROUNDING`).
_LIMIT = 0.1
#: The number of changes of the equations by rounding that are tried.
_CHANGES = 8


def simple(target: System, points: ComplexArray) -> NDArray[np.bool_]:
    """Return which points (P, 8) of one system are simple solutions."""
    return np.asarray(nonlinearity(target, points) < _LIMIT)


def nonlinearity(target: System, points: ComplexArray) -> FloatArray:
    """Return the ratio of second to first order at points (P, 8); infinite or NaN if singular.

    The units of e and f are their sizes, so that a solution far away, whose e is small, does not
    count as singular.
    """
    unit = np.repeat(
        np.stack([np.linalg.norm(part, axis=1) for part in (points[:, :4], points[:, 4:])], 1),
        4,
        axis=1,
    )
    jacobian = target.jacobians(points)
    size = np.linalg.norm(jacobian * unit[:, None, :], axis=2)
    # A row is added for the scale of the point.
    patch = (points / np.where(unit > 0, unit, 1.0)).conj()[:, None, :]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rows = jacobian * unit[:, None, :] / size[:, :, None]
        inverse = _inverse(np.concatenate([rows, patch], axis=1))[:, :, :-1] / size[:, None, :]
        values = target.values(points)[:, None, :] + _changes(target, points)
        # The first-order move for each change, (P, changes, 8).
        first = values @ inverse.swapaxes(1, 2)
        second = np.stack(
            [target.bends(points, first[:, k] * unit) for k in range(_CHANGES)], axis=1
        )
        bent = np.linalg.norm(second @ inverse.swapaxes(1, 2), axis=2)
        return np.asarray((bent / np.linalg.norm(first, axis=2)).max(axis=1))


def _inverse(matrices: ComplexArray) -> ComplexArray:
    """Return the inverses (P, 8, 8); infinite for singular matrices."""
    try:
        return np.asarray(np.linalg.inv(matrices))
    except np.linalg.LinAlgError:
        if len(matrices) == 1:
            return np.full(matrices.shape, np.inf, dtype=np.complex128)
        return np.concatenate([_inverse(matrix[None]) for matrix in matrices])


def _changes(target: System, points: ComplexArray) -> ComplexArray:
    """Return changes of the values (P, changes, 7) of the size of rounding in the coefficients."""
    monomials = [np.linalg.norm(part, axis=1) for part in (points[:, :4], points[:, 4:])]
    e, f = monomials
    parts = (slice(0, 10), slice(10, 26), slice(26, 27))

    def terms(quadrics: ComplexArray) -> FloatArray:
        sizes = np.stack([np.linalg.norm(quadrics[:, part], axis=1) for part in parts])
        return np.asarray(np.stack([e * e, e * f, f * f], axis=1) @ sizes)

    coefficients = target.coefficients
    first = terms(coefficients.g)
    g, h = (np.abs(evaluate(quadrics, points)) for quadrics in coefficients[:2])
    n = np.abs(evaluate(NORM[None], points)) * (e * e)[:, None]
    product = first * h + terms(coefficients.h) * g + np.abs(coefficients.tau) * n
    rows = np.where(target.structure.is_product, product, first)
    size = np.concatenate([(e * f)[:, None], rows], axis=1)
    rng = np.random.default_rng(EQUATIONS)
    phases = np.exp(2j * np.pi * rng.random((_CHANGES, 1 + EQUATIONS)))
    return np.asarray(ROUNDING * size[:, None, :] * phases)
