"""An instance modulo a random prime that is derived from it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

from flint import nmod

from gspcli.catalogue.kinds import DLL, Kind
from gspcli.certification.counting.coordinate_choice import Blocks, choose
from gspcli.certification.counting.elements import NoElementError
from gspcli.certification.counting.exact_platform import (
    EvaluatedConstraint,
    evaluated,
    exact_constraints,
)
from gspcli.certification.counting.homomorphism import (
    LARGE,
    Homomorphism,
    Randomness,
    Requirements,
    homomorphisms,
)
from gspcli.certification.counting.motion_equations import (
    MotionEquation,
    MotionEquations,
    equations,
    parallel_lines,
)
from gspcli.certification.numbers.balls import dot
from gspcli.errors import IncompleteError
from gspcli.geometry.instance import Instance

#: The most primes that are tried if one divides a denominator.
_ATTEMPTS = 5
#: With more DLL `ModularPlatform.has_lone_lines` is not decided.
_MOST_LINES = 3


class NotCountedError(IncompleteError):
    """The solutions of an instance could not be counted; the message gives the reason."""


class ModularPlatform:
    """The constraints of an instance modulo a prime.

    Parameters
    ----------
    instance
        The instance.
    seed
        The prime and everything random is derived from it and the instance.
    values_free
        Whether the values are random instead of those of the instance.
    index
        Another index gives another prime.
    bits
        Bits of the prime: `LARGE` or, where `Requirements.has_small_primes`, `SMALL`.

    Raises
    ------
    NotCountedError
        If the numbers have no homomorphism to a prime field that is known to be one.

    Attributes
    ----------
    exact
        The constraints with exact numbers.
    requirements
        The conditions on primes.
    choices
        Choices of sides: for each constraint 1 or -1.
    bits
        Bits of the prime.
    blocks
        The coordinates that suit the constraints.
    prime
        The prime.
    rows
        The constraints modulo the prime.
    randomness
        The source of further random numbers.
    """

    def __init__(
        self,
        instance: Instance,
        seed: int,
        *,
        values_free: bool = False,
        index: int = 0,
        bits: int = LARGE,
    ) -> None:
        try:
            self.exact = exact_constraints(instance, values_free=values_free)
            self.requirements = Requirements(x for row in self.exact for x in row.numbers)
        except NoElementError as error:
            message = f"the solutions cannot be counted exactly: no exact arithmetic for {error}"
            raise NotCountedError(message) from None
        text = f"{seed} {index} {bits} {values_free} {_identity(instance)}"
        self.bits = bits
        self.choices = tuple(itertools.product(*(row.sides for row in self.exact)))
        self.blocks = choose(self.kinds)
        self.randomness = Randomness(f"{text} forms")
        self.prime, self.rows = self._images(homomorphisms(self.requirements, text, bits))
        if values_free:
            self.rows = [
                replace(row, value=nmod(self.randomness.below(self.prime), self.prime))
                for row in self.rows
            ]

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The kinds of the constraints."""
        return tuple(row.kind for row in self.exact)

    def equations(self, signs: Sequence[int]) -> MotionEquations:
        """Return the equations modulo the prime for a choice of sides."""
        return equations(on_sides(self.rows, signs))

    def parallel_lines(self) -> list[tuple[MotionEquation, MotionEquation]]:
        """Return for each DLL the conditions for parallel lines, and for their distance."""
        in_base = Blocks.TRANSLATION in self.blocks
        return [
            parallel_lines(
                row,
                [nmod(self.randomness.below(self.prime), self.prime) for _ in range(3)],
                in_base=in_base,
            )
            for row in self.rows
            if row.kind is DLL
        ]

    @property
    def has_lone_lines(self) -> bool:
        """Whether no two pairs of lines of a DLL can be parallel, or anti-parallel, together.

        They can be only if the lines of both bodies enclose the same angle. Numbers that differ
        modulo a prime are different.
        """
        rows = [row for row in self.rows if row.kind is DLL]
        return len(rows) <= _MOST_LINES and not any(
            _cosine_squared(one.u, other.u) == _cosine_squared(one.v, other.v)
            for one, other in itertools.combinations(rows, 2)
        )

    def _images(self, candidates: Iterator[Homomorphism]) -> tuple[int, list[EvaluatedConstraint]]:
        for homomorphism in islice(candidates, _ATTEMPTS):
            try:
                return homomorphism.prime, [evaluated(row, homomorphism) for row in self.exact]
            except ZeroDivisionError:
                continue
        message = "the solutions cannot be counted exactly: a number is divided by zero"
        raise NotCountedError(message)


def _cosine_squared(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return the square of the cosine of the angle of two directions."""
    return dot(a, b) ** 2 / (dot(a, a) * dot(b, b))


def on_sides(
    rows: Sequence[EvaluatedConstraint], signs: Sequence[int]
) -> list[EvaluatedConstraint]:
    """Return constraints on one choice of sides."""
    return [row.on_side(sign) for row, sign in zip(rows, signs, strict=True)]


def _identity(instance: Instance) -> str:
    """Return a text that contains all numbers of an instance."""
    parts = [instance.units.angle.value]
    for row in instance.constraints:
        parts += [row.kind.name, row.side.value, str(row.value)]
        for geometry in (row.platform, row.base):
            for name in ("position", "direction", "normal"):
                parts += map(str, getattr(geometry, name, ()))
    return " ".join(parts)
