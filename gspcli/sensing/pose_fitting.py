"""Least-squares poses of more than six measurements, each mode that fits, and the outlier."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import GspError
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance
from gspcli.geometry.least_squares import Ends, descend
from gspcli.geometry.quaternions import rotation_from_vector, vector_from_rotation
from gspcli.sensing.choices import candidates_of, next_choice, platform_of
from gspcli.sensing.fitted_poses import FittedPose, PoseFit, Without
from gspcli.sensing.mode_readings import parsed_readings
from gspcli.sensing.pose_numbers import PoseNumbers, pose_sizes, value_sigmas
from gspcli.sensing.sensor_kinds import SensorReading
from gspcli.solver import SolveResult, solve

Array = NDArray[np.float64]

#: At most this many choices of six measurements are solved.
CHOICES = 8
#: Descents take at most this many steps; short ones, which choose measurements, this many.
_STEPS, _SHORT = 100, 10
#: Newton's method then takes this many steps, with central differences of this much.
_POLISH, _APART = 4, 1e-4
#: Sums of squares that differ by less than this part, or than this, are equal: rounding decides.
_EQUAL = 1e-6
#: Minima nearer than this, in radians and typical lengths, are one.
_SAME = 1e-5
#: Of the outlier the studentised residual is at least this part of the largest; the fit without it
#: starts at this many poses. Others with which data are not a thousand times less likely are alike.
_SUSPECT, _NEAREST = 0.7, 12
_LIKELIER = 2 * math.log(1000)
#: Numbers of which the others leave less than this part open are not checked by them.
_UNCHECKED = 1e-6


class Minima(NamedTuple):
    """Poses of least squares, the best first: (n, 3, 3), (n, 3), and their sums of squares."""

    R: Array
    T: Array
    cost: Array


def fit_poses(
    instance: Instance,
    readings: Sequence[str | SensorReading] | None = None,
    *,
    sigma: Mapping[str, float] | None = None,
) -> PoseFit:
    """Return the poses that fit the six values and further readings best, by least squares.

    Every minimum of the sum of squares that is reached from a pose of six of the measurements is
    returned; several choices of six are solved. It is not proved that there are no others.

    Parameters
    ----------
    instance
        The platform; its values are measurements, too.
    readings
        Texts such as ``"leg P7 B7 = 212.4 ± 0.1"`` (`gspcli.sensing.sensor_kinds`); those of the
        instance if None.
    sigma
        Standard deviations of the values by ``value``, ``angle`` or the number of a constraint, in
        the units of the instance; else the tolerances of the constraints.

    Raises
    ------
    ArgumentError
        If a reading or deviation is wrong or missing.
    GspError
        If no choice of six measurements has a pose.

    Examples
    --------
    >>> import gspcli
    >>> m2 = gspcli.example("rubin-m2")
    >>> fit = gspcli.fit_poses(m2, ["leg P1 B2 = 2.913 ± 0.002"], sigma={"value": 1e-5})
    >>> [pose.fits for pose in fit.poses][:2]
    [True, False]
    """
    checked(instance)
    given = instance.readings if readings is None else readings
    parsed = tuple(parsed_readings(instance, given, repeated=True))
    numbers = PoseNumbers(instance, parsed, value_sigmas(instance, sigma or {}))
    starts, solved = _starts(numbers)
    minima = _minima(numbers, *starts)
    poses = tuple(
        _pose(numbers, R, T, float(cost))
        for R, T, cost in zip(minima.R, minima.T, minima.cost, strict=True)
    )
    without = None
    if poses and not poses[0].fits:
        without = _without(numbers, Minima(*starts, np.zeros(0)), poses[0])
    return PoseFit(numbers, poses, solved, len(starts[0]), without)


def _starts(numbers: PoseNumbers) -> tuple[tuple[Array, Array], tuple[tuple[int, ...], ...]]:
    """Return the poses of choices of six measurements, and the choices that were solved.

    Of poses that are not real the nearest real one is a start, too: with errors of measurement two
    real poses become complex.
    """
    instance = numbers.instance
    candidates = candidates_of(instance, numbers.readings)
    size = pose_sizes(instance)
    used, chosen = np.zeros(len(candidates), int), candidates[:6]
    R, T, solved = np.zeros((0, 3, 3)), np.zeros((0, 3)), []
    for _ in range(CHOICES):
        platform = platform_of(instance, chosen)
        owners = tuple(sorted({one.owner for one in chosen}))
        if platform is not None:
            try:
                result = solve(platform)
            except GspError:
                result = None
            if result is not None and len(result.R):
                more = _real_starts(result)
                R, T = np.concatenate((R, more[0])), np.concatenate((T, more[1]))
                solved.append(owners)
        for k, one in enumerate(candidates):
            used[k] += one in chosen
        if not len(R) or len(candidates) == 6:
            if len(candidates) == 6:
                break
            at = np.eye(3), np.zeros(3)
        else:
            # Where the best pose so far is.
            at = _near_best(numbers, *more, size)
        following = next_choice(
            candidates, numbers.slopes(at[0][None], at[1][None])[0] * size, used
        )
        if following is None or all(used[candidates.index(one)] > 1 for one in following):
            break
        chosen = following
    if not len(R):
        message = (
            "no choice of six of the measurements has a pose: are they in the units of SPEC, and "
            "at one pose?"
        )
        raise GspError(message)
    return (R, T), tuple(solved)


def _real_starts(result: SolveResult) -> tuple[Array, Array]:
    """Return the real poses of a result, and the nearest ones to those that are not real."""
    U, _, V = np.linalg.svd(result.R.real)
    sign = np.linalg.det(U @ V)
    U[..., 2] *= sign[:, None]
    return U @ V, result.T.real.copy()


def _near_best(numbers: PoseNumbers, R: Array, T: Array, size: Array) -> tuple[Array, Array]:
    """Return where the best of some short descents ends."""
    ends = _descended(numbers, R, T, size, _SHORT)
    best = _in_order(ends.squares)[0]
    return ends.point[0][best], ends.point[1][best]


def _minima(numbers: PoseNumbers, R: Array, T: Array) -> Minima:
    """Return the distinct ends of descents from poses, the best first."""
    size = pose_sizes(numbers.instance)
    ends = _descended(numbers, R, T, size)
    (R, T), cost = ends.point, ends.squares
    kept: list[int] = []
    for k in _in_order(cost):
        if not ends.ended[k] or not np.isfinite(cost[k]):
            continue
        turns = np.linalg.norm(vector_from_rotation(R[kept] @ R[k].T), axis=-1) if kept else []
        moves = np.linalg.norm(T[kept] - T[k], axis=-1) / size[-1] if kept else []
        if not any(a < _SAME and b < _SAME for a, b in zip(turns, moves, strict=True)):
            kept.append(k)
    R, T, cost = _polished(numbers, R[kept], T[kept], size)
    order = _in_order(cost)
    return Minima(R[order], T[order], cost[order])


def _in_order(cost: Array) -> list[int]:
    """Return the indices of sums of squares, the smallest first, equal ones as they were given."""
    order: list[int] = []
    least, first = -math.inf, 0
    for k in np.argsort(cost, kind="stable").tolist():
        if not cost[k] - least <= _EQUAL * (1 + cost[k]):
            least, first = float(cost[k]), len(order)
        order[first:] = sorted([*order[first:], k])
    return order


def _polished(numbers: PoseNumbers, R: Array, T: Array, size: Array) -> tuple[Array, Array, Array]:
    """Return minima to the last digits, by Newton's method, and their sums of squares.

    Descents end where the sum of squares does not fall: there half of the digits of a pose are
    right. A pose that is not a minimum of its own (not isolated, or a saddle) is returned
    unchanged.
    """

    def gradient(R: Array, T: Array) -> Array:
        slopes = numbers.slopes(R, T) * size
        return np.asarray(np.einsum("nmk,nm->nk", slopes, numbers.residuals(R, T)))

    def moved(R: Array, T: Array, step: NDArray[Any]) -> tuple[Array, Array]:
        return rotation_from_vector(step[:, :3]) @ R, T + step[:, 3:] * size[3:]

    start = R, T
    if not len(R):
        return R, T, np.zeros(0)
    with np.errstate(all="ignore"):
        columns = []
        for unit in _APART * np.eye(6):
            ends = [gradient(*moved(R, T, sign * np.tile(unit, (len(R), 1)))) for sign in (-1, 1)]
            columns.append((ends[0] - ends[1]) / (2 * _APART))
        curvature = np.stack(columns, axis=-1)
        curvature = np.nan_to_num((curvature + np.swapaxes(curvature, 1, 2)) / 2)
        values = np.linalg.eigvalsh(curvature)
        minimum = values[:, 0] > _UNCHECKED * values[:, -1]
        curvature[~minimum] = np.eye(6)
        for _ in range(_POLISH):
            R, T = moved(R, T, np.linalg.solve(curvature, gradient(R, T)[..., None])[..., 0])
        kept = minimum & (np.linalg.norm(T - start[1], axis=1) < _SAME * size[-1])
        kept &= np.linalg.norm(R - start[0], axis=(1, 2)) < _SAME
    R = np.where(kept[:, None, None], R, start[0])
    T = np.where(kept[:, None], T, start[1])
    return R, T, (numbers.residuals(R, T) ** 2).sum(axis=1)


def _descended(numbers: PoseNumbers, R: Array, T: Array, size: Array, steps: int = _STEPS) -> Ends:
    """Return where descents from poses end, with steps in radians and typical lengths."""

    def equations(R: Array, T: Array) -> tuple[Array, Array]:
        # A residual is the reading less the value at the pose.
        return numbers.residuals(R, T), -numbers.slopes(R, T) * size

    def moved(step: Array, R: Array, T: Array) -> tuple[Array, Array]:
        return rotation_from_vector(step[:, :3]) @ R, T + step[:, 3:] * size[3:]

    # Residuals are in standard deviations.
    return descend(equations, moved, (R, T), steps=steps, noise=1.0)


def _pose(numbers: PoseNumbers, R: Array, T: Array, cost: float) -> FittedPose:
    """Return a minimum with its covariance and residuals."""
    size = pose_sizes(numbers.instance)
    residual = numbers.residuals(R, T)
    slopes = numbers.slopes(R[None], T[None])[0] * size
    U, s, V = np.linalg.svd(slopes, full_matrices=False)
    gain: Array = np.asarray(V, float)
    told = len(s) == 6 and s[-1] > 1e-9 * s[0]
    covariance: Array = np.full((6, 6), np.inf)
    if told:
        covariance = (gain.T / np.asarray(s, float) ** 2) @ gain * np.outer(size, size)
    hat = (U[:, s > 1e-9 * s[0]] ** 2).sum(axis=1)
    open_part = 1 - hat
    checked_ones = open_part > _UNCHECKED
    studentised = np.where(
        checked_ones, residual / np.sqrt(np.where(checked_ones, open_part, 1.0)), np.nan
    )
    freedom = len(residual) - int((s > 1e-9 * s[0]).sum())
    return FittedPose(R, T, cost, freedom, covariance, residual, studentised, numbers.owners)


def _without(numbers: PoseNumbers, starts: Minima, best: FittedPose) -> Without | None:
    """Return the fit without the measurement that agrees least; None if that tells nothing.

    Measurements with large studentised residuals are left out in turn, and the one is named
    without which chi-squared is least. Others of which the data are not a thousand times less
    likely cannot be distinguished from it: with one number more than six none can.
    """
    sizes = best.measurement_sizes
    if best.freedom < 1 or not np.isfinite(sizes).any():
        return None
    suspects = np.flatnonzero(sizes >= _SUSPECT * np.nanmax(sizes)).tolist()
    fits = []
    for k in suspects:
        rest = replace(numbers, left_out=frozenset((k,)))
        if len(rest.owners) < 6:
            continue
        # The outlier has drawn all minima to it: poses of six others are starts, too.
        near = np.argsort((rest.residuals(starts.R, starts.T) ** 2).sum(axis=1))[:_NEAREST]
        R = np.concatenate((best.R[None], starts.R[near]))
        T = np.concatenate((best.T[None], starts.T[near]))
        minima = _minima(rest, R, T)
        if len(minima.R):
            pose = _pose(rest, minima.R[0], minima.T[0], float(minima.cost[0]))
            fits.append((k, pose))
    if not fits:
        return None
    order = _in_order(np.array([pose.chi_squared for _, pose in fits]))
    (worst, pose), *others = (fits[k] for k in order)
    most = pose.chi_squared + _LIKELIER
    return Without(worst, tuple(k for k, one in others if one.chi_squared < most), pose)
