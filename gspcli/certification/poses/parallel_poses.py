"""The poses of a platform at which exactly certain lines are parallel, by many digits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import acb, ctx
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.counting import by_points
from gspcli.certification.equations.frames import StudyFrames
from gspcli.certification.equations.statement import Statement
from gspcli.certification.numbers.balls import cross, rotated
from gspcli.certification.poses.locator import Located, Locator
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Line
from gspcli.geometry.tolerances import NEARLY_PARALLEL_SINE

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
