"""Platforms with products: short series where all ends are proved, long ones else."""

import numpy as np
import pytest

from gspcli.catalogue.parsing import parse_type
from gspcli.solver import solve, tracking
from gspcli.solver.generate import random_instance
from gspcli.solver.proof import CountKind


@pytest.fixture(scope="module")
def platform():
    return random_instance(parse_type("5PP PL"), np.random.default_rng(3))[0]


def refused(*_, **__):
    message = "this is not to be needed"
    raise AssertionError(message)


@pytest.mark.parametrize("certify", [True, False])
def test_proved_ends_of_short_series_are_the_answer(platform, certify, monkeypatch):
    monkeypatch.setattr(tracking, "track_platforms", refused)
    found = solve(platform, certify=certify)
    assert found.proof.by is CountKind.TYPE
    assert len(found.R) == found.certified.sum() == found.expected == 80
    assert found.residuals.max() < 1e-8


@pytest.mark.parametrize("certify", [True, False])
def test_mutual_moments_are_proved_too_without_being_asked(certify, monkeypatch):
    """Paths that are judged by eye take three times as long."""
    monkeypatch.setattr(tracking, "track_platforms", refused)
    legs = random_instance(parse_type("6D 4PP PL LL"), np.random.default_rng(5))[0]
    found = solve(legs, certify=certify)
    assert found.proof.by is CountKind.TYPE
    assert len(found.R) == found.certified.sum() == found.expected


def test_what_is_not_proved_is_followed_again(platform, monkeypatch):
    known = solve(platform)
    short = tracking.short_pursuits

    def spoilt(arrangement, *, seed, jobs):
        for (tracked_paths,) in short(arrangement, seed=seed, jobs=jobs):
            tracked_paths._results.points[0, 0] = tracked_paths._results.points[0, 1]
            tracked_paths.is_regular = False
            yield [tracked_paths]

    monkeypatch.setattr(tracking, "short_pursuits", spoilt)
    found = solve(platform)
    assert found.proof.by is CountKind.TYPE
    np.testing.assert_allclose(found.T, known.T, atol=1e-9)


def test_platforms_without_products_have_quicker_paths():
    from gspcli.geometry.arrangement import Arrangement

    legs = random_instance(parse_type("6PP"), np.random.default_rng(3))[0]
    assert list(tracking.short_pursuits(Arrangement.of(legs), seed=1, jobs=1)) == []
