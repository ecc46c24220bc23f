"""Requirements on poses, and the worst of many rows for each requirement.

Requirements are written as ``range, cone, clearance>=0.5, condition<=50``. `QUANTITIES` defines the
quantities and whether a large or a small number is better. `judge` takes their numbers for n poses
and says whether all poses keep the requirements.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import GspError
from gspcli.geometry.instance import Array
from gspcli.motion.files.number_tables import wrong_number
from gspcli.records import dataclass
from gspcli.ties import first_largest
from gspcli.wording import listed, shown, suggestion


class RequiredQuantity(NamedTuple):
    """A quantity on which a pose can have a requirement."""

    least: bool
    """Whether a requirement says the least that it may be, else the most."""
    limit: float | None
    """What is required where no number is given; None if one must be."""
    meaning: str
    """What the number is, for the help."""


QUANTITIES = {
    "range": RequiredQuantity(
        False, 1.0, "the share of its range that a value takes, 1 at the ends"
    ),
    "transmission": RequiredQuantity(
        True, None, "how much of a motor's motion acts along its rod, 0 to 1"
    ),
    "cone": RequiredQuantity(False, 1.0, "the tilt of a leg by the half angle of its cone"),
    "clearance": RequiredQuantity(True, None, "proved, as gsp clearance"),
    "pose-clearance": RequiredQuantity(True, None, "proved, as gsp clearance --of pose"),
    "condition": RequiredQuantity(False, None, "the condition number"),
    "gap": RequiredQuantity(True, None, "the least gap between legs and bodies, by shapes in SPEC"),
    "force": RequiredQuantity(False, None, "the largest force in a constraint under the load"),
    "moment": RequiredQuantity(False, None, "the largest moment in an angle under the load"),
    "torque": RequiredQuantity(False, None, "the largest torque of a crank under the load"),
    "stiffness": RequiredQuantity(True, None, "the least stiffness of the point"),
    "power": RequiredQuantity(False, None, "what all drives do, as gsp dynamics"),
    "frequency": RequiredQuantity(
        True, None, "the lowest natural frequency, as gsp dynamics --modes"
    ),
    "error": RequiredQuantity(False, None, "the proved error of the point from the tolerances"),
}

_PART = re.compile(r"([a-z-]+)\s*(?:(<=|>=|≤|≥)\s*(.*))?", re.DOTALL)
_SIGNS = {"≤": "<=", "≥": ">="}


@dataclass(frozen=True)
class Requirement:
    """One requirement."""

    #: A key of `QUANTITIES`.
    quantity: str
    #: The largest, or the smallest, number that is allowed.
    limit: float

    def __str__(self) -> str:
        sign = ">=" if QUANTITIES[self.quantity].least else "<="
        return f"{self.quantity} {sign} {self.limit:g}"


def parse_requirements(text: str) -> list[Requirement]:
    """Read the requirements of `--require`: names with numbers, between commas.

    Parameters
    ----------
    text
        Such as ``range, cone, clearance>=0.5``; range and cone have no number.

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
            raise GspError(f"--require: found {shown(part.strip())}, expected {known}{near}")
        quantity = QUANTITIES[name]
        wanted = ">=" if quantity.least else "<="
        if not sign and quantity.limit is not None:
            limit = quantity.limit
        elif _SIGNS.get(sign, sign) != wanted:
            raise GspError(f"--require: found {shown(part.strip())}, expected {name}{wanted}NUMBER")
        elif wrong := wrong_number(number.strip()):
            raise GspError(f"--require: {name}: {wrong}")
        else:
            limit = float(number)
        if any(one.quantity == name for one in found):
            raise GspError(f"--require: found {name} twice, expected each quantity once")
        found.append(Requirement(name, limit))
    return found


class QuantityParts(NamedTuple):
    """A quantity of n poses that is the worst of several parts."""

    values: Array
    """Shape (n, parts)."""
    names: Sequence[str]
    """What the parts are called."""

    @property
    def largest(self) -> Array:
        """The largest part, shape (n,)."""
        return np.asarray(self.values.max(axis=1))

    @property
    def least(self) -> Array:
        """The least part, shape (n,)."""
        return np.asarray(self.values.min(axis=1))


@dataclass(frozen=True)
class RequirementVerdict:
    """Whether all rows keep a requirement, and the worst row."""

    #: The requirement.
    requirement: Requirement
    #: Whether all rows keep it.
    met: bool
    #: The number in the worst row; NaN if it could not be computed, which violates the requirement.
    worst: float
    #: The index of that row.
    row: int
    #: The part with this number, such as ``constraint 2``; empty if there are no parts.
    part: str = ""
    #: Whether it is also judged between the rows.
    between: bool = False


def keeping(
    requirements: Sequence[Requirement], quantities: Mapping[str, Array | QuantityParts]
) -> NDArray[np.bool_]:
    """Return which of n poses keep all requirements, shape (n,); arguments as for `judge`."""
    kept = np.ones(1, bool)
    for one in requirements:
        given = quantities[one.quantity]
        parts = given.values if isinstance(given, QuantityParts) else given[:, None]
        least = QUANTITIES[one.quantity].least
        # What is not known is not kept.
        kept = kept & (parts >= one.limit if least else parts <= one.limit).all(axis=1)
    return np.asarray(kept)


def judge(
    requirements: Sequence[Requirement], quantities: Mapping[str, Array | QuantityParts]
) -> list[RequirementVerdict]:
    """Return for each requirement whether all rows keep it, and the first worst row.

    Parameters
    ----------
    requirements
        The requirements.
    quantities
        The numbers of n poses by the keys of `QUANTITIES`: shape (n,), or in parts. NaN stands for
        a number that could not be computed: it violates a requirement that all others keep.

    Raises
    ------
    GspError
        If there is no pose.
    """
    verdicts = []
    for one in requirements:
        given = quantities[one.quantity]
        parts = given if isinstance(given, QuantityParts) else QuantityParts(given[:, None], ("",))
        if not parts.values.size:
            raise GspError(f"there is no pose of which {one} could be required")
        least = QUANTITIES[one.quantity].least
        unknown = np.isnan(parts.values)
        bad = np.where(unknown, -np.inf, parts.values * (-1 if least else 1))
        if unknown.any() and bad.max() <= one.limit * (-1 if least else 1):
            # No number violates it, and of some it is not known.
            bad = np.where(unknown, 1.0, 0.0)
        row, part = np.unravel_index(int(first_largest(bad.ravel())), bad.shape)
        worst = float(parts.values[row, part])
        met = worst >= one.limit if least else worst <= one.limit
        verdicts.append(RequirementVerdict(one, met, worst, int(row), parts.names[int(part)]))
    return verdicts
