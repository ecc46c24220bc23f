"""The probability that random forms and combinations mislead, for any prime."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from gspcli.catalogue.bounds import varieties
from gspcli.certification.counting import error_bounds
from gspcli.certification.counting.error_bounds import ErrorBounds, MinorBits


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
