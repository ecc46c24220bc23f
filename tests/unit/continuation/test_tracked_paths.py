"""Paths followed with more digits: all of them arrive, each once, with the digits asked for."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.quadrics import random_quadrics
from gspcli.continuation.systems import Coefficients, FineCoefficients, Structure, System
from gspcli.continuation.tracked_paths import joined_ends, track_all


@pytest.fixture(scope="module")
def tracked_paths():
    structure = Structure("pplsss", (False,) * 6).canonical()
    quadrics = random_quadrics(structure.spaces, np.random.default_rng(5))
    return next(track_all([System.of(structure, quadrics)], seed=1))


@pytest.fixture(scope="module")
def target(tracked_paths):
    exactly = Coefficients(*(x.astype(object) for x in tracked_paths._target.coefficients))
    return FineCoefficients.of(exactly)


def _in_order(tracked_paths, index, target, **options):
    """Return the ends of some paths in the order of their indices."""
    parts = list(tracked_paths.track(index, target, **options))
    which = np.concatenate([index for index, _ in parts])
    assert sorted(which.tolist()) == list(range(len(index)))
    return joined_ends([ends for _, ends in parts]).take(np.argsort(which))


def _overlaps(one, other):
    one, other = (x / np.linalg.norm(x, axis=1)[:, None] for x in (one, other))
    return np.abs(one.conj() @ other.T)


@pytest.mark.parametrize("few", [1, 12])
@pytest.mark.parametrize("digits", [32, 64])
def test_paths_that_arrive_early_come_first_and_each_once(
    tracked_paths, target, digits, few, monkeypatch
):
    monkeypatch.setattr("gspcli.continuation.tracked_paths._FEW_STEPS", few)
    index = np.arange(3, 9)
    parts = list(tracked_paths.track(index, target, digits=digits))
    assert len(parts) == (1 if few > 1 else 2)
    assert sorted(np.concatenate([which for which, _ in parts]).tolist()) == list(range(6))
    first = tracked_paths.first().points[index]
    for which, ends in parts:
        assert ends.digits == digits
        assert ends.low.shape == (len(which), 3, 8)
        assert ends.converged.all()
        # With more digits each path leads where it led with few.
        assert np.diag(_overlaps(ends.points, first[which])).min(initial=1) > 1 - 1e-12


@pytest.mark.parametrize(("digits", "near"), [(32, 1e-22), (64, 1e-46)])
def test_ends_have_the_digits_that_were_asked_for(tracked_paths, target, digits, near):
    """Along other random paths the same solutions are reached, in other multiples."""
    every = np.arange(tracked_paths.count)
    index = every if digits == 32 else every[:4]
    ends = _in_order(tracked_paths, index, target, digits=digits)
    others = _in_order(tracked_paths, every, target, digits=digits, attempt=1)
    overlaps = _overlaps(ends.points, others.points)
    partner = overlaps.argmax(axis=1)
    assert overlaps[np.arange(len(index)), partner].min() > 1 - 1e-12
    ratios = _ratios(others)
    for one, k in zip(_ratios(ends), partner.tolist(), strict=True):
        assert abs(one - ratios[k]) < near * abs(one)


def _ratios(ends):
    """Return the quotients of the first two coordinates, in many digits."""
    from flint import acb, ctx

    with ctx.workprec(400):
        sums = [
            [sum((acb(x) for x in (high[k], *low[:, k])), acb(0)) for k in (0, 1)]
            for high, low in zip(ends.points.tolist(), ends.low, strict=True)
        ]
        return [(a / b).mid() for a, b in sums]


def test_no_paths_have_no_ends(tracked_paths, target):
    for digits in (32, 64):
        ends = _in_order(tracked_paths, np.arange(0), target, digits=digits)
        assert len(ends.points) == len(ends.low) == len(ends.converged) == 0
