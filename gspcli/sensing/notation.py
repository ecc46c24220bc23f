"""The notation of sensors and readings.

The grammar, with blanks between words::

    reading    = sensor "=" number { "," number } ( "±" | "+-" | "+/-" ) number
    sensor     = "leg" place place
               | "coordinate" direction place
               | "joint" leg ( "platform" | "base" ) "about" direction [ "from" direction ]
               | "inclinometer" [ direction ]
               | ( "distance" | "angle" ) part part
    part       = name | "(" number "," number "," number ")"
    place      = name | "(" number "," number "," number ")"
    direction  = "x" | "y" | "z" | "(" number "," number "," number ")"

A place is a point of the instance file, or coordinates in the frame of its body; a part is a point,
a line or a plane. The first place of a leg, the first part of a distance or angle, and the place of
a coordinate are on the platform. Numbers are written as in an instance file. The angle of a joint
is measured from the z axis by default, or from the x axis if its axis is along z.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from gspcli.catalogue.kinds import DPP, KINDS_BY_NAME
from gspcli.errors import ArgumentError
from gspcli.geometry.coordinates import Body
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number, parse_number
from gspcli.geometry.primitives import Geometry, Point, Vector
from gspcli.geometry.ranges import wrong_value
from gspcli.records import dataclass
from gspcli.sensing.sensor_kinds import (
    AXES,
    KINDS,
    CoordinateSensor,
    Inclinometer,
    JointSensor,
    LegSensor,
    Sensor,
    SensorPoint,
    ValueSensor,
    checked_joint,
    usual_zero,
)
from gspcli.wording import counted, listed, shown, suggestion

_SIGNS = ("±", "+/-", "+-")
_FORMS = {
    "leg": "leg P7 B7",
    "coordinate": "coordinate z P1",
    "joint": "joint 1 base about x",
    "inclinometer": "inclinometer",
    "distance": "distance P1 L2",
    "angle": "angle L1 H2",
}
_EXAMPLE = "leg P7 B7 = 212.4 ± 0.1"
_COUNTS = {1: "one number", 2: "two numbers, rx and ry"}


@dataclass(frozen=True)
class SensorReading:
    """A reading of a sensor.

    Attributes
    ----------
    sensor
        The sensor.
    values
        One number, or two for an inclinometer, in the units of the instance.
    sigma
        Their standard deviation.
    """

    sensor: Sensor
    values: tuple[float, ...]
    sigma: float

    def __str__(self) -> str:
        values = ", ".join(f"{value:.12g}" for value in self.values)
        return f"{self.sensor} = {values} ± {self.sigma:.12g}"


@dataclass(frozen=True)
class _Word:
    """A word of a text, and its column, from 1."""

    text: str
    column: int


def parse_sensor(text: str, instance: Instance, *, repeated: bool = False) -> Sensor:
    """Return the sensor that a text names.

    Parameters
    ----------
    text, instance
        The text, and the platform of its names.
    repeated
        Whether a leg may be that of a constraint, which is measured once more.

    Raises
    ------
    ArgumentError
        Names the column of the mistake.
    """
    words = _Words(text, instance)
    sensor = words.sensor()
    words.end()
    if not repeated:
        _check_new(sensor, instance)
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
    given, _, sigma = rest.partition(sign)
    values = [_number(word) for word in _parts(given, start)]
    count = 2 if isinstance(sensor, Inclinometer) else 1
    place = f"column {start + len(given) - len(given.lstrip())}"
    if len(values) != count:
        message = f"found {counted(len(values), 'number')}, expected {_COUNTS[count]}"
        raise ArgumentError(message, place)
    if wrong := _wrong(sensor, values[0], instance):
        message = f"found {values[0]:g}, {wrong}"
        raise ArgumentError(message, place)
    word = _Word(sigma.strip(), start + len(given) + len(sign) + len(sigma) - len(sigma.lstrip()))
    deviation = _number(word)
    if deviation <= 0:
        message = f"found {shown(word.text)}, expected a standard deviation above 0"
        raise ArgumentError(message, f"column {word.column}")
    return SensorReading(sensor, tuple(values), deviation)


def _wrong(sensor: Sensor, value: float, instance: Instance) -> str:
    """Return what is wrong with the value of a leg, a distance or an angle, or nothing."""
    if isinstance(sensor, LegSensor):
        return "" if value >= 0 else "expected a length of at least 0"
    if not isinstance(sensor, ValueSensor) or sensor.measured.has_sides:
        return ""
    return wrong_value(sensor.measured, Number.of(value), instance.units.angle)


def _check_new(sensor: Sensor, instance: Instance) -> None:
    """Raise an error if a sensor measures one of the constraints: all modes have its value."""
    if not isinstance(sensor, LegSensor | ValueSensor):
        return
    kind = DPP if isinstance(sensor, LegSensor) else sensor.measured
    ends = sensor.platform.primitive(instance), sensor.base.primitive(instance)
    for number, row in enumerate(instance.constraints, 1):
        if row.kind is kind and all(map(_same_place, ends, (row.platform, row.base))):
            message = (
                f"found constraint {number}, expected another {sensor.kind}: all modes have its "
                "value"
            )
            raise ArgumentError(message, "column 1")


def _same_place(one: Geometry, other: Geometry) -> bool:
    """Return whether two primitives of one body are at the same place, as stated."""
    if isinstance(one, Point) or isinstance(other, Point):
        return one.position == other.position
    return one == other


def _parts(text: str, start: int) -> Iterator[_Word]:
    """Yield the parts between commas with their columns; commas in parentheses do not count."""
    depth, begin = 0, 0
    for k, character in enumerate(f"{text},"):
        depth += (character == "(") - (character == ")")
        if character == "," and (depth <= 0 or k == len(text)):
            part = text[begin:k]
            yield _Word(part.strip(), start + begin + len(part) - len(part.lstrip()))
            begin = k + 1


def _exact(word: _Word) -> Number:
    try:
        return parse_number(word.text)
    except ValueError as error:
        raise ArgumentError(str(error), f"column {word.column}") from None


def _number(word: _Word) -> float:
    return _exact(word).value


class _Words:
    """The words of a sensor, taken one after the other."""

    def __init__(self, text: str, instance: Instance) -> None:
        self.instance = instance
        self.words = list(_split(text))
        self.next = 0
        self.last = len(text.rstrip()) + 1

    def take(self, expected: str) -> _Word:
        """Return the next word."""
        if self.next == len(self.words):
            message = f"found no more words, expected {expected}"
            raise ArgumentError(message, f"column {self.last}")
        self.next += 1
        return self.words[self.next - 1]

    def wrong(self, word: _Word, expected: str) -> ArgumentError:
        """Return the error of a word."""
        return ArgumentError(
            f"found {shown(word.text)}, expected {expected}", f"column {word.column}"
        )

    def end(self) -> None:
        """Raise an error if there are more words."""
        if self.next < len(self.words):
            raise self.wrong(self.words[self.next], "nothing more")

    def sensor(self) -> Sensor:
        """Return the sensor that the words name."""
        word = self.take(f"a sensor such as {_EXAMPLE.partition(' =')[0]}")
        kind = word.text.lower()
        if kind == "leg":
            return LegSensor(self.place("platform"), self.place("base"))
        if kind == "coordinate":
            return CoordinateSensor(self.direction(), self.place("platform"))
        if kind == "joint":
            return self.joint()
        if kind in ("distance", "angle"):
            return self.value(word, kind)
        if kind == "inclinometer":
            more = self.next < len(self.words)
            return Inclinometer(self.direction() if more else AXES["z"])
        if kind.startswith(("crank.", "slide.")):
            message = (
                f"{word.text} reads the same at all modes, which are those for one position of "
                "the motors: expected a sensor of something else"
            )
            raise ArgumentError(message, f"column {word.column}")
        forms = "; ".join(_FORMS.values())
        raise self.wrong(word, f"one of {forms}{suggestion(kind, KINDS)}")

    def value(self, first: _Word, quantity: str) -> Sensor:
        """Return the sensor of a distance or an angle of two primitives."""
        here, there = self.part("platform"), self.part("base")
        kinds = [place.primitive(self.instance).primitive for place in (here, there)]
        name = quantity[0].upper() + "".join(kind.value for kind in kinds)
        measured = KINDS_BY_NAME.get(name)
        if measured is None:
            what = " and ".join(f"a {kind.name.lower()}" for kind in kinds)
            message = f"found {what}, which have no {quantity}"
            raise ArgumentError(message, f"column {first.column}")
        return LegSensor(here, there) if measured is DPP else ValueSensor(measured, here, there)

    def part(self, body: Body) -> SensorPoint:
        """Return a point, a line or a plane of a body."""
        named = self.instance.named(body)
        if self.next < len(self.words) and self.words[self.next].text in named:
            return SensorPoint(body, self.take("").text)
        return self.place(body, "point, line or plane")

    def joint(self) -> JointSensor:
        """Return the sensor of a joint's angle."""
        first = word = self.take("the number of a leg")
        if not word.text.isdecimal():
            raise self.wrong(word, f"the number of a leg, as in {_FORMS['joint']}")
        leg = int(word.text[:4]) - 1
        word = self.take("platform or base")
        if word.text not in ("platform", "base"):
            raise self.wrong(word, "platform or base")
        body: Body = "platform" if word.text == "platform" else "base"
        word = self.take("about and an axis")
        if word.text != "about":
            raise self.wrong(word, "about and an axis")
        axis = self.direction()
        zero = usual_zero(axis)
        if self.next < len(self.words):
            word = self.take("from")
            if word.text != "from":
                raise self.wrong(word, "from and a direction, or nothing more")
            zero = self.direction()
        try:
            return checked_joint(self.instance, JointSensor(leg, body, axis, zero))
        except ArgumentError as error:
            raise ArgumentError(error.message, f"column {first.column}") from None

    def direction(self) -> Vector:
        """Return a direction: x, y, z or a vector."""
        word = self.take("a direction: x, y, z or (x, y, z)")
        if word.text in AXES:
            return AXES[word.text]
        if not word.text.startswith("("):
            raise self.wrong(word, "a direction: x, y, z or (x, y, z)")
        found = self.vector(word)
        if not any(number.value for number in found):
            raise self.wrong(word, "a direction: any nonzero vector")
        return found

    def place(self, body: Body, what: str = "point") -> SensorPoint:
        """Return a point of a body; `what` is expected, in words."""
        word = self.take(f"a {what} of the {body}, or (x, y, z)")
        if word.text.startswith("("):
            return SensorPoint(body, position=self.vector(word))
        named = self.instance.named(body)
        points = [
            name
            for name, geometry in named.items()
            if isinstance(geometry, Point) or what != "point"
        ]
        if word.text in points:
            return SensorPoint(body, word.text)
        other = self.instance.named("base" if body == "platform" else "platform")
        hint = suggestion(word.text, points) or (f": {listed(points)}" if len(points) > 1 else "")
        if word.text in other:
            hint = ": the platform's comes first, the base's second"
        elif word.text in named:
            hint = f": {word.text} is no point"
        raise self.wrong(word, f"a {what} of the {body}, or (x, y, z)" + hint)

    def vector(self, word: _Word) -> Vector:
        """Return the vector that is written between parentheses."""
        parts = list(_parts(word.text[1:-1], word.column + 1))
        if not word.text.endswith(")") or len(parts) != 3:
            raise self.wrong(word, "three numbers (x, y, z)")
        x, y, z = map(_exact, parts)
        return x, y, z


def _split(text: str) -> Iterator[_Word]:
    """Yield the words of a text; parentheses with their content are one word."""
    begin, depth = None, 0
    for k, character in enumerate(f"{text} "):
        if begin is None:
            if not character.isspace():
                begin, depth = k, int(character == "(")
            continue
        if character.isspace() and (depth <= 0 or k == len(text)):
            yield _Word(re.sub(r"\s+", " ", text[begin:k]), begin + 1)
            begin = None
        else:
            depth += (character == "(") - (character == ")")
