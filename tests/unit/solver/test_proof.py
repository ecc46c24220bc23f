from __future__ import annotations

import pytest

from gspcli.solver.results.proof import CountKind, Grade, Proof


def test_a_count_for_every_prime_is_a_proof() -> None:
    assert Proof.modulo(CountKind.EXACT, 0.0) == Proof(CountKind.EXACT)
    assert Proof(CountKind.EXACT).to_json() == {
        "by": "exact count",
        "grade": "certain",
        "modulo_random_prime": False,
    }
    assert Proof(CountKind.TYPE).grade is Grade.CERTAIN
    assert Proof(CountKind.TYPE).words == "proved"
    assert not Proof(CountKind.TYPE).reservation


@pytest.mark.parametrize("error", [1e-15, 0.3])
def test_the_bound_of_a_random_prime_is_told(error: float) -> None:
    proof = Proof.modulo(CountKind.GEOMETRY, error)
    assert proof is not None
    assert proof.to_json() == {
        "by": "geometry count",
        "grade": "up to a random prime",
        "modulo_random_prime": error,
    }
    assert proof.grade is Grade.PRIME
    assert proof.words == "proved up to a random prime"


@pytest.mark.parametrize(
    ("error", "bound"),
    [
        (1.23e-12, "10^11, treat as certain"),
        (9.9e-11, "10^10, treat as certain"),
        (1e-3, "10^3"),
    ],
)
def test_the_bound_that_is_printed_is_not_less_than_the_error(error: float, bound: str) -> None:
    said = Proof(CountKind.GEOMETRY, error).reservation
    assert said == (
        f"proved by the geometry count up to a random prime: wrong at most once in {bound}"
    )


def test_a_probability_of_at_most_one_proves_nothing() -> None:
    assert Proof.modulo(CountKind.EXACT, 1.0) is None
