"""Data that do not fit a machine are doubted, and the usual mistakes of files are recognized."""

from __future__ import annotations

import numpy as np
import pytest
from measured_machines import SIGMA, noisy, nominal, reachable, readings, real, rotary

import gspcli
from gspcli.errors import IncompleteError
from gspcli.geometry.euler import euler_from_rotation
from gspcli.geometry.quaternions import apply, quaternion_from_rotation, rotation_from_quaternion
from gspcli.resources import data_path
from tests.support.driven_machines import crank_angles


def _transposed(R):
    return np.swapaxes(R, 1, 2)


def _rolled(R):
    return rotation_from_quaternion(np.roll(quaternion_from_rotation(R), -1, axis=1))


@pytest.mark.parametrize(
    ("wrong", "cause"),
    [
        (lambda v, R, T: (v * 1e3, R, T), "readings of lengths are too large by 1000"),
        (lambda v, R, T: (v / 25.4, R, T), "readings of lengths are too small by 25.4"),
        (lambda v, R, T: (v, R, T / 1e3), "measured positions are too small by 1000"),
        (lambda v, R, T: (v[:, [1, 0, 2, 3, 4, 5]], R, T), "readings 1 and 2 are exchanged"),
        (lambda v, R, T: (v[:, [0, 1, 2, 3, 5, 4]], R, T), "readings 5 and 6 are exchanged"),
        (lambda v, R, T: (v, _transposed(R), T), "rotations are transposed"),
        (lambda v, R, T: (v, _rolled(R), T), "quaternions have the scalar last"),
        (lambda v, R, T: (v, R, T[:, [1, 0, 2]]), "positions x and y are exchanged"),
        (lambda v, R, T: (v, _transposed(R), -apply(_transposed(R), T)), "poses are inverted"),
    ],
)
def test_mistakes_of_files_are_recognized(wrong, cause):
    rng = np.random.default_rng(1)
    seen = noisy(real(), *reachable(12, rng), rng)
    right = gspcli.calibrate(nominal(), *seen, sigma=SIGMA)
    assert right.doubts == ()
    assert right.cause is None
    assert "doubted" not in repr(right)
    found = gspcli.calibrate(nominal(), *wrong(*seen), sigma=SIGMA, hold_unknown=True)
    assert found.doubts
    assert cause in str(found.cause)
    assert repr(found).endswith(", doubted>")
    assert found.to_json()["cause"] == found.cause


def test_angles_in_radians_read_as_degrees(gsp, tmp_path):
    """Positions too large by 100 explain such a file less badly than nothing."""
    instance, _, angles, R, T = rotary(np.random.default_rng(10), 40)
    turns = euler_from_rotation("ZYX", R)
    spec = tmp_path / "machine.yaml"
    gspcli.dump(instance, spec)
    names = [f"crank.B{k}" for k in range(1, 7)]
    causes = []
    for unit in (180 / np.pi, 1.0):
        rows = np.hstack((T, turns * unit, np.rad2deg(angles)))
        lines = [",".join(["x,y,z,rx,ry,rz", *names])]
        lines += [",".join(map(repr, row)) for row in rows.tolist()]
        data = tmp_path / "data.csv"
        data.write_text("\n".join(lines) + "\n", encoding="utf-8")
        sigma = ("--sigma", "crank=0.1", "--sigma", "position=0.01", "--sigma", "rotation=0.1")
        run = gsp("calibrate", spec, data, "--euler", "ZYX", *sigma, "--prior", "5")
        causes.append("probably rx, ry, rz are radians, not degrees" in run.out + run.err)
    assert causes == [False, True]


def test_no_cause_is_named_without_a_mistake():
    """Numbers at random are those of no mistake."""
    rng = np.random.default_rng(1)
    values, R, T = noisy(real(), *reachable(12, rng), rng)
    found = gspcli.calibrate(
        nominal(), rng.uniform(700, 1000, values.shape), R, T, sigma=SIGMA, hold_unknown=True
    )
    assert found.doubts
    assert found.cause is None


def test_what_the_data_do_not_tell_may_be_a_mistake_of_them():
    rng = np.random.default_rng(1)
    values, R, T = noisy(real(), *reachable(12, rng), rng)
    with pytest.raises(IncompleteError, match="probably the readings of lengths are too large by"):
        gspcli.calibrate(nominal(), values * 1e3, R, T)


def test_sigmas_that_are_too_small_are_no_mistake_of_the_file():
    rng = np.random.default_rng(2)
    seen = noisy(real(), *reachable(30, rng), rng)
    small = {name: number / 2 for name, number in SIGMA.items()}
    found = gspcli.calibrate(nominal(), *seen, sigma=small)
    assert len(found.doubts) == 1
    assert "chi-squared" in found.doubts[0]
    assert found.cause is None
    large = {name: number * 2 for name, number in SIGMA.items()}
    assert gspcli.calibrate(nominal(), *seen, sigma=large).doubts == ()


def test_right_data_are_doubted_seldom():
    """Once in a thousand by chi-squared; of 20 fits with 12 degrees of freedom none."""
    rng = np.random.default_rng(3)
    doubted = 0
    for _ in range(20):
        seen = noisy(real(), *reachable(9, rng), rng)
        found = gspcli.calibrate(nominal(), *seen, sigma=SIGMA, hold_unknown=True)
        doubted += any("chi-squared" in doubt for doubt in found.doubts)
    assert doubted == 0


def test_outliers_of_a_robust_fit_are_no_doubt():
    rng = np.random.default_rng(4)
    values, R, T = noisy(real(), *reachable(40, rng), rng)
    values[3, 2] += 0.5
    assert gspcli.calibrate(nominal(), values, R, T, sigma=SIGMA).doubts
    robust = gspcli.calibrate(nominal(), values, R, T, sigma=SIGMA, robust=True)
    assert robust.doubts == ()
    assert np.argwhere(robust.outliers).tolist() == [[3, 2]]
    # Nothing is right where a third of the rows is wrong.
    values[::3, 2] += 0.5
    many = gspcli.calibrate(nominal(), values, R, T, sigma=SIGMA, robust=True)
    assert "rows are outliers by more than 5 sigma" in many.doubts[0]


def test_a_machine_farther_off_than_was_stated_before():
    R, T = reachable(20, np.random.default_rng(5))
    values = readings(real(), R, T)
    near = gspcli.calibrate(nominal(), values, R, T, prior=5)
    assert near.doubts == ()
    far = gspcli.calibrate(nominal(), values, R, T, prior=0.1)
    (doubt,) = far.doubts
    assert "times what it is known to before (--prior 0.1 mm), and" in doubt


def test_cranks_that_are_exchanged_or_turn_the_other_way():
    instance = gspcli.load(data_path("platforms", "t-top-head.yaml"))
    home = gspcli.solve(instance).home
    rng = np.random.default_rng(6)
    T = home.T + 0.05 * float(np.linalg.norm(home.T)) * rng.uniform(-1, 1, (400, 3))
    R = np.broadcast_to(home.R, (400, 3, 3))
    _, angles = crank_angles(instance, R, T, along=False)
    there = np.flatnonzero(np.isfinite(angles).all(axis=1))[:40]
    stated = np.tile([float(row.value.value) for row in instance.constraints], (len(there), 1))
    given = {"hold_unknown": True, "sigma": {"value": 1e-5, "crank": 1e-3}}
    seen = stated, R[there], T[there]
    assert gspcli.calibrate(instance, *seen, drives=angles[there], **given).doubts == ()
    for cranks, cause in (
        (angles[there][:, [0, 1, 3, 2, 4, 5]], "are exchanged"),
        (-angles[there], "cranks have the wrong sign"),
    ):
        found = gspcli.calibrate(instance, *seen, drives=cranks, **given)
        assert found.doubts
        assert cause in str(found.cause)
