from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.machine import Machine
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import MovingPlatform, measure
from gspcli.motion.following.branch_follower import Stop
from gspcli.motion.singularities import clearances as module
from gspcli.motion.singularities.clearances import clearances, each_clearance, weights_of
from gspcli.motion.singularities.neighbourhoods import SIGNS
from gspcli.resources import data_path, instance_files

TYPES = ["6PP", "6PH", "6PL", "6DLL", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH"]


def clearance(instance, R, T, weights=None, **more):
    """Return the clearance of one pose, in the units of the instance."""
    machine = Machine.of(instance)
    weights = None if weights is None else weights * machine.units
    found = each_clearance(machine, R[None], T[None], weights=weights, **more)[0]
    return replace(found, numbers=None if found.numbers is None else found.numbers / machine.units)


def platform(name, seed):
    instance, (R, T) = random_instance(gspcli.parse_type(name), np.random.default_rng(seed))
    return instance, R, T


@pytest.mark.parametrize("name", TYPES)
def test_nothing_is_singular_within_the_lower_bound(name):
    instance, R, T = platform(name, 1)
    lower = clearances(Machine.of(instance), R[None], T[None])[0][0]
    assert lower > 0
    moving = MovingPlatform(instance)
    values = measure(instance, R, T)
    rng = np.random.default_rng(2)
    directions = np.concatenate((SIGNS, -SIGNS, rng.uniform(-1, 1, size=(64, 6))))
    ends = np.stack(
        (np.broadcast_to(values, directions.shape), values + lower * directions), axis=1
    )
    start = np.repeat(moving.points(R[None], T[None]), len(ends), axis=0)
    followed = moving.follow(moving.internal(ends), np.arange(len(ends)), start)
    assert (followed.stop == Stop.END).all()


@pytest.mark.parametrize("name", TYPES)
def test_the_upper_bound_is_a_fold_of_the_same_mode(name):
    instance, R, T = platform(name, 3)
    found = clearance(instance, R, T)
    assert 0 < found.lower <= found.upper
    if np.isinf(found.upper):
        return
    assert found.numbers is not None
    if found.end is not None:
        # The distance that becomes zero before any fold found.
        assert found.R is None
        assert found.upper == measure(instance, R, T)[found.end] == measure(instance, R, T).min()
        return
    assert np.abs(found.numbers - measure(instance, R, T)).max() == pytest.approx(found.upper)
    assert np.allclose(measure(instance, found.R, found.T), found.numbers, atol=1e-6)


def test_bounds_of_random_hexapods_are_near_to_each_other():
    ratios, refined = [], []
    for seed in range(5):
        instance, R, T = platform("6PP", seed)
        ratios.append(clearance(instance, R, T).ratio)
        refined.append(clearance(instance, R, T, refine=True).ratio)
        assert 1 <= refined[-1] <= ratios[-1]
    assert np.median(ratios) < 4
    assert np.median(refined) < 2


def test_weights_and_ranges():
    instance = gspcli.load(data_path("platforms", "workspace-study.yaml"))
    machine = Machine.of(instance)
    weights, ranged = weights_of(machine)
    assert ranged
    assert np.allclose(weights, [(c.limits[1].value - c.limits[0].value) / 2 for c in
                                 instance.constraints])  # fmt: skip
    poses = gspcli.solve(instance)
    R, T = poses.R[poses.real].real, poses.T[poses.real].real
    one, ten = (clearances(machine, R, T, weights=np.full(6, x))[0] for x in (1, 10))
    assert np.allclose(ten, one / 10, rtol=0.1)
    assert not weights_of(Machine.of(gspcli.example("platform-6-6")))[1]


def test_a_singular_pose_has_no_clearance():
    instance = gspcli.load(data_path("examples", "platform-6-6.yaml"))
    values = [[2.53, 2.08, 0.93, 1.97, 1.46, 1.73], [2.6, 2.0, 1.0, 1.9, 1.46, 1.73]]
    fold = gspcli.track(instance, values).events[0]
    assert clearances(Machine.of(instance), fold.R[None], fold.T[None])[0][0] < 1e-9


def test_nothing_is_followed_from_a_pose_that_is_exactly_singular():
    instance = gspcli.load(data_path("examples", "singular-pose.yaml"))
    poses = gspcli.solve(instance)
    found = clearance(instance, poses.R[0].real, poses.T[0].real)
    assert (found.lower, found.R) == (0, None)
    # What is known of values holds all the same: none is below zero.
    assert found.upper == measure(instance, poses.R[0].real, poses.T[0].real).min()


@pytest.mark.parametrize(("weights", "every"), [(None, 1), ([1, 1, 5, 90, 90, 90], 8)])
def test_no_value_goes_beyond_the_end_of_its_range(weights, every):
    instance = gspcli.load(data_path("examples", "surfaces-ppp.yaml"))
    poses = gspcli.solve(instance)
    units = np.ones(6) if weights is None else np.array(weights, float)
    ends = []
    which = np.flatnonzero(poses.real)[::every]
    for R, T in zip(poses.R[which].real, poses.T[which].real, strict=True):
        values = measure(instance, R, T)
        found = clearance(instance, R, T, weights=weights)
        # A DLL is at least 0; ALL and AHH are between 0 and 180 degrees, ALH within 90.
        d, a, b, c = values[2:]
        rooms = np.array([d, min(a, 180 - a), 90 - abs(b), min(c, 180 - c)]) / units[2:]
        assert 0 < found.lower <= found.upper <= rooms.min()
        if found.end is not None:
            assert found.R is None
            assert found.upper == pytest.approx(rooms.min(), rel=1e-12)
            ends.append(found.end)
    if weights is None:
        assert 2 in ends


def test_mistakes_are_named():
    instance, R, T = platform("6PP", 0)
    with pytest.raises(ArgumentError, match="weights: found"):
        clearances(Machine.of(instance), R[None], T[None], weights=[1, 2, 3])


@pytest.mark.parametrize("name", ["rubin-m2", "figure-3"])
def test_many_poses_have_the_clearances_of_each(name: str, monkeypatch) -> None:
    """And what can be done for all of them at once is: lower bounds, and first looks at lines."""
    instance = gspcli.load(instance_files()[name])
    result = gspcli.solve(instance)
    R, T = result.R[result.real].real[:3], result.T[result.real].real[:3]
    T = T + 1e-3 * result.arrangement.length
    alone = [clearance(instance, turn, place) for turn, place in zip(R, T, strict=True)]
    calls = []
    counting = lambda *a, **k: calls.append(a) or clearances(*a, **k)  # noqa: E731
    monkeypatch.setattr(module, "clearances", counting)
    together = module.each_clearance(Machine.of(instance), R, T)
    assert len(calls) == 1
    for one, other in zip(alone, together, strict=True):
        assert (one.lower, one.upper, one.end) == (other.lower, other.upper, other.end)


def test_no_poses_have_no_clearances() -> None:
    instance = gspcli.load(instance_files()["rubin-m2"])
    assert not module.each_clearance(Machine.of(instance), np.zeros((0, 3, 3)), np.zeros((0, 3)))


def test_rounding_errors_do_not_choose_between_folds_that_are_equally_near() -> None:
    """A symmetric machine has several; from poses that differ by 1e-15 the same one is named."""
    instance = gspcli.example("workspace-study")
    poses, home = gspcli.solve(instance), instance.home
    R, T = poses.R[poses.real].real, poses.T[poses.real].real
    k = np.linalg.norm(T - home.T, axis=1).argmin()
    rng = np.random.default_rng(4)
    turns = R[k] + 1e-15 * rng.normal(size=(20, 3, 3))
    places = T[k] + 1e-13 * rng.normal(size=(20, 3))
    values = [row["values"] for row in gspcli.clearance(instance, turns, places).rows()]
    assert np.allclose(values, values[0], rtol=1e-9)
