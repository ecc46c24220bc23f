"""How many poses a platform has, exactly: finitely many or not, distinct, with multiplicity."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

from flint import nmod

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import GspType
from gspcli.certification.counting.coordinates import DEGREES, Blocks, choose, quadrics
from gspcli.certification.counting.equations import equations
from gspcli.certification.counting.error_bounds import COMMUTATOR_TESTS, error_bounds, total
from gspcli.certification.counting.exact_numbers import NoElementError
from gspcli.certification.counting.exact_platform import (
    EvaluatedConstraint,
    ExactConstraint,
    evaluated,
    exact_constraints,
)
from gspcli.certification.counting.homomorphism import Randomness, Requirements, homomorphisms
from gspcli.certification.counting.residue_counts import Outcome, ResidueCount, count
from gspcli.errors import GspError
from gspcli.geometry.instance import Instance

DEFAULT_SEED = 20031
#: Billions of multiplications after which a count is given up, by default: each takes a second
#: or two.
DEFAULT_LIMIT = 5.0
_BILLION = 10**9
_UNLIMITED = 2**62


class NotCountedError(GspError):
    """The solutions of an instance could not be counted; says why."""

    exit_code = 4


@dataclass(frozen=True)
class SideCount:
    """The solutions for one choice of sides.

    Attributes
    ----------
    signs
        For each constraint 1 or -1: on which side of the plane the point lies; 1 for all others.
    solutions, distinct
        As in `ExactCount`.
    """

    signs: tuple[int, ...]
    solutions: int | None
    distinct: int | None


@dataclass(frozen=True)
class ExactCount:
    """How many complex solutions the equations of an instance have (paper, Section 4).

    Attributes
    ----------
    finite
        Whether they are finite in number.
    solutions
        Their number with multiplicity, for the sides asked for; None if infinite.
    distinct
        The number of distinct ones; None if infinite, or too much work.
    error
        0.0 if `finite` and `solutions` are proved outright; else a bound of the probability that
        the random prime has misled.
    distinct_error
        The same for `distinct`.
    proved_lower
        So many isolated solutions, with multiplicity, there are in any case.
    proved_distinct
        So many distinct isolated solutions there are in any case.
    sides
        The counts for each choice of sides; solutions on both sides at once do not occur.
    prime
        The prime that was used.
    """

    finite: bool
    solutions: int | None
    distinct: int | None
    error: float
    distinct_error: float
    proved_lower: int
    proved_distinct: int
    sides: tuple[SideCount, ...]
    prime: int


def exact_count(
    instance: Instance, *, seed: int = DEFAULT_SEED, limit: float | None = DEFAULT_LIMIT
) -> ExactCount | None:
    """Return how many solutions an instance has, or None if that could not be computed.

    Parameters
    ----------
    instance
        The platform; its numbers are taken as written.
    seed
        The prime and everything random is derived from it and from the instance.
    limit
        Work after which to give up, in billions of multiplications modulo the prime (a second or
        two each); None for none.

    Returns
    -------
    ExactCount or None
        None where `count_exactly` raises.
    """
    try:
        return count_exactly(instance, seed=seed, limit=limit)
    except NotCountedError:
        return None


def geometry_count(
    instance: Instance, *, seed: int = DEFAULT_SEED, limit: float | None = DEFAULT_LIMIT
) -> ExactCount | None:
    """Return how many solutions an instance's geometry has with generic values, or None.

    Parameters and result are as in `exact_count`.
    """
    try:
        return count_geometry(instance, seed=seed, limit=limit)
    except NotCountedError:
        return None


def count_exactly(
    instance: Instance, *, seed: int = DEFAULT_SEED, limit: float | None = DEFAULT_LIMIT
) -> ExactCount:
    """Return how many solutions an instance has.

    Parameters are as in `exact_count`.

    Raises
    ------
    NotCountedError
        If the numbers of the instance have no homomorphism to a prime field that is known to be
        one, or if it is more work than `limit`.
    """
    return _count(instance, seed, limit, values_free=False)


def count_geometry(
    instance: Instance, *, seed: int = DEFAULT_SEED, limit: float | None = DEFAULT_LIMIT
) -> ExactCount:
    """Return how many solutions an instance's geometry has with generic values.

    Parameters and errors are as in `count_exactly`. All choices of sides are alike, so one is
    counted.
    """
    return _count(instance, seed, limit, values_free=True)


def _count(instance: Instance, seed: int, limit: float | None, *, values_free: bool) -> ExactCount:
    text = f"{seed} {values_free} {_identity(instance)}"
    max_work = _UNLIMITED if limit is None else int(limit * _BILLION)
    try:
        exact = exact_constraints(instance, values_free=values_free)
        requirements = Requirements(number for row in exact for number in row.numbers)
    except NoElementError as error:
        message = f"the solutions cannot be counted exactly: no exact arithmetic for {error}"
        raise NotCountedError(message) from None
    for homomorphism in homomorphisms(requirements, text):
        try:
            rows = [evaluated(row, homomorphism) for row in exact]
        except ZeroDivisionError:
            continue
        break
    prime = homomorphism.prime
    randomness = Randomness(f"{text} forms")
    choices = list(itertools.product(*(row.sides for row in exact)))
    if values_free:
        rows = [replace(row, value=nmod(randomness.below(prime), prime)) for row in rows]
    blocks = choose([row.kind for row in rows])
    results: list[ResidueCount] = []
    for signs in choices:
        if values_free and results:
            # Generic values have no sign: all sides are alike.
            results.append(results[0])
            continue
        chosen = [row.on_side(sign) for row, sign in zip(rows, signs, strict=True)]
        result = count(
            equations(chosen),
            blocks,
            prime,
            seed=randomness.below(2**63),
            max_work=max_work,
        )
        if result.outcome is Outcome.STOPPED:
            message = (
                "the solutions cannot be counted exactly within the limit of "
                f"{max_work / _BILLION:g} billion multiplications"
            )
            raise NotCountedError(message)
        max_work -= result.work
        results.append(result)
    return _assembled(exact, requirements, rows, blocks, choices, results, prime)


def _assembled(
    exact: Sequence[ExactConstraint],
    requirements: Requirements,
    rows: Sequence[EvaluatedConstraint],
    blocks: Blocks,
    choices: Sequence[tuple[int, ...]],
    results: Sequence[ResidueCount],
    prime: int,
) -> ExactCount:
    finite = all(result.outcome is Outcome.FINITE for result in results)
    isolated = [r for r in results if r.outcome is Outcome.FINITE]
    points = max((result.solutions for result in isolated), default=0)
    bounds = error_bounds(exact, requirements, points)
    errors = [_error(result, rows, blocks, bounds[0]) for result in results]
    simple = [result.distinct == result.solutions for result in results]
    error = total(errors)
    distinct: int | None = None
    if finite and all(result.distinct is not None for result in results):
        distinct = sum(result.distinct or 0 for result in results)
    return ExactCount(
        finite=finite,
        solutions=sum(result.solutions for result in results) if finite else None,
        distinct=distinct,
        error=error,
        # As many distinct values as solutions prove the solutions distinct.
        distinct_error=total([error, *(0.0 if done else bounds[1] for done in simple)]),
        proved_lower=sum(result.solutions for result in isolated),
        proved_distinct=sum(result.distinct or 0 for result in isolated),
        sides=tuple(
            SideCount(
                signs,
                result.solutions if result.outcome is Outcome.FINITE else None,
                result.distinct if result.outcome is Outcome.FINITE else None,
            )
            for signs, result in zip(choices, results, strict=True)
        ),
        prime=prime,
    )


def _error(
    result: ResidueCount, rows: Sequence[EvaluatedConstraint], blocks: Blocks, bound: float
) -> float:
    """Return 0 if one prime proves that there are just so many solutions, else a bound.

    If no solution is at infinity modulo the prime, none is, and the theorem of Bezout applies: the
    degree of the coordinates' variety (data/varieties.json) times those of the equations. Isolated
    solutions modulo the prime come from solutions; if they are as many as the generic count, these
    are all (docs/counts.md), and only the random tests of the border basis may have misled.
    """
    kinds = [row.kind for row in rows]
    if result.outcome is not Outcome.FINITE:
        return bound
    if not result.has_falls and result.solutions == DEGREES[blocks] << quadrics(blocks, kinds):
        return 0.0
    # The equation of a DLL of distance zero is the root of the generic one.
    halved = sum(row.kind is DLL and row.is_zero for row in rows)
    if result.solutions << halved == generic_counts(GspType.of(kinds)).one_sided:
        return 0.0 if result.all_commutators else COMMUTATOR_TESTS
    return bound


def _identity(instance: Instance) -> str:
    """Return a text that says all numbers of an instance."""
    parts = [instance.units.angle.value]
    for row in instance.constraints:
        parts += [row.kind.name, row.side.value, str(row.value)]
        for geometry in (row.platform, row.base):
            for name in ("position", "direction", "normal"):
                parts += map(str, getattr(geometry, name, ()))
    return " ".join(parts)
