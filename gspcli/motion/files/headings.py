"""Headings of other programs that have one meaning: ``X [mm]``, ``L1``, ``Roll``, ``Time``.

Their meanings are defined only here; a file is read as if it had our names. The meaning of a name
that differs between programs is not guessed: the message says what to write.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

from gspcli.records import dataclass
from gspcli.wording import listed

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
ROLL_PITCH_YAW = {"roll": "rx", "pitch": "ry", "yaw": "rz"}


class Order(NamedTuple):
    """Headings of turns about x, y and z, and the order that is taken if none is given."""

    names: tuple[str, str, str]
    sequence: str
    """As `gspcli.geometry.euler` has it."""
    source: str
    """Who has it so, for messages."""

    @property
    def words(self) -> str:
        """The message about a file with such headings."""
        heads = " ".join(self.names if len(self.names[0]) > 1 else map(str.upper, self.names))
        return (
            f"{heads}: turns about x, y, z in the order {self.sequence}{self.source} "
            "(--euler gives another)"
        )


#: Roll, pitch and yaw are xyz about the axes of the base, which is ZYX about those of the platform.
ORDERS = (
    Order(("roll", "pitch", "yaw"), "ZYX", ""),
    Order(("u", "v", "w"), "XYZ", ", as controllers of PI have it"),
    Order(("a", "b", "c"), "ZYX", ", as LinuxCNC has it"),
)
#: Words of other programs in full, from which suggestions for misspelt ones are taken.
WORDS = (
    *_TIMES,
    *ROLL_PITCH_YAW,
    *(f"{word} {k}" for word in ("leg", "length") for k in range(1, 7)),
    *(f"{word} {axis}" for word in ("position", "rotation") for axis in "xyz"),
    *(f"quaternion {axis}" for axis in "wxyz"),
)
#: Headings of other programs with more than one meaning, and what to write instead.
_AMBIGUOUS = (
    (("a", "b", "c", "u", "v", "w"), "A B C and U V W may both be turns: leave out one of them"),
    (("alpha", "beta", "gamma"), "alpha beta gamma do not say about which axes: write rx ry rz"),
    (("phi", "theta", "psi"), "phi theta psi do not say about which axes: write rx ry rz"),
    (("q0", "q1", "q2", "q3"), "q0 ... q3 do not say which is the scalar: write qw qx qy qz"),
    (("q1", "q2", "q3", "q4"), "q1 ... q4 do not say which is the scalar: write qw qx qy qz"),
)


@dataclass(frozen=True)
class Heading:
    """A cell of a heading.

    Attributes
    ----------
    name
        Our name of the column. A name with a dot is kept as written: it contains a name that the
        user has chosen.
    word
        The heading as written, without a unit.
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


def headings(texts: Sequence[str]) -> list[Heading]:
    """Return what the cells of a heading mean; A B C or U V W beside X Y Z are turns."""
    found = [Heading.of(text) for text in texts]
    names = {one.name for one in found}
    groups = [order.names for order in ORDERS[1:] if {*order.names} <= names]
    if len(groups) != 1 or not {"x", "y", "z"} <= names or {"rx", "ry", "rz"} & names:
        return found
    turns = dict(zip(groups[0], ("rx", "ry", "rz"), strict=True))
    return [replace(one, name=turns.get(one.name, one.name)) for one in found]


def order_of(words: Collection[str]) -> Order | None:
    """Return the order that the headings of a file say, without units; None if they say none."""
    names = {word.lower().strip() for word in words}
    return next((order for order in ORDERS if {*order.names} <= names), None)


def hints(names: Collection[str]) -> str:
    """Return what to write for names that have no one meaning; nothing if there are no such."""
    found = [text for group, text in _AMBIGUOUS if {*group} <= {name.lower() for name in names}]
    return f": {listed(found, 'and')}" if found else ""
