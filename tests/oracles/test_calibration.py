"""Fits agree with scipy's least_squares, in which the poses are ordinary unknowns."""

from __future__ import annotations

import numpy as np
import pytest
from measured_machines import SIGMA, noisy, nominal, reachable, real, seen_of

import gspcli
from gspcli.calibration.measurements import Noise
from gspcli.calibration.model import Model
from gspcli.geometry.quaternions import cross_matrix, rotation_from_vector, vector_from_rotation

optimize = pytest.importorskip("scipy.optimize")


@pytest.mark.parametrize("robust", [False, True])
def test_least_squares(robust):
    rng = np.random.default_rng(1)
    n = 16
    values, R, T = noisy(real(), *reachable(n, rng), rng)
    values[2, 3] += 0.02
    model = Model.of(nominal())
    seen = seen_of(values, R, T)
    noise = Noise(1e-3, 1, 5e-3, np.deg2rad(SIGMA["rotation"]), 1, 1, 1)
    found = gspcli.calibrate(nominal(), values, R, T, sigma=SIGMA, robust=robust, hold_unknown=True)
    assert found.unknowns.count == 0
    # What a robust fit leaves out counts for neither.
    assert np.argwhere(found.outliers).tolist() == ([[2, 3]] if robust else [])
    counts = ~found.outliers
    size = model.sizes[model.free]
    # Twists in units of what is measured, so that all unknowns are of order one.
    twist_size = np.array([1e-3] * 3 + [1.0] * 3)

    def residual(x):
        step = np.zeros(len(model.free))
        step[model.free] = x[:42] * size
        twist = x[42:].reshape(n, 6) * twist_size
        places = rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]
        return (seen.rows(model.moved(step), *places, noise).residual * counts).ravel()

    # It starts beside the end of ours, by some deviations: from afar it stops early.
    fit = found.fit
    ends = [a.point - b.point for a, b in zip(fit.model.blocks, model.blocks, strict=True)]
    turns = vector_from_rotation(fit.R @ np.swapaxes(R, 1, 2))
    twists = np.concatenate((turns, fit.T - T), axis=1) / twist_size
    start = np.concatenate((np.concatenate([*ends, fit.model.offsets]) / size, twists.ravel()))
    start += 0.02 * rng.normal(size=len(start))

    def jacobian(x):
        step = np.zeros(len(model.free))
        step[model.free] = x[:42] * size
        twist = x[42:].reshape(n, 6) * twist_size
        places = rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]
        _, by_model, by_pose = seen.rows(model.moved(step), *places, noise)
        # A rotation turns with its vector by the left Jacobian matrix, here next to one.
        K = cross_matrix(twist[:, :3])
        by_pose[..., :3] = by_pose[..., :3] @ (np.eye(3) + K / 2 + K @ K / 6)
        whole = np.zeros((n, 12, 42 + 6 * n))
        whole[..., :42] = by_model[..., model.free] * size
        for k in range(n):
            whole[k, :, 42 + 6 * k : 48 + 6 * k] = by_pose[k] * twist_size
        return (whole * counts[..., None]).reshape(12 * n, -1)

    oracle = optimize.least_squares(
        residual,
        start,
        jac=jacobian,
        x_scale="jac",
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-12,
        max_nfev=200,
    )
    assert found.fit.cost == pytest.approx(2 * oracle.cost, rel=1e-9)
    step = np.zeros(len(model.free))
    step[model.free] = oracle.x[:42] * size
    theirs = model.moved(step)
    for ours, other in zip(found.fit.model.blocks, theirs.blocks, strict=True):
        assert np.abs(ours.point - other.point).max() < 1e-5
    # The covariance is the inverse of J^T J, the poses included.
    inverse = np.linalg.inv(oracle.jac.T @ oracle.jac)
    sigma = np.sqrt(np.diag(inverse)[:42]) * size
    assert np.sqrt(np.diag(found.fit.covariance)[model.free]) == pytest.approx(sigma, rel=1e-5)
