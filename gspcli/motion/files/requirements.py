"""What is required of poses, and which of many rows of them is the worst.

Requirements are written as ``range, cone, clearance>=0.5, condition<=50``. What a quantity is, and
whether much or little of it is good, is said here once; who has computed it for n poses asks
`judge` whether all of them keep what is required.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import GspError
from gspcli.motion.files.number_tables import wrong_number
from gspcli.records import dataclass
from gspcli.wording import listed, shown, suggestion

Array = NDArray[np.float64]


class Quantity(NamedTuple):
    """Something that may be required of a pose."""

    least: bool
    """Whether a requirement says the least that it may be, else the most."""
    limit: float | None
    """What is required where no number is given; None if one must be."""
    meaning: str
    """What the number is, for the help."""


QUANTITIES = {
    "range": Quantity(False, 1.0, "the share of its range that a value takes, 1 at the ends"),
    "cone": Quantity(False, 1.0, "the tilt of a leg by the half angle of its cone"),
    "clearance": Quantity(True, None, "proved, as gsp clearance"),
    "pose-clearance": Quantity(True, None, "proved, as gsp clearance --of pose"),
    "condition": Quantity(False, None, "the condition number"),
    "force": Quantity(False, None, "the largest force in a constraint under the load"),
    "moment": Quantity(False, None, "the largest moment in an angle under the load"),
    "stiffness": Quantity(True, None, "the least stiffness of the point"),
    "power": Quantity(False, None, "what all drives do, as gsp dynamics"),
    "frequency": Quantity(True, None, "the lowest natural frequency, as gsp dynamics --modes"),
    "error": Quantity(False, None, "the proved error of the point from the tolerances"),
}

_PART = re.compile(r"([a-z-]+)\s*(?:(<=|>=|≤|≥)\s*(.*))?", re.DOTALL)
_SIGNS = {"≤": "<=", "≥": ">="}


@dataclass(frozen=True)
class Requirement:
    """One requirement.

    Attributes
    ----------
    quantity
        A key of `QUANTITIES`.
    limit
        The most, or the least, that it may be.
    """

    quantity: str
    limit: float

    def __str__(self) -> str:
        sign = ">=" if QUANTITIES[self.quantity].least else "<="
        return f"{self.quantity} {sign} {self.limit:g}"


def parse_requirements(text: str, option: str = "--require") -> list[Requirement]:
    """Read requirements: names with numbers, between commas.

    Parameters
    ----------
    text
        As ``range, cone, clearance>=0.5``; range and cone alone mean that they are kept.
    option
        How errors name what was read.

    Raises
    ------
    GspError
        If a quantity is not known, stands twice, or has no number or the wrong sign.
    """
    found: list[Requirement] = []
    for part in text.split(","):
        match = _PART.fullmatch(part.strip().lower().replace("_", "-"))
        name, sign, number = match.groups(default="") if match else (part.strip(), "", "")
        if name not in QUANTITIES:
            known = listed(QUANTITIES)
            near = suggestion(name, QUANTITIES)
            message = f"{option}: found {shown(part.strip())}, expected {known}{near}"
            raise GspError(message)
        quantity = QUANTITIES[name]
        wanted = ">=" if quantity.least else "<="
        if not sign and quantity.limit is not None:
            limit = quantity.limit
        elif _SIGNS.get(sign, sign) != wanted:
            message = f"{option}: found {shown(part.strip())}, expected {name}{wanted}NUMBER"
            raise GspError(message)
        elif wrong := wrong_number(number.strip()):
            message = f"{option}: {name}: {wrong}"
            raise GspError(message)
        else:
            limit = float(number)
        if any(one.quantity == name for one in found):
            message = f"{option}: found {name} twice, expected each quantity once"
            raise GspError(message)
        found.append(Requirement(name, limit))
    return found


class Parts(NamedTuple):
    """A quantity of n poses that is the largest of several parts."""

    values: Array
    """Shape (n, parts)."""
    names: Sequence[str]
    """What the parts are called."""

    @property
    def largest(self) -> Array:
        """The quantity, shape (n,)."""
        return np.asarray(self.values.max(axis=1))


@dataclass(frozen=True)
class Verdict:
    """Whether all rows keep a requirement.

    Attributes
    ----------
    requirement
        The requirement.
    met
        Whether they do.
    worst
        The number in the worst row; NaN if it has none there, which is not met.
    row
        The index of that row.
    part
        What it is the number of, such as ``constraint 2``; empty where there are no parts.
    """

    requirement: Requirement
    met: bool
    worst: float
    row: int
    part: str = ""


def judge(
    requirements: Sequence[Requirement], quantities: Mapping[str, Array | Parts]
) -> list[Verdict]:
    """Return for each requirement whether all rows keep it, and the worst row.

    Parameters
    ----------
    requirements
        What is required.
    quantities
        The numbers of n poses by the keys of `QUANTITIES`: shape (n,), or in parts. NaN is what
        could not be computed: the worst of all.

    Raises
    ------
    GspError
        If there is no pose.
    """
    verdicts = []
    for one in requirements:
        given = quantities[one.quantity]
        parts = given if isinstance(given, Parts) else Parts(given[:, None], ("",))
        if not parts.values.size:
            message = f"there is no pose of which {one} could be required"
            raise GspError(message)
        least = QUANTITIES[one.quantity].least
        bad = np.where(np.isnan(parts.values), np.inf, parts.values * (-1 if least else 1))
        row, part = np.unravel_index(int(bad.argmax()), bad.shape)
        worst = float(parts.values[row, part])
        met = worst >= one.limit if least else worst <= one.limit
        verdicts.append(Verdict(one, met, worst, int(row), parts.names[int(part)]))
    return verdicts
