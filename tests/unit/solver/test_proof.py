from __future__ import annotations

import pytest

from gspcli.solver.results.proof import CountKind, Proof


def test_a_count_for_every_prime_is_a_proof() -> None:
    assert Proof.modulo(CountKind.EXACT, 0.0) == Proof(CountKind.EXACT)
    assert Proof(CountKind.EXACT).to_json() == {"by": "exact count", "modulo_random_prime": False}


@pytest.mark.parametrize("error", [1e-15, 0.3])
def test_the_bound_of_a_random_prime_is_told(error: float) -> None:
    proof = Proof.modulo(CountKind.GEOMETRY, error)
    assert proof is not None
    assert proof.to_json() == {"by": "geometry count", "modulo_random_prime": error}


def test_a_probability_of_at_most_one_proves_nothing() -> None:
    assert Proof.modulo(CountKind.EXACT, 1.0) is None
