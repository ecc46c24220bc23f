"""Bounds of speeds and accelerations of motors, compared with differences of samples."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.drive_numbers import is_driven
from gspcli.geometry.drives import Drives
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.motion.paths.rate_bounds import Rates
from gspcli.motion.paths.series import Ball, Series
from gspcli.motion.poses.inverse_kinematics import values_at

PIVOT = np.array([0.1, 0.2, -0.05])


@pytest.mark.parametrize("sequence", ["ZYX", "xyz", "YXZ"])
@pytest.mark.parametrize(
    "name",
    [
        *("workspace-study", "six-planes", "figure-2", "fixture-3-2-1", "surfaces-scc"),
        *("example-6.8", "hexaglide", "t-top-head", "three-prs"),
    ],
)
def test_no_motor_is_quicker_than_its_bound(name, sequence):
    """Bounds are those of samples, up to a thousandth: neither wrong nor useless."""
    instance = gspcli.example(name)
    solved = gspcli.solve(instance)
    home = solved.home or solved.poses[int(np.flatnonzero(solved.real)[0])]
    R, T = home.R.real, home.T.real
    drives = None
    if is_driven(instance):
        of = Drives.of(instance)
        drives = of, of.knees(R, T)
    rates = Rates(instance, PIVOT, sequence, drives)
    sizes = np.array([0.003 * rates._arrangement.length] * 3 + [0.003] * 3)
    draw = np.random.default_rng(3)
    velocity, bend = draw.normal(size=(2, 6)) * sizes
    place = np.concatenate((T + R @ PIVOT, euler_from_rotation(sequence, R)))
    speeds, bends = rates.bounds(place, velocity, bend, 1.0)
    t = np.linspace(0, 1, 1001)[:, None]
    parameters = place + velocity * t + bend * t**2 / 2
    turned = rotation_from_euler(sequence, parameters[:, 3:])
    moved = parameters[:, :3] - turned @ PIVOT
    if drives:
        of, knees = drives
        numbers = of.inverse(turned, moved, knees) / of.units
    else:
        numbers = values_at(instance, turned, moved)
    step = t[1, 0]
    seen = np.abs(np.diff(numbers, axis=0)).max(axis=0) / step
    seen_bends = np.abs(np.diff(numbers, 2, axis=0)).max(axis=0) / step**2
    assert (seen <= speeds[:-2] * (1 + 1e-9)).all()
    assert (speeds[:-2] <= seen * 1.01).all()
    room = 1e-8 * np.abs(numbers).max()
    assert (seen_bends <= bends[:-2] + room).all()
    assert (bends[:-2] <= seen_bends * 1.01 + room).all()
    spin = turned[:-1].swapaxes(1, 2) @ turned[1:]
    angle = np.arccos(np.minimum((np.trace(spin, axis1=1, axis2=2) - 1) / 2, 1))
    assert angle.max() / step == pytest.approx(speeds[-1], rel=0.01)
    assert np.linalg.norm(velocity[:3] + bend[:3] * t, axis=1).max() == pytest.approx(
        speeds[-2], rel=0.01
    )


def test_a_value_at_zero_has_no_bound():
    instance = gspcli.example("surfaces-sss")
    rates = Rates(instance, np.zeros(3), "ZYX")
    # The points of the first distance meet.
    first = instance.constraints[0]
    base = np.array([x.value for x in first.base.position])
    own = np.array([x.value for x in first.platform.position])
    place = np.concatenate((base - own, np.zeros(3)))
    way = np.array([1.0, 0, 0, 0, 0, 0])
    speeds, _ = rates.bounds(place - way / 2, way, 0 * way, 1.0)
    assert not np.isfinite(speeds[0])


def test_balls_contain_what_numbers_do():
    draw = np.random.default_rng(0)
    a, b = draw.normal(size=(2, 500)) + 2
    r = draw.random(size=(2, 500)) * 0.3
    balls = Ball(a, r[0]), Ball(b, r[1])
    for _ in range(20):
        x, y = (m + s * (2 * draw.random(500) - 1) for m, s in zip((a, b), r, strict=True))
        for ball, number in (
            (balls[0] + balls[1], x + y),
            (balls[0] - balls[1], x - y),
            (balls[0] * balls[1], x * y),
            (balls[0].over(balls[1]), x / y),
            (balls[0].cos(), np.cos(x)),
            (balls[0].sin(), np.sin(x)),
        ):
            assert (np.abs(number - ball.mid) <= ball.rad).all()
        root = balls[0].sqrt()
        known = np.isfinite(root.rad)
        assert known.any()
        assert (np.abs(np.sqrt(np.abs(x)) - root.mid) <= root.rad)[known].all()


def test_series_are_derivatives():
    half = np.zeros(1)
    t = Series.of_motion(*(np.full((1, 1), x) for x in (0.3, 1.0, 0.0)), half)
    cos, sin = t.cos_sin()
    found = (sin * cos).over(t).sqrt().balls
    s, h = 0.3, 1e-4

    def f(x):
        return np.sqrt(np.sin(x) * np.cos(x) / x)

    assert found[0].mid[0, 0] == pytest.approx(f(s))
    assert found[1].mid[0, 0] == pytest.approx((f(s + h) - f(s - h)) / 2 / h, rel=1e-6)
    second = (f(s + h) - 2 * f(s) + f(s - h)) / h**2
    assert 2 * found[2].mid[0, 0] == pytest.approx(second, rel=1e-5)
