"""What proves that a list of poses is complete."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

from gspcli.records import dataclass


class CountKind(StrEnum):
    """A count that certified poses can reach (docs/completeness.md)."""

    TYPE = "type count"
    """As many distinct simple poses as the type has: there can be no other solution at all."""
    GEOMETRY = "geometry count"
    """As many as this geometry has with values in general position."""
    EXACT = "exact count"
    """As many as the numbers as written have, with multiplicities."""


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

    @property
    def reservation(self) -> str:
        """What the proof rests on besides, in words; nothing if it holds for every prime."""
        if not self.error:
            return ""
        return f"proved by the {self.by} modulo a random prime: error below {self.error:.0e}"

    def to_json(self) -> dict[str, Any]:
        """Return the proof as plain data: `modulo_random_prime` is false or the error bound."""
        return {"by": self.by.value, "modulo_random_prime": self.error or False}
