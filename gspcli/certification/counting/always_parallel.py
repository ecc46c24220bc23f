"""Lines that are parallel at every pose, such as posts and bores of a plate on a table.

For parallel lines the equation of a DLL holds at any distance (docs/counts.md). The
constraint is that of a point of one line and the other line. Whether lines are always parallel
depends on the other constraints. If there are m DLL, the others have a solution set of dimension
m, and the lines must be parallel on all its components. To test this, m spheres about random
points replace the DLL. The six equations then have finitely many solutions, some on every
component, and the lines are parallel at all of them.

The test is wrong with a probability below ``4 m deg / 2^60``, deg the degree of the solution set.
Proof: let W be a component on which the lines are not parallel, and B the part where they are, or
the part at infinity; dim B < m. Take the resultant of W, the spheres and the function whose zero is
B. Its degree is deg W in the coefficients of each sphere, hence at most 2 deg W in its two points
and radius. It is zero if the spheres meet in B. It is not zero for all spheres, because 1, R, T, U
and rho generate their coefficients, so that they have no point in common. For any others W has a
solution on the spheres, and none of them is in B.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from gspcli.catalogue.kinds import DLL, DPL, DPP
from gspcli.certification.counting.coordinate_choice import DEGREES, choose, quadrics
from gspcli.certification.counting.error_bounds import ErrorBounds, total
from gspcli.certification.counting.homomorphism import Randomness
from gspcli.certification.counting.modular_platform import ModularPlatform
from gspcli.certification.counting.motion_equations import equations
from gspcli.certification.counting.residue_counts import Ending, count
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from gspcli.records import dataclass

#: Primes are added until the probability that all of them are wrong is below this; the most primes.
_ENOUGH, _MOST_PRIMES = 1e-12, 3
#: Bits of the random coordinates and radii of the spheres.
_RANDOM_BITS = 60
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
    found = _modulo_a_prime(instance, f"{seed} spheres", seed, max_work)
    for index in range(1, _MOST_PRIMES):
        if found.error < _ENOUGH or not found.constraints:
            break
        left = max(0, max_work - found.work)
        found = found.confirmed(_modulo_a_prime(instance, f"{seed} spheres {index}", seed, left))
    return found


def _modulo_a_prime(instance: Instance, text: str, seed: int, max_work: int) -> ParallelLines:
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
        return Point(tuple(_random(randomness) for _ in range(3)))

    return Constraint(DPP, point(), point(), _random(randomness))


def _random(randomness: Randomness) -> Number:
    return Number.of(Fraction(randomness.below(2**_RANDOM_BITS)))
