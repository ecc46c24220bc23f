"""The number of poses of a platform: a count of its equations, corrected for parallel lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from gspcli import __version__
from gspcli.catalogue.kinds import DLL
from gspcli.certification.counting.error_bounds import total
from gspcli.certification.counting.exact_counts import (
    BILLION,
    ExactCount,
    SideCount,
    count_equations,
)
from gspcli.certification.counting.modular_platform import ModularPlatform, NotCountedError
from gspcli.certification.counting.parts import (
    always_parallel,
    by_points,
    count_parts,
    dimension,
    on_a_hyperplane,
)
from gspcli.defaults import COUNT_LIMIT, LONG_COUNT, SEED
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass

if TYPE_CHECKING:
    import pandas as pd


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
    """The count for a choice of sides.

    Attributes
    ----------
    side
        The counts.
    error, distinct_error
        As in `ExactCount`; None if they are those of the count of all sides.
    proved_lower, proved_distinct
        As in `ExactCount`, if they are not in the count of all sides.
    """

    side: SideCount
    error: float | None = None
    distinct_error: float | None = None
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
