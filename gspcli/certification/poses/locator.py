"""Proved poses near approximate Study points of an instance, with as many digits as needed.

A platform that is special up to eps has poses eps^-2 lengths away, with N of size eps^4, near each
other. Doubles do not suffice for them; Newton's method on the exact equations with two, four or
eight times as many digits does. The results are proved like every certificate (`isolation`), with N
!= 0 and the stated constraints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import chain

import numpy as np
from flint import acb, ctx
from numpy.typing import NDArray

from gspcli.certification.equations.ball_system import (
    BallSystem,
    PoseBall,
    pose_of_point,
    satisfies_constraints,
)
from gspcli.certification.equations.local_frames import StudyFrames, length_scale
from gspcli.certification.equations.mirror_images import STUDY_SIGNS, mirrored, mirrored_pose
from gspcli.certification.numbers.balls import largest
from gspcli.certification.numbers.correct_rounding import accurate, rounded
from gspcli.certification.numbers.rounding import NEAREST
from gspcli.certification.poses.isolation import Isolation, refine_point, step_length
from gspcli.geometry import study
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.quaternions import canonical_sign
from gspcli.records import dataclass

Complex = NDArray[np.complex128]
#: Study points by the bytes of T.
StudyPoints = Mapping[bytes, Sequence[acb]]

#: The approximate number of correct bits of a point in doubles, and bits of the last attempt.
DOUBLE, LAST_PRECISION = 64, 1024
#: From this precision on a point is given up if Newton's method moves it by more than the second
#: number, relative to its largest coordinate: it is no approximation of a simple solution.
_PATIENCE, _UNSETTLED = 256, 2.0**-12
#: Bits for poses that 32 digits do not round correctly. The second are for numbers half-way between
#: two doubles, as an entry of a rotation is where it is a ratio of two values.
_MANY_BITS = 128, 512
#: A solution with a smaller N counts as infinite: a platform with such a pose needs decimals of
#: three hundred digits.
_NULL = 2.0**-900


@dataclass(frozen=True)
class Located:
    """A pose that is proved to be a simple solution, and real or not."""

    #: The proof.
    isolation: Isolation
    #: Balls of the pose, translations in units of `scale`.
    pose: PoseBall
    #: The length scale of the instance.
    scale: float
    #: Whether it is real.
    real: bool

    @property
    def conjugate(self) -> Located:
        """The conjugate pose; the same numbers prove it, because the equations are real."""
        # Conjugation rounds to the working precision, too.
        with ctx.workprec(2 * self.isolation.precision):
            centre = tuple(x.conjugate() for x in self.isolation.centre)
            pose = PoseBall(
                [[x.conjugate() for x in row] for row in self.pose.rotation],
                [x.conjugate() for x in self.pose.translation],
            )
        other = replace(self, isolation=replace(self.isolation, centre=centre), pose=pose)
        if self.numbers is not None:
            R, T, quaternion = (x.conj() + 0.0 for x in self.numbers)
            other.__dict__["numbers"] = R, T, canonical_sign(quaternion[None])[0]
        return other

    @property
    def mirrored(self) -> Located:
        """The mirror image in the planes z = 0, of equations that are the same in it."""
        signs = STUDY_SIGNS.astype(int).tolist()
        patch = signs[self.isolation.patch]
        with ctx.workprec(2 * self.isolation.precision):
            centre = [x * (s * patch) for x, s in zip(self.isolation.centre, signs, strict=True)]
            x, y, z = self.pose.rotation
            pose = PoseBall(
                [[x[0], x[1], -x[2]], [y[0], y[1], -y[2]], [-z[0], -z[1], z[2]]],
                [*self.pose.translation[:2], -self.pose.translation[2]],
            )
        other = replace(self, isolation=replace(self.isolation, centre=tuple(centre)), pose=pose)
        if self.numbers is not None:
            R, T, quaternion = self.numbers
            e = canonical_sign(mirrored(quaternion)[None])[0]
            other.__dict__["numbers"] = *mirrored_pose(R, T), e
        return other

    @cached_property
    def numbers(self) -> tuple[Complex, Complex, Complex] | None:
        """R (3, 3), T (3,) in length units and the quaternion (4,), `rounded` or `accurate`.

        The result is None if the balls are too large.
        """
        R = self._in_doubles(list(chain(*self.pose.rotation)))
        T = self._in_doubles(self.pose.translation, least_unit=1.0)
        # N may be as small as the precision of the proof allows.
        with ctx.workprec(2 * self.isolation.precision):
            e = self.isolation.point[:4]
            norm = dot4(e, e)
            # A ball across the negative numbers has no square root.
            root = norm.sqrt() if norm.real > 0 else (-norm).sqrt() * acb(0, 1)
            quaternion = self._in_doubles([entry / root for entry in e])
        if R is None or T is None or quaternion is None:
            return None
        return R.reshape(3, 3), self.scale * T, canonical_sign(quaternion[None])[0]

    def is_within(self, R: Complex, T: Complex, off: float) -> bool:
        """Whether it is within a bound of the error of a pose, R (3, 3) and T (3,)."""
        gap = max(np.abs(self.R - R).max(), np.abs(self.T - T).max() / self.scale)
        size = max(1.0, np.abs(R).max(), np.abs(T).max() / self.scale)
        return bool(gap <= off + NEAREST * size)

    def _in_doubles(self, numbers: Sequence[acb], least_unit: float = 0.0) -> Complex | None:
        """Return numbers in balls as doubles: correctly rounded if real, else accurate."""
        if self.real:
            return rounded(numbers, real=True, least_unit=least_unit)
        return accurate(numbers, least_unit=least_unit)

    @property
    def R(self) -> Complex:
        """The rotation, rounded, shape (3, 3)."""
        return self._known[0]

    @property
    def T(self) -> Complex:
        """The translation in length units, rounded, shape (3,)."""
        return self._known[1]

    @property
    def quaternion(self) -> Complex:
        """The quaternion with ``e.e = 1``, rounded, shape (4,)."""
        return self._known[2]

    @property
    def _known(self) -> tuple[Complex, Complex, Complex]:
        assert self.numbers is not None
        return self.numbers


@dataclass(frozen=True)
class AtInfinity:
    """A simple solution of the equations with N = 0 to all digits of the last precision."""

    isolation: Isolation


def dot4(a: Sequence[acb], b: Sequence[acb]) -> acb:
    """Return the bilinear product of two vectors of length four."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


class Locator:
    """Finds the solutions of one instance near approximate points.

    Parameters
    ----------
    instance
        The exact instance.
    frames
        The coordinates in which points are given.

    Attributes
    ----------
    scale
        The length scale of the instance.
    """

    def __init__(self, instance: Instance, frames: StudyFrames) -> None:
        self.instance = instance
        self.frames = frames
        self.scale = length_scale(instance)
        self._systems: dict[int, BallSystem] = {}

    def system(self, precision: int) -> BallSystem:
        """Return the equations at a precision, which must be the working one."""
        if precision not in self._systems:
            self._systems[precision] = BallSystem(self.instance, precision)
        return self._systems[precision]

    def sides(self, signs: Sequence[int]) -> tuple[int, ...]:
        """Return for each constraint the index of its equation, by the signs of the distances."""
        return tuple(
            int(row.kind.has_sides and row.side is Side.BOTH and sign < 0 and row.value.value != 0)
            for row, sign in zip(self.instance.constraints, signs, strict=True)
        )

    def locate(
        self, points: Complex, low: Complex | None, sides: tuple[int, ...], bits: int = DOUBLE
    ) -> list[Located | AtInfinity | None]:
        """Return the pose that is proved near each point, or None.

        Parameters
        ----------
        points
            Study points in the coordinates of `frames`, of any norm, shape (n, 8).
        low
            Doubles to add to the points, for more digits; shape (n, k, 8).
        sides
            For each constraint the index of its equation (`BallSystem.equations`).
        bits
            To how many bits they are known, about.
        """
        rest = np.zeros((len(points), 0, 8)) if low is None else low
        with ctx.workprec(LAST_PRECISION):
            starts = [self.in_frames(point, more) for point, more in zip(points, rest, strict=True)]
        return [self.locate_exactly(start, sides, bits) for start in starts]

    def near(
        self, R: Complex, T: Complex, sides: tuple[int, ...], bits: int = DOUBLE
    ) -> Located | AtInfinity | None:
        """Return the pose proved near R (3, 3) and T (3,), in frames of the instance, or None.

        The sides and bits are those of `locate`.
        """
        points, _ = study.study_points(R[None], T[None] / self.scale)
        with ctx.workprec(LAST_PRECISION):
            start = self.exactly(points[0])
        return self.locate_exactly(start, sides, bits)

    def near_proved(
        self, R: Complex, T: Complex, off: float, sides: tuple[int, ...]
    ) -> Located | None:
        """Return a pose that is proved within a bound of its error with many digits, or None.

        R, T and the sides are those of `near`; the bound is `PoseProofs.deviation`.
        """
        for bits in _MANY_BITS:
            found = self.near(R, T, sides, bits)
            if isinstance(found, Located):
                return found if found.is_within(R, T, off) else None
        return None

    @staticmethod
    def exactly(point: Complex) -> list[acb]:
        """Return doubles as numbers of arbitrary precision."""
        return [acb(x) for x in point.tolist()]

    @staticmethod
    def exact_sum(parts: Complex) -> list[acb]:
        """Return sums of doubles, shape (k, 8), as numbers of arbitrary precision."""
        with ctx.workprec(LAST_PRECISION):
            return [sum(map(acb, column), acb(0)) for column in parts.T.tolist()]

    def in_frames(self, point: Complex, low: Complex) -> list[acb]:
        """Return a point in the frames of the instance, lengths in units of its scale.

        Parameters
        ----------
        point, low
            As one of those of `locate`.
        """
        numbers = self.exactly(point)
        for more in low:
            numbers = [a + b for a, b in zip(numbers, self.exactly(more), strict=True)]
        e, f = numbers[:4], numbers[4:]
        base, platform = ([acb(0), *map(acb, x)] for x in (self.frames.base, self.frames.platform))
        ahead, behind = study.product(base, e), study.product(e, platform)
        scale = acb(self.scale)
        return e + [
            (acb(self.frames.length) * x + (a - b) / 2) / scale
            for x, a, b in zip(f, ahead, behind, strict=True)
        ]

    def is_surrounded(self, point: Complex, low: Complex, pose: Located) -> bool:
        """Whether no other solution is as near to a pose as a point (`in_frames`) is."""
        with ctx.workprec(LAST_PRECISION):
            return pose.isolation.surrounds(self.in_frames(point, low))

    def point_of_pose(self, R: Sequence[Sequence[acb]], T: Sequence[acb], bits: int) -> list[acb]:
        """Return the Study point of a pose in length units of the instance, shape (8,)."""
        with ctx.workprec(bits):
            # Proportional to e_k e for each k: the largest loses the fewest digits.
            (a, b, c), (d, e, f), (g, h, i) = R
            multiples = (
                [1 + a + e + i, h - f, c - g, d - b],
                [h - f, 1 + a - e - i, b + d, c + g],
                [c - g, b + d, 1 - a + e - i, f + h],
                [d - b, c + g, f + h, 1 - a - e + i],
            )
            quaternion = max(multiples, key=lambda x: float(largest(x)))
            place = [acb(0), *(x / self.scale for x in T)]
            return quaternion + [x / 2 for x in study.product(place, quaternion)]

    def locate_exactly(
        self, start: Sequence[acb], sides: tuple[int, ...], bits: int = DOUBLE
    ) -> Located | AtInfinity | None:
        """Return what is proved near a point in the frames of the instance and its length scale.

        Parameters
        ----------
        start
            The point.
        sides
            For each constraint the index of its equation.
        bits
            To how many bits it is known, about.
        """
        # Correct rounding needs more bits than the point has; a Newton step doubles them.
        precision, last = 2 * bits, max(LAST_PRECISION, 4 * bits)
        patch = max(range(4), key=lambda k: float(abs(start[k]).mid()))
        if start[patch].contains(0):
            return None
        with ctx.workprec(last):
            point = [(x / start[patch]).mid() for x in start]
        point[patch] = acb(1)
        reached = point
        while precision <= last:
            with ctx.workprec(precision):
                system = self.system(precision)
                # With too few digits Newton's method may diverge from a good start. Near a second
                # solution it is slow, and continues from its last point with more digits.
                if reached is not point:
                    point = min(
                        (point, reached), key=lambda x: step_length(system, x, patch, sides)
                    )
                    reached = point
                found = refine_point(system, point, patch, sides)
                if isinstance(found, Isolation):
                    located = _located(system, found)
                    if located is not None:
                        return located
                    point = reached = list(found.centre)
                    if 2 * precision > last and dot4(point, point).abs_upper() < _NULL:
                        return AtInfinity(found)
                else:
                    moved = float(largest([x - y for x, y in zip(found, point, strict=True)]))
                    size = float(largest(point))
                    if not moved < _UNSETTLED * size and precision >= max(_PATIENCE, 2 * bits):
                        return None
                    reached = list(found)
            precision *= 2
        return None


def _located(system: BallSystem, isolation: Isolation) -> Located | None:
    """Return the pose of a solution if it is proved and accurate enough to be rounded."""
    real = isolation.real
    pose = pose_of_point(isolation.point)
    if pose is None or real is None or not satisfies_constraints(system, pose, real=real):
        return None
    located = Located(isolation, pose, system.scale, real)
    return None if located.numbers is None else located
