"""Multiple poses with many digits; the speed of Newton's method gives the multiplicity.

Balls alone never prove a singular solution. The results here are numerical; together with the exact
count they become statements about the platform (`gspcli.solver.by_count`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
from flint import acb, acb_mat, ctx
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.counting import by_points
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.local_frames import StudyFrames
from gspcli.certification.equations.statement import Statement
from gspcli.certification.numbers.balls import cross, dot, largest, rotated
from gspcli.certification.poses.locator import Located, Locator, dot4
from gspcli.geometry import study
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Line
from gspcli.geometry.tolerances import NEARLY_PARALLEL_SINE
from gspcli.records import dataclass

Complex = NDArray[np.complex128]
#: Bits with which lines are compared with parallel ones.
_BITS = 512


def where_parallel(
    instance: Instance, lines: Sequence[int], R: ArrayLike, T: ArrayLike
) -> NDArray[np.bool_]:
    """Return at which simple poses of the platform with points exactly these lines are parallel.

    At such a pose balls of 512 bits separate all other lines from parallel ones, and do not
    separate these. This proves these to be parallel only if the number of such poses is known to be
    the same.

    Parameters
    ----------
    instance
        The platform with lines, on one choice of sides.
    lines
        Indices of the DLL in question.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).

    Returns
    -------
    numpy.ndarray
        Shape (n,).
    """
    same = by_points(instance, lines)
    locator = Locator(same, StudyFrames.of(Arrangement.of(same)))
    located = [
        _located(locator, rotation, translation)
        for rotation, translation in zip(np.asarray(R), np.asarray(T), strict=True)
    ]
    with ctx.workprec(_BITS):
        given = Locator(instance, locator.frames).system(_BITS).statements
        found = [pose is not None and _are_parallel(given, lines, pose) for pose in located]
    return np.array(found, np.bool_)


def _located(
    locator: Locator, R: NDArray[np.complex128], T: NDArray[np.complex128]
) -> Located | None:
    rotation = [[acb(x) for x in row] for row in R.tolist()]
    start = locator.point_of_pose(rotation, [acb(x) for x in T.tolist()], _BITS)
    sides = (0,) * len(locator.instance.constraints)
    found = locator.locate_exactly(start, sides, _BITS)
    return found if isinstance(found, Located) else None


def _are_parallel(given: Sequence[Statement], lines: Sequence[int], pose: Located) -> bool:
    for index, line in enumerate(given):
        if line.kind is DLL:
            u = rotated(pose.pose.rotation, [acb(x) for x in line.u])
            across = cross(u, [acb(x) for x in line.v])
            if all(x.contains(0) for x in across) != (index in lines):
                return False
    return True


def nearly_parallel(instance: Instance, R: Complex) -> NDArray[np.bool_]:
    """Return which DLL have nearly parallel lines at poses, shape (n, 6).

    For parallel lines the equation holds at any distance, so the constraint has to be measured.
    """
    nearly = np.zeros((len(R), len(instance.constraints)), bool)
    for k, constraint in enumerate(instance.constraints):
        line, other = constraint.platform, constraint.base
        if constraint.kind is DLL and isinstance(line, Line) and isinstance(other, Line):
            normal = np.cross(R @ line.unit, other.unit)
            sizes = 1 + np.abs(R).max(axis=(1, 2)) ** 2
            nearly[:, k] = np.abs((normal**2).sum(axis=1)) <= NEARLY_PARALLEL_SINE**2 * sizes
    return nearly


#: Working precision in bits; a pose of multiplicity m is accurate to a part 1/m of them.
_PRECISION = 1024
#: The most steps, and the length of the last one as a part of N.
_STEPS, _CONVERGED = 250, 2.0**-80
#: A shorter step is one of quadratic convergence.
_QUICK = 2.0**-400
#: Convergence is linear if each of this many last steps is longer than this part of the one before.
_STEADY, _SLOW = 8, 0.2
#: A limit at a greater relative distance from the start is another solution.
_REACH = 1e-3
#: Coordinates of limits that differ by less are equal.
_SAME = 2.0**-60


@dataclass(frozen=True, eq=False)
class MultiplePose:
    """A pose at which several solutions meet, by numerical evidence."""

    #: The pose in the frames and length units of the instance, shapes (3, 3), (3,), (4,).
    R: Complex
    T: Complex
    quaternion: Complex
    #: Whether it is its own conjugate.
    real: bool
    #: The number of paths that lead to it.
    multiplicity: int
    #: Whether the stated constraints hold: no DLL has parallel lines at another distance, for which
    #: its equation holds, too.
    is_pose: bool


def multiple_poses(
    locator: Locator,
    points: Complex,
    low: Complex,
    multiplicity: Sequence[int],
    sides: tuple[int, ...],
) -> Iterator[MultiplePose]:
    """Yield the different multiple poses near approximate points, without simple ones.

    Parameters
    ----------
    locator
        The locator of the instance.
    points
        Study points in the coordinates of `Locator.frames`, of any norm, shape (n, 8).
    low
        Doubles to add to the points, shape (n, k, 8).
    multiplicity
        The number of paths that end at each; numbers of equal poses are added.
    sides
        For each constraint the index of its equation.
    """
    limits: list[list[acb]] = []
    paths: list[int] = []
    with ctx.workprec(_PRECISION):
        system = locator.system(_PRECISION)
        for start, more, number in zip(points, low, multiplicity, strict=True):
            limit = _limit(system, locator.in_frames(start, more), sides)
            if limit is None:
                continue
            same = next((k for k, x in enumerate(limits) if _are_same(limit, x)), None)
            if same is None:
                limits.append(limit)
                paths.append(number)
            else:
                paths[same] += number
        for limit, number in zip(limits, paths, strict=True):
            # Two simple poses near each other look like a double pose with few digits.
            if locator.locate_exactly(limit, sides) is not None:
                continue
            n, rotation, translation = study.motion(limit)
            real = _gap(limit, [x.conjugate() for x in limit]) < _SAME
            R = [[x / n for x in row] for row in rotation]
            T = [x / n for x in translation]
            root = dot4(limit[:4], limit[:4]).sqrt()
            yield MultiplePose(
                _middles(list(chain(*R)), real).reshape(3, 3),
                _middles([x * system.scale for x in T], real, float(system.scale)),
                _middles([x / root for x in limit[:4]], real),
                real,
                number,
                _is_pose(
                    system, [[x / n for x in row] for row in rotation], [x / n for x in translation]
                ),
            )


def _is_pose(system: BallSystem, R: list[list[acb]], T: list[acb]) -> bool:
    """Whether no parallel lines have another distance, by the digits of the pose."""
    for given in system.statements:
        if given.kind is not DLL:
            continue
        u, v, a, b = ([acb(x) for x in vector] for vector in (given.u, given.v, given.a, given.b))
        u, a = rotated(R, u), rotated(R, a)
        normal = cross(u, v)
        # Complex directions may span an isotropic plane without being parallel.
        if largest(normal) < _SAME * largest(u) * largest(v):
            across = cross([x + t - y for x, t, y in zip(a, T, b, strict=True)], v)
            if abs(dot(across, across) / dot(v, v) - given.value**2) > _SAME:
                return False
    return True


def _limit(system: BallSystem, start: list[acb], sides: tuple[int, ...]) -> list[acb] | None:
    """Return the limit of Newton's method if it converges linearly, else None.

    Each step covers the part 1/m of the distance to a solution of multiplicity m.
    """
    patch = max(range(4), key=lambda k: float(abs(start[k])))
    point = [(x / start[patch]).mid() for x in start]
    first, last, slow = point, 0.0, 0
    for _ in range(_STEPS):
        step = _step(system, point, patch, sides)
        if step is None:
            return None
        length = float(largest(step))
        point = [(x - dx).mid() for x, dx in zip(point, step, strict=True)]
        slow = slow + 1 if length > _SLOW * last > 0 else 0
        # At a solution at infinity, N = 0, the condition is never met.
        if slow >= _STEADY and length < _CONVERGED * min(1.0, float(abs(dot4(point, point)))):
            return point if _gap(point, first) < _REACH * float(largest(first)) else None
        if length < _QUICK:
            return None
        last = length
    return None


def _step(
    system: BallSystem, point: list[acb], patch: int, sides: tuple[int, ...]
) -> list[acb] | None:
    values, jacobian = system.at(point, sides)
    rows = [[x.mid() for x in row] for row in jacobian.tolist()]
    for row in rows:
        del row[patch]
    try:
        step = (acb_mat(rows).mid().inv().mid() * values.mid()).entries()
    except ZeroDivisionError:
        return None
    step.insert(patch, acb(0))
    return [x.mid() for x in step] if largest(step).is_finite() else None


def _are_same(a: Sequence[acb], b: Sequence[acb]) -> bool:
    """Whether two limits are one point; of equal coordinates of e another may be 1 in each."""
    patch = max(range(4), key=lambda k: float(abs(a[k])))
    if not abs(b[patch]) > _SAME:
        return False
    return _gap([x / a[patch] for x in a], [x / b[patch] for x in b]) < _SAME


def _gap(a: Sequence[acb], b: Sequence[acb]) -> float:
    return float(largest([x - y for x, y in zip(a, b, strict=True)]))


def _middles(numbers: Sequence[acb], real: bool, scale: float = 1.0) -> Complex:
    """Return numbers of about a scale as doubles; what is only the error of a limit is zero."""
    values = np.array([complex(number.mid()) for number in numbers])
    parts = values.view(np.float64)
    parts[np.abs(parts) < _SAME * max(scale, float(np.abs(parts).max()))] = 0.0
    return values.real.astype(complex) if real else values
