from __future__ import annotations

import numpy as np
import pytest

from gspcli.motion.bisection import bisected


@pytest.mark.parametrize("first", [0.5, 0.25])
def test_both_ends_enclose_where_it_ceases(first: float) -> None:
    """Of several orders of magnitude at once; what holds at neither stays at zero."""
    edges, tried = np.array([0.7, 3e-4, 0.0, 1.0]), []

    def holds(sizes):
        tried.append(sizes)
        return sizes <= edges

    low, high = bisected(holds, np.zeros(4), np.ones(4), 40, close=1.01, first=first)
    assert (low <= edges).all()
    assert (high[:3] > edges[:3]).all()
    assert (high[:2] <= 1.01 * low[:2]).all()
    assert low[2] == 0
    assert len(tried) == 40


def test_nothing_is_tried_where_the_ends_are_near() -> None:
    ends = bisected(lambda sizes: 1 / 0, np.array([1.0]), np.array([1.001]), 9, close=1.01)
    assert [end.tolist() for end in ends] == [[1.0], [1.001]]
