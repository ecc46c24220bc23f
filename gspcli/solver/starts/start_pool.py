"""Solved systems of one geometry near many sets of values: from the nearest paths are shorter.

The start of a geometry (`geometry_start`) is about the mean of all sets, far enough from real
values that nothing about it is special. Members of a pool have the values of some of the sets, and
smaller imaginary parts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.reduced_homotopy import ReducedEnds, ReducedHomotopy
from gspcli.continuation.tracker import PathStatus
from gspcli.continuation.tracker_options import FROM_START, SHORT_STEPS, TrackerOptions
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Sets of values for each member: one costs about as much as ten sets cost less by it, and no
#: more than so many are of use.
_SETS_A_MEMBER = 32
_LEAST, _MOST = 4, 128
#: The imaginary parts of a member as parts of those of the start.
_NEARER = 0.3
#: Solutions whose Study points have a cosine nearer to one are not told apart.
_SAME = 1e-10


@dataclass(frozen=True, eq=False)
class StartPool:
    """Solved systems of one geometry.

    Attributes
    ----------
    homotopy
        The equations.
    parameters
        What they are linear in, of each member, shape (s, 6).
    points
        The solutions in the coordinates of the equations, shape (s, n, d).
    unit
        In which differences of each parameter are measured, shape (6,).
    """

    homotopy: ReducedHomotopy
    parameters: ComplexArray
    points: ComplexArray
    unit: Array

    def about(self, parameters: Array, jobs: int) -> StartPool:
        """Return a pool for sets of real parameters (b, 6), solved from the first member of this.

        The members are among the sets; this pool if there are too few of those.
        """
        size = min(len(parameters) // _SETS_A_MEMBER, _MOST)
        if size < _LEAST:
            return self
        chosen = np.linspace(0, len(parameters) - 1, size).astype(np.intp)
        members = parameters[chosen] + 1j * _NEARER * self.parameters[0].imag
        ends = self._follow(members, np.zeros(size, np.int32), FROM_START, jobs)
        good = np.flatnonzero(_all_different(ends))
        deviation = parameters.std(axis=0)
        unit = np.where(deviation > 0, deviation, 1.0)
        if not len(good):
            return self
        return StartPool(self.homotopy, members[good], ends.points[good], unit)

    def follow(self, parameters: Array, options: TrackerOptions, jobs: int) -> ComplexArray:
        """Return the ends of paths from the nearest member to each set of parameters (b, 6).

        Study points of any norm, shape (b, n, 8), not a number where a path is lost.
        """
        ends = self._follow(parameters.astype(complex), self._nearest(parameters), options, jobs)
        # What is no end must not pass for one.
        ends.study[ends.status != PathStatus.REGULAR] = np.nan
        return ends.study

    def solutions_at(self, parameters: ComplexArray) -> ComplexArray | None:
        """Return the Study points (n, 8) to which all of the first member lead.

        None if a path to these parameters (6,), complex numbers, is lost, or two of them meet.
        """
        ends = self._follow(parameters[None], np.zeros(1, np.int32), SHORT_STEPS, 1)
        return ends.study[0] if _all_different(ends)[0] else None

    def _follow(
        self, parameters: ComplexArray, start: NDArray[np.int32], options: TrackerOptions, jobs: int
    ) -> ReducedEnds:
        given = self.parameters, self.points, start, parameters
        return self.homotopy.track(*given, options=options, jobs=jobs)

    def _nearest(self, parameters: Array) -> NDArray[np.int32]:
        """Return which member is nearest to each set of parameters (b, 6)."""
        if len(self.parameters) == 1:
            return np.zeros(len(parameters), np.int32)
        members, sets = self.parameters.real / self.unit, parameters / self.unit
        # Of the squared distances the squares of the sets are the same for all members.
        far = (members**2).sum(axis=1) - 2 * sets @ members.T
        nearest: NDArray[np.int32] = far.argmin(axis=1).astype(np.int32)
        return nearest


def _all_different(ends: ReducedEnds) -> NDArray[np.bool_]:
    """Return to which targets (b,) all paths lead, to different solutions."""
    # Paths that fail may leave no numbers: these are different from none.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        points = ends.study / np.linalg.norm(ends.study, axis=-1, keepdims=True)
        overlaps = np.abs(points.conj() @ points.swapaxes(1, 2))
    overlaps[:, np.eye(points.shape[1], dtype=bool)] = 0
    regular = (ends.status == PathStatus.REGULAR).all(axis=1)
    return np.asarray(regular & (overlaps < 1 - _SAME).all(axis=(1, 2)))
