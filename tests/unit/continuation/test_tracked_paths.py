"""Ends of paths with more digits: what Newton's method reaches, and what it leaves alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.continuation.monodromy import random_quadrics
from gspcli.continuation.systems import Coefficients, FineCoefficients, Structure, System
from gspcli.continuation.tracked_paths import track_all


@pytest.fixture(scope="module")
def tracked_paths():
    structure = Structure("pplsss", (False,) * 6).canonical()
    quadrics = random_quadrics(structure.spaces, np.random.default_rng(5))
    return next(track_all([System.of(structure, quadrics)], seed=1))


@pytest.fixture(scope="module")
def target(tracked_paths):
    exactly = Coefficients(*(x.astype(object) for x in tracked_paths._target.coefficients))
    return FineCoefficients.of(exactly)


def test_simple_ends_are_known_to_64_digits(tracked_paths, target):
    ends = tracked_paths.first()
    better = tracked_paths.improved(ends, target)
    assert better.digits == 64
    assert better.low.shape == (tracked_paths.paths, 3, 8)
    assert np.abs(better.points - ends.points).max() < 1e-12 * np.abs(ends.points).max()
    # Of the same end with an error Newton's method makes the same numbers, in any multiple.
    shaken = replace(ends, points=ends.points * (1 + 1e-9 * np.random.default_rng(2).random(8)))
    again = tracked_paths.improved(shaken, target)
    for one, other in zip(_ratios(better), _ratios(again), strict=True):
        assert abs(one - other) < 1e-50


def _ratios(ends):
    """Return the quotients of the first two coordinates, in many digits."""
    from flint import acb, ctx

    with ctx.workprec(400):
        sums = [
            [sum((acb(x) for x in (high[k], *low[:, k])), acb(0)) for k in (0, 1)]
            for high, low in zip(ends.points.tolist(), ends.low, strict=True)
        ]
        return [(a / b).mid() for a, b in sums]


def test_what_newtons_method_does_not_settle_stays(tracked_paths, target):
    ends = tracked_paths.first().take(np.arange(3))
    wrong = replace(ends, points=np.full_like(ends.points, np.nan))
    same = tracked_paths.improved(wrong, target)
    assert np.isnan(same.points).all()
    assert not same.low.any()


def test_newtons_method_with_32_digits_says_where_it_converges(tracked_paths, target):
    ends = tracked_paths.first().take(np.arange(6))
    shaken = ends.points * (1 + 1e-6 * np.random.default_rng(3).random(8))
    shaken[4] = np.nan
    index, better = tracked_paths.converged(replace(ends, points=shaken), target)
    assert sorted(index.tolist()) == [0, 1, 2, 3, 5]
    assert better.digits == 32
    units = [x / np.linalg.norm(x, axis=1)[:, None] for x in (better.points, ends.points[index])]
    overlap = np.abs((units[0] * units[1].conj()).sum(axis=1))
    assert overlap.min() > 1 - 1e-12
    none, nothing = tracked_paths.converged(ends.take(np.zeros(6, np.bool_)), target)
    assert len(none) == len(nothing.points) == 0


@pytest.mark.parametrize("few", [1, 12])
def test_paths_that_arrive_early_come_first_and_each_once(tracked_paths, target, few, monkeypatch):
    monkeypatch.setattr("gspcli.continuation.tracked_paths._FEW_STEPS", few)
    index = np.arange(8)
    parts = list(tracked_paths.deeply(index, target))
    assert len(parts) == (1 if few > 1 else 2)
    assert sorted(np.concatenate([which for which, _ in parts]).tolist()) == index.tolist()
    first = tracked_paths.first().points[:8]
    for which, ends in parts:
        assert ends.settled.all()
        units = [x / np.linalg.norm(x, axis=1)[:, None] for x in (ends.points, first[which])]
        assert np.abs((units[0] * units[1].conj()).sum(axis=1)).min(initial=1) > 1 - 1e-12
