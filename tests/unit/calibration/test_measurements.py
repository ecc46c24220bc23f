"""The derivatives of all that can be measured, by all parameters and by the pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.calibration.measurements import Measurements, Noise
from gspcli.calibration.model import Model, calibrated, file_numbers
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import cross_matrix, rotation_from_vector
from gspcli.resources import data_path

MACHINES = [
    ("platforms", "rubin-m2"),
    ("platforms", "t-top-head"),
    ("examples", "figure-2"),
    ("examples", "surfaces-psc"),
    ("examples", "parallel-edges"),
    ("examples", "fixture-3-2-1"),
]
STEP = 1e-6


def _load(folder, name):
    return gspcli.load(data_path(folder, f"{name}.yaml"))


def test_hat_is_the_cross_product():
    a, b = np.random.default_rng(1).normal(size=(2, 4, 3))
    assert np.allclose((cross_matrix(a) @ b[..., None])[..., 0], np.cross(a, b))


@pytest.mark.parametrize(("folder", "name"), MACHINES)
def test_derivatives(folder, name):
    rng = np.random.default_rng(2)
    model = Model.of(_load(folder, name), drives=True)
    model = replace(model, frames=0.3 * rng.normal(size=12))
    n, length = 3, model.length
    R = rotation_from_vector(0.5 * rng.normal(size=(n, 3)))
    T = length * rng.normal(size=(n, 3))
    points = {"Q": rng.normal(size=(n, 3))}
    own = [b.name for b in model.blocks if b.sort == "point" and b.body == "platform"]
    points |= {name: rng.normal(size=(n, 3)) for name in own[:1]}
    A, B = rotation_from_vector(model.frames.reshape(2, 2, 3)[:, 0])
    seen = Measurements(
        rng.normal(size=(n, 6)),
        rotation_from_vector(1e-3 * rng.normal(size=(n, 3))) @ A @ R @ B,
        rng.normal(size=(n, 3)),
        length * np.array([0.1, 0.2, 0.3]),
        points,
        {"Q": length * np.array([0.3, 0.1, 0.2])},
        0.1 * rng.normal(size=(n, 2)),
        0.3 * rng.normal(size=(n, len(model.drives))) if model.drives else None,
    )
    # The weight of a row with a crank depends on the geometry a little, which is no derivative.
    noise = Noise(1, 1, 1, 1, 1, 0, 0)

    def residual(model, R, T):
        return seen.rows(model, R, T, noise).residual

    _, by_model, by_pose = seen.rows(model, R, T, noise)
    for k, size in enumerate(model.sizes):
        step = np.zeros(len(model.free))
        step[k] = STEP * size
        ends = residual(model.moved(step), R, T) - residual(model.moved(-step), R, T)
        found = by_model[..., k] * size
        assert np.allclose(ends / 2 / STEP, found, atol=1e-6 * max(1, np.abs(found).max()))
    for k in range(6):
        twist = STEP * np.eye(6)[k]
        there = rotation_from_vector(twist[:3]) @ R, T + twist[3:]
        back = rotation_from_vector(-twist[:3]) @ R, T - twist[3:]
        ends = residual(model, *there) - residual(model, *back)
        assert np.allclose(ends / 2 / STEP, by_pose[..., k], atol=1e-6 * np.abs(by_pose).max())


@pytest.mark.parametrize(("folder", "name"), MACHINES)
def test_numbers_of_a_file_are_those_of_the_model(folder, name):
    rng = np.random.default_rng(3)
    instance = _load(folder, name)
    model = Model.of(instance, drives=True)
    step = 0.01 * model.length * rng.normal(size=len(model.free)) * model.sizes
    step[model.geometry + 6 :] = 0
    step[~model.free] = 0
    model = model.moved(step)
    numbers = file_numbers(instance, model)
    for k, size in enumerate(model.sizes):
        ends = [
            file_numbers(instance, model.moved(s * STEP * size * np.eye(len(step))[k])).values
            for s in (1, -1)
        ]
        slopes = (ends[0] - ends[1]) / 2 / STEP
        assert np.allclose(slopes, numbers.slopes[:, k] * size, atol=1e-6 * model.length)
    known = {one: 0.0 for one in numbers.names if not one.startswith(("device", "target", "scale"))}
    known = {
        one: s for one, s in known.items() if not one.startswith("offset") or model.offsets.any()
    }
    planes = [k + 1 for k, kind in enumerate(model.kinds) if kind.has_sides]
    known = {one: s for one, s in known.items() if one not in {f"offset.{k}" for k in planes}}
    again = Model.of(calibrated(instance, model, known), drives=True)
    R = rotation_from_vector(0.2 * rng.normal(size=(4, 3)))
    T = model.length * rng.normal(size=(4, 3))
    angles = rng.normal(size=(4, len(model.drives))) if model.drives else None
    one, other = (measured(m.bodies(angles), R, T) for m in (model, again))
    assert np.abs(one - other).max() < 1e-11 * max(1, model.length)
    assert np.abs(model.offsets - again.offsets).max() < 1e-12
