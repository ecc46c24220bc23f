"""The exact number of solutions of a platform: finite or not, with multiplicity, distinct."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import chain, combinations
from typing import TYPE_CHECKING, Any

from flint import nmod

from gspcli import __version__
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DLL, DPL, DPP
from gspcli.catalogue.types import GspType
from gspcli.certification.counting.error_bounds import (
    COMMUTATOR_TESTS,
    ErrorBounds,
    lines_height,
    total,
)
from gspcli.certification.counting.modular_platform import (
    LARGE,
    SMALL,
    ModularPlatform,
    NotCountedError,
    Randomness,
    on_sides,
)
from gspcli.certification.counting.motion_equations import (
    DEGREES,
    FUNCTIONS,
    Blocks,
    MotionEquation,
    MotionEquations,
    choose,
    equations,
    parallel_lines,
    quadrics,
    with_moments,
)
from gspcli.certification.counting.residue_counts import Ending, ResidueCount, count
from gspcli.defaults import COUNT_LIMIT, LONG_COUNT, SEED
from gspcli.geometry import study
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from gspcli.records import dataclass

if TYPE_CHECKING:
    import pandas as pd


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
    """The solutions for one choice of sides."""

    #: The side of the plane of each constraint, 1 or -1; 1 for constraints without a plane.
    signs: tuple[int, ...]
    #: As in `ExactCount`; also None if another choice of sides is infinite and this was not
    #: counted.
    solutions: int | None
    distinct: int | None
    spurious: int | None
    spurious_distinct: int | None
    #: Indices of the DLL whose lines are parallel at every pose. Each is counted as the distance of
    #: a point of its line: the equation of the DLL holds at any distance.
    parallel: tuple[int, ...] = ()
    #: The poses by the DLL whose lines are parallel, if lines are parallel on infinitely many
    #: solutions of the equations, but not at every pose. The last part may be infinite.
    parts: tuple[PartCount, ...] = ()

    @property
    def infinite_part(self) -> PartCount | None:
        """A part with infinitely many poses that satisfy the stated constraints, if known."""
        return next((part for part in self.parts if part.solutions is None), None)


@dataclass(frozen=True)
class ExactCount:
    """The number of complex solutions of the equations of an instance (paper, Section 4).

    If the lines of a DLL are parallel at every pose, its equation is that of a point and a line.
    """

    #: Whether their number is finite.
    finite: bool
    #: Their number with multiplicity, for the sides asked for; None if infinite.
    solutions: int | None
    #: The number of distinct ones; None if infinite, or too much work.
    distinct: int | None
    #: 0.0 if `finite` and `solutions` are proved for certain; else a bound of the probability that
    #: the random prime gave a wrong result.
    error: float
    #: The error of `distinct`, `spurious` and `spurious_distinct`.
    distinct_error: float
    #: A lower bound of the isolated solutions with multiplicity, proved for certain.
    proved_lower: int
    #: A lower bound of the distinct isolated solutions, proved for certain.
    proved_distinct: int
    #: The counts for each choice of sides; solutions on both sides at once do not occur.
    sides: tuple[SideCount, ...]
    #: The number of solutions that are no poses: the lines of a DLL are parallel, so that its
    #: equation holds at any distance, and have another distance. None if unknown or infinite.
    spurious: int | None
    spurious_distinct: int | None
    #: Whether the lines of no two DLL can be parallel together. Then a platform of the geometry
    #: that has as many distinct simple solutions as the count of the geometry has no others.
    has_lone_lines: bool
    #: The primes that were used; more than one only if one was not enough.
    primes: tuple[int, ...]

    def confirmed(self, other: ExactCount) -> ExactCount:
        """Return the count that another prime confirms; `NotCountedError` if they disagree."""
        if replace(self, error=0, distinct_error=0, primes=()) != replace(
            other, error=0, distinct_error=0, primes=()
        ):
            raise NotCountedError(
                f"the primes {self.primes} and {other.primes} disagree: take another seed"
            )
        return replace(
            self,
            error=self.error * other.error,
            distinct_error=self.distinct_error * other.distinct_error,
            primes=self.primes + other.primes,
        )


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
        found = found.confirmed(one) if found else one
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


# The poses that satisfy the stated constraints, counted by the DLL with parallel lines.
#
# The equation of a DLL holds at any distance if its lines are parallel. So the poses are counted in
# parts, one for each set of DLL: exactly the lines of these are parallel and have their distances,
# which is linear in R and quadratic in T or U. Each other DLL adds a coordinate: the inverse of
# ``w . (R u x v)``, w random, which is zero for parallel lines. No pose is in two parts.
#
# A part is also cut with random hyperplanes. Their number is the dimension of a part that they
# meet; a part of lower dimension they miss. One hyperplane that meets a part proves it infinite,
# often with far less work than an elimination without hyperplanes (error bounds:
# docs/exact-counts.md).


#: Bits of the coefficients of random vectors and hyperplanes.
_RANDOM_BITS = 60
#: The height of a hyperplane: at most 17 coefficients.
_HYPERPLANE_HEIGHT = _RANDOM_BITS + 5.0
#: The most primes of a part.
_MOST_PART_PRIMES = 16
#: Largest dimension of a set of motions.
_MOST_DIMENSIONS = 6


@dataclass(frozen=True)
class PartCount:
    """The poses at which the lines of some DLL are parallel, and the lines of no other DLL."""

    #: The indices of these DLL.
    parallel: tuple[int, ...]
    #: Their numbers with and without multiplicity; None if infinite. With parallel lines the
    #: multiplicity is that of a solution of more than six equations. With hyperplanes the distinct
    #: poses are not counted.
    solutions: int | None
    distinct: int | None
    #: A bound of the probability that the result of the random primes is wrong.
    error: float
    #: The number of multiplications.
    work: int
    #: The primes that were used.
    primes: tuple[int, ...]

    def confirmed(self, other: PartCount) -> PartCount:
        """Return the count that another prime confirms; `NotCountedError` if they disagree."""
        if (self.solutions, self.distinct) != (other.solutions, other.distinct):
            raise NotCountedError("the primes of an exact count disagree: take another seed")
        return replace(
            self,
            error=self.error * other.error,
            work=self.work + other.work,
            primes=self.primes + other.primes,
        )


def count_parts(instance: Instance, seed: int, max_work: int) -> tuple[PartCount, ...]:
    """Count the poses of an instance with one choice of sides by the DLL with parallel lines.

    An infinite part is the last one. A hyperplane decides whether the first part is infinite.

    Parameters
    ----------
    instance
        The platform.
    seed
        The primes and everything random are derived from it and from the instance.
    max_work
        Multiplications after which to give up.

    Raises
    ------
    NotCountedError
        If numbers have no homomorphism to a prime field, if the work exceeds the limit, or if
        primes disagree.
    """
    lines = [k for k, row in enumerate(instance.constraints) if row.kind is DLL]
    edge = on_a_hyperplane(instance, seed, max_work)
    if edge.solutions is None:
        return (edge,)
    max_work = max(0, max_work - edge.work)
    found: list[PartCount] = []
    for parallel in _subsets(lines):
        part = _part(instance, parallel, 0, seed, max_work)
        max_work = max(0, max_work - part.work)
        found.append(part)
        if part.solutions is None:
            break
    return tuple(found)


def on_a_hyperplane(instance: Instance, seed: int, max_work: int, *, slices: int = 1) -> PartCount:
    """Return the poses without parallel lines on random hyperplanes.

    If there are any, the platform has infinitely many poses, and the count says so.

    Parameters and errors are those of `count_parts`; with more hyperplanes (`slices`) only sets of
    as many dimensions are seen, with less work.
    """
    found = _part(instance, (), slices, seed, max_work)
    return replace(found, solutions=None) if found.solutions else found


def dimension(instance: Instance, seed: int, max_work: int) -> tuple[int, float]:
    """Return the dimension of the set of poses without parallel lines, and a bound of the error.

    Parameters and errors are those of `count_parts`. The dimension is -1 if there are no poses.
    """
    for slices in range(_MOST_DIMENSIONS + 1):
        part = _part(instance, (), slices, seed, max_work)
        if part.solutions:
            return slices, part.error
        if part.solutions == 0:
            break
    if slices == 0:
        return -1, part.error
    raise NotCountedError(
        "hyperplanes do not say which dimension a set of motions has: take another seed"
    )


def _part(
    instance: Instance, parallel: tuple[int, ...], slices: int, seed: int, max_work: int
) -> PartCount:
    """Count a part, cut with some hyperplanes, modulo as many primes as needed."""
    found: PartCount | None = None
    for index in range(_MOST_PART_PRIMES):
        platform = ModularPlatform(instance, seed, index=index)
        try:
            one = _modulo_a_prime(platform, parallel, slices, max_work)
        except NotCountedError:
            if found is None:
                raise
            break
        max_work = max(0, max_work - one.work)
        found = found.confirmed(one) if found else one
        if found.error < _ENOUGH:
            break
    assert found is not None
    return found


def _modulo_a_prime(
    platform: ModularPlatform, parallel: tuple[int, ...], slices: int, max_work: int
) -> PartCount:
    given = _equations(platform, parallel, slices)
    counted = count(
        given,
        platform.blocks,
        platform.prime,
        seed=platform.randomness.below(2**63),
        max_work=max_work,
        find_distinct=not slices,
        moment_relations=False,
    )
    if counted.outcome is Ending.STOPPED:
        raise NotCountedError(
            "the poses cannot be counted by their parallel lines within the limit"
        )
    is_finite = counted.outcome is Ending.FINITE
    if is_finite and counted.distinct is None and not slices:
        raise NotCountedError("the distinct poses cannot be counted within the limit")
    return PartCount(
        parallel,
        counted.solutions if is_finite else None,
        counted.distinct if is_finite else None,
        _error(platform, counted, parallel, slices, len(given.moments)),
        counted.work,
        (platform.prime,),
    )


def _equations(
    platform: ModularPlatform, parallel: tuple[int, ...], slices: int
) -> MotionEquations:
    """Return the equations of a part, cut with some hyperplanes."""
    rows = on_sides(platform.rows, platform.choices[0])
    others = [row for k, row in enumerate(rows) if k not in parallel]
    in_base = Blocks.TRANSLATION in platform.blocks
    given = with_moments(equations(others))
    moments, result = list(given.moments), list(given.equations)
    for row in others:
        if row.kind is DLL:
            crossing, _ = parallel_lines(row, _random(platform, 3), in_base=in_base)
            result.append(_inverse(crossing, FUNCTIONS + len(moments), platform.prime))
            moments.append({})
    for k in parallel:
        for axis in range(3):
            unit = [int(axis == j) for j in range(3)]
            crossing, distance = parallel_lines(rows[k], unit, in_base=in_base)
            result.append(crossing)
        result.append(distance)
    places = [study.NORM, *chain(*study.ROTATION)]
    places += study.TRANSLATION if Blocks.TRANSLATION in platform.blocks else ()
    places += study.BODY if Blocks.BODY in platform.blocks else ()
    for _ in range(slices):
        values = _random(platform, len(places))
        result.append(MotionEquation(dict(zip(places, values, strict=True))))
    return MotionEquations(moments, result)


def _inverse(function: MotionEquation, place: int, prime: int) -> MotionEquation:
    """Return the equation that the product of a linear function and a coordinate is one."""
    quarter = nmod(4, prime) ** -1
    plus, minus = (function.linear | {place: sign} for sign in (1, -1))
    return MotionEquation({study.NORM: -1}, [(quarter, plus), (-quarter, minus)])


def _random(platform: ModularPlatform, number: int) -> list[nmod]:
    bits = 2**_RANDOM_BITS
    return [nmod(platform.randomness.below(bits), platform.prime) for _ in range(number)]


def _error(
    platform: ModularPlatform,
    counted: ResidueCount,
    parallel: tuple[int, ...],
    slices: int,
    moments: int,
) -> float:
    """Return a bound of the probability that the count of a part with hyperplanes is wrong."""
    bounds = ErrorBounds.of(platform.exact, platform.requirements, platform.blocks)
    lines = [row for row in platform.exact if row.kind is DLL]
    heights = [lines_height(row, _RANDOM_BITS) for row in lines]
    heights += [_HYPERPLANE_HEIGHT] if slices else []
    height = max([bounds.bits.height, *heights])
    bounds = replace(bounds, bits=replace(bounds.bits, height=height, moments=moments))
    # Solutions of six equations modulo the prime come from solutions; those of more need not.
    is_lifted = not parallel and not slices
    is_finite = counted.outcome is Ending.FINITE
    finite = is_finite and (is_lifted or counted.solutions == 0)
    errors = [bounds.count(counted.reach, finite=finite)]
    if is_finite and counted.distinct not in (None, counted.solutions):
        errors.append(bounds.distinct(counted.reach, counted.solutions))
    # A random vector may vanish at lines that are not parallel; a hyperplane may contain a
    # component.
    blocks, kinds = platform.blocks, platform.kinds
    most = DEGREES[blocks] << quadrics(blocks, kinds)
    errors.append((len(lines) - len(parallel) + slices) * most / 2.0**_RANDOM_BITS)
    return total(errors)


#: Primes are added until the probability that all of them are wrong is below this; the most primes.
_ENOUGH_SPHERES, _MOST_SPHERE_PRIMES = 1e-12, 3
#: Coordinates in which spheres are linear.
_ALL = max(DEGREES)


@dataclass(frozen=True)
class ParallelLines:
    """The DLL of a platform whose lines are parallel at every pose."""

    #: Their indices.
    constraints: tuple[int, ...]
    #: A bound of the probability that this is wrong.
    error: float
    #: The number of multiplications.
    work: int

    def confirmed(self, other: ParallelLines) -> ParallelLines:
        """Return the result of two independent computations, with the product of their errors."""
        both = tuple(k for k in self.constraints if k in other.constraints)
        return ParallelLines(both, self.error * other.error, self.work + other.work)


def always_parallel(instance: Instance, seed: int, max_work: int) -> ParallelLines:
    """Return which lines of a platform are parallel at all solutions of the other constraints.

    Parameters
    ----------
    instance
        A platform with one choice of sides.
    seed
        The primes and the spheres are derived from it and from the instance.
    max_work
        The most multiplications; None is returned after them.
    """
    found = _on_spheres(instance, f"{seed} spheres", seed, max_work)
    for index in range(1, _MOST_SPHERE_PRIMES):
        if found.error < _ENOUGH_SPHERES or not found.constraints:
            break
        left = max(0, max_work - found.work)
        found = found.confirmed(_on_spheres(instance, f"{seed} spheres {index}", seed, left))
    return found


def _on_spheres(instance: Instance, text: str, seed: int, max_work: int) -> ParallelLines:
    dll = [k for k, row in enumerate(instance.constraints) if row.kind is DLL]
    others = [row for row in instance.constraints if row.kind is not DLL]
    randomness = Randomness(text)
    # The lines follow the six equations, so that their numbers are modulo the same prime. Other
    # spheres have another prime.
    spheres = [_sphere(randomness) for _ in dll]
    rows = (*others, *spheres, *(instance.constraints[k] for k in dll))
    platform = ModularPlatform(replace(instance, constraints=rows), seed)
    kinds = platform.kinds[: len(instance.constraints)]
    blocks = choose(kinds)
    counted = count(
        equations(platform.rows[: len(kinds)]),
        blocks,
        platform.prime,
        seed=platform.randomness.below(2**63),
        max_work=max_work,
        conditions=[crossing for crossing, _ in platform.parallel_lines()],
        groups=[[k] for k in range(len(dll))],
    )
    finite = counted.outcome is Ending.FINITE and counted.solutions > 0
    if not finite or len(counted.apart) < len(dll):
        return ParallelLines((), 0.0, counted.work)
    parallel = tuple(k for k, (apart, _) in zip(dll, counted.apart, strict=True) if not apart)
    bounds = ErrorBounds.of(platform.exact, platform.requirements, blocks)
    errors = [
        bounds.count(counted.reach, finite=True),
        bounds.vanishing(counted.reach, counted.solutions, len(parallel)),
        4 * len(dll) * (DEGREES[_ALL] << quadrics(_ALL, kinds)) / 2.0**_RANDOM_BITS,
    ]
    return ParallelLines(parallel, total(errors), counted.work)


def by_points(instance: Instance, lines: Sequence[int]) -> Instance:
    """Return an instance with points for lines; it is equivalent where the lines are parallel.

    Parameters
    ----------
    instance
        The platform.
    lines
        Indices of the DLL in question.
    """
    rows = list(instance.constraints)
    for k in lines:
        position = rows[k].platform.position
        rows[k] = replace(rows[k], kind=DPL, platform=Point(position), platform_name="")
    return replace(instance, constraints=tuple(rows))


def _sphere(randomness: Randomness) -> Constraint:
    def point() -> Point:
        return Point(tuple(_random_number(randomness) for _ in range(3)))

    return Constraint(DPP, point(), point(), _random_number(randomness))


def _random_number(randomness: Randomness) -> Number:
    return Number.of(Fraction(randomness.below(2**_RANDOM_BITS)))


# The number of poses of a platform: a count of its equations, corrected for parallel lines.


_UNLIMITED = 2**62


def exact_count(
    instance: Instance, *, seed: int = SEED, limit: float | None = COUNT_LIMIT, suspect: bool = True
) -> ExactCount | None:
    """Return the number of solutions of an instance, or None if it could not be computed.

    Parameters
    ----------
    instance
        The platform; its numbers are taken as written.
    seed
        The prime and everything random is derived from it and from the instance.
    limit
        The most work, in billions of multiplications modulo the prime (a second or two each); None
        for no limit.
    suspect
        Whether to search for infinitely many solutions by a hyperplane first, with the same limit.

    Returns
    -------
    ExactCount or None
        None if `count_exactly` raises an error.
    """
    try:
        return count_exactly(instance, seed=seed, limit=limit, suspect=suspect)
    except NotCountedError:
        return None


def geometry_count(
    instance: Instance, *, seed: int = SEED, limit: float | None = COUNT_LIMIT
) -> ExactCount | None:
    """Return the number of solutions of a geometry with generic values, or None.

    Parameters and result are as in `exact_count`.
    """
    try:
        return count_geometry(instance, seed=seed, limit=limit)
    except NotCountedError:
        return None


def count_exactly(
    instance: Instance, *, seed: int = SEED, limit: float | None = COUNT_LIMIT, suspect: bool = True
) -> ExactCount:
    """Return the number of solutions of an instance.

    Parameters are as in `exact_count`.

    Raises
    ------
    NotCountedError
        If no homomorphism of the numbers of the instance to a prime field is known, or if the work
        exceeds `limit`.
    """
    max_work = work_limit(limit)
    if (repeated := repeated_constraints(instance)) and suspect:
        # Each solution lies on a set of as many dimensions: the elimination would be long.
        infinite = _infinite(instance, seed, max_work, slices=repeated)
        if infinite is not None:
            return infinite
    try:
        found = count_equations(instance, seed, max_work, values_free=False)
    except NotCountedError:
        # The proof that there are infinitely many can be far less work.
        infinite = _infinite(instance, seed, max_work) if suspect else None
        if infinite is None:
            raise
        return infinite
    if found.finite or not any(row.kind is DLL for row in instance.constraints):
        return found
    return _joined(found, [_side_count(instance, side, seed, max_work) for side in found.sides])


def count_geometry(
    instance: Instance, *, seed: int = SEED, limit: float | None = COUNT_LIMIT
) -> ExactCount:
    """Return the number of solutions of a geometry with generic values.

    Parameters and errors are as in `count_exactly`. All choices of sides have the same count, so
    only one is counted.
    """
    return count_equations(instance, seed, work_limit(limit), values_free=True)


def dimension_exactly(
    instance: Instance, *, limit: float | None = COUNT_LIMIT
) -> tuple[int, float]:
    """Return the dimension of the set of poses over the complex numbers, with an error bound.

    Parameters and errors are those of `count_exactly`; the instance has one choice of sides.

    Returns
    -------
    dimension
        The dimension of the poses at which no lines of a DLL are parallel; -1 if there are none.
    error
        A bound of the probability that the random prime and hyperplanes gave a wrong result.
    """
    return dimension(instance, SEED, work_limit(limit))


def with_points_for_lines(instance: Instance) -> Instance | None:
    """Return the instance with points for lines that are parallel at every pose, or None.

    The instance has one choice of sides. The result is None if there are no such lines, or if this
    could not be decided.
    """
    try:
        lines = always_parallel(instance, SEED, work_limit(COUNT_LIMIT))
    except NotCountedError:
        return None
    return by_points(instance, lines.constraints) if lines.constraints else None


def work_limit(limit: float | None) -> int:
    """Return a limit in multiplications."""
    return _UNLIMITED if limit is None else int(min(limit * BILLION, _UNLIMITED))


def repeated_constraints(instance: Instance) -> int:
    """Return how many constraints say the same as one before them, in the same numbers."""
    rows = {
        (row.kind, row.platform, row.base, str(row.value), row.side) for row in instance.constraints
    }
    return len(instance.constraints) - len(rows)


def _infinite(
    instance: Instance, seed: int, max_work: int, *, slices: int = 1
) -> ExactCount | None:
    """Return the count of a platform whose poses meet random hyperplanes, else None."""
    platform = ModularPlatform(instance, seed)
    for signs in platform.choices:
        try:
            chosen = instance.on_sides(signs)
            part = on_a_hyperplane(chosen, seed, max_work, slices=slices)
        except NotCountedError:
            return None
        max_work = max(0, max_work - part.work)
        if part.solutions is None:
            unknown = [SideCount(other, None, None, None, None) for other in platform.choices]
            return ExactCount(
                finite=False,
                solutions=None,
                distinct=None,
                error=part.error,
                distinct_error=part.error,
                proved_lower=0,
                proved_distinct=0,
                sides=tuple(
                    replace(side, parts=(part,)) if side.signs == signs else side
                    for side in unknown
                ),
                spurious=None,
                spurious_distinct=None,
                has_lone_lines=platform.has_lone_lines,
                primes=part.primes,
            )
    return None


@dataclass(frozen=True)
class _Side:
    """The count for a choice of sides."""

    #: The counts.
    side: SideCount
    #: As in `ExactCount`; None if they are those of the count of all sides.
    error: float | None = None
    distinct_error: float | None = None
    #: As in `ExactCount`, if they are not in the count of all sides.
    proved_lower: int = 0
    proved_distinct: int = 0


def _side_count(instance: Instance, side: SideCount, seed: int, max_work: int) -> _Side:
    """Return the count of the poses for a choice of sides, without spurious solutions.

    Lines that are always parallel are replaced by points; otherwise the poses are counted in parts.
    """
    if side.solutions is not None:
        return _Side(side)
    chosen = instance.on_sides(side.signs)
    lines = always_parallel(chosen, seed, max_work)
    left = max(0, max_work - lines.work)
    if not lines.constraints:
        return _in_parts(chosen, side, seed, left)
    counted = count_equations(by_points(chosen, lines.constraints), seed, left, values_free=False)
    (found,) = counted.sides
    return _Side(
        replace(found, signs=side.signs, parallel=lines.constraints),
        total([lines.error, counted.error]),
        total([lines.error, counted.distinct_error]),
        counted.proved_lower,
        counted.proved_distinct,
    )


def _in_parts(instance: Instance, side: SideCount, seed: int, max_work: int) -> _Side:
    """Return the count in parts; that of the equations if it could not be computed."""
    try:
        parts = count_parts(instance, seed, max_work)
    except NotCountedError:
        return _Side(side)
    counted = replace(side, parts=parts)
    error = total(part.error for part in parts)
    if counted.infinite_part is None:
        solutions, distinct = (
            sum(getattr(part, name) for part in parts) for name in ("solutions", "distinct")
        )
        counted = replace(
            counted, solutions=solutions, distinct=distinct, spurious=0, spurious_distinct=0
        )
    return _Side(counted, error, error)


def _joined(found: ExactCount, sides: Sequence[_Side]) -> ExactCount:
    """Return the count of a platform whose equations have infinitely many solutions."""
    numbers = [side.side for side in sides]
    finite = all(side.solutions is not None for side in numbers)

    def added(name: str) -> int | None:
        known = [getattr(side, name) for side in numbers]
        return sum(known) if finite and None not in known else None

    # The first count is used only for sides without such lines.
    errors = [found.error if side.error is None else side.error for side in sides]
    distinct_errors = [
        found.distinct_error if side.distinct_error is None else side.distinct_error
        for side in sides
    ]
    return replace(
        found,
        finite=finite,
        solutions=added("solutions"),
        distinct=added("distinct"),
        error=total(errors),
        distinct_error=total(distinct_errors),
        proved_lower=found.proved_lower + sum(side.proved_lower for side in sides),
        proved_distinct=found.proved_distinct + sum(side.proved_distinct for side in sides),
        sides=tuple(numbers),
        spurious=added("spurious"),
        spurious_distinct=added("spurious_distinct"),
    )


@dataclass(frozen=True, eq=False)
class PlatformCounts:
    """The exact numbers of complex poses of a platform.

    Attributes
    ----------
    instance
        The platform, its numbers taken as written.
    seed
        Of the random prime.
    geometry, exact
        The counts for almost all values and for the values of the instance; None if not counted.
    refusal
        The reason why a count is missing, or empty.
    """

    instance: Instance
    seed: int
    geometry: ExactCount | None
    exact: ExactCount | None
    refusal: str = ""

    def __repr__(self) -> str:
        kinds = self.instance.name or self.instance.type.id
        if self.exact is None:
            return f"<PlatformCounts of {kinds}: type {self.type_count}, not counted exactly>"
        if not self.exact.finite:
            return f"<PlatformCounts of {kinds}: infinitely many poses>"
        counts = f"exact {self.exact.solutions}, {self.exact.distinct} of them distinct"
        return f"<PlatformCounts of {kinds}: type {self.type_count}, {counts}>"

    @property
    def type_count(self) -> int:
        """The generic count of the type for the sides asked for."""
        return self.instance.expected

    def to_frame(self) -> pd.DataFrame:
        """Return one row: the counts, and bounds of the probability of errors; imports pandas."""
        import pandas as pd

        document = self.to_json()
        keys = ("type_count", "geometry_count", "exact_count", "distinct", "finite", "at_least")
        return pd.DataFrame([{key: document[key] for key in keys}])

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.count/1``."""
        exact, geometry = self.exact, self.geometry
        return {
            "schema": "gsp.count/1",
            **self.instance.to_json(),
            "type_count": self.type_count,
            "geometry_count": geometry.solutions if geometry else None,
            "exact_count": exact.solutions if exact else None,
            "distinct": exact.distinct if exact else None,
            "finite": exact.finite if exact else None,
            "spurious": exact.spurious if exact else None,
            "spurious_distinct": exact.spurious_distinct if exact else None,
            "at_least": exact.proved_lower if exact else None,
            "proof": {
                "type_count": {"modulo_random_prime": False},
                "geometry_count": _proof(geometry.error if geometry else None),
                "exact_count": _proof(exact.error if exact else None),
                "distinct": _proof(exact.distinct_error if exact else None),
            },
            "sides": [
                {
                    "signs": list(side.signs),
                    "exact_count": side.solutions,
                    "distinct": side.distinct,
                }
                for side in (exact.sides if exact else ())
            ],
            "primes": list(exact.primes) if exact else [],
            "seed": self.seed,
            "version": __version__,
        }


def count_platform(
    instance: Instance, *, effort: float = LONG_COUNT, seed: int = SEED
) -> PlatformCounts:
    """Count the complex poses of a platform exactly, without finding them.

    Parameters
    ----------
    instance
        The platform.
    effort
        The most multiplications, in billions.
    seed
        Of the random prime.
    """
    geometry = exact = None
    refusal = ""
    try:
        geometry = count_geometry(instance, seed=seed, limit=effort)
        exact = count_exactly(instance, seed=seed, limit=effort)
    except NotCountedError as error:
        refusal = str(error)
    return PlatformCounts(instance, seed, geometry, exact, refusal)


def _proof(error: float | None) -> dict[str, Any] | None:
    return None if error is None else {"modulo_random_prime": error or False}


def proof_text(error: float) -> str:
    """Return in words how sure a count is; the error is rounded up to a power of ten."""
    if error == 0:
        return "proved"
    power = next(k for k in range(-17, 1) if error <= float(f"1e{k}"))
    return f"random prime, error below 1e{power}"
