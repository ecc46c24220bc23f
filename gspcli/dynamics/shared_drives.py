"""Drives that several rods share, such as the carriages of a linear delta."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.dynamics.arrays import RowError
from gspcli.dynamics.drives import DrivesAtPoses
from gspcli.dynamics.mass_model import MassModel
from gspcli.dynamics.moved_points import Knees
from gspcli.geometry.quaternions import (
    apply,
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
)

Array = NDArray[np.float64]

#: Rates that differ by more than this part of the largest one are not those of one drive.
_SAME = 1e-6


def check_shared(drives: DrivesAtPoses, twists: Array) -> None:
    """Refuse motions, shape (n, 6), at which the rods of one drive ask for different rates.

    Raises
    ------
    RowError
        Naming the rods.
    """
    sharing = drives.model.sharing
    if sharing is None or drives.points is None:
        return
    rates = apply(drives.pulls, twists)
    means = rates @ sharing / sharing.sum(axis=0)
    apart = np.abs(rates - means @ sharing.T)
    wrong = apart > _SAME * np.abs(rates).max(axis=-1, keepdims=True)
    if wrong.any():
        row, k = np.argwhere(wrong)[0].tolist()
        known = drives.points.drives
        rods = (np.flatnonzero(known.index == known.index[k]) + 1).tolist()
        name = known.names[known.index[k]]
        message = (
            f"rods {' and '.join(map(str, rods))} ask for different speeds of {name}: the platform "
            "cannot move so"
        )
        raise RowError(row, message)


def closed(model: MassModel, state: Array, knees: Knees | None) -> Array:
    """Return a state (T, quaternion, ...) in metres at which rods of one drive agree again.

    Integration lets them drift apart by rounding errors and by its own.
    """
    known, sharing = model.drives, model.sharing
    assert known is not None
    assert sharing is not None
    state = state.copy()
    R, T = rotation_from_quaternion(state[3:7]), state[:3]
    for _ in range(2):
        wanted = known.wanted(R, T / model.metre, knees) * np.where(
            known.driven, model.drive_metres, 0.0
        )
        means = wanted @ sharing / sharing.sum(axis=0) @ sharing.T
        pulls = DrivesAtPoses(model, R[None], T[None], means[None]).pulls[0]
        twist = np.linalg.solve(pulls, means - wanted)
        R, T = rotation_from_vector(twist[:3]) @ R, T + twist[3:]
    state[:3], state[3:7] = T, quaternion_from_rotation(R)
    return state
