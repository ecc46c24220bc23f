"""Multiple poses to many digits: where Newton's method converges slowly, and how slowly says why.

Balls alone never prove a singular solution. What is said here of a point is numerical; it becomes
a statement about the platform together with its exact count (`gspcli.solver.completion`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
from flint import acb, acb_mat, ctx
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.equations import study
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.numbers.balls import cross, dot, largest, rotated
from gspcli.certification.poses.locator import Locator, dot4
from gspcli.records import dataclass

Complex = NDArray[np.complex128]

#: Bits in which multiple poses are approached; a pose of multiplicity m keeps a part 1/m of them.
_PRECISION = 1024
#: Steps, and the length of the last one, as a part of N, of coordinates of at most about one.
_STEPS, _CONVERGED = 250, 2.0**-80
#: A shorter step is one of quadratic convergence.
_QUICK = 2.0**-400
#: Convergence is linear if each of so many last steps is longer than this part of the one before.
_STEADY, _SLOW = 8, 0.2
#: A limit that is farther from where it was looked for than this part of it is another one.
_REACH = 1e-3
#: Coordinates that differ by less are the same at the end.
_SAME = 2.0**-60


@dataclass(frozen=True, eq=False)
class MultiplePose:
    """A pose at which several solutions meet, as well as can be told.

    Attributes
    ----------
    R, T, quaternion
        The pose in the frames and length units of the instance, shapes (3, 3), (3,), (4,).
    real
        Whether it is its own conjugate.
    multiplicity
        How many paths lead to it.
    is_pose
        Whether the constraints hold as they are stated: the lines of no DLL are parallel at another
        distance, where its equation holds all the same.
    """

    R: Complex
    T: Complex
    quaternion: Complex
    real: bool
    multiplicity: int
    is_pose: bool


def multiple_poses(
    locator: Locator,
    points: Complex,
    low: Complex,
    multiplicity: Sequence[int],
    sides: tuple[int, ...],
) -> Iterator[MultiplePose]:
    """Yield the different multiple poses near approximate points; simple ones are left out.

    Parameters
    ----------
    locator
        Of the instance.
    points
        Study points in the coordinates of `Locator.frames`, of any norm, shape (n, 8).
    low
        What is to be added to them, shape (n, k, 8).
    multiplicity
        How many paths end at each; those that turn out to be one pose add up.
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
            same = next((k for k, x in enumerate(limits) if _gap(limit, x) < _SAME), None)
            if same is None:
                limits.append(limit)
                paths.append(number)
            else:
                paths[same] += number
        for limit, number in zip(limits, paths, strict=True):
            # Two simple poses side by side look like a double one from far enough.
            if locator.locate_exactly(limit, sides) is not None:
                continue
            n, rotation, translation = study.motion(limit)
            real = _gap(limit, [x.conjugate() for x in limit]) < _SAME
            R = [[x / n for x in row] for row in rotation]
            T = [x / n for x in translation]
            root = dot4(limit[:4], limit[:4]).sqrt()
            yield MultiplePose(
                _middles(list(chain(*R)), real).reshape(3, 3),
                _middles([x * system.scale for x in T], real),
                _middles([x / root for x in limit[:4]], real),
                real,
                number,
                _is_pose(
                    system, [[x / n for x in row] for row in rotation], [x / n for x in translation]
                ),
            )


def _is_pose(system: BallSystem, R: list[list[acb]], T: list[acb]) -> bool:
    """Whether no parallel lines have another distance, as well as so many digits tell."""
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
    """Return where Newton's method converges to, linearly; None if it does not.

    A step covers the part 1/m of the way to a solution of multiplicity m, all the way down.
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
        # A solution at infinity has N = 0: there this never ends.
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


def _gap(a: Sequence[acb], b: Sequence[acb]) -> float:
    return float(largest([x - y for x, y in zip(a, b, strict=True)]))


def _middles(numbers: Sequence[acb], real: bool) -> Complex:
    values = np.array([complex(number.mid()) for number in numbers])
    return values.real.astype(complex) if real else values
