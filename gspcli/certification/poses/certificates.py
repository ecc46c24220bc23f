"""Certificates: the proved properties of approximate poses, of each and of all together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from enum import Enum
from typing import TYPE_CHECKING, Any, overload

from gspcli.certification.poses.isolation import Isolation
from gspcli.geometry.instance import Instance, Side
from gspcli.records import dataclass

if TYPE_CHECKING:
    import pandas as pd


class Outcome(Enum):
    """The reason why a candidate is certified or not."""

    CERTIFIED = "certified"
    REFUTED = "refuted"
    TOO_FAR = "too far"
    NOT_AS_STATED = "not as stated"
    NOT_ISOLATED = "not isolated"
    NOT_A_NUMBER = "not a number"

    @property
    def meaning(self) -> str:
        """The outcome in a sentence."""
        return _MEANINGS[self]


_MEANINGS = {
    Outcome.CERTIFIED: "one simple solution is proved to be near, and alone there",
    Outcome.REFUTED: "it is proved that no solution is within the tolerance",
    Outcome.TOO_FAR: "no solution is proved to be within the tolerance, nor that there is none",
    Outcome.NOT_AS_STATED: "the solution nearby is not proved to meet the constraints as stated",
    Outcome.NOT_ISOLATED: "no simple, isolated solution could be proved nearby",
    Outcome.NOT_A_NUMBER: "a number of the pose or of the instance is not finite",
}


@dataclass(frozen=True)
class Certificate:
    """The proved properties of one candidate.

    Attributes
    ----------
    outcome
        `Outcome.CERTIFIED`, or the reason why nothing is proved.
    real
        True if the solution is proved to be real, False if it is proved not to be, else None.
    error
        Proved bound of the distance between the solution and `isolation.centre`, in Study
        coordinates (lengths by the scale of the instance).
    uniqueness
        Radius of the ball about that centre in which there is no other solution with the
        same sides.
    deviation
        Proved bound of the difference between the candidate and the solution in any entry of R
        and of T, the latter divided by `length`.
    length
        The unit of deviations of T: `Certificates.least_length`. If T is larger than eight scales,
        so that it has a relative error, the unit is the scale.
    residual_bound
        For real solutions: proved bound of the difference between the values measured on the
        candidate (its given numbers are exact) and the stated values, in the units of the instance.
    sides
        For each constraint the side on which the point of a real solution is proved to lie, and
        that of its equation for another; None where a constraint has no sides, the distance is
        zero or nothing is proved, and for a solution that may be either.
    same_as
        Index of the first candidate that is proved to approximate the same solution.
    unresolved
        Indices of the candidates whose solutions are proved to be neither the same nor different,
        and of those that approximate the same solution, but have another solution as near in
        doubles.
    precision
        Bits of the last attempt.
    isolation
        The proof, from which the solution can be refined.
    equivalent
        The instance whose equations the proof uses, if it is not the given one: it has the same
        poses, and points for lines that are parallel at every pose.
    """

    outcome: Outcome
    precision: int
    real: bool | None = None
    error: float | None = None
    uniqueness: float | None = None
    deviation: float | None = None
    residual_bound: float | None = None
    sides: tuple[Side | None, ...] | None = None
    same_as: int | None = None
    unresolved: tuple[int, ...] = ()
    isolation: Isolation | None = field(default=None, repr=False)
    equivalent: Instance | None = field(default=None, repr=False)
    length: float | None = None

    @property
    def certified(self) -> bool:
        """Whether exactly one simple solution is proved near the candidate."""
        return self.outcome is Outcome.CERTIFIED

    def to_json(self) -> dict[str, Any]:
        """Return the certificate as plain data; candidates and constraints are counted from 1."""
        sides = [side and side.value for side in self.sides or ()]
        return {
            "certified": self.certified,
            "outcome": self.outcome.value,
            "real": self.real,
            "same_as": None if self.same_as is None else self.same_as + 1,
            "unresolved": [index + 1 for index in self.unresolved],
            "residual_bound": self.residual_bound,
            "deviation": self.deviation,
            "sides": {str(k): side for k, side in enumerate(sides, 1) if side},
            "precision": self.precision,
            "error": self.error,
            "uniqueness": self.uniqueness,
        }


@dataclass(frozen=True)
class Certificates(Sequence[Certificate]):
    """The certificates of all candidates, in their order.

    Attributes
    ----------
    items
        One for each candidate.
    scale
        The length, a power of two, by which translations are divided in errors.
    least_length
        The length, a power of two, by which translations that are not far are divided in
        deviations. It is the largest one below the size of the smaller body that is no point, and
        at least 2^-20 of the scale.
    """

    items: tuple[Certificate, ...]
    scale: float
    least_length: float

    @property
    def deviations(self) -> tuple[float, float]:
        """Proved bounds for all that are certified: of R, and of T in the unit of the instance."""
        bounds = [
            (item.deviation, item.deviation * item.length)
            for item in self.items
            if item.certified and item.deviation is not None and item.length is not None
        ]
        turned, moved = zip(*bounds, strict=True) if bounds else ((0.0,), (0.0,))
        return max(turned), max(moved)

    @overload
    def __getitem__(self, index: int) -> Certificate: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Certificate, ...]: ...

    def __getitem__(self, index: int | slice) -> Certificate | tuple[Certificate, ...]:
        """Return one certificate, or several by a slice."""
        return self.items[index]

    def __repr__(self) -> str:
        return (
            f"<Certificates: {self.certified} of {len(self)} certified, {self.distinct} of them "
            f"proved different, {self.real} of these real>"
        )

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each candidate (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.to_json()["solutions"])

    def to_json(self) -> dict[str, Any]:
        """Return the certificates as plain data, as `gsp certify` prints them."""
        entries = enumerate((item.to_json() for item in self.items), 1)
        return {
            "scale": self.scale,
            "least_length": self.least_length,
            "counts": {
                "poses": len(self),
                "certified": self.certified,
                "distinct": self.distinct,
                "real": self.real,
            },
            "solutions": [{"number": number, **entry} for number, entry in entries],
        }

    def __len__(self) -> int:
        """Return the number of candidates."""
        return len(self.items)

    @property
    def certified(self) -> int:
        """The number of certified candidates, duplicates included."""
        return sum(item.certified for item in self.items)

    @property
    def distinct(self) -> int:
        """The number of pairwise different solutions that are proved to exist."""
        return len(self._representatives())

    @property
    def real(self) -> int:
        """The number of pairwise different solutions that are proved to exist and to be real."""
        return sum(self.items[k].real is True for k in self._representatives())

    def _representatives(self) -> set[int]:
        chosen: set[int] = set()
        for index, item in enumerate(self.items):
            if item.certified and item.same_as is None and chosen.isdisjoint(item.unresolved):
                chosen.add(index)
        return chosen
