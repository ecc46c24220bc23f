"""Poses from the eigenvectors of multiplication matrices, without any path.

The algebra of solutions is computed in as many digits as wanted along the elimination that a prime
has shown; the values of the normal monomials at the solutions are the eigenvectors of a linear
form's multiplication. Poses far away are found as well as near ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from flint import acb, arb, ctx, fmpq

from gspcli.certification.counting.coordinate_forms import NotFollowedError
from gspcli.certification.counting.elements import Element, Sum
from gspcli.certification.counting.exact_platform import evaluated
from gspcli.certification.counting.followed import FollowedElimination
from gspcli.certification.counting.homomorphism import Randomness
from gspcli.certification.counting.modular_platform import (
    ModularPlatform,
    NotCountedError,
    on_sides,
)
from gspcli.certification.counting.motion_equations import equations, with_moments
from gspcli.certification.counting.platform_counts import work_limit
from gspcli.certification.counting.residue_counts import Ending, trace
from gspcli.certification.counting.spectrum import SpectrumError, eigenvectors
from gspcli.certification.equations import study
from gspcli.certification.numbers.balls import rotated
from gspcli.defaults import COUNT_LIMIT, SEED
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass

#: The coefficients of the linear form whose eigenvectors are sought are below this number.
_COEFFICIENTS = 64


@dataclass(frozen=True)
class ApproximatePose:
    """A complex pose in high precision, without any bound of its error.

    Attributes
    ----------
    R
        The rotation, by rows.
    T
        The translation.
    signs
        For each constraint 1 or -1: on which side of the plane the point lies; 1 for all others.
    """

    R: tuple[tuple[acb, acb, acb], ...]
    T: tuple[acb, acb, acb]
    signs: tuple[int, ...]


def poses_by_elimination(
    instance: Instance, bits: int, *, seed: int = SEED, limit: float | None = COUNT_LIMIT
) -> list[ApproximatePose] | None:
    """Return approximations of all poses of an instance, by eigenvectors.

    Parameters
    ----------
    instance
        The platform.
    bits
        The working precision. Poses at distances L, or errors of the data at which they appear,
        cost a multiple of log2(L) of it.
    seed, limit
        As in `exact_count`.

    Returns
    -------
    list of ApproximatePose or None
        As many as there are solutions with multiplicity, those of multiple ones badly approximated;
        None if there are infinitely many, or the elimination cannot be followed.
    """
    try:
        platform = ModularPlatform(instance, seed)
    except NotCountedError:
        return None
    with _precision(bits):
        rows = [evaluated(row, _real) for row in platform.exact]
        poses: list[ApproximatePose] = []
        for signs in platform.choices:
            result, followed = trace(
                with_moments(platform.equations(signs)),
                platform.blocks,
                platform.prime,
                seed=platform.randomness.below(2**63),
                max_work=work_limit(limit),
            )
            if result.outcome is not Ending.FINITE:
                return None
            if result.solutions == 0:
                continue
            try:
                algebra = FollowedElimination(
                    with_moments(equations(on_sides(rows, signs))), followed
                )
                poses += _poses(algebra, signs, platform.randomness)
            except (NotFollowedError, SpectrumError, ZeroDivisionError):
                return None
        return poses


@contextmanager
def _precision(bits: int) -> Iterator[None]:
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


def _real(element: Element) -> arb:
    """Return a ball with a real element."""
    quotient: acb = _sum(element.numerator) / _sum(element.denominator)
    return quotient.real


def _sum(terms: Sum) -> acb:
    total = acb(0)
    for term, factor in terms.items():
        value = acb(fmpq(factor.numerator, factor.denominator))
        if term.radicand != 1:
            value *= arb(term.radicand).sqrt()
        if term.turn or term.radians:
            turn, radians = (fmpq(x.numerator, x.denominator) for x in (term.turn, term.radians))
            value *= acb(0, 2 * arb.pi() * turn + radians).exp()
        if term.pi:
            value *= arb.pi() ** term.pi
        total += value
    return total


def _poses(
    algebra: FollowedElimination, signs: tuple[int, ...], randomness: Randomness
) -> list[ApproximatePose]:
    form = [randomness.below(_COEFFICIENTS) + 1 for _ in range(algebra.variables)]
    coordinates = algebra.coordinates()
    entries = sorted({0}.union(*coordinates))
    result = []
    for vector in eigenvectors(algebra.multiplication(form), entries):
        at = {k: x / vector[0] for k, x in zip(entries, vector, strict=True)}
        values = [
            sum((at[k] * x for k, x in coordinate.items()), acb(0)) for coordinate in coordinates
        ]
        result.append(_pose(algebra.functions(values), signs))
    return result


def _pose(functions: dict[int, acb], signs: tuple[int, ...]) -> ApproximatePose:
    x, y, z = (
        (functions[i].mid(), functions[j].mid(), functions[k].mid()) for i, j, k in study.ROTATION
    )
    if study.TRANSLATION[0] in functions:
        a, b, c = (functions[k] for k in study.TRANSLATION)
    else:
        a, b, c = rotated((x, y, z), [functions[k] for k in study.BODY])
    return ApproximatePose((x, y, z), (a.mid(), b.mid(), c.mid()), signs)
