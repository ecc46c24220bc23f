"""The exact counts of one platform, by two independent means, and its real poses by a third.

1. msolve, from the equations in the entries of the motion (`matrix_ideal`), modulo one prime;
2. Singular, from those in unit dual quaternions (`quaternion_counts`), modulo another; of more than
   `MOST_BY_SINGULAR` poses, which would take it long, msolve again.

They must agree; if they do not, a prime was bad, and two of three must. The real poses are isolated
by msolve over the rational numbers. Irrational numbers are rounded to `ROUNDED`
decimals for this, and the rounded platform must have the same counts. Then nothing that decides the
number of real poses has changed, unless the platform is nearer to another number than that. Where
that takes too long, and first of more than `FEW` poses, all are proved one by one: `proved_poses`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice

from gspcli.catalogue.kinds import DLL
from gspcli.geometry.instance import Constraint, Instance
from tools.oracle import msolve, proved_poses, quaternion_counts
from tools.oracle.homomorphisms import Homomorphism, fields
from tools.oracle.matrix_ideal import (
    Ideal,
    Polynomial,
    R,
    Ring,
    T,
    constant,
    equations,
    parallel,
    variable,
    without_linear,
)
from tools.oracle.msolve import Count
from tools.oracle.number_parts import UnknownNumberError, direction
from tools.oracle.rational_numbers import Rationals, Rounded
from tools.special.platforms import Platform

MSOLVE_LIMIT_S, REAL_LIMIT_S = 600.0, 60.0
MOST_BY_SINGULAR = 100
#: Of more poses msolve mostly takes longer than its minute.
FEW = 64
#: Decimals to which irrational numbers are rounded to isolate real poses.
ROUNDED = 30


class DisagreementError(Exception):
    """No two means agree."""


@dataclass(frozen=True)
class ExactCounts:
    """What is known of one platform.

    Attributes
    ----------
    finite
        Whether there are finitely many complex poses.
    count, distinct
        The number of poses with and without multiplicity, None if there are infinitely many.
    spurious
        How many solutions of the equations are no poses, with multiplicity: the lines of a DLL are
        parallel there and have another distance. They are in none of the other numbers.
    real
        The number of distinct real poses, None if it is not known.
    means
        Program and prime of the two counts.
    real_by
        How the real ones are counted.
    """

    finite: bool
    count: int | None
    distinct: int | None
    spurious: int
    real: int | None
    means: tuple[str, str]
    real_by: str


def exact_counts(instance: Instance, *, with_real: bool = True) -> ExactCounts:
    """Return the exact counts of a platform, those of real poses if asked for.

    Raises
    ------
    DisagreementError
        If no two of three counts agree.
    """
    chosen = list(islice(fields(instance), 3))
    counts: dict[str, Count] = {}
    for prime, count in _counts(instance, chosen):
        counts[prime] = count
        agreed, votes = Counter(counts.values()).most_common(1)[0]
        if votes == 2:
            break
    else:
        raise DisagreementError(str(counts))
    first, second = [name for name, count in counts.items() if count == agreed]
    stated, spurious = agreed, 0
    extra = None
    if agreed.finite:
        stated, spurious, extra = _as_stated(instance, chosen[0], agreed)
    real, real_by = None, ""
    if agreed.finite and with_real:
        real, real_by = real_poses(instance, stated, without_parallel=extra is not None)
    return ExactCounts(
        stated.finite, stated.count, stated.distinct, spurious, real, (first, second), real_by
    )


def counted(platform: Platform, *, with_real: bool) -> dict[str, object]:
    """Return the row of a platform in the table.

    Raises
    ------
    DisagreementError
        If no two of three counts agree.
    """
    found = exact_counts(platform.instance, with_real=with_real)

    def cell(value: object) -> object:
        return "" if value is None else value

    return {
        "id": platform.id,
        "sha256": platform.sha256,
        "type": platform.instance.type.id,
        "finite": "yes" if found.finite else "no",
        "count": cell(found.count),
        "distinct": cell(found.distinct),
        "spurious": found.spurious,
        "real": cell(found.real),
        "first_by": found.means[0],
        "second_by": found.means[1],
        "real_by": found.real_by,
    }


def _counts(instance: Instance, chosen: list[Homomorphism]) -> Iterator[tuple[str, Count]]:
    first = None
    for field in chosen:
        # The second of three.
        if field is chosen[1] and (first is None or (first.count or 0) <= MOST_BY_SINGULAR):
            found = quaternion_counts.count(instance, field)
            yield f"Singular {field.prime}", _of_singular(found)
            continue
        ideal = without_linear(equations(instance, field))
        first = msolve.count(ideal, time_limit_s=MSOLVE_LIMIT_S)
        if first is None:
            message = "msolve took too long"
            raise DisagreementError(message)
        yield f"msolve {field.prime}", first


def _of_singular(found: dict[str, int]) -> Count:
    if found["dimension"] > 0:
        return Count(finite=False)
    return Count(True, found.get("complex", 0), found.get("distinct", 0))


def _as_stated(
    instance: Instance, field: Homomorphism, counted: Count
) -> tuple[Count, int, bool | None]:
    """Return the count of the poses, the others, and whether those are to be left out.

    Raises
    ------
    DisagreementError
        If parallel lines have their distance in some solutions and not in others.
    """
    ideal, ring = equations(instance, field), Ring(field.prime)
    for constraint in instance.constraints:
        if constraint.kind is not DLL:
            continue
        vanishing = parallel(constraint, field, ring)
        together = Ideal(ideal.names, [*ideal.polynomials, *vanishing], field.prime)
        at_parallel = msolve.count(without_linear(together))
        if at_parallel is None or not at_parallel.distinct:
            continue
        distance = _distance_of_parallel(constraint, field, ring)
        stated = Ideal(ideal.names, [*together.polynomials, distance], field.prime)
        right = msolve.count(without_linear(stated))
        if right is not None and right.distinct == at_parallel.distinct:
            continue
        if right is None or right.distinct:
            message = "some parallel lines have their distance, some do not"
            raise DisagreementError(message)
        rest = msolve.count(without_linear(_where_not_parallel(ideal, vanishing, ring)))
        if rest is None or counted.count is None or rest.count is None:
            message = "msolve took too long"
            raise DisagreementError(message)
        return rest, counted.count - rest.count, True
    return counted, 0, None


def _distance_of_parallel(constraint: Constraint, field: Homomorphism, ring: Ring) -> Polynomial:
    # That of a point of one line from the other.
    x = [constant(value) for value in field.vector(constraint.base.position)]
    y = [constant(value) for value in field.vector(constraint.platform.position)]
    v = [constant(value) for value in field.vector(direction(constraint.base))]
    offset = ring.less([ring.sum(ring.dot(row, y), t) for row, t in zip(R, T, strict=True)], x)
    squared = ring.times(field.square(constraint.value), ring.square(v))
    return ring.sum(ring.square(ring.cross(offset, v)), ring.times(-1, squared))


def _where_not_parallel(ideal: Ideal, vanishing: list[Polynomial], ring: Ring) -> Ideal:
    """Return the ideal with the inverse of a combination of what vanishes at parallel lines."""
    mixed = ring.sum(*(ring.times(7 + 5 * number**2, p) for number, p in enumerate(vanishing)))
    inverse = ring.sum(ring.product(variable("k"), mixed), constant(-1))
    return Ideal([*ideal.names, "k"], [*ideal.polynomials, inverse], ideal.prime)


def real_poses(
    instance: Instance, counted: Count, *, without_parallel: bool
) -> tuple[int | None, str]:
    """Return the number of distinct real poses, None if it is not known, and by what means.

    Parameters
    ----------
    instance
        A platform with finitely many poses.
    counted
        The number of poses; a rounded platform must have the same.
    without_parallel
        Whether solutions at parallel lines are to be left out.
    """
    assert counted.distinct is not None
    ways = [_by_msolve, _one_by_one]
    for way in ways if counted.distinct <= FEW else reversed(ways):
        found = way(instance, counted, without_parallel)
        if found[0] is not None:
            return found
    return None, ""


def _one_by_one(instance: Instance, counted: Count, _: bool) -> tuple[int | None, str]:
    assert counted.distinct is not None
    found = proved_poses.real_poses(instance, counted.distinct)
    return found, "proofs one by one" if found is not None else ""


def _by_msolve(
    instance: Instance, counted: Count, without_parallel: bool
) -> tuple[int | None, str]:
    field = next(islice(fields(instance), 1, None))
    for numbers, means in (
        (Rationals(instance), "msolve over Q"),
        (Rounded(instance, ROUNDED), f"msolve over Q, rounded to {ROUNDED} decimals"),
    ):
        try:
            ideal = equations(instance, numbers)
        except UnknownNumberError:
            continue
        if without_parallel:
            ring = Ring(0)
            for constraint in instance.constraints:
                if constraint.kind is DLL:
                    vanishing = parallel(constraint, numbers, ring)
                    ideal = _where_not_parallel(ideal, vanishing, ring)
                    break
        if isinstance(numbers, Rounded):
            modulo = Ring(field.prime)
            reduced = [
                modulo.reduced({m: field.rational(Fraction(c)) for m, c in p.items()})
                for p in ideal.polynomials
            ]
            rounded = Ideal(ideal.names, reduced, field.prime)
            if msolve.count(without_linear(rounded), time_limit_s=MSOLVE_LIMIT_S) != counted:
                return None, ""
        if counted.count == 0:
            return 0, means
        found = msolve.real_points(without_linear(ideal), time_limit_s=REAL_LIMIT_S)
        return found, means if found is not None else ""
    return None, ""
