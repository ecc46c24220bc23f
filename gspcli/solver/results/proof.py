"""What proves that a list of poses is complete."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount


class CountKind(StrEnum):
    """A count that certified poses can reach (docs/certificates.md)."""

    TYPE = "type count"
    """As many distinct simple poses as the type has: there can be no other solution at all."""
    GEOMETRY = "geometry count"
    """As many as this geometry has with values in general position."""
    EXACT = "exact count"
    """As many as the numbers as written have, with multiplicities."""


class Grade(StrEnum):
    """How certain a proof is."""

    CERTAIN = "certain"
    """No random choice can make it wrong."""
    PRIME = "up to a random prime"
    """It is wrong if the random prime of a count is a bad one, with a probability that is known."""


@dataclass(frozen=True)
class Proof:
    """Why there are no other poses, or why there are infinitely many.

    Attributes
    ----------
    by
        The count that decides.
    error
        Bound of the probability that the random prime of the count is a bad one; 0 if the
        count holds for every prime.
    """

    by: CountKind
    error: float = 0.0

    @classmethod
    def modulo(cls, by: CountKind, error: float) -> Proof | None:
        """Return a proof by a count modulo a random prime; None if the bound of its error is 1."""
        return cls(by, error) if error < 1 else None

    @classmethod
    def by_geometry(cls, count: ExactCount | None, number: int) -> Proof | None:
        """Return the proof that this many poses, at least one, are all that the geometry has."""
        # Two pairs of lines parallel at once spoil the argument (docs/counts.md).
        if count is None or not number or count.solutions != number or not count.has_lone_lines:
            return None
        return cls.modulo(CountKind.GEOMETRY, count.error)

    @property
    def grade(self) -> Grade:
        """Whether the proof is certain."""
        return Grade.PRIME if self.error else Grade.CERTAIN

    @property
    def words(self) -> str:
        """The grade in a sentence: proved, or proved up to a random prime."""
        return f"proved {self.grade}" if self.error else "proved"

    @property
    def reservation(self) -> str:
        """That the proof is up to a random prime, in words; empty if it is certain."""
        if not self.error:
            return ""
        times = math.floor(-math.log10(self.error))
        said = f"wrong at most once in 10^{times}" + (", treat as certain" if times >= 9 else "")
        return f"proved by the {self.by} up to a random prime: {said}"

    def to_json(self) -> dict[str, Any]:
        """Return the proof as plain data: `modulo_random_prime` is false or the error bound."""
        return {
            "by": self.by.value,
            "grade": self.grade.value,
            "modulo_random_prime": self.error or False,
        }
