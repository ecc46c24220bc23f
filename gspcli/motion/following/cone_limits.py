"""The parts of a trajectory on which legs keep their cones, proved between the rows, too.

A mode is followed once more, and each proved segment is kept: on it the pose is within a radius of
a chord of twists, along which the platform turns and moves at constant rates. The height of a leg
along the axis of its cone, less the length times the cosine of the cone, is enclosed by its value
in the middle of a part, its slope there and a bound of its second derivative. If its sign is not
proved, the part is halved. Where the radius is too large for this, the part is followed again in
shorter steps from its beginning, where the pose is known as well as at the end of the one before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.coordinates import Coordinate
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import JointCone, joint_cones
from gspcli.geometry.primitives import Point
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion.following.followed_rows import ROUNDING, RowFollower, Segments
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: The shortest part of a step between rows in the search for the place at which a cone is left.
_SHORTEST = 2.0**-36
#: A part that is followed again is divided into so many.
_STEPS = 8
_OUTWARD = 1 + 2.0**-30


@dataclass(frozen=True)
class Stretch:
    """A part of the path of a mode.

    Attributes
    ----------
    begin, end
        Rows, counted from 0, with fractions.
    states
        For each cone: 1 if it is proved to be kept all along, -1 if it is proved to be violated all
        along, else 0.
    """

    begin: float
    end: float
    states: tuple[int, ...]


class _Point(NamedTuple):
    """The end of a leg in its body, as its drive moves it: derivatives by the part of the step."""

    place: Array
    rate: Array
    bend: float


class _Part(NamedTuple):
    """A part of the step between two rows, on one of the segments.

    At the beginning of the segment the pose is within `near` of the chord; 0 stands for the pose
    that Newton's method finds there.
    """

    segments: Segments
    k: int
    begin: float
    end: float
    near: float


class ConeProofs:
    """The cones of an instance along one trajectory.

    Parameters
    ----------
    instance
        The platform with the cones. A value of zero is zero at all rows.
    chosen
        The drives that move.
    rows
        Values and numbers of drives, shape (r, 6 + d); distances not negative.

    Raises
    ------
    ArgumentError
        As for `RowFollower`.
    """

    def __init__(self, instance: Instance, chosen: tuple[Coordinate, ...], rows: Array) -> None:
        self.instance, self.rows = instance, rows
        self.cones = joint_cones(instance)
        self.follower = RowFollower(instance, chosen)

    def stretches(self, R: Array, T: Array) -> list[list[Stretch]]:
        """Return the proved stretches of modes, in order; there may be gaps between them.

        Parameters
        ----------
        R, T
            Their poses at the rows, shapes (m, r, 3, 3) and (m, r, 3), NaN from where a mode has
            ended.
        """
        return [self._of_mode(*mode) for mode in zip(R, T, strict=True)]

    def _of_mode(self, R: Array, T: Array) -> list[Stretch]:
        found: list[Stretch] = []
        row, end = 0, int(np.isfinite(T[:, 0]).sum())
        # After a failed proof the next one begins at the row after it.
        while row < min(end, len(self.rows) - 1):
            mode = self.follower.follow(self.rows[row:], R[row], T[row], keep=True)
            for k in range(len(mode.segments.row)):
                found += self._judged(row, mode.segments, k)
            row += max(mode.reached, 0) + 1
        return found

    def _judged(self, first: int, segments: Segments, k: int) -> list[Stretch]:
        """Return the states on a segment, by time; its rows are counted from one of them."""
        row = first + int(segments.row[k])
        near = float(segments.error[k - 1]) + ROUNDING if k else 0.0
        queue = [_Part(segments, k, float(segments.begin[k]), float(segments.end[k]), near)]
        found = []
        while queue:
            part = queue.pop()
            states, change, lost, least = self._states(row, part)
            open_ = states == 0
            if part.end - part.begin > _SHORTEST and (open_ & (change > least / 4)).any():
                finer = []
                if (open_ & (lost > change)).any():
                    finer = self._again(row, part)
                middle = (part.begin + part.end) / 2
                halves = [part._replace(end=middle), part._replace(begin=middle)]
                queue += (finer or halves)[::-1]
                continue
            begin, end = row + part.begin, row + part.end
            found.append(Stretch(begin, end, tuple(states.tolist())))
        return found

    def _again(self, row: int, part: _Part) -> list[_Part]:
        """Return a part in shorter segments; nothing if these are not nearer to their poses."""
        segments, k, f = part.segments, part.k, self.follower
        begin, end = float(segments.begin[k]), float(segments.end[k])
        R, T = self._chord(part, begin)
        place = T * f.reach + f.origin - R @ f.middle
        share = (begin + (end - begin) * np.arange(_STEPS + 1) / _STEPS)[:, None]
        rows = self.rows[row] + (self.rows[row + 1] - self.rows[row]) * share
        rows[:, :6][:, f.driven] = self.rows[row, :6][f.driven]
        mode = f.follow(rows, R, place, part.near * f.reach, keep=True)
        finer = mode.segments
        if mode.reached < _STEPS or not (finer.radius < 0.5 * segments.radius[k]).all():
            return []
        low, high = (
            begin + (end - begin) * (finer.row + x) / _STEPS for x in (finer.begin, finer.end)
        )
        # The ends of neighbours agree, and those of the whole segment stay.
        low[1:] = high[:-1]
        low[0], high[-1] = begin, end
        finer = replace(finer, begin=low, end=high)
        near = np.concatenate(([part.near], finer.error[:-1] + ROUNDING))
        return [
            _Part(
                finer,
                j,
                max(part.begin, float(low[j])),
                min(part.end, float(high[j])),
                float(near[j]),
            )
            for j in range(len(low))
            if low[j] < part.end and high[j] > part.begin
        ]

    @staticmethod
    def _chord(part: _Part, at: float) -> tuple[Array, Array]:
        segments, k = part.segments, part.k
        s = (at - segments.begin[k]) / (segments.end[k] - segments.begin[k])
        R, T = segments.chord(np.array([k]), np.array([s]))
        return R[0], T[0]

    def _states(self, row: int, part: _Part) -> tuple[NDArray[np.int64], Array, Array, Array]:
        """Return the states of the cones on a part, (n,).

        Also bounds of how much the quantities change along the chord, of what the radius about it
        adds, and of the part of the latter that shorter steps do not reduce.
        """
        segments, k, begin, end, _ = part
        s, half = (begin + end) / 2, (end - begin) / 2
        R, T = self._chord(part, s)
        d = segments.d[k] / (segments.end[k] - segments.begin[k])
        first, last = self.follower.in_units(self.rows[row : row + 2])
        numbers = first + s * (last - first), last - first
        found = [
            self._enclosed(joint, (R, T), d, numbers, half, segments, k) for joint in self.cones
        ]
        middle, change, lost, least = np.array(found).reshape(-1, 4).T
        wide = (change + lost) * _OUTWARD
        states = np.where(middle > wide, 1, np.where(middle < -wide, -1, 0))
        return states, change, lost, least

    def _enclosed(
        self,
        joint: JointCone,
        pose: tuple[Array, Array],
        d: Array,
        numbers: tuple[Array, Array],
        half: float,
        segments: Segments,
        k: int,
    ) -> tuple[float, float, float, float]:
        """Return the quantity of a cone in the middle, its change, and what radius and error add.

        Parameters
        ----------
        joint
            The cone.
        pose, d
            The chord in the middle of the part, and its twist by the part of the step.
        numbers
            The numbers of the equations there, and their rates, shapes (6,).
        half
            Half of the length of the part.
        segments, k
            The segment.
        """
        (R, T), w, leg = pose, d[:3], joint.constraint
        spin, on_base = float(np.linalg.norm(w)), joint.body == "base"
        y, x = (self._placed(body, leg, numbers) for body in ("platform", "base"))
        arm, size = R @ y.place, float(self.follower.numbers.norm_y[leg])
        r = arm + T - x.place
        v = np.cross(w, arm) + R @ y.rate + d[3:] - x.rate
        bend = spin**2 * size + 2 * spin * float(np.linalg.norm(y.rate)) + y.bend + x.bend
        axis, turned = self._axis(joint, numbers)
        swing = float(np.linalg.norm(turned))
        if on_base:
            axis_rate = np.cross(turned, axis)
        else:
            axis, turned = R @ axis, R @ turned
            axis_rate = np.cross(w + turned, axis)
            swing += spin
        sign = 1.0 if on_base else -1.0
        cosine = np.cos(joint.cone.half_angle.value * self.instance.units.angle.in_radians)
        driven = self.follower.driven[leg]
        rod = self.rows[0, leg] / self.follower.reach
        length, grows = (rod, 0.0) if driven else (numbers[0][leg], numbers[1][leg])
        middle = sign * r @ axis - cosine * length
        slope = sign * (v @ axis + r @ axis_rate) - cosine * grows
        fast = float(np.linalg.norm(v)) + half * bend
        far = float(np.linalg.norm(r)) + half * fast
        bend += 2 * fast * swing + far * swing**2
        change = half * abs(slope) + half**2 / 2 * bend

        def added(radius: float) -> float:
            moved = radius * (1 + size)
            turns = 0.0 if on_base else radius * (far + moved)
            return (moved + turns + ROUNDING * (1 + far + size)) * _OUTWARD

        lost, least = added(float(segments.radius[k])), added(float(segments.error[k]))
        return float(middle), float(change), lost, least

    def _placed(self, body: str, leg: int, numbers: tuple[Array, Array]) -> _Point:
        """Return the end of a leg in a body."""
        n = self.follower.numbers
        place, kind = (n.Y if body == "platform" else n.X)[leg], n.kinds[leg]
        if not (self.follower.driven[leg] and kind.startswith(body.upper())):
            return _Point(place, np.zeros(3), 0.0)
        c, rate = numbers[0][leg], numbers[1][leg]
        A, B = n.A[leg], n.B[leg]
        if kind.endswith("SLIDE"):
            return _Point(place + B * c, B * rate, 0.0)
        cosine, sine = np.cos(c), np.sin(c)
        along = (B * cosine - A * sine) * rate
        return _Point(place + A * cosine + B * sine, along, float(n.crank[leg]) * rate**2)

    def _axis(self, joint: JointCone, numbers: tuple[Array, Array]) -> tuple[Array, Array]:
        """Return the axis of a cone in its body, which turns with an arm, and how fast it does."""
        leg = joint.constraint
        axis = np.asarray(joint.cone.unit)
        row = self.follower.instance.constraints[leg]
        end = row.base if joint.body == "base" else row.platform
        if not (self.follower.driven[leg] and isinstance(end, Point) and end.crank is not None):
            return axis, np.zeros(3)
        crank = np.asarray(end.crank.unit)
        turned = rotation_from_vector(crank * numbers[0][leg]) @ axis
        return turned, crank * numbers[1][leg]


def covered(stretches: Sequence[Stretch], rows: int) -> bool:
    """Whether all cones are proved to be kept along all of some rows."""
    end = 0.0
    for stretch in stretches:
        if stretch.begin > end or min(stretch.states) < 1:
            return False
        end = stretch.end
    return end >= rows - 1
