"""The closed form of platforms with three angles, without proofs: what the solver proves."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.three_angles import study_points


class ClosedForm(NamedTuple):
    """All poses, shapes (n, 3, 3) and (n, 3), and which are real."""

    R: np.ndarray
    T: np.ndarray
    real: np.ndarray
    account: PathAccount


def closed_form_poses(arrangement: Arrangement) -> ClosedForm | None:
    """Return all poses of a platform; None if it is not in general position."""
    given = arrangement.normalized
    found = study_points(given, given.values[given.distances][None], given.values[None])
    if not found.general[0]:
        return None
    points = found.points[0].reshape(-1, 8)
    R, T = arrangement.poses_of(points)
    count = len(points)
    account = PathAccount(expected=count, found=count, basis=Basis.COUNT)
    return ClosedForm(R, T, (points.imag == 0).all(axis=1), account)
