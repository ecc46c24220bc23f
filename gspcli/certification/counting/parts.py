"""The poses that satisfy the stated constraints, counted by the DLL with parallel lines.

The equation of a DLL holds at any distance if its lines are parallel. So the poses are counted in
parts, one for each set of DLL: exactly the lines of these are parallel and have their distances,
which is linear in R and quadratic in T or U. Each other DLL adds a coordinate: the inverse of ``w .
(R u x v)``, w random, which is zero for parallel lines. No pose is in two parts.

A part is also cut with random hyperplanes. Their number is the dimension of a part that they meet;
a part of lower dimension they miss. One hyperplane that meets a part proves it infinite, often with
far less work than an elimination without hyperplanes (error bounds: docs/exact-counts.md).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain, combinations

from flint import nmod

from gspcli.catalogue.kinds import DLL, DPL, DPP
from gspcli.certification.counting.error_bounds import ErrorBounds, lines_height, total
from gspcli.certification.counting.modular_platform import (
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
from gspcli.geometry import study
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from gspcli.records import dataclass

#: Bits of the coefficients of random vectors and hyperplanes.
_RANDOM_BITS = 60
#: The height of a hyperplane: at most 17 coefficients.
_HYPERPLANE_HEIGHT = _RANDOM_BITS + 5.0
#: Primes are added until the probability that all of them are wrong is below this; the most primes.
_ENOUGH, _MOST_PRIMES = 1e-9, 16
#: Largest dimension of a set of motions.
_MOST_DIMENSIONS = 6


@dataclass(frozen=True)
class PartCount:
    """The poses at which the lines of some DLL are parallel, and the lines of no other DLL.

    Attributes
    ----------
    parallel
        The indices of these DLL.
    solutions, distinct
        Their numbers with and without multiplicity; None if infinite. With parallel lines the
        multiplicity is that of a solution of more than six equations. With hyperplanes the distinct
        poses are not counted.
    error
        A bound of the probability that the result of the random primes is wrong.
    work
        The number of multiplications.
    primes
        The primes that were used.
    """

    parallel: tuple[int, ...]
    solutions: int | None
    distinct: int | None
    error: float
    work: int
    primes: tuple[int, ...]


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
    for index in range(_MOST_PRIMES):
        platform = ModularPlatform(instance, seed, index=index)
        try:
            one = _modulo_a_prime(platform, parallel, slices, max_work)
        except NotCountedError:
            if found is None:
                raise
            break
        max_work = max(0, max_work - one.work)
        found = one if found is None else _confirmed(found, one)
        if found.error < _ENOUGH:
            break
    assert found is not None
    return found


def _confirmed(found: PartCount, other: PartCount) -> PartCount:
    if (found.solutions, found.distinct) != (other.solutions, other.distinct):
        raise NotCountedError("the primes of an exact count disagree: take another seed")
    return replace(
        found,
        error=found.error * other.error,
        work=found.work + other.work,
        primes=found.primes + other.primes,
    )


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


def _subsets(items: Sequence[int]) -> Iterator[tuple[int, ...]]:
    return chain.from_iterable(combinations(items, size) for size in range(len(items) + 1))


#: Primes are added until the probability that all of them are wrong is below this; the most primes.
_ENOUGH_SPHERES, _MOST_SPHERE_PRIMES = 1e-12, 3
#: Coordinates in which spheres are linear.
_ALL = max(DEGREES)


@dataclass(frozen=True)
class ParallelLines:
    """The DLL of a platform whose lines are parallel at every pose.

    Attributes
    ----------
    constraints
        Their indices.
    error
        A bound of the probability that this is wrong.
    work
        The number of multiplications.
    """

    constraints: tuple[int, ...]
    error: float
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
