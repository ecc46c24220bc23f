"""Twists and accelerations of a motion that is known exactly, from rows of poses."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.dynamics.trajectories import spline_motion
from gspcli.errors import ArgumentError
from gspcli.geometry.quaternions import apply, cross, rotation_from_vector

SWINGS = 0.04, 0.03, 0.05
SHIFTS = np.array([4.0, 3.0, 2.0])
RATES = 2 * np.pi * np.array([1.0, 1.5, 0.7])


def moving(t):
    """Return poses, twists and accelerations of R = Rz Ry Rx and T, exactly."""
    R = np.broadcast_to(np.eye(3), (len(t), 3, 3))
    twists, accelerations = np.zeros((2, len(t), 6))
    for i in (2, 1, 0):
        unit, phase = np.eye(3)[i], (RATES[i] * t + i)[:, None]
        rate = apply(R, SWINGS[i] * RATES[i] * np.cos(phase) * unit)
        bend = apply(R, -SWINGS[i] * RATES[i] ** 2 * np.sin(phase) * unit)
        accelerations[:, :3] += bend + cross(twists[:, :3], rate)
        twists[:, :3] += rate
        R = R @ rotation_from_vector(SWINGS[i] * np.sin(phase) * unit)
    phase = RATES * t[:, None]
    twists[:, 3:] = SHIFTS * RATES * np.cos(phase)
    accelerations[:, 3:] = -SHIFTS * RATES**2 * np.sin(phase)
    return R, SHIFTS * np.sin(phase), twists, accelerations


def test_fifty_rows_a_period():
    t = np.linspace(0, 4, 200)
    R, T, twists, accelerations = moving(t)
    found = spline_motion(t, R, T)
    sizes = np.abs(accelerations).max(axis=0)
    off = np.abs(found.accelerations - accelerations).max(axis=1, where=True) / sizes.max()
    assert off[20:-20].max() < 5e-6
    assert 1e-6 < off.max() < 5e-3
    assert np.abs(found.twists - twists)[20:-20].max() < 1e-6 * np.abs(twists).max()


def test_more_rows_are_better_by_the_fourth_power():
    errors = []
    for count in (100, 200):
        t = np.linspace(0, 4, count)
        R, T, _, accelerations = moving(t)
        inside = slice(count // 10, -count // 10)
        errors.append(np.abs(spline_motion(t, R, T).accelerations - accelerations)[inside].max())
    assert 10 < errors[0] / errors[1] < 30


def test_the_sign_of_quaternions_does_not_matter():
    """Past half a turn the canonical sign changes."""
    t = np.linspace(0, 1, 12)
    R = rotation_from_vector(np.outer(5 * t, [0.6, 0, 0.8]))
    found = spline_motion(t, R, np.zeros((12, 3)))
    assert np.allclose(found.twists[:, :3], [3, 0, 4], atol=1e-4)
    assert np.allclose(found.accelerations, 0, atol=0.02)


@pytest.mark.parametrize(
    ("count", "turn", "message"),
    [
        (5, 0.1, "found 5 rows with times, expected at least 6"),
        (6, 8.0, "turns by 91.7 degrees from row 1 to row 2, expected less than 90"),
    ],
)
def test_too_few_rows(count, turn, message):
    t = np.linspace(0, 1, count)
    R = rotation_from_vector(np.outer(turn * t, [0, 0, 1]))
    with pytest.raises(ArgumentError, match=message):
        spline_motion(t, R, np.zeros((count, 3)))


def test_times_increase():
    t = np.array([0, 1, 2, 2, 3, 4.0])
    with pytest.raises(ArgumentError, match="found 2 at row 4 after 2, expected times that"):
        spline_motion(t, np.tile(np.eye(3), (6, 1, 1)), np.zeros((6, 3)))
