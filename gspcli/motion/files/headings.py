"""Headings of other programs, where they have one meaning: ``X [mm]``, ``L1``, ``Roll``, ``Time``.

What they mean is said here and nowhere else; a file is read as if it had our names. Names that
mean different things in different programs are not guessed: messages say what to write.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection

from gspcli.geometry.lengths import METRES
from gspcli.records import dataclass
from gspcli.wording import listed, shown

#: A unit at the end of a heading, in brackets of either sort.
_UNIT = re.compile(r"(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]")
_LEG = re.compile(r"(?:l|leg|leg length|length|strut|actuator|cylinder) ?([1-6])")
#: Words about a coordinate, before it or after it.
_POSITION, _ANGLE, _QUATERNION = (
    re.compile(rf"(?:{words}) ?({axes})|({axes}) (?:{words})")
    for words, axes in (
        ("p|pos|position", "[xyz]"),
        ("rot|rotation|theta|angle", "[xyz]"),
        ("q|quat|quaternion|orientation", "[wxyz]"),
    )
)
_TIMES = ("time", "timestamp")
#: Turns about x, y, z, and their order where nothing else is said: about the axes of the base, that
#: is ZYX about those of the platform.
ROLL_PITCH_YAW = {"roll": "rx", "pitch": "ry", "yaw": "rz"}
SEQUENCE = "ZYX"
#: What is written in other programs and has no one meaning, with what to write.
_AMBIGUOUS = (
    (("a", "b", "c"), "A B C are turns in another order in each program: write rx ry rz"),
    (("u", "v", "w"), "U V W are turns in one program and axes in another: write rx ry rz"),
    (("alpha", "beta", "gamma"), "alpha beta gamma do not say about which axes: write rx ry rz"),
    (("phi", "theta", "psi"), "phi theta psi do not say about which axes: write rx ry rz"),
    (("q0", "q1", "q2", "q3"), "q0 ... q3 do not say which is the scalar: write qw qx qy qz"),
    (("q1", "q2", "q3", "q4"), "q1 ... q4 do not say which is the scalar: write qw qx qy qz"),
)

#: Units in radians, in seconds, and those in which numbers are taken as they are.
_RADIANS = {
    **dict.fromkeys(("deg", "degree", "degrees", "°"), math.pi / 180),
    **dict.fromkeys(("rad", "radian", "radians"), 1.0),
    "mrad": 1e-3,
}
_SECONDS = {**dict.fromkeys(("s", "sec", "second", "seconds"), 1.0), "ms": 1e-3, "min": 60.0}
_PLAIN = {"", "-", "1", "n", "nm", "n m"}
_LENGTHS = {
    **{unit.lower(): size for unit, size in METRES.items()},
    **dict.fromkeys(("meter", "metre", "meters", "metres"), 1.0),
    **dict.fromkeys(("millimeter", "millimetre", "millimeters", "millimetres"), 1e-3),
}


@dataclass(frozen=True)
class Heading:
    """A cell of a heading.

    Attributes
    ----------
    name
        What the column is called here. Names with a dot are kept as they are written: they name
        what somebody has named.
    word
        The same as it is written, without a unit.
    unit
        What is in brackets, or None.
    is_leg
        Whether it says that the column is the length of a leg.
    """

    name: str
    word: str
    unit: str | None = None
    is_leg: bool = False

    @classmethod
    def of(cls, text: str) -> Heading:
        """Return what a cell of a heading means."""
        match = _UNIT.fullmatch(text)
        word, unit = (match[1], match[2]) if match and match[1] else (text, None)
        if "." in word:
            return cls(word, word, unit)
        plain = " ".join(re.split(r"[\s_-]+", word.lower().strip()))
        if leg := _LEG.fullmatch(plain):
            return cls(leg[1], word, unit, is_leg=True)
        for pattern, prefix in ((_POSITION, ""), (_ANGLE, "r"), (_QUATERNION, "q")):
            if found := pattern.fullmatch(plain):
                return cls(prefix + (found[1] or found[2]), word, unit)
        if plain in _TIMES:
            return cls("t", word, unit)
        return cls(ROLL_PITCH_YAW.get(plain, word.lower()), word, unit)


@dataclass(frozen=True)
class FileUnits:
    """The units in which numbers are wanted; a file that names others is converted.

    Attributes
    ----------
    length
        The name of the unit of lengths; empty if it does not matter.
    in_radians
        The unit of angles.
    """

    length: str = ""
    in_radians: float = 1.0

    def factor(self, unit: str) -> float | str:
        """Return by what numbers with a unit are multiplied, or what is wrong with the unit.

        Velocities and accelerations, as mm/s and deg/s^2, are those of the unit before the stroke.
        """
        base = re.sub(r"\s*/\s*s(\^?2|²)?$", "", unit.lower())
        if base in _PLAIN or (not self.length and base in _LENGTHS) or base == self.length.lower():
            return 1.0
        if base in _RADIANS:
            return _RADIANS[base] / self.in_radians
        if base in _SECONDS and base == unit.lower():
            return _SECONDS[base]
        own = _LENGTHS.get(self.length.lower())
        if base in _LENGTHS and own is not None:
            return _LENGTHS[base] / own
        return f"found the unit {shown(unit)}, expected {self.length or 'a length'}, deg, rad or s"


def hints(names: Collection[str]) -> str:
    """Return what to write for names that have no one meaning; nothing if there are no such."""
    found = [text for group, text in _AMBIGUOUS if {*group} <= {name.lower() for name in names}]
    return f": {listed(found, 'and')}" if found else ""
