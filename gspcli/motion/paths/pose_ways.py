"""Straight ways in position and angles, proved regular and within the limits.

On a straight way the position of the pivot and the three angles change linearly, as a controller of
six axes moves them. The box of parameters between its ends is divided by the grid of
`PoseBoxes.judge`; the cells on the diagonal contain the whole way. So if all of them keep the
limits and contain no singular pose, so does the way. Cells that are not proved are halved.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import euler_from_rotation
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import apply
from gspcli.motion.workspace.pose_boxes import NEGATIVE, PARAMETERS, PoseBoxes
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: A way is divided at first until no angle of a piece changes by more, in radians.
_TURN = 0.5
#: Most cells of a piece that may be open, and most times that a piece is halved besides.
_MOST_OPEN, _MOST_CUTS = 256, 4
#: Half the width of the box about a pose whose sign is asked for, relative to the sizes.
_NEAR = 1e-9


@dataclass(frozen=True)
class WayProof:
    """What is proved of a straight way.

    Attributes
    ----------
    sign
        The sign of the determinant of the Jacobian matrix on the whole way, 1 or -1; 0 if the way
        is not proved.
    cells
        How many cells are proved.
    reason
        Why the way is not proved, in words; empty if it is.
    violated
        Whether it is proved that some pose of the way is singular or violates a limit.
    left
        The conditions that are not proved on some part of the way, as bits of `PoseBoxes`.
    shared
        Whether rods that share a motor are not parallel on the way.
    """

    sign: int
    cells: int
    reason: str = ""
    violated: bool = False
    left: int = 0
    shared: bool = False


class PoseWays:
    """Straight ways in position and angles of one platform.

    Parameters
    ----------
    instance
        The platform with its limits.
    pivot
        The point of the platform whose position is a parameter, shape (3,); the centre of its
        points if None.
    sequence
        The order of the axes of the angles, as in `gspcli.geometry.euler`.
    limits
        Whether ranges and cones must be kept, too.
    working_modes
        The signs of the gains of cranks and slides, shape (6,). If None they are those of the
        stated home, or, without one, those of the unmoved platform.
    """

    def __init__(
        self,
        instance: Instance,
        *,
        pivot: ArrayLike | None = None,
        sequence: str = "ZYX",
        limits: bool = True,
        working_modes: NDArray[np.int64] | None = None,
    ) -> None:
        self.instance = instance
        arrangement = Arrangement.of(instance)
        self.pivot = np.asarray(arrangement.platform_centre if pivot is None else pivot, float)
        self.boxes = PoseBoxes(
            instance, np.eye(3), np.zeros(3), pivot=self.pivot, sequence=sequence, regular=True,
            working_modes=working_modes,
        )  # fmt: skip
        #: The machine, in the working modes of all ways.
        self.machine = self.boxes.machine
        self._conditions = self.boxes.conditions if limits else self.boxes.reached
        #: Sizes of the six parameters: lengths of the platform, and radians.
        self.sizes = np.array([arrangement.length] * 3 + [1.0] * 3)

    def arrangement(self, R: Array, T: Array) -> Arrangement:
        """Return the platform at poses: points of cranks and slides are where they reach them."""
        return self.machine.placed(R, T)

    def _is_apart(self, begin: Array, end: Array) -> str:
        """Return why rods that share a drive may not agree on a way, or nothing."""
        if not self.machine.shared:
            return ""
        free = [name for name, a, b in zip(PARAMETERS, begin, end, strict=True) if a != b]
        try:
            self.boxes.refuse_shared(self.poses(begin)[0], free)
        except ArgumentError:
            return "rods that share a drive are not parallel"
        return ""

    def parameters(self, R: ArrayLike, T: ArrayLike) -> Array:
        """Return the parameters of poses, ``(..., 3, 3), (..., 3) -> (..., 6)``.

        The middle one of the angles is between -pi/2 and pi/2, see `euler_from_rotation`.
        """
        R, T = np.asarray(R, float), np.asarray(T, float)
        place = T + apply(R, np.broadcast_to(self.pivot, T.shape))
        return np.concatenate((place, euler_from_rotation(self.boxes.sequence, R)), axis=-1)

    def poses(self, parameters: Array) -> tuple[Array, Array]:
        """Return the poses (R, T) of parameters, ``(..., 6) -> (..., 3, 3), (..., 3)``."""
        return self.boxes.poses(parameters)

    def nearest(self, parameters: Array, goals: Array) -> Array:
        """Return the parameters of the same poses as goals that are nearest to some, (..., 6).

        Angles may differ by whole turns; and each rotation has two triples of angles, one with the
        middle angle beyond a right angle.
        """
        middle = PARAMETERS.index(self.boxes.middle)
        other = goals.copy()
        other[..., 3:] += np.pi
        other[..., middle] = np.pi - goals[..., middle]
        found = []
        for one in (goals, other):
            turned = one.copy()
            away = one[..., 3:] - parameters[..., 3:]
            turned[..., 3:] -= 2 * np.pi * np.round(away / (2 * np.pi))
            found.append(turned)
        far = [np.abs(one - parameters)[..., 3:].sum(axis=-1) for one in found]
        return np.where((far[0] <= far[1])[..., None], found[0], found[1])

    def continued(self, R: Array, T: Array) -> Array:
        """Return the parameters of rows of poses, each continued from the one before, (r, 6)."""
        found = self.parameters(R, T)
        for k in range(1, len(found)):
            found[k] = self.nearest(found[k - 1], found[k])
        return found

    def prove(self, begin: Array, end: Array) -> WayProof:
        """Prove the straight way between two sets of parameters, shape (6,) each."""
        reason = self._is_apart(begin, end)
        if reason:
            return WayProof(0, 0, reason, shared=True)
        steps = max(1, int(np.ceil(np.abs(end - begin)[3:].max() / _TURN)))
        knots = begin + (end - begin) * (np.arange(steps + 1) / steps)[:, None]
        knots[-1] = end
        # The last piece is the first one of the stack.
        pieces = [(knots[k], knots[k + 1], 0) for k in range(steps)][::-1]
        sign = cells = 0
        while pieces:
            first, last, cuts = pieces.pop()
            found = self._piece(first, last)
            if not found.sign:
                if found.violated or cuts == _MOST_CUTS:
                    return found
                half = (first + last) / 2
                pieces += [(half, last, cuts + 1), (first, half, cuts + 1)]
                continue
            if sign * found.sign < 0:
                return WayProof(0, cells, "singularity", violated=True)
            sign, cells = found.sign, cells + found.cells
        return WayProof(sign, cells)

    def _piece(self, begin: Array, end: Array) -> WayProof:
        """Prove a piece on one grid."""
        way = end - begin
        free = np.flatnonzero(way).tolist()
        if not free:
            return self.at(begin)
        bounds = np.stack((np.minimum(begin, end), np.maximum(begin, end)), axis=1)
        bits = min(64 // len(free), 20)
        top = np.uint64(64 // len(free))
        mask = np.uint64((1 << int(top)) - 1) if len(free) > 1 else ~np.uint64(0)
        index, left = np.zeros(1, np.uint64), np.array([self._conditions])
        signs: set[int] = set()
        cells = 0
        for level in range(bits + 1):
            last = np.uint64((1 << level) - 1)
            keys = np.zeros(len(index), np.uint64)
            for place, k in enumerate(free):
                keys |= (index if way[k] > 0 else last - index) << np.uint64(place * int(top))
            found = self.boxes.judge(bounds, free, level, keys, left, split=False)
            cells += len(found.inside)
            signs.update((found.inside_signs & NEGATIVE).tolist())
            if len(found.inside) + len(found.open) < len(index):
                return WayProof(0, cells, "limit", violated=True)
            if len(signs) > 1:
                return WayProof(0, cells, "singularity", violated=True)
            if not len(found.open):
                return WayProof(-1 if signs.pop() else 1, cells)
            if len(found.open) > _MOST_OPEN:
                break
            index = found.open & mask
            if way[free[0]] < 0:
                index = last - index
            left = found.open_left & ~NEGATIVE
            index, left = np.concatenate((2 * index, 2 * index + 1)), np.concatenate((left, left))
        open_ = int(left[0] & ~NEGATIVE)
        return WayProof(0, cells, ", ".join(self.boxes.names(open_)), left=open_)

    def contains(self, low: Array, high: Array, cuts: int = _MOST_CUTS) -> WayProof:
        """Prove that all poses of a box are regular and within the limits, shape (6,) each.

        Then each way within the box is proved, straight or not. The box is halved so often.
        """
        boxes, sign, cells = [(low, high, cuts)], 0, 0
        one = np.zeros(1, np.uint64)
        while boxes:
            low, high, left = boxes.pop()
            bounds = np.stack((low, high), axis=1)
            free = np.flatnonzero(low < high).tolist()
            found = self.boxes.judge(
                bounds, free, 0, one, np.array([self._conditions]), split=False
            )
            if len(found.inside):
                here = -1 if found.inside_signs[0] & NEGATIVE else 1
                if sign * here < 0:
                    return WayProof(0, cells, "singularity", violated=True)
                sign, cells = here, cells + 1
                continue
            if not len(found.open) or not left:
                names = self.boxes.names(int(found.open_left[0])) if len(found.open) else ["limit"]
                return WayProof(0, cells, ", ".join(names))
            axis = int(((high - low) / self.sizes).argmax())
            first, second = high.copy(), low.copy()
            first[axis] = second[axis] = (low[axis] + high[axis]) / 2
            boxes += [(low, first, left - 1), (second, high, left - 1)]
        return WayProof(sign, cells)

    def at(self, parameters: Array) -> WayProof:
        """Prove that a pose is regular and within the limits, with poses very near to it."""
        half = _NEAR * (self.sizes + np.abs(parameters))
        if self.machine.shared:
            half[3:] = 0
        reason = self._is_apart(parameters - half, parameters + half)
        if reason:
            return WayProof(0, 0, reason, shared=True)
        return self.contains(parameters - half, parameters + half, cuts=0)
