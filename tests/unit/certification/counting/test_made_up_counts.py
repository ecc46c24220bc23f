"""What a count modulo a prime may claim, on made-up counts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from mpmath import log, mpf

from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.names import parse_type
from gspcli.certification.counting import error_bounds, exact_counts
from gspcli.certification.counting.error_bounds import COMMUTATOR_TESTS, ErrorBounds, total
from gspcli.certification.counting.exact_counts import ParallelLines, PartCount
from gspcli.certification.counting.modular_platform import ModularPlatform, NotCountedError
from gspcli.certification.counting.motion_equations import DEGREES, choose, quadrics
from gspcli.certification.counting.residue_counts import Ending, ResidueCount
from gspcli.geometry.building import hexapod
from gspcli.geometry.random_instances import random_instance

COUNTED = ResidueCount(Ending.FINITE, 40, 40, (), False, 6, True, 1)


@pytest.fixture(scope="module")
def plates() -> ModularPlatform:
    """A platform whose numbers are small integers."""
    points = [[0, 0, 0], [7, 1, 0], [9, 6, 0], [4, 11, 0], [-3, 8, 0], [-5, 2, 1]]
    return ModularPlatform(hexapod(points, points[::-1], [3, 4, 5, 6, 7, 8]), 1)


def test_there_are_as_many_primes_as_is_said() -> None:
    """Dusart's bounds of the number of primes below 2^60 and 2^61."""
    least = mpf(2) ** 61 / (log(mpf(2) ** 61) - 1)
    most = mpf(2) ** 60 / (log(mpf(2) ** 60) - mpf("1.1"))
    assert least - most >= error_bounds.PRIMES > (least - most) * mpf("0.9")


def test_errors_add_up() -> None:
    assert total([0.25, 0.5]) == 0.75
    assert total([0.75, 0.5]) == 1.0


def test_a_larger_field_has_more_primes_that_mislead(plates: ModularPlatform) -> None:
    bounds = ErrorBounds.of(plates.exact, plates.requirements, plates.blocks)
    one = bounds.count(6, finite=True) - COMMUTATOR_TESTS
    four = replace(bounds, degree=4).count(6, finite=True) - COMMUTATOR_TESTS
    assert four == pytest.approx(4 * one, rel=1e-6)
    # Every image of a transcendental number is random, too.
    irrational = replace(bounds, is_rational=False).count(6, finite=True)
    assert irrational > bounds.bits.finite(6) / 2**60
    # A form takes the same value at two of n points with a probability below n^2 / 2^60.
    assert bounds.distinct(6, 40) > 40**2 / 2**60
    assert bounds.vanishing(6, 40, 3) > 120 / 2**60
    assert bounds.count(6, finite=True) > 300 / 2**60


def test_hyperplanes_may_miss_and_are_numbers_themselves(
    plates: ModularPlatform, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A random hyperplane contains a component with a probability of its degree by 2^60."""
    nothing = replace(COUNTED, solutions=0, distinct=None, reach=3)

    def error(slices: int, counted: ResidueCount = nothing) -> float:
        return exact_counts._error(plates, counted, (), slices, 0)

    # Their coefficients have more bits than those of the platform.
    bounds = ErrorBounds.of(plates.exact, plates.requirements, plates.blocks)
    assert bounds.bits.height < 60
    higher = replace(bounds, bits=replace(bounds.bits, height=65.0, moments=0))
    assert error(1) >= higher.count(3, finite=True)
    # Solutions of more equations than six modulo a prime need not come from solutions.
    some = replace(nothing, solutions=3)
    assert error(1, some) > error(1)
    assert error(1, some) >= higher.count(3, finite=False)
    monkeypatch.setattr(error_bounds, "PRIMES", math.inf)
    monkeypatch.setattr(error_bounds, "COMMUTATOR_TESTS", 0.0)
    kinds = plates.kinds
    most = DEGREES[plates.blocks] << quadrics(plates.blocks, kinds)
    assert choose(kinds) == plates.blocks
    for slices in range(4):
        assert error(slices) == pytest.approx(slices * most / 2**60, rel=1e-9, abs=0)


def test_primes_that_disagree_prove_nothing() -> None:
    one = PartCount((), 3, 3, 1e-5, 10, (7,))
    assert one.confirmed(replace(one, error=1e-4)).error == pytest.approx(1e-9)
    for changes in ({"solutions": 4}, {"distinct": 2}, {"solutions": None}):
        with pytest.raises(NotCountedError, match="disagree"):
            one.confirmed(replace(one, **changes))
    count = exact_counts.ExactCount(
        True, 40, 40, 1e-5, 1e-4, 40, 40, (), 0, 0, has_lone_lines=True, primes=(7,)
    )
    confirmed = count.confirmed(replace(count, primes=(11,)))
    assert (confirmed.error, confirmed.distinct_error) == pytest.approx((1e-10, 1e-8))
    for changes in ({"solutions": 39}, {"distinct": 39}, {"finite": False}, {"spurious": 1}):
        with pytest.raises(NotCountedError, match="disagree"):
            count.confirmed(replace(count, **changes))


def test_lines_are_always_parallel_if_all_computations_say_so() -> None:
    both = ParallelLines((1, 3), 1e-5, 1).confirmed(ParallelLines((3, 4), 1e-4, 1))
    assert both.constraints == (3,)
    assert both.error == pytest.approx(1e-9)


def test_one_prime_proves_a_count_only_at_its_largest(plates: ModularPlatform) -> None:
    """Without solutions at infinity by the theorem of Bezout, or as many as almost all have."""
    assert set(plates.kinds) == {DPP}

    def proved(**changes: object) -> float | None:
        return exact_counts._proved_error(replace(COUNTED, **changes), plates)

    assert DEGREES[plates.blocks] << quadrics(plates.blocks, plates.kinds) == 40
    assert proved() == 0.0
    assert proved(solutions=39) is None
    assert proved(solutions=39, has_falls=True) is None
    assert proved(solutions=40, outcome=Ending.INFINITE) is None


def test_falls_of_degree_may_hide_solutions_at_infinity() -> None:
    """Bezout's number counts only without them; the generic count is proved by a border basis."""
    instance = random_instance(parse_type("4PP ALL AHL"), np.random.default_rng(1))[0]
    platform = ModularPlatform(instance, 1)
    most = DEGREES[platform.blocks] << quadrics(platform.blocks, platform.kinds)
    generic = exact_counts.generic_counts(exact_counts.GspType.of(platform.kinds)).one_sided
    assert generic < most

    def proved(**changes: object) -> float | None:
        return exact_counts._proved_error(replace(COUNTED, **changes), platform)

    assert proved(solutions=most) == 0.0
    assert proved(solutions=most, has_falls=True) is None
    assert proved(solutions=generic, has_falls=True) == 0.0
    assert proved(solutions=generic, has_falls=True, all_commutators=False) == COMMUTATOR_TESTS


def test_what_is_not_distinct_or_spurious_is_not_proved_outright(plates: ModularPlatform) -> None:
    def errors(spurious=(0, 0), **changes):
        counted = replace(COUNTED, **changes)
        found = exact_counts._Result(counted, spurious)
        return exact_counts._errors(found, plates)

    assert errors() == (0.0, 0.0)
    assert errors(distinct=39)[1] > 0
    assert errors(spurious=(1, 1))[1] > 0
    assert errors(solutions=38, distinct=38)[0] > 0
