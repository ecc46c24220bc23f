"""The numbers of a platform for the step of a controller and for searches of its nearest poses.

They are in units of its size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DPP, Primitive
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import value_range
from gspcli.geometry.enclosures import above
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.limits import ROUNDING, joint_cones
from gspcli.geometry.machine import Machine, driven_points
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Geometry, Line, Point, Slide
from gspcli.geometry.readings import factors, offsets
from gspcli.records import dataclass

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
    stays = Machine.of(instance).stays
    for k, (row, kind) in enumerate(zip(instance.constraints, numbers.kinds, strict=True)):
        motor = motor_of(row)
        limits = row.limits if motor is None else motor.limits
        if stays[k]:
            limits = row.value, row.value
        if limits is None:
            continue
        unit = radian if kind.endswith("CRANK") or kind[0] == "A" else 1 / numbers.reach
        least, most = (limit.value * unit for limit in limits)
        negative = motor is None and row.side is Side.NEGATIVE
        low[k], high[k] = (-most, -least) if negative else (least, most)
    cones = joint_cones(instance)
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
