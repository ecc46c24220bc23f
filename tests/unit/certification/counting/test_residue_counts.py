"""The kernel's arithmetic, against small systems whose solutions are known."""

import pytest

from gspcli.certification.counting.motion_equations import (
    DEGREES,
    Blocks,
    MotionEquation,
    MotionEquations,
)
from gspcli.certification.counting.residue_counts import Ending, count
from gspcli.geometry import study

PRIMES = (2**30 - 35, 2**60 + 33, 2**61 - 1)
T = Blocks.TRANSLATION


def fixed_translation() -> list[MotionEquation]:
    return [
        MotionEquation({position: 1, study.NORM: 5 - k})
        for k, position in enumerate(study.TRANSLATION)
    ]


def entry(i: int, j: int, value: int, prime: int) -> MotionEquation:
    return MotionEquation({study.ROTATION[i][j]: 1, study.NORM: -value % prime})


def run(equations: list[MotionEquation], prime: int, blocks: Blocks = T, **options):
    return count(MotionEquations([], equations), blocks, prime, seed=1, max_work=10**9, **options)


@pytest.mark.parametrize("prime", PRIMES)
@pytest.mark.parametrize("build", ["", "portable"])
def test_three_entries_on_the_diagonal_leave_eight_rotations(prime, build):
    # The squares of a quaternion's entries are given, and with them the entries up to signs.
    rows = [*fixed_translation(), *(entry(i, i, 3 + i * i, prime) for i in range(3))]
    result = run(rows, prime, build=build)
    assert (result.outcome, result.solutions, result.distinct) == (Ending.FINITE, 8, 8)


@pytest.mark.parametrize("prime", PRIMES)
def test_identity_is_a_multiple_solution(prime):
    rows = [*fixed_translation(), *(entry(i, i, 1, prime) for i in range(3))]
    result = run(rows, prime)
    assert (result.outcome, result.solutions, result.distinct) == (Ending.FINITE, 8, 1)


@pytest.mark.parametrize("prime", PRIMES)
def test_contradictions_and_freedom(prime):
    rows = [*fixed_translation(), entry(0, 0, 1, prime), entry(0, 1, 2, prime)]
    contradiction = run([*rows, entry(0, 0, 2, prime)], prime)
    assert (contradiction.outcome, contradiction.solutions) == (Ending.FINITE, 0)
    free = run([*rows[:4], entry(1, 1, 3, prime), entry(1, 1, 3, prime)], prime)
    assert free.outcome is Ending.INFINITE


def test_all_builds_and_primes_agree_on_every_set_of_coordinates():
    for blocks in DEGREES:
        found = set()
        for prime in PRIMES:
            rows = [
                MotionEquation(
                    {k: (7 * i + 3) ** (k + 2) % prime for k in range(13) if T in blocks or k < 10}
                )
                if i < 3
                else entry(i - 3, 1, 2 + i, prime)
                for i in range(6)
            ]
            if T not in blocks:
                rows[:3] = [
                    MotionEquation({0: i + 2, 13 + i: 1, 1: i * i + 1, 5: 3 * i + 1})
                    for i in range(3)
                ]
            for build in ("", "portable"):
                result = run(rows, prime, blocks, build=build)
                found.add((result.outcome, result.solutions, result.distinct))
        assert len(found) == 1, blocks


def test_small_and_other_primes_are_refused():
    for prime in (7, 2**40 + 15, 2**62 + 1, 2**60):
        with pytest.raises(ValueError, match="prime"):
            run(fixed_translation(), prime)
