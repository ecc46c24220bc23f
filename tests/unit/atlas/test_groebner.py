"""Counting modulo a prime."""

from __future__ import annotations

from itertools import product

import pytest

from gspcli.errors import NotFiniteError
from tools.atlas.groebner import msolve_path, standard_monomials
from tools.atlas.tasks import PRIMES, Task

needs_msolve = pytest.mark.skipif(msolve_path() is None, reason="msolve is not installed")


@pytest.mark.parametrize(
    "leading",
    [
        [(0, 0, 0)],
        [(1, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(2, 0, 0), (0, 3, 0), (0, 0, 4)],
        [(3, 0, 0), (1, 1, 0), (0, 4, 0), (0, 2, 1), (0, 0, 3), (2, 0, 1)],
    ],
)
def test_standard_monomials_as_counted_one_by_one(leading: list[tuple[int, ...]]) -> None:
    expected = sum(
        not any(all(a <= b for a, b in zip(m, monomial, strict=True)) for m in leading)
        for monomial in product(range(6), repeat=3)
    )
    assert standard_monomials(leading) == expected


def test_infinitely_many_standard_monomials() -> None:
    with pytest.raises(NotFiniteError):
        standard_monomials([(2, 0), (1, 1)])


@needs_msolve
@pytest.mark.parametrize("prime", PRIMES)
@pytest.mark.parametrize(
    ("subject", "sides"),
    [("aaappp", 1), ("ssssss", 1), ("DPP DPL DLP", 1), ("DPH DPH DHP DHP", 2), ("DLL DLL DLL", 1)],
)
def test_quotients_have_the_expected_dimension(subject: str, sides: int, prime: int) -> None:
    task = Task(subject, sides, prime)
    assert task.run() == task.expected


@needs_msolve
def test_a_time_limit_gives_no_count() -> None:
    assert Task("DLL DLL DLL DLL DLL DLL", 1, PRIMES[0]).run(timeout_s=0.2) is None
