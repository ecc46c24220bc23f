"""Units of columns: which kind of quantity a column is, and by what its numbers are multiplied.

A column has its kind by its name: x is a length, rx an angle, t a time. A unit of another kind is
an error, since the number cannot be what the heading says.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from gspcli.geometry.instance import Instance
from gspcli.geometry.lengths import METRES
from gspcli.records import dataclass
from gspcli.wording import listed, shown


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
