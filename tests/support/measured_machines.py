"""Machines whose true numbers are known, and measurements of them with made-up noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import gspcli
from gspcli.calibration.measurements import Measurements
from gspcli.calibration.model import Model
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import rotation_from_vector
from tests.support.driven_machines import crank_angles

# Nategh and Agheli, "A total solution to kinematic calibration of hexapod machine tools with a
# minimum number of measurement configurations and superior accuracies" (2009): nominal and real
# numbers, mm, as in calibration.m of github.com/tabathaviso/hexapod-parallel-manipulator.
_BASE = """305.4001 111.1565 0 -56.4357 320.0625 0 -248.9644 208.9060 0
-248.9644 -208.9060 0 -56.4357 -320.0625 0 305.4001 -111.1565 0"""
_PLATFORM = """92.1597 84.4488 0 27.055 122.037 0 -119.2146 37.58822 0
-119.2146 -37.5882 0 27.055 -122.037 0 92.1597 -84.4488 0"""
_REAL_BASE = """305.2599 115.0695 2.6210 -55.2814 322.9819 4.2181 -244.7954 208.0087 3.9365
-252.5755 -211.8783 -3.0128 -53.9678 -320.6115 4.3181 302.4266 -109.4351 3.3812"""
_REAL_PLATFORM = """96.6610 81.7602 1.0684 22.2476 125.2511 -0.5530 -122.4519 36.6453 4.3547
-120.6859 -34.4565 -4.9014 24.7769 -125.0489 -4.8473 91.3462 -80.9866 0.2515"""
_LENGTH = 604.8652
_REAL_LENGTHS = (604.4299, 607.2473, 600.4441, 605.9031, 604.5251, 600.0616)
LEGS = (700.0, 1000.0)
HOME = np.array([0.0, 0.0, 800.0])
#: Noise: 1 um of values, 5 um and 20 urad of poses.
SIGMA = {"value": 1e-3, "position": 5e-3, "rotation": float(np.rad2deg(20e-6))}


def _points(text):
    return np.array(text.split(), float).reshape(6, 3)


def nominal():
    """The machine as designed, with its ranges."""
    base, platform = _points(_BASE), _points(_PLATFORM)
    made = gspcli.hexapod(base, platform, np.linalg.norm(platform + HOME - base, axis=1).round(4))
    limits = Number.of(LEGS[0]), Number.of(LEGS[1])
    return replace(made, constraints=tuple(replace(c, limits=limits) for c in made.constraints))


def real():
    """The machine as built, a model."""
    made = gspcli.hexapod(_points(_REAL_BASE), _points(_REAL_PLATFORM), [1] * 6)
    return replace(Model.of(made), offsets=np.array(_REAL_LENGTHS) - _LENGTH)


def numbers(model):
    """The coordinates of all points and the offsets, shape (42,)."""
    return np.concatenate([*[block.point for block in model.blocks], model.offsets])


def readings(model, R, T, angles=None):
    """What a machine reads at poses, radians for angles."""
    values = measured(model.bodies(angles), R, T)
    skew = [k for k, kind in enumerate(model.kinds) if kind.name == "DLL"]
    values[:, skew] = np.abs(values[:, skew])
    return (values - model.offsets) / (1 + model.scales)


def reachable(count, rng, tilt=np.pi / 9):
    """Random poses of the nominal machine within its ranges."""
    model, turns, places = Model.of(nominal()), [], []
    while sum(map(len, places)) < count:
        axis = rng.normal(size=(2000, 3))
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        R = rotation_from_vector(axis * rng.uniform(0, tilt, (2000, 1)))
        T = HOME + rng.uniform(-1, 1, (2000, 3)) * [250, 250, 200]
        values = readings(model, R, T)
        kept = ((values > LEGS[0]) & (values < LEGS[1])).all(axis=1)
        turns.append(R[kept])
        places.append(T[kept])
    return np.concatenate(turns)[:count], np.concatenate(places)[:count]


def noisy(model, R, T, rng):
    """Readings and poses with the noise of `SIGMA`."""
    values = readings(model, R, T) + SIGMA["value"] * rng.normal(size=(len(T), 6))
    turn = np.deg2rad(SIGMA["rotation"]) * rng.normal(size=(len(T), 3))
    return values, rotation_from_vector(turn) @ R, T + SIGMA["position"] * rng.normal(size=T.shape)


def seen_of(values, R, T, **more):
    """Whole poses as measurements."""
    lines = tuple(str(k + 1) for k in range(len(T)))
    return Measurements(values, R, T, np.zeros(3), lines=lines, **more)


def pose_error(model, R, T):
    """How far the poses for given readings are from true ones: rms, lengths."""
    from gspcli.geometry.measurement import jacobian

    truth = real()
    short = measured(model.bodies(), R, T) - readings(truth, R, T) - model.offsets
    twists = np.linalg.solve(jacobian(truth.bodies(), R, T), short[..., None])[..., 0]
    return float(np.sqrt((twists[:, 3:] ** 2).sum(axis=1).mean()))


#: Noise of a rotary machine: cranks and rotations in degrees, positions of a machine of metres.
ROTARY_SIGMA = {"crank": 2e-3, "position": 1e-5, "rotation": 1e-3}


def rotary(rng, count):
    """A rotary machine as stated, the true model, and exact cranks (radians) and poses of it."""
    from gspcli.geometry.measurement import jacobian
    from gspcli.resources import data_path

    instance = gspcli.load(data_path("platforms", "t-top-head.yaml"))
    home = gspcli.solve(instance).home
    model = Model.of(instance, drives=True)
    turns = rotation_from_vector(0.12 * rng.normal(size=(4 * count, 3)))
    R, T = turns @ home.R, home.T + 0.08 * model.length * rng.uniform(-1, 1, (4 * count, 3))
    _, angles = crank_angles(instance, R, T)
    there = np.flatnonzero(np.isfinite(angles).all(axis=1))[:count]
    R, T, angles = R[there], T[there], np.deg2rad(angles[there])
    step = 1e-3 * model.length * model.sizes * rng.normal(size=len(model.free))
    truth = model.moved(np.where(model.free, step, 0.0))
    stated = np.array([float(row.value.value) for row in instance.constraints])
    for _ in range(20):
        bodies = truth.bodies(angles)
        short = measured(bodies, R, T) - stated - truth.offsets
        twist = np.linalg.solve(jacobian(bodies, R, T), -short[..., None])[..., 0]
        R, T = rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]
    return instance, truth, angles, R, T


def noisy_rotary(angles, R, T, rng):
    """Cranks (degrees) and poses with the noise of `ROTARY_SIGMA`."""
    cranks = np.rad2deg(angles) + ROTARY_SIGMA["crank"] * rng.normal(size=angles.shape)
    turn = np.deg2rad(ROTARY_SIGMA["rotation"]) * rng.normal(size=T.shape)
    places = T + ROTARY_SIGMA["position"] * rng.normal(size=T.shape)
    return cranks, rotation_from_vector(turn) @ R, places
