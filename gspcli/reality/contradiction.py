"""Why a platform has no real pose: the fewest of its constraints that contradict each other.

Subsystems are solved by minimization from many random poses: numerical evidence, which can miss a
pose, and is called so wherever it is shown. The distance of a point from a point or a line is not
smooth where it is zero; so a short one is a vector of its length whose direction is unknown.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLP, DPL, DPP
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.least_squares import Point, descend
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import (
    cross_matrix,
    rotation_from_quaternion,
    rotation_from_vector,
    unit_quaternion,
)
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Random poses that each subsystem is tried from, and the steps from each.
STARTS, _STEPS = 100, 60
#: A subsystem is solved when all values are right to this, lengths by the platform's.
_SOLVED = 1e-7
#: A distance is short when it is at most this part of the platform's length.
_SHORT = 0.3


def contradiction(arrangement: Arrangement) -> tuple[int, ...]:
    """Return constraints that no pose was found to satisfy together, none of them needless.

    Parameters
    ----------
    arrangement
        A platform without a real pose.

    Returns
    -------
    tuple of int
        Their indices: for each of them there is a pose that satisfies all the others of the
        list. Empty if a pose was found that satisfies all.
    """
    platform = arrangement.normalized
    needed = list(range(len(platform.kinds)))
    if _is_satisfied(platform, needed):
        return ()
    for index in tuple(needed):
        others = [k for k in needed if k != index]
        if others and not _is_satisfied(platform, others):
            needed = others
    return tuple(needed)


def _is_satisfied(platform: Arrangement, chosen: list[int]) -> bool:
    """Return whether some of the constraints are satisfied where the minimization ends."""
    part = replace(
        platform,
        kinds=tuple(platform.kinds[k] for k in chosen),
        **{
            name: getattr(platform, name)[chosen]
            for name in ("y", "x", "u", "v", "values", "sides")
        },
    )
    rng = np.random.default_rng(SEED)
    R = rotation_from_quaternion(unit_quaternion(rng.standard_normal((STARTS, 4))))
    T = rng.uniform(-2, 2, (STARTS, 3))
    # A distance to a plane or between lines has a sign; where it is free, some starts have each.
    free = np.array([kind.is_distance for kind in part.kinds]) & (part.signs == 0)
    signs = np.where(free, rng.choice((-1.0, 1.0), (STARTS, len(chosen))), 1.0)
    targets = part.targets * np.where(part.signs < 0, -1.0, signs)
    unsigned = np.array([kind in (DPP, DPL, DLP) for kind in part.kinds])
    targets = np.where(unsigned, np.abs(targets), targets)
    short = np.flatnonzero(unsigned & (targets[0] <= _SHORT))
    search = _Search(part, targets, short)
    start = R, T, search.directions(rng)
    ends = descend(search.equations, search.moved, start, steps=_STEPS, enough=_SOLVED**2)
    return bool(ends.squares.min() <= _SOLVED**2)


@dataclass(frozen=True, eq=False)
class _Search:
    """The equations of a minimization, where some distances are vectors of unknown direction."""

    #: The constraints.
    part: Arrangement
    #: Their values with signs, for each start, shape (n, m).
    targets: Array
    #: Which of them are vectors, s indices.
    short: NDArray[np.intp]

    @property
    def _axes(self) -> Array:
        """The direction of the line of each short distance, zero between points, shape (s, 3)."""
        return np.asarray(self.part.u[self.short] + self.part.v[self.short])

    @property
    def _turns(self) -> Array:
        """Which turns its vector can make: all, or those about the line, shape (s, 3, 3)."""
        axes = self._axes
        along = axes[:, :, None] * axes[:, None, :]
        return np.where(np.any(axes != 0, axis=1, keepdims=True)[..., None], along, np.eye(3))

    def directions(self, rng: np.random.Generator) -> Array:
        """Return random directions of the vectors, across the lines, shape (n, s, 3)."""
        across = rng.standard_normal((len(self.targets), len(self.short), 3))
        across -= (across * self._axes).sum(axis=-1, keepdims=True) * self._axes
        return np.asarray(across / np.linalg.norm(across, axis=-1, keepdims=True))

    def moved(self, step: Array, R: Array, T: Array, directions: Array) -> Point:
        """Return a pose and directions after a twist and turns."""
        turns = (self._turns @ step[:, 6:].reshape(directions.shape)[..., None])[..., 0]
        turned = (rotation_from_vector(turns) @ directions[..., None])[..., 0]
        return rotation_from_vector(step[:, :3]) @ R, T + step[:, 3:6], turned

    def equations(self, R: Array, T: Array, directions: Array) -> tuple[Array, Array]:
        """Return how far the values and vectors are from the wanted ones, and the derivatives."""
        n, s = directions.shape[:2]
        long = np.delete(np.arange(len(self.part.kinds)), self.short)
        values = (measured(self.part, R, T) - self.targets)[:, long]
        by_pose = jacobian(self.part, R, T)[:, long]
        by_turns = np.zeros((n, len(long), 3 * s))
        if s:
            vectors, slopes = self._vectors(R, T)
            wanted = self.targets[:, self.short, None]
            values = np.hstack((values, (vectors - wanted * directions).reshape(n, -1)))
            by_pose = np.concatenate((by_pose, slopes.reshape(n, -1, 6)), axis=1)
            blocks = np.zeros((n, s, 3, s, 3))
            k = np.arange(s)
            blocks[:, k, :, k] = np.swapaxes(
                wanted[..., None] * (cross_matrix(directions) @ self._turns), 0, 1
            )
            by_turns = np.concatenate((by_turns, blocks.reshape(n, 3 * s, 3 * s)), axis=1)
        return values, np.concatenate((by_pose, by_turns), axis=-1)

    def _vectors(self, R: Array, T: Array) -> tuple[Array, Array]:
        """Return the vectors of short distances, (n, s, 3), and derivatives by a twist.

        In the frame of the line: the platform's for a line there, else the base's.
        """
        r, _, arm = (part[:, self.short] for part in self.part.placed(R, T))
        lines = np.array([self.part.kinds[k] is DLP for k in self.short])[:, None, None]
        frames = np.where(lines, np.swapaxes(R, 1, 2)[:, None], np.eye(3))
        axes = self._axes
        frames = (np.eye(3) - axes[:, :, None] * axes[:, None, :]) @ frames
        about = np.where(lines[:, 0], arm - r, arm)
        slopes = np.concatenate((-frames @ cross_matrix(about), frames), axis=-1)
        return (frames @ r[..., None])[..., 0], slopes
