"""Numbers of modes are those of `solve`, wherever a track begins."""

import numpy as np
import pytest

import gspcli
from gspcli.motion.files.value_files import nominal_values
from gspcli.resources import instance_files
from gspcli.spec import load

MACHINES = ("rubin-m2", "nano-hexapod", "workspace-study", "sdss-primary", "t-top-head")


@pytest.mark.parametrize("name", MACHINES)
def test_a_track_from_the_stated_values_has_the_numbers_of_solve(name):
    instance = load(instance_files()[name])
    result = gspcli.solve(instance)
    values = nominal_values(instance)
    found = gspcli.track(instance, np.stack([values, values]))
    assert found.modes.tolist() == list(range(1, result.counts.real + 1))
    assert found.new == []
    assert np.abs(found.R[:, 0] - result.R[result.real].real).max() < 1e-9
    assert np.abs(found.T[:, 0] - result.T[result.real].real).max() < 1e-9


@pytest.mark.parametrize("name", MACHINES)
def test_a_track_that_begins_elsewhere_carries_them_along(name):
    instance = load(instance_files()[name])
    values = nominal_values(instance)
    rng = np.random.default_rng(7)
    away = values * (1 + 0.003 * rng.uniform(-1, 1, 6))
    there = gspcli.track(instance, np.stack([values, away]))
    here = gspcli.track(instance, np.stack([away, away]))
    arrived = ~np.isnan(there.T[:, -1, 0])
    numbers = there.modes[arrived]
    assert len(numbers)
    assert here.modes[: len(numbers)].tolist() == numbers.tolist()
    assert here.T[: len(numbers), 0] == pytest.approx(there.T[arrived, -1], abs=1e-7)
    assert here.R[: len(numbers), 0] == pytest.approx(there.R[arrived, -1], abs=1e-7)
    assert here.new == here.modes[len(numbers) :].tolist()
    assert all(number > here.known for number in here.new)


def test_home_is_home_at_other_values_though_the_order_is_another():
    instance = load(instance_files()["nano-hexapod"])
    values = nominal_values(instance) + 0.02
    moved = gspcli.set_values(instance, dict(enumerate(values.tolist(), 1)))
    home = gspcli.solve(instance).home.number
    found = gspcli.track(instance, np.stack([values, values]), modes=[home])
    assert found.modes.tolist() == [home]
    assert found.T[0, 0] == pytest.approx(gspcli.solve(moved).home.T, abs=1e-9)


def test_a_pose_that_is_born_on_the_way_is_new():
    instance = load(instance_files()["rubin-m2"])
    values = nominal_values(instance)
    rng = np.random.default_rng(1)
    for _ in range(50):
        away = values + 0.3 * rng.uniform(-1, 1, 6)
        found = gspcli.track(instance, np.stack([away, away]))
        if found.new:
            break
    assert found.known == 2
    assert found.new == list(range(3, 3 + len(found.new)))
    with pytest.raises(gspcli.GspError, match="expected one of those at the first row"):
        gspcli.track(instance, np.stack([away, away]), modes=[99])
