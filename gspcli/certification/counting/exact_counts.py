"""The exact number of solutions of a platform: finite or not, with multiplicity, distinct."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, combinations

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import GspType
from gspcli.certification.counting.error_bounds import COMMUTATOR_TESTS, ErrorBounds, total
from gspcli.certification.counting.modular_platform import (
    LARGE,
    SMALL,
    ModularPlatform,
    NotCountedError,
)
from gspcli.certification.counting.motion_equations import DEGREES, MotionEquation, quadrics
from gspcli.certification.counting.parts import PartCount
from gspcli.certification.counting.residue_counts import Ending, ResidueCount, count
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass

#: The most DLL whose lines may be parallel together.
_MOST = 3


def spurious(
    lines: Sequence[tuple[MotionEquation, MotionEquation]],
    result: ResidueCount,
    run: Callable[..., ResidueCount],
) -> tuple[int, int] | None:
    """Return the number of spurious solutions, with multiplicity and distinct.

    Parameters
    ----------
    lines
        For each DLL the functions that vanish if its lines are parallel, and if they have its
        distance.
    result
        A count with the first of these as conditions, each a group of its own.
    run
        A function that counts again with other `conditions` and `groups`.

    Returns
    -------
    tuple or None
        None if it is not known.
    """
    if result.distinct is None or len(result.apart) < len(lines):
        return None
    singular = [
        pair for pair, (n, _) in zip(lines, result.apart, strict=True) if n < result.solutions
    ]
    if not singular:
        return 0, 0
    if len(singular) > _MOST:
        return None
    # Condition 2 k is the crossing of the k-th DLL, and 2 k + 1 its distance. Solutions that are
    # spurious for all of J: all crossings vanish, and no distance does.
    terms: list[tuple[int, list[int]]] = []
    for bad in _subsets(range(len(singular))):
        for crossed in _subsets(bad):
            if bad:
                sign = -1 if (len(bad) + 1 + len(crossed)) % 2 else 1
                group = [2 * k + 1 for k in bad] + [2 * k for k in crossed]
                terms.append((sign, group))
    conditions = [condition for pair in singular for condition in pair]
    found = run(conditions=conditions, groups=[group for _, group in terms])
    if len(found.apart) < len(terms):
        return None
    counts = [sign * n for (sign, _), (n, _) in zip(terms, found.apart, strict=True)]
    distinct = [sign * n for (sign, _), (_, n) in zip(terms, found.apart, strict=True)]
    return sum(counts), sum(distinct)


def _subsets(items: Sequence[int]) -> list[tuple[int, ...]]:
    return list(chain.from_iterable(combinations(items, n) for n in range(len(items) + 1)))


BILLION = 10**9
#: Primes are added until the probability that all of them are wrong is below this; the most primes.
_ENOUGH, _MOST_PRIMES = 1e-9, 6
#: From this generic count on a small prime is tried first, which takes a third of the time.
_LARGE_COUNT = 100


@dataclass(frozen=True)
class SideCount:
    """The solutions for one choice of sides.

    Attributes
    ----------
    signs
        The side of the plane of each constraint, 1 or -1; 1 for constraints without a plane.
    solutions, distinct, spurious, spurious_distinct
        As in `ExactCount`; also None if another choice of sides is infinite and this was not
        counted.
    parallel
        Indices of the DLL whose lines are parallel at every pose. Each is counted as the distance
        of a point of its line: the equation of the DLL holds at any distance.
    parts
        The poses by the DLL whose lines are parallel, if lines are parallel on infinitely many
        solutions of the equations, but not at every pose. The last part may be infinite.
    """

    signs: tuple[int, ...]
    solutions: int | None
    distinct: int | None
    spurious: int | None
    spurious_distinct: int | None
    parallel: tuple[int, ...] = ()
    parts: tuple[PartCount, ...] = ()

    @property
    def infinite_part(self) -> PartCount | None:
        """A part with infinitely many poses that satisfy the stated constraints, if known."""
        return next((part for part in self.parts if part.solutions is None), None)


@dataclass(frozen=True)
class ExactCount:
    """The number of complex solutions of the equations of an instance (paper, Section 4).

    If the lines of a DLL are parallel at every pose, its equation is that of a point and a line.

    Attributes
    ----------
    finite
        Whether their number is finite.
    solutions
        Their number with multiplicity, for the sides asked for; None if infinite.
    distinct
        The number of distinct ones; None if infinite, or too much work.
    error
        0.0 if `finite` and `solutions` are proved for certain; else a bound of the probability that
        the random prime gave a wrong result.
    distinct_error
        The error of `distinct`, `spurious` and `spurious_distinct`.
    proved_lower
        A lower bound of the isolated solutions with multiplicity, proved for certain.
    proved_distinct
        A lower bound of the distinct isolated solutions, proved for certain.
    sides
        The counts for each choice of sides; solutions on both sides at once do not occur.
    spurious, spurious_distinct
        The number of solutions that are no poses: the lines of a DLL are parallel, so that its
        equation holds at any distance, and have another distance. None if unknown or infinite.
    has_lone_lines
        Whether the lines of no two DLL can be parallel together. Then a platform of the geometry
        that has as many distinct simple solutions as the count of the geometry has no others.
    primes
        The primes that were used; more than one only if one was not enough.
    """

    finite: bool
    solutions: int | None
    distinct: int | None
    error: float
    distinct_error: float
    proved_lower: int
    proved_distinct: int
    sides: tuple[SideCount, ...]
    spurious: int | None
    spurious_distinct: int | None
    has_lone_lines: bool
    primes: tuple[int, ...]


def count_equations(
    instance: Instance, seed: int, max_work: int, *, values_free: bool
) -> ExactCount:
    """Return the number of solutions of the equations of an instance.

    Parameters
    ----------
    instance
        The platform.
    seed
        The primes and everything random are derived from it and from the instance.
    max_work
        The most multiplications.
    values_free
        Whether the values are random instead of those of the instance.

    Raises
    ------
    NotCountedError
        If no homomorphism of the numbers of the instance to a prime field is known, or if the work
        exceeds the limit.
    """
    found = _quick_count(instance, seed, max_work, values_free=values_free)
    if found is not None:
        return found
    for index in range(_MOST_PRIMES):
        platform = ModularPlatform(instance, seed, values_free=values_free, index=index)
        results = _results(platform, max_work, same=values_free)
        max_work = max(0, max_work - sum(result.counted.work for result in results))
        one = _assembled(platform, results)
        found = one if found is None else _confirmed(found, one)
        if max(found.error, found.distinct_error) < _ENOUGH:
            break
    assert found is not None
    return found


def _quick_count(
    instance: Instance, seed: int, max_work: int, *, values_free: bool
) -> ExactCount | None:
    """Return the count if it is large and a small prime proves it; else None."""
    if generic_counts(instance.type).one_sided < _LARGE_COUNT:
        return None
    platform = ModularPlatform(instance, seed, values_free=values_free)
    if not platform.requirements.has_small_primes:
        return None
    platform = ModularPlatform(instance, seed, values_free=values_free, bits=SMALL)
    found = _assembled(platform, _results(platform, max_work, same=values_free))
    if max(found.error, found.distinct_error) < _ENOUGH and found.spurious == 0:
        return found
    return None


@dataclass(frozen=True)
class _Result:
    """The counts for a choice of sides modulo a prime, with those of spurious solutions."""

    counted: ResidueCount
    spurious: tuple[int, int] | None


def _results(platform: ModularPlatform, max_work: int, *, same: bool) -> list[_Result]:
    """Count the solutions modulo a prime for each choice of sides, or for one if all are alike."""
    results: list[_Result] = []
    lines = platform.parallel_lines()
    for signs in platform.choices[:1] if same else platform.choices:
        left = max(0, max_work - sum(result.counted.work for result in results))
        run = partial(
            count,
            platform.equations(signs),
            platform.blocks,
            platform.prime,
            seed=platform.randomness.below(2**63),
            max_work=left,
        )
        counted = run(
            conditions=[crossing for crossing, _ in lines], groups=[[k] for k in range(len(lines))]
        )
        if counted.outcome is Ending.STOPPED:
            raise NotCountedError(
                "the solutions cannot be counted exactly within the limit of "
                f"{max_work / BILLION:g} billion multiplications: --effort raises it"
            )
        results.append(_Result(counted, spurious(lines, counted, run)))
    return results * (len(platform.choices) if same else 1)


def _confirmed(found: ExactCount, other: ExactCount) -> ExactCount:
    """Return a count that another prime confirms.

    Raises
    ------
    NotCountedError
        If the primes disagree.
    """
    if replace(found, error=0, distinct_error=0, primes=()) != replace(
        other, error=0, distinct_error=0, primes=()
    ):
        raise NotCountedError(
            f"the primes {found.primes} and {other.primes} disagree: take another seed"
        )
    return replace(
        found,
        error=found.error * other.error,
        distinct_error=found.distinct_error * other.distinct_error,
        primes=found.primes + other.primes,
    )


def _assembled(platform: ModularPlatform, found: Sequence[_Result]) -> ExactCount:
    results = [result.counted for result in found]
    finite = all(result.outcome is Ending.FINITE for result in results)
    isolated = [r for r in results if r.outcome is Ending.FINITE]
    errors, further_errors = zip(*(_errors(result, platform) for result in found), strict=True)
    error = total(errors)

    def added(numbers: Iterable[int | None]) -> int | None:
        known = [number for number in numbers if number is not None]
        return sum(known) if finite and len(known) == len(results) else None

    return ExactCount(
        finite=finite,
        solutions=added(result.solutions for result in results),
        distinct=added(result.distinct for result in results),
        error=error,
        distinct_error=total([error, *further_errors]),
        proved_lower=sum(result.solutions for result in isolated),
        proved_distinct=sum(result.distinct or 0 for result in isolated),
        sides=tuple(
            _side(signs, result) for signs, result in zip(platform.choices, found, strict=True)
        ),
        spurious=added(r.spurious and r.spurious[0] for r in found),
        spurious_distinct=added(r.spurious and r.spurious[1] for r in found),
        has_lone_lines=platform.has_lone_lines,
        primes=(platform.prime,),
    )


def _side(signs: tuple[int, ...], result: _Result) -> SideCount:
    if result.counted.outcome is not Ending.FINITE:
        return SideCount(signs, None, None, None, None)
    wrong, distinct = result.spurious or (None, None)
    return SideCount(signs, result.counted.solutions, result.counted.distinct, wrong, distinct)


def _errors(found: _Result, platform: ModularPlatform) -> tuple[float, float]:
    """Return bounds of the probability of a wrong count, and of wrong distinct or spurious ones."""
    result, error = found.counted, _proved_error(found.counted, platform)
    # As many distinct values as solutions prove that solutions are distinct. If no solution is
    # spurious modulo a prime, none is.
    is_distinct = result.distinct == result.solutions
    is_spurious = found.spurious is not None and found.spurious != (0, 0)
    if error is not None and is_distinct and not is_spurious:
        return error, 0.0
    if platform.bits != LARGE:  # Such a count is used only for its lower bounds.
        return 1.0 if error is None else error, 1.0
    bounds = ErrorBounds.of(platform.exact, platform.requirements, platform.blocks)
    reach, points = result.reach, result.solutions
    if error is None:
        error = bounds.count(reach, finite=result.outcome is Ending.FINITE)
    further = [] if is_distinct else [bounds.distinct(reach, points)]
    if is_spurious:
        further.append(bounds.spurious(reach, points, platform.kinds.count(DLL)))
    return error, total(further)


def _proved_error(result: ResidueCount, platform: ModularPlatform) -> float | None:
    """Return 0, or nearly 0, if one prime proves the number of solutions; else None.

    If no solution is at infinity modulo the prime, none is, and Bezout's theorem applies: the
    number is the degree of the coordinates' variety (data/varieties.json) times those of the
    equations. Isolated solutions modulo the prime come from solutions. If they are as many as the
    generic count, there are no others (docs/counts.md). Then only the random tests of the
    border basis may be wrong.
    """
    blocks, kinds = platform.blocks, platform.kinds
    if result.outcome is not Ending.FINITE:
        return None
    if not result.has_falls and result.solutions == DEGREES[blocks] << quadrics(blocks, kinds):
        return 0.0
    # The equation of a DLL of distance zero is the square root of the generic one.
    halved = sum(row.kind is DLL and row.is_zero for row in platform.rows)
    if result.solutions << halved == generic_counts(GspType.of(kinds)).one_sided:
        return 0.0 if result.all_commutators else COMMUTATOR_TESTS
    return None
