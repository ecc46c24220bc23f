"""Intervals of 95 % contain the truth 95 times of a hundred."""

from __future__ import annotations

import numpy as np
import pytest
from measured_machines import (
    ROTARY_SIGMA,
    SIGMA,
    noisy,
    noisy_rotary,
    nominal,
    numbers,
    reachable,
    real,
    rotary,
)

import gspcli
from gspcli.calibration.model import file_numbers


@pytest.mark.slow
def test_intervals_cover_the_truth():
    """All of them 93 to 97 % in 200 repetitions, each of 42 numbers 90 to 99 %."""
    rng = np.random.default_rng(11)
    hits, freedom, chi = [], 0, []
    for _ in range(200):
        found = gspcli.calibrate(
            nominal(), *noisy(real(), *reachable(30, rng), rng), sigma=SIGMA, hold_unknown=True
        )
        assert found.unknowns.count == 0
        model = found.fit.model
        sigma = np.sqrt(np.diag(found.fit.covariance)[model.free])
        hits.append(np.abs(numbers(model) - numbers(real())) < 1.96 * sigma)
        chi.append(found.chi_squared)
        freedom = found.freedom
    share = np.mean(hits, axis=0)
    assert 0.93 <= share.mean() <= 0.97
    assert 0.90 <= share.min() <= share.max() <= 0.99
    assert np.mean(chi) == pytest.approx(freedom, rel=0.03)


@pytest.mark.slow
def test_intervals_of_a_rotary_machine_cover_the_truth():
    """60 repetitions, cranks measured and rods not: 93 to 97 %, and chi-squared as it should be."""
    rng = np.random.default_rng(15)
    instance, truth, angles, R, T = rotary(rng, 60)
    true = file_numbers(instance, truth)
    blank, hits, chi = np.full((len(T), 6), np.nan), [], []
    for _ in range(60):
        cranks, turns, places = noisy_rotary(angles, R, T, rng)
        found = gspcli.calibrate(
            instance, blank, turns, places, drives=cranks, sigma=ROTARY_SIGMA, prior=0.1
        )
        assert found.unknowns.count == 0
        there = [true.names.index(name) for name in found.names]
        off = np.abs(found.after - true.values[there])
        hits.append((off < 1.96 * found.sigma)[found.sigma > 0])
        chi.append(found.chi_squared)
    assert 0.93 <= np.mean(hits) <= 0.97
    assert np.mean(chi) == pytest.approx(found.freedom, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 0.03])
def test_intervals_of_robust_fits_cover_the_truth(share):
    """Legs, 30 rows, with and without outliers of 50 deviations, 60 repetitions: 93 to 97 %."""
    rng, hits = np.random.default_rng(21), []
    for _ in range(60):
        values, R, T = noisy(real(), *reachable(30, rng), rng)
        values += 0.05 * rng.choice([-1, 1], values.shape) * (rng.random(values.shape) < share)
        found = gspcli.calibrate(
            nominal(), values, R, T, sigma=SIGMA, robust=True, hold_unknown=True
        )
        sigma = np.sqrt(np.diag(found.fit.covariance)[found.fit.model.free])
        hits.append(np.abs(numbers(found.fit.model) - numbers(real())) < 1.96 * sigma)
    assert 0.93 <= np.mean(hits) <= 0.97


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 0.03])
def test_intervals_of_robust_fits_of_a_rotary_machine_cover_the_truth(share):
    """Cranks, 30 rows, outliers of 50 deviations, 60 repetitions: 93 to 97 %."""
    rng, hits = np.random.default_rng(22), []
    for _ in range(60):
        instance, truth, angles, R, T = rotary(rng, 30)
        true = file_numbers(instance, truth)
        cranks, turns, places = noisy_rotary(angles, R, T, rng)
        wrong = rng.random(cranks.shape) < share
        cranks += 50 * ROTARY_SIGMA["crank"] * rng.choice([-1, 1], cranks.shape) * wrong
        found = gspcli.calibrate(
            instance,
            np.full((len(T), 6), np.nan),
            turns,
            places,
            drives=cranks,
            sigma=ROTARY_SIGMA,
            prior=0.1,
            robust=True,
            hold_unknown=True,
        )
        there = [true.names.index(name) for name in found.names]
        off = np.abs(found.after - true.values[there])
        hits.append((off < 1.96 * found.sigma)[found.sigma > 0].mean())
    assert 0.93 <= np.mean(hits) <= 0.97
