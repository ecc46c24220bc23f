from __future__ import annotations

import pytest

from gspcli.solver.proof import Ground, Proof


def test_a_count_for_every_prime_is_a_proof() -> None:
    assert Proof.modulo(Ground.EXACT, 0.0) == Proof(Ground.EXACT)
    assert Proof(Ground.EXACT).to_json() == {"by": "exact count", "modulo_random_prime": False}


@pytest.mark.parametrize("error", [1e-15, 0.3])
def test_the_bound_of_a_random_prime_is_told(error: float) -> None:
    proof = Proof.modulo(Ground.GEOMETRY, error)
    assert proof is not None
    assert proof.to_json() == {"by": "geometry count", "modulo_random_prime": error}


def test_a_probability_of_at_most_one_proves_nothing() -> None:
    assert Proof.modulo(Ground.EXACT, 1.0) is None
