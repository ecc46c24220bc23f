"""None"""

from __future__ import annotations

import math
import random
from dataclasses import replace
from fractions import Fraction

import pytest
from flint import fmpz

from gspcli import hexapod
from gspcli.catalogue.bounds import varieties
from gspcli.certification.counting import count_exactly, error_bounds
from gspcli.certification.counting.error_bounds import (
    ErrorBounds,
    MinorBits,
    _log_above,
    equation_height,
)
from gspcli.certification.counting.modular_platform import Homomorphism, Randomness, Requirements
from gspcli.certification.counting.motion_equations import (
    choose,
    equations,
    evaluated,
    exact_constraints,
)
from gspcli.certification.counting.residue_counts import count
from gspcli.resources import data_directory
from gspcli.spec import load, loads

PRIMES = tuple(p for p in range(2**29 + 1, 2**29 + 120, 2) if fmpz(p).is_prime())


def bounds(instance) -> ErrorBounds:
    rows = exact_constraints(instance)
    blocks = choose([row.kind for row in rows])
    return ErrorBounds.of(rows, Requirements(x for row in rows for x in row.numbers), blocks)


def modulo(instance, prime: int):
    """Count modulo a prime that is given."""
    rows = exact_constraints(instance)
    requirements = Requirements(x for row in rows for x in row.numbers)
    image = Homomorphism(requirements, prime, Randomness("test"))
    return count(
        equations([evaluated(row, image) for row in rows]),
        choose([row.kind for row in rows]),
        prime,
        seed=1,
        max_work=10**9,
        find_distinct=False,
    )


def planar_pair(shift: int):
    """Return a platform of two plates, congruent but for a shift of one point and out of its plane.

    Congruent plates have fewer poses than others.
    """
    plate = [[0, 0, 0], [7, 1, 0], [9, 6, 0], [4, 11, 0], [-3, 8, 0], [-5, 2, 0]]
    base = [list(point) for point in plate]
    base[1][0] += shift
    base[2][2] += 3 * shift
    return hexapod(base, plate, [3, 4, 5, 6, 7, 8])


def test_primes_that_divide_a_distance_from_a_special_platform_mislead():
    product = math.prod(PRIMES)
    special, nearly = count_exactly(planar_pair(0)), count_exactly(planar_pair(product))
    assert (special.solutions, nearly.solutions) == (16, 40)
    assert [modulo(planar_pair(product), p).solutions for p in PRIMES] == [16] * len(PRIMES)
    # So their product divides the integers, whose bits the bound must cover.
    height = equation_height(exact_constraints(planar_pair(product)))
    assert height > math.log2(product)
    found = bounds(planar_pair(product))
    assert found.bits.finite(modulo(planar_pair(product), PRIMES[0]).reach) > math.log2(product)


def test_few_small_primes_mislead_on_a_real_hexapod():
    # All of them together have fewer bits than the bound.
    instance = load(data_directory() / "platforms" / "rubin-camera.yaml")
    exact = count_exactly(instance)
    assert 0 < exact.error < 1e-9
    primes = [p for p in range(101, 500, 2) if fmpz(p).is_prime()]
    results = {p: modulo(instance, p) for p in primes}
    bad = {p: result for p, result in results.items() if result.solutions != exact.solutions}
    # What is finite modulo a prime is a lower bound.
    assert all(result.solutions < exact.solutions for result in bad.values())
    reach = max(result.reach for result in results.values())
    assert sum(map(math.log2, bad)) <= bounds(instance).bits.finite(reach)
    assert len(bad) < len(primes) / 4


def test_bounds_grow_with_degrees_digits_and_solutions():
    bits = MinorBits(height=60.0, variety=varieties()["R,T,U,rho"], moments=0)
    longer = replace(bits, height=120.0)
    for few, many in ((bits.finite, longer.finite), (bits.infinite, longer.infinite)):
        values = [few(reach) for reach in range(3, 9)]
        assert values == sorted(set(values))
        assert all(many(reach) > few(reach) for reach in range(3, 9))
    assert bits.distinct(6, 36) < bits.distinct(6, 40) < bits.distinct(7, 40)
    assert 0 < bits.vanishing(6, 36, 1) < bits.vanishing(6, 36, 2)
    # Fewer products are sums of fewer minors; with none of a degree above all there is nothing.
    assert bits.finite(1) == 0
    # One minor of the columns of degree 1 and 2, and one of those of degree 2 only: 153 monomials,
    # of which 37 depend on others by the equations of the motions.
    assert bits.finite(2) == 60.0 * (116 - 1 + 116 - 17) + (153 - 1 + 153 - 17)


@pytest.mark.parametrize("digits", [3, 6, 9])
def test_more_decimals_make_equations_higher(digits):
    short = planar_pair(0)
    text = str(1 + 10**-digits)
    long = hexapod(
        [[0, 0, 0], [7, 1, 0], [9, 6, 0], [4, 11, 0], [-3, 8, 0], [-5, text, 0]],
        [[0, 0, 0], [7, 1, 0], [9, 6, 0], [4, 11, 0], [-3, 8, 0], [-5, 2, 0]],
        [3, 4, 5, 6, 7, 8],
    )
    added = equation_height(exact_constraints(long)) - equation_height(exact_constraints(short))
    assert added > math.log2(10) * 2 * digits - 8


def test_spurious_solutions_have_a_bound_too():
    lines = loads((data_directory() / "examples" / "platform-6-6.yaml").read_text("utf-8"))
    found = bounds(lines)
    assert 0 < found.spurious(8, 60, 1) < found.spurious(8, 60, 2) <= 1
    assert found.count(6, finite=False) > found.count(6, finite=True)


def test_logarithms_are_rounded_upwards() -> None:
    """Also of powers of two, and of what is just above one; no farther than two bits."""
    near = [Fraction(2**k + d, 2**j) for k in (1, 5, 40) for d in (-1, 0, 1) for j in (0, 3, 39)]
    rng = random.Random(1)
    for x in [
        *near,
        *(Fraction(rng.randrange(1, 10**9), rng.randrange(1, 10**9)) for _ in range(200)),
    ]:
        bits = int(_log_above(x))
        assert 2**bits >= x
        assert _log_above(-x) == bits
        assert bits == 0 or x * 4 > 2**bits


# The probability that random forms and combinations mislead, for any prime.


def test_what_is_random_besides_the_prime_may_mislead(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the lemma of Schwartz and Zippel: at most the degree by the number of random numbers."""
    monkeypatch.setattr(error_bounds, "PRIMES", math.inf)
    bits = MinorBits(height=10.0, variety=varieties()["R,T,U,rho"], moments=0)
    bounds = ErrorBounds(bits, 1, is_rational=True)
    drawn = 2.0**60
    # Combinations of commutators, of degree 3, fewer than a hundred.
    assert bounds.count(6, finite=True) >= 300 / drawn
    # A form takes one value at two of n points, or a projection loses one of n factors.
    for points in (2, 40, 100):
        pairs = points * (points - 1) / 2
        assert bounds.distinct(6, points) >= (pairs + points) / drawn
        assert bounds.spurious(6, points, 1) >= (pairs + points) / drawn
        # A random vector hides that a condition does not vanish at one of the points.
        assert bounds.vanishing(6, points, 3) >= 3 * points / drawn
    assert replace(bounds, is_rational=False).count(6, finite=True) > bits.finite(6) / drawn
