"""All poses of a platform with three distances and three angles (Algorithm 6.6).

First the rotations, then for each the translations (`gspcli.geometry.three_angles`). Nothing is
assumed about the position of the frames or the primitives, but that everything is in general
position: by Bezout's theorem there are no other poses then. What is not in general position is not
answered here.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby, islice

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.types import MAX_ANGLES
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import canonical_sign, pose_from_study, unit_quaternion
from gspcli.geometry.three_angles import study_points
from gspcli.solver.pose_set import PoseSet

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: How many sets of values are solved together.
_BATCH = 64


def solve_closed_forms(arrangement: Arrangement, values: Array) -> Iterator[PoseSet | None]:
    """Yield all poses of one geometry with each of many sets of values, in order.

    Parameters
    ----------
    arrangement
        The geometry and the sides; its own values are not used.
    values
        Shape (b, 6), in the units of the instance.

    Yields
    ------
    None for sets of values with which something is not in general position.

    Raises
    ------
    ValueError
        If the arrangement has not three angles.
    """
    if len(arrangement.angles) != MAX_ANGLES:
        message = f"the closed form needs three angles, not {len(arrangement.angles)}"
        raise ValueError(message)
    distances = arrangement.distances
    # A distance of zero has one sign: it changes the structure.
    for _, group in groupby(values, key=lambda row: tuple(row[distances] == 0)):
        while batch := list(islice(group, _BATCH)):
            yield from _solve_batch(arrangement, np.array(batch))


def _solve_batch(arrangement: Arrangement, values: Array) -> Iterator[PoseSet | None]:
    """Yield the poses for sets of values in which the same distances are zero."""
    length = arrangement.length_with(values)
    given = arrangement.with_values(values[0]).in_units_of(length)
    found = study_points(given, values[:, arrangement.distances] / length, values)
    signs = np.where(arrangement.sided, found.signs, 1.0).repeat(found.points.shape[2], axis=0)
    number = len(signs)
    points = found.points[found.general].reshape(-1, 8)
    R, T = pose_from_study(points[:, :4], points[:, 4:])
    quaternions = canonical_sign(unit_quaternion(points[:, :4]))
    T, real = arrangement.restored(R, T, length), (points.imag == 0).all(axis=1)
    end = 0
    for is_general in found.general.tolist():
        if not is_general:
            yield None
            continue
        begin, end = end, end + number
        here = slice(begin, end)
        yield PoseSet(
            quaternions=quaternions[here],
            R=R[here],
            T=T[here],
            real=real[here],
            certified=np.zeros(number, bool),
            multiplicity=np.ones(number, int),
            motions=(),
            account=PathAccount(expected=number, found=number, basis=Basis.COUNT),
            signs=signs,
        )
