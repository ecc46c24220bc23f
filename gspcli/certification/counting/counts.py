"""How many poses a platform has, exactly: finitely many or not, distinct, with multiplicity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import GspType
from gspcli.certification.counting.coordinates import DEGREES, quadrics
from gspcli.certification.counting.error_bounds import COMMUTATOR_TESTS, error_bounds, total
from gspcli.certification.counting.modular_platform import ModularPlatform, NotCountedError
from gspcli.certification.counting.residue_counts import Outcome, ResidueCount, count
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance

#: Billions of multiplications after which a count is given up, by default: each takes a second
#: or two.
DEFAULT_LIMIT = 5.0
_BILLION = 10**9
_UNLIMITED = 2**62


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
    instance: Instance, *, seed: int = SEED, limit: float | None = DEFAULT_LIMIT
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
    instance: Instance, *, seed: int = SEED, limit: float | None = DEFAULT_LIMIT
) -> ExactCount | None:
    """Return how many solutions an instance's geometry has with generic values, or None.

    Parameters and result are as in `exact_count`.
    """
    try:
        return count_geometry(instance, seed=seed, limit=limit)
    except NotCountedError:
        return None


def count_exactly(
    instance: Instance, *, seed: int = SEED, limit: float | None = DEFAULT_LIMIT
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
    instance: Instance, *, seed: int = SEED, limit: float | None = DEFAULT_LIMIT
) -> ExactCount:
    """Return how many solutions an instance's geometry has with generic values.

    Parameters and errors are as in `count_exactly`. All choices of sides are alike, so one is
    counted.
    """
    return _count(instance, seed, limit, values_free=True)


def _count(instance: Instance, seed: int, limit: float | None, *, values_free: bool) -> ExactCount:
    platform = ModularPlatform(instance, seed, values_free=values_free)
    max_work = work_limit(limit)
    results: list[ResidueCount] = []
    for signs in platform.choices:
        if values_free and results:
            # Generic values have no sign: all sides are alike.
            results.append(results[0])
            continue
        result = count(
            platform.equations(signs),
            platform.blocks,
            platform.prime,
            seed=platform.randomness.below(2**63),
            max_work=max_work,
        )
        if result.outcome is Outcome.STOPPED:
            message = (
                "the solutions cannot be counted exactly within the limit of "
                f"{limit:g} billion multiplications"
            )
            raise NotCountedError(message)
        max_work -= result.work
        results.append(result)
    return _assembled(platform, results)


def work_limit(limit: float | None) -> int:
    """Return a limit in multiplications."""
    return _UNLIMITED if limit is None else int(limit * _BILLION)


def _assembled(platform: ModularPlatform, results: Sequence[ResidueCount]) -> ExactCount:
    finite = all(result.outcome is Outcome.FINITE for result in results)
    isolated = [r for r in results if r.outcome is Outcome.FINITE]
    points = max((result.solutions for result in isolated), default=0)
    bounds = error_bounds(platform.exact, platform.requirements, points)
    error = total(_error(result, platform, bounds[0]) for result in results)
    # As many distinct values as solutions prove the solutions distinct.
    doubtful = [result for result in results if result.distinct != result.solutions]
    distinct: int | None = None
    if finite and all(result.distinct is not None for result in results):
        distinct = sum(result.distinct or 0 for result in results)
    return ExactCount(
        finite=finite,
        solutions=sum(result.solutions for result in results) if finite else None,
        distinct=distinct,
        error=error,
        distinct_error=total([error, *(bounds[1] for _ in doubtful)]),
        proved_lower=sum(result.solutions for result in isolated),
        proved_distinct=sum(result.distinct or 0 for result in isolated),
        sides=tuple(
            SideCount(
                signs,
                result.solutions if result.outcome is Outcome.FINITE else None,
                result.distinct if result.outcome is Outcome.FINITE else None,
            )
            for signs, result in zip(platform.choices, results, strict=True)
        ),
        prime=platform.prime,
    )


def _error(result: ResidueCount, platform: ModularPlatform, bound: float) -> float:
    """Return 0 if one prime proves that there are just so many solutions, else a bound.

    If no solution is at infinity modulo the prime, none is, and the theorem of Bezout applies: the
    degree of the coordinates' variety (data/varieties.json) times those of the equations. Isolated
    solutions modulo the prime come from solutions; if they are as many as the generic count, these
    are all (docs/counts.md), and only the random tests of the border basis may have misled.
    """
    blocks, kinds = platform.blocks, platform.kinds
    if result.outcome is not Outcome.FINITE:
        return bound
    if not result.has_falls and result.solutions == DEGREES[blocks] << quadrics(blocks, kinds):
        return 0.0
    # The equation of a DLL of distance zero is the root of the generic one.
    halved = sum(row.kind is DLL and row.is_zero for row in platform.rows)
    if result.solutions << halved == generic_counts(GspType.of(kinds)).one_sided:
        return 0.0 if result.all_commutators else COMMUTATOR_TESTS
    return bound
