"""Headings of other programs that have one meaning: ``X [mm]``, ``L1``, ``Roll``, ``Time``.

Their meanings are defined only here; a file is read as if it had our names. The meaning of a name
that differs between programs is not guessed: the message says what to write.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from gspcli.errors import Mistake, SpecError
from gspcli.geometry.instance import METRES, Instance
from gspcli.records import dataclass
from gspcli.wording import listed, nearest, shown, suggestion

#: A unit at the end of a heading, in brackets of either sort.
_UNIT = re.compile(r"(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]")
_LEG = re.compile(r"(?:l|leg|leg length|length|strut|actuator|cylinder) ?([1-6])")
#: Words about a coordinate, before it or after it.
_POSITION, _TURNED, _QUATERNION = (
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
        for pattern, prefix in ((_POSITION, ""), (_TURNED, "r"), (_QUATERNION, "q")):
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


# Which columns of a table are known; the others are refused, unless they are left out by name.
#
# A column with a misspelt heading would otherwise be dropped, and the numbers of the platform taken
# in its place.


#: What stands for any text in the name of a column that is left out.
_ANY = "*"
_NUMBERS = "123456"
#: What `gsp` writes beside poses and values: tables with these are read again without them.
BESIDE = frozenset(
    (
        *("number", "row", "mode", "real", "sides", "multiplicity", "residual", "certified"),
        *("condition", "home", "distance", "turn", "off", "fits", "status", "orientation"),
        *(
            "range",
            "cone",
            "clearance",
            "pose_clearance",
            "gap",
            "gap_between",
            "force",
            "moment",
            "stiffness",
        ),
        *("transmission", "torque", "torque_of"),
        *("power", "frequency", "error", "kinetic", "potential", "work"),
        *("shift", "limits", "way"),
        *(f"{name}{k}" for name in "fva" for k in _NUMBERS),
        *(f"{name}{axis}" for name in ("w", "v", "alpha", "a") for axis in "xyz"),
        *(f"t{axis}_imag" for axis in "xyz"),
        *(f"q{axis}_imag" for axis in "wxyz"),
        *(f"{turn}{axis}_{end}" for turn in ("", "r") for axis in "xyz" for end in ("low", "high")),
    )
)


def left_out(cells: Sequence[str], ignore: Collection[str], name: str) -> frozenset[int]:
    """Return the places of the columns that are left out because they are named.

    Parameters
    ----------
    cells
        The heading, as written.
    ignore
        Names of columns that are left out, as written in the heading or as `gsp` calls them. A name
        with ``*``, which stands for any text, leaves out unknown columns only.
    name
        How messages name the file.

    Raises
    ------
    SpecError
        If there is no such column.
    """
    if not ignore:
        return frozenset()
    meant = [Heading.of(cell).name for cell in cells]
    found: set[int] = set()
    for one in ignore:
        if _ANY in one:
            continue
        places = [k for k, cell in enumerate(cells) if cell == one]
        name_here = Heading.of(one).name.lower()
        places = places or [k for k, key in enumerate(meant) if key and key.lower() == name_here]
        if not places:
            message = f"{name} has no column {shown(one)}{suggestion(one, cells)}"
            raise SpecError([Mistake(None, "--ignore", message)])
        found.update(places)
    return frozenset(found)


def unknown(
    place: int,
    written: str,
    word: str,
    cells: Sequence[str],
    known: Collection[str],
    expected: str,
    ignore: Collection[str],
) -> str:
    """Return the message about an unknown column; empty if the column may be left out.

    That is so if a name with ``*`` in `ignore` is like it, if it has neither a name nor cells, or
    if it has no name, is the first one and counts the rows.

    Parameters
    ----------
    place
        Which column it is, from 0.
    written, word
        Its heading, and that without a unit.
    cells
        What is in it.
    known, expected
        The known names, and the text that lists them if none is spelt like this one.
    ignore
        Names of columns that are left out.
    """
    if any(_is_like(written, one) for one in ignore if _ANY in one):
        return ""
    hint = "(--ignore leaves it out)"
    if written:
        names = {*known, *(name for name in WORDS if Heading.of(name).name in known)}
        near = nearest(word, sorted(names))
        said = f": did you mean {near}?" if near else f", expected {expected}"
        return f"found the unknown column {shown(written)}{said} {hint}"
    stripped = [cell.strip() for cell in cells]
    counted = any(stripped == [str(k + first) for k in range(len(stripped))] for first in (0, 1))
    if not any(stripped) or (place == 0 and counted):
        return ""
    return f"found a column without a name, expected one {hint}"


def _is_like(written: str, pattern: str) -> bool:
    """Return whether a heading is like a name with stars."""
    parts = map(re.escape, pattern.split(_ANY))
    return re.fullmatch(".*".join(parts), written, re.IGNORECASE) is not None


# Units of columns: which kind of quantity a column is, and by what its numbers are multiplied.
#
# A column has its kind by its name: x is a length, rx an angle, t a time. A unit of another kind is
# an error, since the number cannot be what the heading says.


class ColumnQuantity(NamedTuple):
    """A kind of quantity: its name in messages, its units by lower-case names, examples."""

    what: str
    units: Mapping[str, float]
    """In metres, radians, seconds, newtons."""
    examples: tuple[str, ...]


_LENGTH = ColumnQuantity(
    "a length",
    {
        **{unit.lower(): size for unit, size in METRES.items()},
        **dict.fromkeys(("meter", "metre", "meters", "metres"), 1.0),
        **dict.fromkeys(("millimeter", "millimetre", "millimeters", "millimetres"), 1e-3),
    },
    ("m", "mm", "in"),
)
_ANGLE = ColumnQuantity(
    "an angle",
    {
        **dict.fromkeys(("deg", "degree", "degrees", "°"), math.pi / 180),
        **dict.fromkeys(("rad", "radian", "radians"), 1.0),
        "mrad": 1e-3,
    },
    ("deg", "rad", "mrad"),
)
_TIME = ColumnQuantity(
    "a time",
    {**dict.fromkeys(("s", "sec", "second", "seconds"), 1.0), "ms": 1e-3, "min": 60.0},
    ("s", "ms", "min"),
)
_FORCE = ColumnQuantity("a force", {"n": 1.0, "kn": 1e3}, ("N", "kN"))
_TORQUE = ColumnQuantity("a torque", {"nm": 1.0, "n m": 1.0}, ("N m",))
_NUMBER = ColumnQuantity("a number without a unit", {"-": 1.0, "1": 1.0}, ())
_VALUE = (_LENGTH, _ANGLE)

#: The kinds of quantities of columns, by their names as `Heading.name`, and how often the quantity
#: is derived by time; the first pattern that fits counts.
_COLUMNS: tuple[tuple[str, tuple[ColumnQuantity, ...], int], ...] = (
    ("t", (_TIME,), 0),
    ("t?[xyz]", (_LENGTH,), 0),
    ("r[xyz]", (_ANGLE,), 0),
    ("q[wxyz]|r[123][123]", (_NUMBER,), 0),
    ("[1-6]", _VALUE, 0),
    ("v[1-6]", _VALUE, 1),
    ("a[1-6]", _VALUE, 2),
    ("v[xyz]", (_LENGTH,), 1),
    ("a[xyz]", (_LENGTH,), 2),
    ("w[xyz]", (_ANGLE,), 1),
    ("alpha[xyz]", (_ANGLE,), 2),
    ("f[1-6]", (_FORCE, _TORQUE), 0),
    (r"incl\.[xy]|crank\..+", (_ANGLE,), 0),
    (r"slide\..+", (_LENGTH,), 0),
    (r"(platform|base)\..+\.(direction|normal|axis)\.[xyz]", (_NUMBER,), 0),
    (r".+\.[xyz]", (_LENGTH,), 0),
)
_RATE = re.compile(r"(.*?)\s*/\s*s(?:ec)?(\^?2|²)?")


@dataclass(frozen=True)
class FileUnits:
    """The units to which the numbers of a file are converted.

    Attributes
    ----------
    length
        The name of the unit of lengths; empty if it does not matter.
    in_radians
        The unit of angles.
    angles
        The names of the columns of values that are angles; the others are lengths. None if either
        is possible.
    """

    length: str = ""
    in_radians: float = 1.0
    angles: frozenset[str] | None = None

    def of(self, instance: Instance) -> FileUnits:
        """Return the same for files in which the columns 1 to 6 are those of an instance."""
        rows = enumerate(instance.constraints, 1)
        return replace(
            self, angles=frozenset(str(k) for k, row in rows if not row.kind.is_distance)
        )

    def factor(self, column: str, unit: str) -> float | str:
        """Return by what the numbers of a column are multiplied, or what is wrong with its unit.

        Parameters
        ----------
        column
            Its name as it is called here (`gspcli.motion.files.headings.Heading`).
        unit
            What is in brackets. Velocities and accelerations have their own: mm/s and deg/s^2.
        """
        if not unit:
            return 1.0
        quantities, order = self._quantities(column)
        rate = _RATE.fullmatch(unit.lower())
        found = (2 if rate[2] else 1) if rate else 0
        base = rate[1] if rate else unit.lower()
        for quantity in quantities if found == order else ():
            if quantity is _LENGTH and not self._metric:
                # Another unit cannot be converted into one that is not known.
                known = base in _LENGTH.units if not self.length else base == self.length.lower()
                if known or base in _NUMBER.units:
                    return 1.0
            elif base in quantity.units:
                return quantity.units[base] / self._size(quantity)
        per = ("", "/s", "/s^2")[order]
        examples = [f"{one}{per}" for kind in quantities for one in self._examples(kind)]
        what = listed(kind.what for kind in quantities) + ("", " per s", " per s^2")[order]
        expected = f"expected {listed(examples)}" if examples else "expected none"
        return f"found the unit {shown(unit)} of the column {column}, {what}: {expected}"

    @property
    def _metric(self) -> bool:
        """Whether the size of the unit of lengths is known."""
        return self.length.lower() in _LENGTH.units

    def _quantities(self, column: str) -> tuple[tuple[ColumnQuantity, ...], int]:
        """Return what a column can be, and how often it is derived by time."""
        for pattern, quantities, order in _COLUMNS:
            if re.fullmatch(pattern, column, re.IGNORECASE):
                if quantities is _VALUE and self.angles is not None:
                    quantities = (_ANGLE if column[-1] in self.angles else _LENGTH,)
                return quantities, order
        return (_NUMBER,), 0

    def _size(self, quantity: ColumnQuantity) -> float:
        """Return the unit to which numbers of a kind are converted, in metres, radians, …."""
        if quantity is _LENGTH:
            return _LENGTH.units[self.length.lower()]
        return self.in_radians if quantity is _ANGLE else 1.0

    def _examples(self, quantity: ColumnQuantity) -> tuple[str, ...]:
        if quantity is _LENGTH and self.length and not self._metric:
            return (self.length,)
        return quantity.examples
