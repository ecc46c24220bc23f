"""Sensors: what they read at a pose, how they are written, and those that are compared by default.

The grammar, with blanks between words::

    reading    = sensor "=" number { "," number } ( "±" | "+-" | "+/-" ) number
    sensor     = ( "leg" | "distance" | "angle" ) part part
               | "joint" leg ( "platform" | "base" ) "about" direction [ "from" direction ]
               | "inclinometer" [ direction ]
    part       = name | "(" number "," number "," number ")"
    direction  = "x" | "y" | "z" | "(" number "," number "," number ")"

The first part is on the platform, the second on the base; coordinates are in the frame of its body.
A leg is the distance of two points. The angle of a joint is measured from the z axis by default, or
from the x axis if its axis is along z. Readings are in the units of the instance. A sensor contains
only names and exact numbers: it means the same on a platform whose cranks have turned.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import ClassVar, Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, DPP, KINDS_BY_NAME, Kind
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement, Bodies
from gspcli.geometry.checking import wrong_value
from gspcli.geometry.coordinates import BODIES, Body
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number, parse_number
from gspcli.geometry.primitives import Geometry, Point, Vector, as_array, unit_vectors, vector
from gspcli.geometry.quaternions import apply, cross, dot
from gspcli.geometry.tolerances import MEASURED_PARALLEL_SINE
from gspcli.records import dataclass
from gspcli.ties import definite_sign
from gspcli.wording import counted, listed, shown, suggestion

Array = NDArray[np.float64]
Unit = Literal["length", "angle"]
Parsed = TypeVar("Parsed")

#: The axes of a frame as directions, by their names.
AXES = {"x": vector(1, 0, 0), "y": vector(0, 1, 0), "z": vector(0, 0, 1)}
KINDS = ("leg", "joint", "inclinometer", "distance", "angle")
#: Decimals of directions of joints, and the part of their size within which points are on a line.
_DECIMALS, _FLAT = 4, 1e-9
_FORMS = ("leg P7 B7", "joint 1 base about x", "inclinometer", "distance P1 L2", "angle L1 H2")
_EXAMPLE = "leg P7 B7 = 212.4 ± 0.1"
_SIGNS = ("±", "+/-", "+-")
_COUNTS = {1: "one number", 2: "two numbers, rx and ry"}


@dataclass(frozen=True)
class SensorPart:
    """A primitive of a body by its name, or a point by its coordinates."""

    body: Body
    name: str = ""
    position: Vector | None = None

    def __str__(self) -> str:
        return self.name if self.position is None else _vector_text(self.position)

    def primitive(self, instance: Instance) -> Geometry:
        """Return what it is on an instance."""
        if self.position is not None:
            return Point(self.position)
        return instance.named(self.body)[self.name]


@dataclass(frozen=True)
class ValueSensor:
    """What a seventh constraint would measure: the length of a leg, a distance or an angle.

    Distances to planes are signed: positive on the side to which the normal points.
    """

    measured: Kind
    platform: SensorPart
    base: SensorPart

    @property
    def kind(self) -> str:
        """``leg``, ``distance`` or ``angle``."""
        if self.measured is DPP:
            return "leg"
        return "distance" if self.measured.is_distance else "angle"

    @property
    def unit(self) -> Unit:
        """The unit of its readings."""
        return "length" if self.measured.is_distance else "angle"

    def __str__(self) -> str:
        return f"{self.kind} {self.platform} {self.base}"

    def read(self, instance: Instance, R: Array, T: Array) -> Array:
        """Return the value at poses, ``(..., 3, 3), (..., 3) -> (..., 1)``."""
        (y, u), (x, v) = (
            _point_and_direction(part.primitive(instance)) for part in (self.platform, self.base)
        )
        values = measured(Bodies((self.measured,), y[None], x[None], u[None], v[None]), R, T)
        if self.measured is DLL:
            values = np.abs(values)
        unit = 1.0 if self.measured.is_distance else instance.units.angle.in_radians
        return np.asarray(values / unit)

    def apart(self, instance: Instance, a: Array, b: Array) -> Array:
        """Return the difference of readings, ``(..., 1), (..., 1) -> (...)``."""
        del instance
        return np.abs(a - b)[..., 0]


@dataclass(frozen=True)
class JointSensor:
    """The angle of a leg's joint about an axis of its body: an encoder on a universal joint.

    In a view along the axis, the leg (from this joint to its other end) is turned by this angle
    from the direction ``zero``. The leg is the index of a DPP, from 0; axis and zero are vectors of
    the body, not parallel.
    """

    leg: int
    body: Body
    axis: Vector
    zero: Vector
    kind: ClassVar[str] = "joint"
    unit: ClassVar[Unit] = "angle"

    def __str__(self) -> str:
        text = f"joint {self.leg + 1} {self.body} about {_direction_text(self.axis)}"
        usual = _usual_zero(self.axis)
        return text if self.zero == usual else f"{text} from {_direction_text(self.zero)}"

    def read(self, instance: Instance, R: Array, T: Array) -> Array:
        """Return the angle at poses, ``(..., 3, 3), (..., 3) -> (..., 1)``."""
        row = instance.constraints[self.leg]
        leg = apply(R, as_array(row.platform.position)) + T - as_array(row.base.position)
        if self.body == "platform":
            leg = -apply(np.swapaxes(R, -1, -2), leg)
        axis, zero = unit_vectors([self.axis, self.zero])
        zero = zero - (zero @ axis) * axis
        zero /= np.linalg.norm(zero)
        angle = np.arctan2(leg @ np.cross(axis, zero), leg @ zero)
        return np.asarray(angle)[..., None] / instance.units.angle.in_radians

    def apart(self, instance: Instance, a: Array, b: Array) -> Array:
        """Return the angle between readings, ``(..., 1), (..., 1) -> (...)``."""
        turn = 2 * np.pi / instance.units.angle.in_radians
        difference = np.abs(a - b)[..., 0] % turn
        return np.asarray(np.minimum(difference, turn - difference))


@dataclass(frozen=True)
class Inclinometer:
    """The tilt of the platform against the vertical ``up``, a vector of the base.

    The readings are two angles, rx and ry. From a position with a vertical z axis the platform is
    turned about its z axis by any angle, then about its y axis by ry, then about its x axis by rx
    (``ZYX``).
    """

    up: Vector
    kind: ClassVar[str] = "inclinometer"
    unit: ClassVar[Unit] = "angle"

    def __str__(self) -> str:
        return "inclinometer" + ("" if self.up == AXES["z"] else f" {_direction_text(self.up)}")

    def read(self, instance: Instance, R: Array, T: Array) -> Array:
        """Return rx and ry at poses, ``(..., 3, 3), (..., 3) -> (..., 2)``."""
        del T
        up = apply(np.swapaxes(R, -1, -2), unit_vectors([self.up])[0])
        x, y, z = np.moveaxis(up, -1, 0)
        angles = np.stack((np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z))), axis=-1)
        return np.asarray(angles / instance.units.angle.in_radians)

    def apart(self, instance: Instance, a: Array, b: Array) -> Array:
        """Return the angle between the verticals of readings, ``(..., 2), (..., 2) -> (...)``."""
        unit = instance.units.angle.in_radians
        first, second = verticals(a * unit), verticals(b * unit)
        normal = cross(first, second)
        angle = np.arctan2(np.sqrt(dot(normal, normal)), dot(first, second))
        return np.asarray(angle / unit)


Sensor: TypeAlias = ValueSensor | JointSensor | Inclinometer


@dataclass(frozen=True)
class SensorReading:
    """A reading of a sensor: one number, or two of an inclinometer, and their deviation."""

    sensor: Sensor
    values: tuple[float, ...]
    sigma: float

    def __str__(self) -> str:
        values = ", ".join(f"{value:.12g}" for value in self.values)
        return f"{self.sensor} = {values} ± {self.sigma:.12g}"


def verticals(angles: Array) -> Array:
    """Return up in the platform from rx and ry in radians, (..., 2) -> (..., 3)."""
    rx, ry = angles[..., 0], angles[..., 1]
    return np.stack((-np.sin(ry), np.cos(ry) * np.sin(rx), np.cos(ry) * np.cos(rx)), axis=-1)


def candidates(instance: Instance) -> list[Sensor]:
    """Return the sensors that are compared by default.

    They are the legs between points of the platform and of the base that no constraint joins, two
    angles of each joint of a leg (about axes in the plane of the joints: one away from their
    middle, and one across), and an inclinometer. Points that no constraint uses are ends of legs,
    too.
    """
    legs = {
        (row.platform.position, row.base.position)
        for row in instance.constraints
        if row.kind is DPP
    }
    here, there = (_points_of(instance, body) for body in BODIES)
    found: list[Sensor] = [
        ValueSensor(DPP, own, other)
        for start, own in here.items()
        for end, other in there.items()
        if (start, end) not in legs
    ]
    for body in BODIES:
        found += _joints(instance, body)
    return [*found, Inclinometer(AXES["z"])]


def body_normal(instance: Instance, body: Body) -> Array | None:
    """Return the unit normal of the plane nearest to the points of a body; None on a line.

    Only those that constraints use count. Its largest component is positive.
    """
    rows = [getattr(row, body) for row in instance.constraints]
    points = np.array([one.point for one in rows if isinstance(one, Point)]).reshape(-1, 3)
    if len(points) < 3:
        return None
    _, sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    return None if sizes[1] <= _FLAT * sizes[0] else definite_sign(axes[2])


def _points_of(instance: Instance, body: Body) -> dict[Vector, SensorPart]:
    """Return the different points of a body, by their coordinates."""
    places: dict[Vector, SensorPart] = {}
    for row in instance.constraints:
        geometry, name = getattr(row, body), getattr(row, f"{body}_name")
        if isinstance(geometry, Point):
            position = None if name else geometry.position
            places.setdefault(geometry.position, SensorPart(body, name or "", position))
    for where, name, geometry in instance.further:
        if where == body and isinstance(geometry, Point):
            places.setdefault(geometry.position, SensorPart(body, name))
    return places


def _joints(instance: Instance, body: Body) -> Iterator[JointSensor]:
    normal, arrangement = body_normal(instance, body), Arrangement.of(instance)
    if normal is None:
        return
    centre = arrangement.platform_centre if body == "platform" else arrangement.base_centre
    for k, row in enumerate(instance.constraints):
        if row.kind is not DPP:
            continue
        way = getattr(row, body).point - centre
        way = way - (way @ normal) * normal
        length = np.linalg.norm(way)
        if length > _FLAT * arrangement.extent:
            for axis in (way / length, np.cross(normal, way / length)):
                yield JointSensor(k, body, _rounded(axis), _rounded(normal))


def _rounded(unit: Array) -> Vector:
    x, y, z = (Number.of(round(value, _DECIMALS) + 0.0) for value in unit.tolist())
    return x, y, z


def _point_and_direction(geometry: Geometry) -> tuple[Array, Array]:
    direction = np.zeros(3) if isinstance(geometry, Point) else geometry.unit
    return as_array(geometry.position), direction


def _vector_text(numbers: Vector) -> str:
    return f"({', '.join(map(str, numbers))})"


def _direction_text(direction: Vector) -> str:
    return next((name for name, axis in AXES.items() if axis == direction), _vector_text(direction))


def _usual_zero(axis: Vector) -> Vector:
    """Return the direction from which angles about an axis are measured by default."""
    return AXES["z" if axis[0].value or axis[1].value else "x"]


def parse_sensor(text: str, instance: Instance, *, repeated: bool = False) -> Sensor:
    """Return the sensor that a text names.

    Parameters
    ----------
    text, instance
        The text, and the platform of its names.
    repeated
        Whether it may be what a constraint measures, which is measured once more.

    Raises
    ------
    ArgumentError
        Names the column of the mistake.
    """
    words = _Words(text, instance)
    sensor = words.sensor()
    if words.words:
        raise words.wrong(words.take(""), "nothing more")
    if isinstance(sensor, ValueSensor) and not repeated:
        ends = sensor.platform.primitive(instance), sensor.base.primitive(instance)
        for number, row in enumerate(instance.constraints, 1):
            places = row.platform, row.base
            if row.kind is sensor.measured and all(map(_same_place, ends, places)):
                message = (
                    f"found constraint {number}, expected another {sensor.kind}: all modes have "
                    "its value"
                )
                raise ArgumentError(message, "column 1")
    return sensor


def parse_reading(text: str, instance: Instance, *, repeated: bool = False) -> SensorReading:
    """Return the reading that a text states; parameters are those of `parse_sensor`.

    Raises
    ------
    ArgumentError
        Names the column of the mistake.
    """
    name, equals, rest = text.partition("=")
    if not equals:
        message = f"found no =, expected a reading such as {_EXAMPLE}"
        raise ArgumentError(message, f"column {len(text.rstrip()) + 1}")
    sensor = parse_sensor(name, instance, repeated=repeated)
    sign = next((sign for sign in _SIGNS if sign in rest), None)
    start = len(name) + 2
    if sign is None:
        message = f"found no ±, expected the standard deviation too: {_EXAMPLE} (or +-)"
        raise ArgumentError(message, f"column {start + len(rest.rstrip())}")
    given, _, last = rest.partition(sign)
    values = [number.value for number in _numbers(given, start)]
    count = 2 if isinstance(sensor, Inclinometer) else 1
    place = f"column {start + len(given) - len(given.lstrip())}"
    if len(values) != count:
        message = f"found {counted(len(values), 'number')}, expected {_COUNTS[count]}"
        raise ArgumentError(message, place)
    wrong = ""
    if isinstance(sensor, ValueSensor) and not sensor.measured.has_sides:
        wrong = wrong_value(sensor.measured, Number.of(values[0]), instance.units.angle)
    if wrong:
        raise ArgumentError(f"found {values[0]:g}, {wrong}", place)
    at = start + len(given) + len(sign)
    (sigma,) = _numbers(last, at)
    if sigma.value <= 0:
        message = f"found {shown(last.strip())}, expected a standard deviation above 0"
        raise ArgumentError(message, f"column {at + len(last) - len(last.lstrip())}")
    return SensorReading(sensor, tuple(values), sigma.value)


def each_parsed(
    given: Sequence[str | Parsed], parse: Callable[[str], Parsed], where: str
) -> list[Parsed]:
    """Return what texts name, at least one; what is no text is taken as it is.

    Raises
    ------
    ArgumentError
        If there is none, or one is wrong: which one, and the column of the mistake.
    """
    if not given:
        raise ArgumentError("found none, expected at least one", where)
    found = []
    for k, one in enumerate(given):
        try:
            found.append(parse(one) if isinstance(one, str) else one)
        except ArgumentError as error:
            at = f", {error.where}" if error.where else ""
            raise ArgumentError(error.message, f"{where}[{k}]{at}") from None
    return found


def check_sigmas(sigma: Mapping[str, float], known: Sequence[str]) -> None:
    """Raise `ArgumentError` for a standard deviation of an unknown name, or that is not above 0."""
    for name, deviation in sigma.items():
        if name not in known:
            raise ArgumentError(f"found {shown(name)}, expected {listed(known)}", "sigma")
        if not 0 < deviation < math.inf:
            message = f"found {deviation:g}, expected a standard deviation above 0"
            raise ArgumentError(message, f"sigma[{name!r}]")


def _same_place(one: Geometry, other: Geometry) -> bool:
    if isinstance(one, Point) or isinstance(other, Point):
        return one.position == other.position
    return one == other


def _numbers(text: str, start: int) -> list[Number]:
    """Return the numbers between commas outside of parentheses; the text begins at a column."""
    found = []
    for part in re.finditer(r"(?:\([^()]*\)|[^,])+|(?<=,)(?=,|$)|^$", text):
        word = part[0].strip()
        try:
            found.append(parse_number(word))
        except ValueError as error:
            column = start + part.start() + len(part[0]) - len(part[0].lstrip())
            raise ArgumentError(str(error), f"column {column}") from None
    return found


class _Words:
    """The words of a sensor with their columns, taken one after the other."""

    def __init__(self, text: str, instance: Instance) -> None:
        self.instance = instance
        found = re.finditer(r"\((?:[^()]|\([^()]*\))*\)?|\S+", text)
        self.words = [(word[0], word.start() + 1) for word in found]
        self.end = len(text.rstrip()) + 1

    def take(self, expected: str) -> tuple[str, int]:
        """Return the next word and its column."""
        if not self.words:
            raise ArgumentError(f"found no more words, expected {expected}", f"column {self.end}")
        return self.words.pop(0)

    def wrong(self, word: tuple[str, int], expected: str) -> ArgumentError:
        """Return the error of a word."""
        return ArgumentError(f"found {shown(word[0])}, expected {expected}", f"column {word[1]}")

    def one_of(self, *known: str) -> str:
        """Return the next word, which must be one of some."""
        word = self.take(listed(known))
        if word[0] not in known:
            raise self.wrong(word, listed(known))
        return word[0]

    def sensor(self) -> Sensor:
        """Return the sensor that the words name."""
        word = self.take(f"a sensor such as {_FORMS[0]}")
        kind = word[0].lower()
        if kind in ("leg", "distance", "angle"):
            return self.value(kind, word[1])
        if kind == "joint":
            return self.joint()
        if kind == "inclinometer":
            return Inclinometer(self.direction() if self.words else AXES["z"])
        if kind.startswith(("crank.", "slide.")):
            message = (
                f"{word[0]} reads the same at all modes, which are those for one position of the "
                "drives: expected a sensor of something else"
            )
            raise ArgumentError(message, f"column {word[1]}")
        raise self.wrong(word, f"one of {'; '.join(_FORMS)}{suggestion(kind, KINDS)}")

    def value(self, kind: str, column: int) -> Sensor:
        """Return the sensor of a leg, a distance or an angle."""
        here, there = (self.part(body, points=kind == "leg") for body in BODIES)
        kinds = [part.primitive(self.instance).primitive for part in (here, there)]
        initial = "A" if kind == "angle" else "D"
        found = KINDS_BY_NAME.get(initial + "".join(one.value for one in kinds))
        if found is None:
            what = " and ".join(f"a {one.name.lower()}" for one in kinds)
            raise ArgumentError(f"found {what}, which have no {kind}", f"column {column}")
        return ValueSensor(found, here, there)

    def joint(self) -> JointSensor:
        """Return the sensor of a joint's angle."""
        word = self.take("the number of a leg")
        if not word[0].isdecimal():
            raise self.wrong(word, f"the number of a leg, as in {_FORMS[1]}")
        leg = int(word[0][:4]) - 1
        body: Body = "platform" if self.one_of("platform", "base") == "platform" else "base"
        self.one_of("about")
        axis = self.direction()
        zero = _usual_zero(axis)
        if self.words:
            self.one_of("from")
            zero = self.direction()
        legs = [k + 1 for k, row in enumerate(self.instance.constraints) if row.kind is DPP]
        if leg + 1 not in legs:
            known = ", ".join(map(str, legs)) or "none here"
            message = f"found constraint {leg + 1}, expected a leg (DPP): {known}"
            raise ArgumentError(message, f"column {word[1]}")
        if np.linalg.norm(np.cross(*unit_vectors([axis, zero]))) < MEASURED_PARALLEL_SINE:
            message = "found an axis along the direction of zero: give another after from"
            raise ArgumentError(message, f"column {word[1]}")
        return JointSensor(leg, body, axis, zero)

    def direction(self) -> Vector:
        """Return a direction: x, y, z or a vector."""
        word = self.take("a direction: x, y, z or (x, y, z)")
        if word[0] in AXES:
            return AXES[word[0]]
        if not word[0].startswith("("):
            raise self.wrong(word, "a direction: x, y, z or (x, y, z)")
        found = self.vector(word)
        if not any(number.value for number in found):
            raise self.wrong(word, "a direction: any nonzero vector")
        return found

    def part(self, body: Body, *, points: bool) -> SensorPart:
        """Return a point of a body, or any primitive."""
        expected = f"a {'point' if points else 'point, line or plane'} of the {body}, or (x, y, z)"
        word = self.take(expected)
        if word[0].startswith("("):
            return SensorPart(body, position=self.vector(word))
        named = self.instance.named(body)
        known = [name for name, one in named.items() if isinstance(one, Point) or not points]
        if word[0] in known:
            return SensorPart(body, word[0])
        hint = suggestion(word[0], known) or (f": {listed(known)}" if len(known) > 1 else "")
        if word[0] in self.instance.named("base" if body == "platform" else "platform"):
            hint = ": the platform's comes first, the base's second"
        elif word[0] in named:
            hint = f": {word[0]} is no point"
        raise self.wrong(word, expected + hint)

    def vector(self, word: tuple[str, int]) -> Vector:
        """Return the vector that is written between parentheses."""
        text, column = word
        numbers = _numbers(text[1:-1], column + 1) if text.endswith(")") else []
        if len(numbers) != 3:
            raise self.wrong(word, "three numbers (x, y, z)")
        x, y, z = numbers
        return x, y, z
