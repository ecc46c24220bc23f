"""The step of a controller that proves its next pose, in Python, and what it needs.

`Follower` is the program of `gsp export --to c`; `RowFollower` takes the same steps along rows of
values or drives. The numbers of a platform for it, and for searches of nearest poses, are in units
of the platform's size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from enum import IntEnum
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DPP, Primitive
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import value_range
from gspcli.geometry.coordinates import Coordinate, carried_by, coordinates
from gspcli.geometry.enclosures import above, roundings
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.machine import ROUNDING, Machine, driven_points
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Geometry, Line, Point, Slide
from gspcli.geometry.quaternions import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
)
from gspcli.geometry.readings import factors, offsets
from gspcli.motion.poses.inverse_kinematics import checked_poses
from gspcli.records import dataclass
from gspcli.wording import shortened

Array = NDArray[np.float64]
Exact = list[Fraction]
#: The kinds of ``platform.c``, in its order. A leg with a crank or slide is a kind of its own,
#: because its value is the angle or the way of the drive.
CONTROLLER_KINDS = (
    *("DPP", "DPL", "DLP", "DPH", "DHP", "DLL", "ALL", "ALH", "AHL", "AHH"),
    *("BASE_CRANK", "PLATFORM_CRANK", "BASE_SLIDE", "PLATFORM_SLIDE"),
)
_DRIVES = CONTROLLER_KINDS[-4:]
BODIES = ("platform", "base")
#: A number without a limit is between this and its negative.
NEVER = 1e30
#: No value is larger, in units of the size or radians.
_LARGEST = 1e9
#: Directions in which the primitives determine the middle less than this are not used.
_LOOSE = 0.05
#: The largest number of joints with a cone.
_CONES = 12


@dataclass(frozen=True, eq=False)
class PlatformNumbers:
    """The numbers of a platform for the step of a controller.

    The fields are those of the struct ``geometry`` in ``gspcli/export/controller/platform.c``, in
    its order and with its meanings.
    """

    kind: NDArray[np.uint8]
    Y: Array
    X: Array
    U: Array
    V: Array
    A: Array
    B: Array
    crank: Array
    rod: Array
    lowest: Array
    highest: Array
    norm_y: Array
    moduli: Array
    middle: Array
    origin: Array
    reach: float
    shift: float
    unit: Array
    offset: Array
    least: Array
    most: Array
    either: NDArray[np.uint8]

    @property
    def kinds(self) -> tuple[str, ...]:
        """The names of the kinds."""
        return tuple(CONTROLLER_KINDS[k] for k in self.kind)

    @property
    def doubles(self) -> Array:
        """All fields that are doubles, one after the other."""
        names = [name for name in self.__annotations__ if name not in ("kind", "either")]
        return np.concatenate([np.ravel(getattr(self, name)) for name in names])


def platform_numbers(
    instance: Instance, margin: float = 0.0, *, shared: bool = False
) -> PlatformNumbers:
    """Return the numbers of an instance.

    Parameters
    ----------
    instance
        The platform.
    margin
        By which part of its range a value may leave the range, from 0 to 1. Impossible distances
        and angles are refused in any case.
    shared
        Whether several rods may share a drive. Each has its number then: the same where they agree.

    Raises
    ------
    ArgumentError
        If the margin is not from 0 to 1, a crank or slide is not at the end of exactly one leg, or
        a leg has two.
    """
    if not 0 <= margin <= 1:
        raise ArgumentError(f"found {margin!r}, expected a part from 0 to 1", "margin")
    rows = instance.constraints
    kinds = [_kind(instance, row, shared) for row in rows]
    middles = [_middle(instance, body) for body in BODIES]
    platform, base = (
        [_Place(getattr(row, body), row.kind.is_distance, middle) for row in rows]
        for body, middle in zip(BODIES, middles, strict=True)
    )
    driven = [kind in _DRIVES for kind in kinds]
    turned = [kind.endswith("CRANK") for kind in kinds]
    angles = [turns or kind[0] == "A" for turns, kind in zip(turned, kinds, strict=True)]
    levers = [_lever(row, p.size, b.size) for row, p, b in zip(rows, platform, base, strict=True)]
    lever = sum(levers) / max(sum(row.kind.is_distance for row in rows), 1)
    reach = 2.0 ** round(math.log2(lever)) if lever > 0 else 1.0
    arms = [
        p if k.startswith("PLATFORM") else b for p, b, k in zip(platform, base, kinds, strict=True)
    ]
    # The number of a slide is in units of reach, as places are: its direction is a unit vector.
    by_number = np.where([kind.endswith("SLIDE") for kind in kinds], 1.0, 1 / reach)
    cranks = np.array([arm.radius for arm in arms]) * by_number
    on_platform = np.array([kind == "PLATFORM_CRANK" for kind in kinds])
    Y, X = (np.array([place.nearest for place in body]) / reach for body in (platform, base))
    shift = 2 * sum(math.hypot(*map(float, middle)) for middle in middles) / reach
    moduli = np.array([p.moduli + b.moduli for p, b in zip(platform, base, strict=True)]) / reach
    unit = np.where(angles, instance.units.angle.in_radians, 1 / reach)
    # The value of a reading x is x scale + offset = (x + offset / scale) scale.
    motors = [motor_of(row) for row in rows]
    scale = np.where(driven, [1.0 + _stated(m, "scale") for m in motors], factors(instance))
    added = np.where(driven, [_stated(m, "offset") for m in motors], offsets(instance))
    limits = _limits(instance, _LARGEST / unit, margin)
    least, most = (limit / scale for limit in limits)
    drives = Machine.of(instance)
    in_file = np.where(angles, instance.units.angle.in_radians, 1.0) * scale
    lowest, highest = (np.clip(held / in_file, -NEVER, NEVER) for held in drives.held)
    sided = [
        row.kind.has_sides and row.side is Side.BOTH and bool(row.limits or stays)
        for row, stays in zip(rows, drives.stays, strict=True)
    ]
    return PlatformNumbers(
        kind=np.array([CONTROLLER_KINDS.index(kind) for kind in kinds], np.uint8),
        Y=Y,
        X=X,
        U=np.array([place.direction for place in platform]),
        V=np.array([place.direction for place in base]),
        A=np.array([arm.A for arm in arms]) / reach,
        B=np.array([arm.B for arm in arms]) * by_number[:, None],
        crank=above(cranks),
        rod=np.where(driven, [row.value.value for row in rows], 0.0) / reach,
        lowest=lowest,
        highest=highest,
        norm_y=above(np.linalg.norm(Y, axis=1) + np.where(on_platform, cranks, 0)),
        moduli=above(moduli),
        middle=np.array([float(x) for x in middles[0]]),
        origin=np.array([float(x) for x in middles[1]]),
        reach=reach,
        shift=shift,
        unit=unit * scale,
        offset=added / scale,
        least=least,
        most=most,
        either=np.array(sided, np.uint8),
    )


def _kind(instance: Instance, row: Constraint, shared: bool) -> str:
    """Return the kind of a constraint by its name in the step."""
    found = driven_points(row)
    if not found:
        return row.kind.name
    if len(found) == 2:
        message = f"a leg has drives at both ends ({row.platform_name} and {row.base_name})"
        raise ArgumentError(f"{message}, expected one: its number is the value")
    if row.kind.has_sides:
        Machine.of(instance).refuse_planes("the step of a controller")
    ((body, point, name, drive),) = found
    legs = [other for other in instance.constraints if _rides(other, body, name)]
    alone = shared or not (point.partner or (len(legs) != 1 and name))
    if not alone or row.kind is not DPP:
        kinds = ", ".join(leg.kind.name for leg in legs)
        message = f"the constraints of its point are {kinds}, expected one DPP"
        if point.partner or len({getattr(leg, f"{body}_name") for leg in legs}) > 1:
            message = (
                "several rods share it, and a controller has a motor for each rod; such machines "
                "work with gsp measure --drives, gsp track and gsp export --to mjcf"
            )
        raise ArgumentError(message, f"{drive.sort}.{point.partner or name}")
    return f"{body.upper()}_{drive.sort.upper()}"


def _rides(row: Constraint, body: str, name: str) -> bool:
    """Return whether a point of a constraint has a name, or moves with the point of this name."""
    point = getattr(row, body)
    return getattr(row, f"{body}_name") == name or (
        isinstance(point, Point) and bool(name) and point.partner == name
    )


def motor_of(row: Constraint) -> Crank | Slide | None:
    """Return the crank or slide that moves a point of a constraint."""
    return next((one.drive for one in driven_points(row)), None)


def _stated(motor: Crank | Slide | None, name: str) -> float:
    """Return the offset or scale of a drive; zero if it has none."""
    number = getattr(motor, name, None)
    return 0.0 if number is None else float(number.value)


def _lever(row: Constraint, platform: float, base: float) -> float:
    """Return the approximate length that equals a radian for a constraint; 0 for an angle.

    With this unit of length the second derivatives by rotations are as large as those by
    translations. Then fewest lines are refused: with half of it twice as many.

    Parameters
    ----------
    row
        The constraint.
    platform, base
        The distances of its primitives from the middles of their bodies.
    """
    value = abs(row.value.value)
    if not row.kind.is_distance:
        return 0.0
    if row.kind.platform is not Primitive.POINT:
        return platform + base + value
    if row.kind.has_sides:
        return platform
    return math.sqrt(platform * (platform + value))


class _Place:
    """The place of a primitive relative to the middle of its body, in length units."""

    def __init__(self, geometry: Geometry, is_distance: bool, middle: Exact) -> None:
        drive = geometry.drive if isinstance(geometry, Point) else None
        self.direction = np.zeros(3) if isinstance(geometry, Point) else geometry.unit
        self.A, self.B, self.nearest = np.zeros((3, 3))
        self.radius = self.size = self.moduli = 0.0
        slides = False
        if not is_distance:
            return
        place = _exact([_apart(x, m) for x, m in zip(geometry.position, middle, strict=True)])
        stated = place
        numbers: tuple[Number, ...] = geometry.position
        if isinstance(geometry, Point):
            if isinstance(drive, Crank):
                place = self._turn(drive, place, middle)
            elif drive is not None:
                self.B, slides = drive.unit, True
        else:
            numbers += geometry.vector
            height = _along(place, _exact(geometry.vector))
            place = _less(place, height) if isinstance(geometry, Line) else height
        self.nearest = np.array([float(x) for x in place])
        self.size = float(np.linalg.norm(self.nearest)) + self.radius
        if slides:
            self.radius = 1.0
        self.moduli = self.size
        if any(x.fraction is None for x in numbers):
            self.moduli += 2 * math.hypot(*map(float, stated))

    def _turn(self, crank: Crank, place: Exact, middle: Exact) -> Exact:
        """Store the circle of a crank; return its centre."""
        axis = _exact(crank.axis)
        centre = [_apart(x, m) for x, m in zip(crank.centre, middle, strict=True)]
        arm = _less(place, _exact(centre))
        arm = _less(arm, _along(arm, axis))
        self.A = np.array([float(x) for x in arm])
        unit = np.array([float(x) for x in axis])
        self.B = np.cross(unit / np.linalg.norm(unit), self.A)
        self.radius = float(np.linalg.norm(self.A))
        return _less(place, arm)


def _apart(number: Number, middle: Fraction) -> Number:
    """Return the difference of two numbers as the nearest double, without cancellation."""
    return number - Number.of(middle)


def _exact(numbers: Sequence[Number]) -> Exact:
    """Return numbers as fractions, irrational ones as those of the nearest doubles."""
    return [Fraction(x.value) if x.fraction is None else x.fraction for x in numbers]


def _less(a: Exact, b: Exact) -> Exact:
    return [x - y for x, y in zip(a, b, strict=True)]


def _along(a: Exact, direction: Exact) -> Exact:
    """Return the part of a vector along a direction."""
    share = Fraction(sum(x * y for x, y in zip(a, direction, strict=True)))
    share /= sum(x * x for x in direction)
    return [share * x for x in direction]


def _middle(instance: Instance, body: str) -> Exact:
    """Return the point of a body that is nearest to its primitives: least squares, few digits.

    Coordinates relative to it are nearly exact, and twists about it move the primitives little.
    """
    bodies = [getattr(row, body) for row in instance.constraints if row.kind.is_distance]
    if not bodies:
        return [Fraction(0)] * 3
    points = np.array([one.point for one in bodies])
    centre = points.mean(axis=0)
    normal, right = np.zeros((3, 3)), np.zeros(3)
    for one, point in zip(bodies, points, strict=True):
        across = np.eye(3)
        if not isinstance(one, Point):
            along = np.outer(one.unit, one.unit)
            across = across - along if isinstance(one, Line) else along
        normal += across
        right += across @ (point - centre)
    centre = centre + np.linalg.pinv(normal, rcond=_LOOSE, hermitian=True) @ right
    grid = 2.0 ** (math.frexp(float(np.abs(points - centre).max()) or 1.0)[1] - 12)
    return [Fraction(float(x)) for x in np.round(centre / grid) * grid]


def _limits(instance: Instance, largest: Array, margin: float) -> tuple[Array, Array]:
    """Return the least and greatest value of each constraint, signed if a side is chosen."""
    least, most = np.zeros((2, 6))
    for k, row in enumerate(instance.constraints):
        lowest, highest = value_range(row.kind, instance.units.angle)
        motor, limits = motor_of(row), row.limits
        if motor is not None:
            lowest, highest, limits = -math.inf, math.inf, motor.limits
        low, high = lowest, highest
        if limits is not None:
            low, high = (limit.value for limit in limits)
            if row.side is Side.NEGATIVE:
                low, high = -high, -low
            more = margin * (high - low)
            if more:
                low, high = max(low - more, min(low, lowest)), min(high + more, max(high, highest))
        room = ROUNDING * max(abs(x) for x in (low, high) if math.isfinite(x) or x == low)
        room = room if math.isfinite(room) else 0.0
        distance = motor is None and row.kind.is_squared
        floor = 0.0 if distance and low >= 0 else -math.inf
        least[k] = max(low - room, floor, -largest[k])
        most[k] = min(high + room, largest[k])
    return least, most


@dataclass(frozen=True, eq=False)
class LimitNumbers:
    """The limits of a platform.

    The fields are those of the struct ``limits`` in ``gspcli/export/controller/nearest.c``, in its
    order and with its meanings; ``leg`` and ``on_base`` have one number for each cone.
    """

    low: Array
    high: Array
    axis: Array
    half: Array
    pivot: Array
    weight: float
    cones: int
    still: bool
    leg: NDArray[np.uint8]
    on_base: NDArray[np.uint8]

    @property
    def arguments(self) -> tuple[Any, ...]:
        """The arguments of ``_kernel.Controller.limit``."""
        names = ("low", "high", "axis", "half", "pivot", "weight")
        doubles = np.concatenate([np.ravel(getattr(self, name)) for name in names])
        return doubles, self.leg, self.on_base, self.still


def limit_numbers(
    instance: Instance,
    numbers: PlatformNumbers,
    *,
    pivot: ArrayLike | None = None,
    still: bool = False,
) -> LimitNumbers:
    """Return the limits of an instance.

    Parameters
    ----------
    instance
        The platform.
    numbers
        The other numbers of the platform.
    pivot
        The point of the platform whose position is compared, shape (3,); its origin if None.
    still
        Whether the platform keeps its rotation.
    """
    low, high = np.full(6, -NEVER), np.full(6, NEVER)
    radian = instance.units.angle.in_radians
    machine = Machine.of(instance)
    for k, (row, kind) in enumerate(zip(instance.constraints, numbers.kinds, strict=True)):
        motor = motor_of(row)
        limits = row.limits if motor is None else motor.limits
        if machine.stays[k]:
            limits = row.value, row.value
        if limits is None:
            continue
        unit = radian if kind.endswith("CRANK") or kind[0] == "A" else 1 / numbers.reach
        least, most = (limit.value * unit for limit in limits)
        negative = motor is None and row.side is Side.NEGATIVE
        low[k], high[k] = (-most, -least) if negative else (least, most)
    cones = machine.cones
    axis, half = np.zeros((_CONES, 3)), np.zeros(_CONES)
    for k, one in enumerate(cones):
        axis[k], half[k] = one.cone.unit, one.cone.half_angle.value * radian
    point = np.zeros(3) if pivot is None else np.asarray(pivot, float)
    return LimitNumbers(
        low=low,
        high=high,
        axis=axis,
        half=half,
        pivot=(point - numbers.middle) / numbers.reach,
        weight=Arrangement.of(instance).length / numbers.reach,
        cones=len(cones),
        still=still,
        leg=np.array([one.constraint for one in cones], np.uint8),
        on_base=np.array([one.body == "base" for one in cones], np.uint8),
    )


Index = NDArray[np.int64]

#: The shortest part of the step between two rows, and the most tries for it.
SHORTEST, _TRIES = 2.0**-40, 2000
#: Numbers without limits.
_NEVER = 1e30
#: A bound of the rounding errors of frames of size one.
FRAME_ERROR: float = roundings(16, 1)


@dataclass(frozen=True, eq=False)
class Segments:
    """Proved segments of one mode.

    On a segment s goes from 0 to 1, and the poses are within ``radius`` of the chord
    ``exp(w) R, T + t`` with ``(w, t) = (s - middle) d``: T is the place of the middle of the
    platform, lengths are in units of `RowFollower.reach`.
    """

    #: The row before, and the part of the step to the next one, shapes (n,).
    row: Index
    begin: Array
    end: Array
    #: 0, or 1/2 if the chord is seen from its middle, shape (n,).
    middle: Array
    #: Shapes (n, 3, 3), (n, 3) and (n, 6).
    R: Array
    T: Array
    d: Array
    #: Bounds of the distance of the poses from the chord, of the one at the end from the end of the
    #: chord, and a distance within which there is no other pose, shapes (n,).
    radius: Array
    error: Array
    alone: Array

    @classmethod
    def of(cls, table: Array) -> Segments:
        """Return what the kernel has written, shape (n, 20).

        Its twists have twice the tangent of half the angle for the length of the rotation.
        """
        d = table[:, 11:17].copy()
        tangent = np.linalg.norm(d[:, :3], axis=1) / 2
        with np.errstate(invalid="ignore"):
            factor = np.where(tangent > 0, np.arctan(tangent) / tangent, 1.0)
        d[:, :3] *= factor[:, None]
        row = table[:, 0].astype(np.int64)
        begin, end, middle, radius, error, alone = table[:, [1, 2, 3, 17, 18, 19]].T
        R, T = rotation_from_quaternion(table[:, 4:8]), table[:, 8:11]
        return cls(row, begin, end, middle, R, T, d, radius, error, alone)

    @classmethod
    def joined(cls, parts: Sequence[Segments]) -> Segments:
        """Return the segments of several modes, one after the other."""
        names = list(cls.__annotations__)
        return cls(*(np.concatenate([getattr(one, name) for one in parts]) for name in names))

    def chord(self, k: Index, s: Array) -> tuple[Array, Array]:
        """Return R and T of points of the chords of some segments, s from 0 to 1."""
        x = (s - self.middle[k])[:, None] * self.d[k]
        return rotation_from_vector(x[:, :3]) @ self.R[k], self.T[k] + x[:, 3:]


@dataclass(frozen=True, eq=False)
class FollowedMode:
    """A mode along rows."""

    #: The last row reached, from 0, and the part of the step to the next one that was followed
    #: beyond it; -1 if Newton's method found no pose at the first row.
    reached: int
    part: float
    #: The poses at the rows reached, shapes (r, 3, 3) and (r, 3).
    R: Array
    T: Array
    #: The last pose (R, T).
    last: tuple[Array, Array]
    #: A bound of its distance from the proved pose, and a distance within which there is no other
    #: one: of twists, as lengths.
    error: float
    alone: float
    #: The numbers of segments that were proved and that were tried, and the largest Kantorovich
    #: number of a proof.
    steps: int
    tries: int
    worst: float
    #: The proved segments, if they were asked for.
    segments: Segments


class RowFollower:
    """A platform whose values, or drives of rods, move linearly between rows.

    Parameters
    ----------
    instance
        The platform. Its values are not used.
    chosen
        The drives that move; other drives stay where the instance states their points.

    Raises
    ------
    ArgumentError
        If a drive moves the point of a constraint that is no leg, or a leg has two.
    """

    def __init__(self, instance: Instance, chosen: Sequence[Coordinate]) -> None:
        self.instance = _without(instance, set(coordinates(instance)) - set(chosen))
        numbers = platform_numbers(self.instance, shared=True)
        self.reach, self.middle, self.origin = numbers.reach, numbers.middle, numbers.origin
        #: The column of each constraint in a row: its value, or the number of its drive.
        self.column = np.arange(6)
        for j, one in enumerate(chosen):
            for body, name in carried_by(instance, one):
                for k, row in enumerate(instance.constraints):
                    if getattr(row, f"{body}_name") == name:
                        self.column[k] = 6 + j
        turns = np.array([kind.endswith("CRANK") or kind[0] == "A" for kind in numbers.kinds])
        self.unit = np.where(turns, instance.units.angle.in_radians, 1 / self.reach)
        self.numbers = replace(
            numbers,
            unit=np.ones(6),
            offset=np.zeros(6),
            least=np.full(6, -_NEVER),
            most=np.full(6, _NEVER),
        )

    @property
    def driven(self) -> NDArray[np.bool_]:
        """Which constraints are rods that a drive moves, shape (6,)."""
        return self.column >= 6

    def knows(self, rows: Array) -> bool:
        """Whether the rods that drives move keep their lengths along rows, shape (r, 6 + d)."""
        rods = rows[:, :6][:, self.driven]
        return bool((rods == rods[:1]).all())

    def in_units(self, rows: Array) -> Array:
        """Return the numbers of the equations: radians, and lengths in units of `reach`, (r, 6)."""
        return np.ascontiguousarray(rows[:, self.column] * self.unit)

    def follow(
        self,
        rows: Array,
        R: Array,
        T: Array,
        near: float = 0.0,
        *,
        shortest: float = SHORTEST,
        tries: int = _TRIES,
        keep: bool = False,
    ) -> FollowedMode:
        """Follow a mode along rows of values and numbers of drives.

        Parameters
        ----------
        rows
            Shape (r, 6 + d), in the units of the instance; rods of drives keep their lengths.
        R, T
            A pose near the mode at the first row.
        near
            A bound of its distance from the mode, a twist as a length; 0 stands for the pose that
            Newton's method finds.
        shortest, tries
            The shortest part of a step between rows that is tried, and how many are tried.
        keep
            Whether to return the proved segments.
        """
        assert self.knows(rows)
        rod = np.where(self.driven, rows[0, :6], 0.0) / self.reach
        numbers = replace(self.numbers, rod=rod)
        kernel = _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)
        pose = np.concatenate((T, quaternion_from_rotation(R)))
        reached, poses, last, part, error, alone, steps, made, worst, table = kernel.follow_rows(
            self.in_units(rows), pose, near, shortest, tries, keep
        )
        return FollowedMode(
            reached,
            part,
            rotation_from_quaternion(poses[:, 3:]),
            poses[:, :3],
            (rotation_from_quaternion(last[3:]), last[:3]),
            error,
            alone,
            steps,
            made,
            worst,
            Segments.of(table),
        )


def _without(instance: Instance, still: set[Coordinate]) -> Instance:
    """Return an instance whose points some drives do not move."""
    places = {key for one in still for key in carried_by(instance, one)}
    constraints = []
    for row in instance.constraints:
        for body in ("platform", "base"):
            point = getattr(row, body)
            if isinstance(point, Point) and (body, getattr(row, f"{body}_name")) in places:
                changed: dict[str, Any] = {body: replace(point, crank=None, slide=None, partner="")}
                row = replace(row, **changed)
        constraints.append(row)
    return replace(instance, constraints=tuple(constraints), dynamics=None) if places else instance


class FollowerStatus(IntEnum):
    """The result of a step; the numbers are those of the header that `gsp export --to c` writes."""

    PROVED = 0
    """The pose is the continuation along the straight line of values, and simple."""
    NOT_FINITE = 1
    """A value is not a finite number."""
    RANGE = 2
    """A value is outside the range of its constraint."""
    SINGULAR = 3
    """Refused: a singular pose is too near, to the start or on the line, or two lines meet."""
    TRIES_SPENT = 4
    """Refused: the line of values is too long for the tries of one step."""
    NOT_FOUND = 5
    """No pose within the limits was found."""


@dataclass(frozen=True)
class FollowerReport:
    """Numbers of the last step, or of the start before the first step.

    At a start ``fraction`` is 1, or 0 if the pose is so nearly singular that no step from it can be
    proved; ``sigma`` and ``alone`` are those of the pose.
    """

    #: How much of the line of values was proved; 1 if all.
    fraction: float
    #: A lower bound, where the last part began, of the least singular value of the Jacobian matrix
    #: of the values. Twists are about the platform's middle, lengths are divided by its size
    #: (``reach`` and ``middle`` of `platform_numbers`). It is seldom less than a third of it.
    sigma: float
    #: No other pose with these values is nearer than this: a length, or radians times the size.
    alone: float
    #: How many parts of the line were proved, and tried.
    steps: int
    tries: int


_STATUSES = tuple(FollowerStatus)


class Follower:
    """A platform that follows its values, each step proved: 1 to 5 µs.

    The program is the one that `gsp export --to c` writes, with the numbers of this platform.

    Parameters
    ----------
    instance
        The platform. Its values are used for the rods of cranks and slides only.
    R, T
        Its pose, shapes (3, 3) and (3,), ``x_base = R x_platform + T``; its values are measured at
        the pose. Cranks and slides have the numbers nearest to zero.

    Raises
    ------
    ArgumentError
        If the pose is not a pose, a crank or slide does not reach it, or a drive is not at the end
        of exactly one leg.

    Examples
    --------
    >>> import gspcli
    >>> from gspcli.resources import instance_files
    >>> platform = gspcli.load(instance_files()["nano-hexapod"])
    >>> pose = gspcli.solve(platform).real_solutions[0]
    >>> follower = gspcli.Follower(platform, pose.R.real, pose.T.real)
    >>> follower.forward(follower.values + 1e-5).name
    'PROVED'
    """

    def __init__(
        self, instance: Instance, R: ArrayLike, T: ArrayLike, *, margin: float = 0.0
    ) -> None:
        rotation, translation = checked_poses(R, T)
        if translation.shape != (3,):
            raise ArgumentError(
                f"found the shape {translation.shape}, expected one pose: (3,)", "T"
            )
        self.instance = instance
        numbers = platform_numbers(instance, margin)
        self._controller = _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)
        pivot = PoseFrame.of(instance).tool.T
        self._controller.limit(*limit_numbers(instance, numbers, pivot=pivot).arguments)
        quaternion = quaternion_from_rotation(rotation)
        status = self._controller.start(np.concatenate((translation, quaternion)))
        if status:
            reasons = {
                FollowerStatus.RANGE: "a crank or slide does not reach this pose, or a value that "
                "stays is another one there",
                FollowerStatus.SINGULAR: "lines are parallel there",
            }
            nothing = "found no pose: a rotation and a translation"
            raise ArgumentError(reasons.get(FollowerStatus(status), nothing))

    def __reduce__(self) -> tuple[Any, ...]:
        return _moved, (self.instance, self.R, self.T, self.values)

    def forward(self, values: ArrayLike) -> FollowerStatus:
        """Move to the pose of other values, if it is proved to be the continuation of this one.

        Parameters
        ----------
        values
            Shape (6,), in the units of the instance, planes signed; of cranks and slides their
            angles and ways.

        Returns
        -------
        FollowerStatus
            PROVED: for every value on the straight line between, exactly one pose is near, it is
            not singular, and the new pose is its end. With any other status the follower has not
            moved.
        """
        try:
            array = np.ascontiguousarray(values, np.float64)
        except (TypeError, ValueError) as error:
            raise ArgumentError(
                f"found {shortened(repr(values))}, expected six numbers", "values"
            ) from error
        if array.shape != (6,):
            raise ArgumentError(f"found the shape {array.shape}, expected (6,)", "values")
        return _STATUSES[self._controller.forward(array)]

    def nearest(self, R: ArrayLike, T: ArrayLike) -> FollowerStatus:
        """Move to the nearest pose to a given one that keeps all ranges and cones: 10 to 60 µs.

        The distance adds the squares of the shift of the tool's point, or of the origin without a
        tool, and of the turn times the typical length of the platform. A search finds the pose; it
        does not exclude nearer ones. `NearestPoses` searches from more poses, and proves that cones
        are kept on the way, too.

        Parameters
        ----------
        R, T
            The given pose, shapes (3, 3) and (3,).

        Returns
        -------
        FollowerStatus
            PROVED: the follower is at the nearest pose that was found, within the limits, and a
            straight line of values leads there as for `forward`, or several do. With any other
            status it is at the end of the last proved line, or has not moved.
        """
        rotation, translation = checked_poses(R, T)
        if translation.shape != (3,):
            raise ArgumentError(
                f"found the shape {translation.shape}, expected one pose: (3,)", "T"
            )
        quaternion = quaternion_from_rotation(rotation)
        return _STATUSES[self._controller.nearest(np.concatenate((translation, quaternion)))]

    @property
    def T(self) -> Array:
        """The translation, shape (3,)."""
        return self._controller.position()

    @property
    def quaternion(self) -> Array:
        """The unit quaternion of the rotation, scalar first, shape (4,)."""
        return self._controller.rotation()

    @property
    def R(self) -> Array:
        """The rotation, shape (3, 3)."""
        return rotation_from_quaternion(self.quaternion)

    @property
    def values(self) -> Array:
        """The values of the pose, shape (6,)."""
        return self._controller.values()

    @property
    def jacobian(self) -> Array:
        """The derivatives of the values by a twist, shape (6, 6); NaN where one has none.

        In the units of the instance, by radians and length units (`geometry.measurement`).
        """
        found = self._controller.jacobian()
        return np.full((6, 6), np.nan) if found is None else found

    @property
    def error(self) -> float:
        """A bound of the distance of the exact pose: a length, or radians times the size."""
        return self._controller.error()

    @property
    def report(self) -> FollowerReport:
        """Numbers of the last step; before the first step, of the start."""
        return FollowerReport(*self._controller.report())

    def __repr__(self) -> str:
        return f"<Follower of {self.instance!r} at {self.T.tolist()}>"


def _moved(instance: Instance, R: Array, T: Array, values: Array) -> Follower:
    """Return a follower at a pose with given values (for unpickling)."""
    follower = Follower(instance, R, T)
    follower.forward(values)
    return follower
