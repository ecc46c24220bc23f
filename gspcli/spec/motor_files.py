"""Files of symmetric hexapods with arms or rails, from the numbers of a drawing.

Three pairs of motors stand at 0, 120 and 240 degrees on a circle of the base, three pairs of joints
at 60, 180 and 300 degrees on one of the platform. Each rod goes to the nearer joint of the next
pair. Coordinates are written as expressions, so that the symmetry is exact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

from gspcli.errors import GspError
from gspcli.geometry.numbers import Number, parse_number
from gspcli.spec.form_of_instance import EDITOR_LINE
from gspcli.wording import listed, shown, suggestion

#: Significant digits of a height or an angle that is computed here.
_DIGITS = 13


class Key(NamedTuple):
    """A number or word of a drawing."""

    meaning: str
    default: str | None
    """What it is if it is not given; None if it must be, or may be left out."""


_RADII = {
    "base": Key("of the motors: radius of their circle, half the angle of a pair", None),
    "platform": Key("of the joints: radius of their circle, half the angle of a pair", None),
}
_LENGTHS = {
    "rod": Key("length of the rods", ""),
    "height": Key("of the platform above the motors at home", ""),
}
KEYS = {
    "rotary": {
        **_RADII,
        "horn": Key("length of the arms, from axis to joint", None),
        **_LENGTHS,
        "axis-angle": Key("of the axes with the middle direction of their pair", "0"),
        "horns": Key("out or in: away from the other motor of the pair, or towards it", "out"),
        "range": Key("of the motors, LOW:HIGH in degrees from home", "-60:60"),
        "unit": Key("of length", "mm"),
    },
    "linear": {
        **_RADII,
        **_LENGTHS,
        "tilt": Key("of the rails from the vertical, outwards", "0"),
        "rails": Key("6, or 3: the rods of a pair ride on one carriage, as in a linear delta", "6"),
        "range": Key("of the carriages, LOW:HIGH from home", ""),
        "unit": Key("of length", "mm"),
    },
}
#: Keys whose value is a word, with the words.
_WORDS = {"horns": ("out", "in"), "rails": ("6", "3")}
#: The second point of each carriage of three, and the first one.
_SECOND = {3: 2, 5: 4, 6: 1}
_HINT = "rod, height or both: without height the arms are level at home"


def motor_file(sort: str, words: Sequence[str], *, comments: bool = False) -> str:
    """Return the text of an instance file.

    Parameters
    ----------
    sort
        ``rotary``: motors turn arms; ``linear``: they move carriages along rails.
    words
        Numbers of the drawing, as KEY=NUMBER with the keys of `KEYS`; angles in degrees.
    comments
        Whether to say what each line means, and where editors find the schema.

    Raises
    ------
    GspError
        If a number is missing, is none or is not possible.
    """
    given = _given(sort, words)
    drawing = _Drawing(sort, given)
    lines = [
        f"# Made by: gsp new --{sort} {' '.join(words)}",
        "gsp: 1",
        f"name: {drawing.title}",
        "type: 6PP",
        f"units: {{length: {given['unit']}, angle: deg}}",
        *drawing.lines(),
    ]
    if comments:
        lines = [_with_comment(line, sort) for line in lines]
    return (EDITOR_LINE if comments else "") + "\n".join(lines) + "\n"


def _with_comment(line: str, sort: str) -> str:
    moved = "an arm turns the point" if sort == "rotary" else "a carriage moves the point"
    comment = {
        "platform:": "joints in the platform's frame",
        "base:": f"{moved}, which is stated at home; range from there",
        "constraints:": "rods of constant length",
        "home:": "the platform in the base; its origin is in the middle of its joints",
    }.get(line.split(" ")[0])
    return f"{line}  # {comment}" if comment else line


def _given(sort: str, words: Sequence[str]) -> dict[str, str]:
    """Return the text of each key, defaults included."""
    keys, found = KEYS[sort], {}
    for word in words:
        key, equal, text = word.partition("=")
        if key not in keys or not equal or not text:
            near = suggestion(key, keys)
            message = f"--{sort}: found {shown(word)}, expected KEY=NUMBER with {listed(keys)}"
            raise GspError(message + near)
        if key in found:
            raise GspError(f"--{sort}: found {key} twice, expected each once")
        found[key] = text
    for key, one in keys.items():
        if one.default is None and key not in found:
            missing = [k for k, other in keys.items() if other.default is None and k not in found]
            raise GspError(
                f"--{sort}: {listed(missing, 'and')} missing, expected KEY=NUMBER of each"
            )
        found.setdefault(key, one.default or "")
    for key in _RADII:
        radius, comma, angle = found[key].partition(",")
        if not comma or not radius or not angle:
            message = f"found {shown(found[key])}, expected RADIUS,HALF_ANGLE such as 80,12"
            raise GspError(f"--{sort}: {key}: {message}")
        found[key], found[f"{key}-angle"] = radius, angle
    if not found["rod"] and not found["height"]:
        raise GspError(f"--{sort}: found neither rod nor height, expected {_HINT}")
    for key, allowed in _WORDS.items():
        if key in found and found[key] not in allowed:
            message = f"found {shown(found[key])}, expected {listed(allowed)}"
            raise GspError(f"--{sort}: {key}: {message}")
    return found


class _Drawing:
    """The numbers of a drawing, and the lines of its file."""

    def __init__(self, sort: str, given: Mapping[str, str]) -> None:
        self.sort, self.given = sort, given
        self.numbers = {
            key: self._number(key)
            for key, text in given.items()
            if text and key not in (*_WORDS, "range", "unit")
        }
        for key, number in self.numbers.items():
            length = key in ("base", "platform", "horn", "rod")
            if length and not number > 0:
                raise GspError(f"--{sort}: {key}: found {given[key]}, expected a length above 0")
            if key.endswith(("base-angle", "platform-angle")) and not 0 <= number < 60:
                message = f"{key}: found {given[key]}, expected a half angle from 0, below 60"
                raise GspError(f"--{sort}: {message}")
        self.shared = given.get("rails") == "3"
        self.legs = [self._leg(k) for k in range(6)]
        self.rise = 0.0
        self.height = self._height()

    @property
    def title(self) -> str:
        """The name of the machine."""
        if self.sort == "rotary":
            return "Rotary hexapod"
        return "Linear delta" if self.shared else "Hexapod on rails"

    def _number(self, key: str) -> float:
        try:
            return parse_number(self.given[key]).value
        except ValueError as error:
            raise GspError(f"--{self.sort}: {key}: {error}") from None

    def _leg(self, k: int) -> dict[str, str]:
        """Return the expressions of a rod: its joints, the arm or rail."""
        pair, plus = (((k + 1) // 2) % 3, k % 2 == 0)
        middle, sign = Fraction(120 * pair), 1 if plus else -1
        base, platform = self.given["base"], self.given["platform"]
        a, b = self.given["base-angle"], self.given["platform-angle"]
        if self.shared:
            half = _sum(Fraction(0), 1, b)
            beside = f"{platform}*sind({half})"
            at, joint = (
                [f"{r}*{f}d({_text(middle)})" for f in ("cos", "sin")]
                for r in (base, f"{platform}*cosd({half})")
            )
            across = [f"{beside}*{f}d({_text((middle + 90 * sign) % 360)})" for f in ("cos", "sin")]
            centre, place = (
                ["" + x + " + " + y for x, y in zip(part, across, strict=True)]
                for part in (at, joint)
            )
        else:
            centre = _circle(base, _sum(middle, sign, a))
            place = _circle(platform, _sum(middle + sign * 60, -sign, b))
        return {
            "centre": f"{centre[0]}, {centre[1]}",
            "place": f"{place[0]}, {place[1]}",
            "middle": _text(middle % 360),
            "sense": "+" if plus else "-",
        }

    def _value(self, expressions: str) -> list[float]:
        return [parse_number(text).value for text in expressions.split(", ")]

    def _height(self) -> float:
        """Return the height at home; the angle of the arms there is noted."""
        leg = self.legs[0]
        x, y = (
            p - c
            for p, c in zip(self._value(leg["place"]), self._value(leg["centre"]), strict=True)
        )
        rod, height = self.numbers.get("rod"), self.numbers.get("height")
        horn = self.numbers.get("horn", 0.0)
        turn = math.radians(self._direction(leg))
        along = x * math.cos(turn) + y * math.sin(turn)
        beside = math.hypot(x, y) ** 2 - along**2
        if rod is None:
            assert height is not None
            return height
        if height is None:
            square = rod**2 - beside - (along - horn) ** 2
            if square <= 0:
                least = math.sqrt(beside + (along - horn) ** 2)
                message = f"rod: found {self.given['rod']}, expected more than {least:.6g}"
                raise GspError(f"--{self.sort}: {message}, how far apart its joints are in plan")
            found = float(f"{math.sqrt(square):.{_DIGITS}g}")
            # The platform of a delta hangs below its carriages.
            return -found if self.shared else found
        if self.sort == "linear":
            message = "found rod and height, expected one of them: a carriage is stated at height 0"
            raise GspError(f"--linear: {message}")
        # |(along, height) - horn (cos, sin)|^2 = rod^2 - beside.
        far = math.hypot(along, height)
        cosine = (far**2 + horn**2 + beside - rod**2) / (2 * horn * far)
        if abs(cosine) > 1:
            message = f"rod {self.given['rod']} does not join arm and platform at height"
            raise GspError(f"--rotary: {message} {self.given['height']}")
        both = [math.atan2(height, along) + s * math.acos(cosine) for s in (-1, 1)]
        near = min((math.remainder(x, math.tau) for x in both), key=abs)
        self.rise = float(f"{math.degrees(near):.{_DIGITS}g}")
        return height

    def _direction(self, leg: Mapping[str, str]) -> float:
        """Return the direction of an arm in plan, in degrees."""
        if self.sort == "linear":
            return 0.0
        return float(parse_number(self._turn(leg)).value)

    def _turn(self, leg: Mapping[str, str]) -> str:
        """Return the direction of an arm in plan as the text of degrees."""
        sign = 1 if leg["sense"] == "+" else -1
        quarter = 90 if self.given["horns"] == "out" else -90
        return _sum(Fraction(leg["middle"]) + sign * quarter, sign, self.given["axis-angle"])

    def lines(self) -> list[str]:
        """Return the sections of the file."""
        platform = [f"  P{k}: {{point: [{leg['place']}, 0]}}" for k, leg in enumerate(self.legs, 1)]
        base = [f"  B{k}: {{{self._driven(k, leg)}}}" for k, leg in enumerate(self.legs, 1)]
        value = self.given["rod"] or "home"
        rows = [f"  - {{distance: [P{k}, B{k}], value: {value}}}" for k in range(1, 7)]
        home = f"home: {{position: [0, 0, {_shortest(self.height)}]}}"
        return ["platform:", *platform, "base:", *base, "constraints:", *rows, home]

    def _driven(self, k: int, leg: Mapping[str, str]) -> str:
        """Return a point of the base with its drive."""
        span = self._range()
        if self.sort == "linear":
            point = f"point: [{leg['centre']}, 0]"
            if self.shared and k in _SECOND:
                return f"{point}, with: B{_SECOND[k]}"
            lean = self.given["tilt"]
            m = leg["middle"]
            rail = (
                "0, 0, 1"
                if not self.numbers["tilt"]
                else f"sind({lean})*cosd({m}), sind({lean})*sind({m}), cosd({lean})"
            )
            return f"{point}, slide: {{direction: [{rail}]{span}}}"
        turn, horn = self._turn(leg), self.given["horn"]
        axis = _sum(Fraction(-90), 1, turn)
        level = f"{horn}*cosd({self.rise!r})" if self.rise else horn
        up = f"{horn}*sind({self.rise!r})" if self.rise else "0"
        x, y = leg["centre"].split(", ")
        point = f"[{x} + {level}*cosd({turn}), {y} + {level}*sind({turn}), {up}]"
        centre, direction = f"[{x}, {y}, 0]", f"[cosd({axis}), sind({axis}), 0]"
        crank = f"crank: {{centre: {centre}, axis: {direction}{span}}}"
        return f"point: {point},\n       {crank}"

    def _range(self) -> str:
        text = self.given["range"]
        if not text:
            return ""
        low, colon, high = text.partition(":")
        try:
            ends = [parse_number(end).value for end in (low, high)] if colon else []
        except ValueError:
            ends = []
        if len(ends) != 2 or not ends[0] < ends[1]:
            message = f"found {shown(text)}, expected LOW:HIGH such as -60:60"
            raise GspError(f"--{self.sort}: range: {message}")
        return f", range: [{low}, {high}]"


def _circle(radius: str, angle: str) -> list[str]:
    """Return the expressions of a point of a circle."""
    return [f"{radius}*{name}d({angle})" for name in ("cos", "sin")]


def _sum(turned: Fraction, sign: int, angle: str) -> str:
    """Return the exact sum of two angles in degrees, the second with a sign, as a text."""
    exact = parse_number(angle).fraction
    if exact is None:
        return f"{_text(turned % 360)} {'+' if sign > 0 else '-'} ({angle})"
    return _text((turned + sign * exact) % 360)


def _text(number: Fraction) -> str:
    return str(Number.of(number))


def _shortest(number: float) -> str:
    return str(Number.of(number))
