"""Poses from the eigenvectors of multiplication matrices, without any path.

The algebra of solutions is computed with any number of digits; the elimination follows the one
modulo a prime. The eigenvectors of the multiplication by a linear form are the values of the normal
monomials at the solutions. Poses far away are found like near ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from flint import acb, arb, arb_mat, ctx, fmpq

from gspcli.certification.counting.coordinate_forms import NotFollowedError
from gspcli.certification.counting.elements import FieldElement, NoElementError, Sum
from gspcli.certification.counting.exact_platform import evaluated, exact_constraints
from gspcli.certification.counting.followed import FollowedElimination
from gspcli.certification.counting.modular_platform import (
    ModularPlatform,
    NotCountedError,
    on_sides,
)
from gspcli.certification.counting.motion_equations import equations, with_moments
from gspcli.certification.counting.platform_counts import work_limit
from gspcli.certification.counting.residue_counts import Ending, trace
from gspcli.certification.counting.spectrum import (
    SpectrumError,
    eigenvectors,
    largest_eigenvectors,
)
from gspcli.certification.equations import study
from gspcli.certification.numbers.balls import rotated
from gspcli.defaults import COUNT_LIMIT, SEED
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.geometry.numbers import Number
from gspcli.records import dataclass

#: The coefficients of the linear form are below this number.
_COEFFICIENTS = 64
#: In degrees, an angle whose cosine has an image, and no special value.
_OTHER_ANGLE = Number.of(37)


@dataclass(frozen=True)
class ApproximatePose:
    """A complex pose in high precision, without a bound of its error.

    Attributes
    ----------
    R
        The rotation, by rows.
    T
        The translation.
    """

    R: tuple[tuple[acb, acb, acb], ...]
    T: tuple[acb, acb, acb]


def poses_by_elimination(
    instance: Instance, bits: int, *, near: int = 0, seed: int = SEED
) -> Iterator[ApproximatePose]:
    """Yield approximations of all poses of an instance, by eigenvectors.

    Parameters
    ----------
    instance
        The platform.
    bits
        The working precision. A pose at a distance L needs a multiple of log2(L) bits.
    near
        The number of poses on a choice of sides, at least half of all, that are much nearer than
        the others. The others are then yielded first, in a fraction of the time.
    seed
        As in `exact_count`.

    Yields
    ------
    As many poses as there are solutions with multiplicity; multiple ones are inaccurate. None if
    there are infinitely many, or if the elimination cannot be followed.
    """
    try:
        exact = exact_constraints(instance)
        platform = _modular_platform(instance, seed)
    except (NoElementError, NotCountedError):
        return
    with _precision(bits):
        rows = [evaluated(row, _real) for row in exact]
    for signs in platform.choices:
        result, followed = trace(
            with_moments(platform.equations(signs)),
            platform.blocks,
            platform.prime,
            seed=platform.randomness.below(2**63),
            max_work=work_limit(COUNT_LIMIT),
        )
        if result.outcome is not Ending.FINITE:
            return
        if result.solutions == 0:
            continue
        try:
            with _precision(bits):
                algebra = FollowedElimination(
                    with_moments(equations(on_sides(rows, signs))), followed
                )
                form = [
                    platform.randomness.below(_COEFFICIENTS) + 1 for _ in range(algebra.variables)
                ]
                matrix = algebra.multiplication(form)
        except (NotFollowedError, ZeroDivisionError):
            continue
        far = algebra.dimension - near
        for number in (far, 0) if 0 < far <= near else (0,):
            # The caller may use another precision.
            with _precision(bits):
                poses = _poses(algebra, matrix, number)
            yield from poses


def _modular_platform(instance: Instance, seed: int) -> ModularPlatform:
    """Return an instance modulo a prime, with other angles if its own have no image.

    The cosine of an angle of ten decimals has too large a degree. Almost all values have the same
    pivots. If those of the instance are not among them, no poses are found.
    """
    try:
        return ModularPlatform(instance, seed)
    except NotCountedError:
        angles = {
            k: _OTHER_ANGLE
            for k, row in enumerate(instance.constraints)
            if not row.kind.is_distance and row.value.fraction
        }
        if not angles or instance.units.angle is not AngleUnit.DEGREE:
            raise
        return ModularPlatform(instance.with_values(angles), seed)


@contextmanager
def _precision(bits: int) -> Iterator[None]:
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


def _real(element: FieldElement) -> arb:
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


def _poses(algebra: FollowedElimination, matrix: arb_mat, far: int) -> list[ApproximatePose]:
    """Return a number of poses far away, or all poses; none if there are too few digits."""
    coordinates = algebra.coordinates()
    entries = sorted({0}.union(*coordinates))
    try:
        if far:
            vectors = largest_eigenvectors(matrix, entries, far)
        else:
            vectors = eigenvectors(matrix, entries)
        return [_pose(algebra, dict(zip(entries, vector, strict=True))) for vector in vectors]
    except (SpectrumError, ZeroDivisionError):
        return []


def _pose(algebra: FollowedElimination, vector: dict[int, acb]) -> ApproximatePose:
    """Return the pose at which normal monomials have values in some proportion."""
    values = [
        sum((vector[k] * x for k, x in coordinate.items()), acb(0)) / vector[0]
        for coordinate in algebra.coordinates()
    ]
    functions = algebra.functions(values)
    x, y, z = (
        (functions[i].mid(), functions[j].mid(), functions[k].mid()) for i, j, k in study.ROTATION
    )
    if study.TRANSLATION[0] in functions:
        a, b, c = (functions[k] for k in study.TRANSLATION)
    else:
        a, b, c = rotated((x, y, z), [functions[k] for k in study.BODY])
    return ApproximatePose((x, y, z), (a.mid(), b.mid(), c.mid()))
