"""Poses that are planned tell more than random ones, and what will be known is predicted."""

from __future__ import annotations

import numpy as np
import pytest
from measured_machines import HOME, SIGMA, noisy, nominal, reachable, real, seen_of

import gspcli
from gspcli.calibration.calibrating import PRIOR, noise_of
from gspcli.calibration.model import Model
from gspcli.calibration.planning import candidates, d_optimal, planned, told_by
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.coordinates import coordinates, moved
from gspcli.geometry.machine import Machine
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.resources import data_path


@pytest.fixture(scope="module")
def plan():
    return planned(nominal(), 12, np.eye(3), HOME, sigma=SIGMA)


def test_a_plan_uses_all_of_the_reach(plan):
    """Twelve poses of it tell the numbers better than thirty of what is turned by 20 degrees."""
    rng, sigma = np.random.default_rng(7), []
    for places in ((plan.R, plan.T), reachable(30, rng)):
        found = gspcli.calibrate(nominal(), *noisy(real(), *places, rng), sigma=SIGMA)
        sigma.append(np.sqrt(np.mean(found.sigma**2)))
    assert sigma[0] < sigma[1] / 1.5


def test_what_will_be_known_is_predicted(plan):
    rng = np.random.default_rng(1)
    found = gspcli.calibrate(nominal(), *noisy(real(), plan.R, plan.T, rng), sigma=SIGMA)
    known = dict(zip(plan.names, plan.sigma, strict=True))
    ratio = [found.deviations[name] / known[name] for name in found.names]
    # At the stated geometry, that differs by millimetres.
    assert 0.8 < min(ratio) <= max(ratio) < 1.25
    assert (plan.sigma < plan.before).all()


def test_planned_poses_are_within_reach(plan):
    assert plan.limited
    assert Machine.of(nominal()).keeps(plan.R, plan.T).all()
    assert "12 of 3000 poses within ranges and cones" in plan.sentences[0]
    # Cones, too, which this machine has.
    machine = gspcli.load(data_path("platforms", "workspace-study-cones.yaml"))
    home = gspcli.solve(machine)
    R, T = home.R[home.real].real, home.T[home.real].real
    k = int(np.flatnonzero(Machine.of(machine).keeps(R, T))[0])
    there = R[k], T[k]
    R, T, _ = candidates(Machine.of(machine), *there, 0, count=200)
    assert len(R) == 200
    assert Machine.of(machine).keeps(R, T).all()


def test_a_plan_goes_on_from_data(plan):
    rng = np.random.default_rng(2)
    R, T = reachable(40, rng, tilt=0.0)
    values, turns, places = noisy(real(), R, T, rng)
    more = planned(nominal(), 4, np.eye(3), HOME, seen=seen_of(values, turns, places), sigma=SIGMA)
    # Translations are measured: turns tell the rest.
    assert more.sigma.max() < 0.1 * more.before.max()
    assert np.linalg.norm(more.R - np.eye(3), axis=(1, 2)).min() > 0.2


def test_home_must_be_within_reach():
    with pytest.raises(ArgumentError, match="home does not keep the limits"):
        planned(nominal(), 3, np.eye(3), 3 * HOME, sigma=SIGMA)


def test_cranks_drive_a_rotary_machine():
    """What is planned are angles of cranks, and their legs keep their lengths there."""
    machine = gspcli.load(data_path("platforms", "reachy-mini-head.yaml"))
    at = gspcli.solve(machine).home
    home = at.R, at.T
    sigma = {"position": 5e-6, "rotation": 1e-3, "crank": 0.02, "value": 2e-6}
    plan = planned(machine, 16, *home, sigma=sigma)
    chosen = tuple(one for one in coordinates(machine) if one.vector == "crank")
    assert tuple(plan.drives) == tuple(f"crank.{one.primitive}" for one in chosen)
    drives, planned_angles = Machine.of(machine), np.array(list(plan.drives.values())).T
    assert (np.deg2rad(planned_angles) >= drives.low - 1e-9).all()
    assert (np.deg2rad(planned_angles) <= drives.high + 1e-9).all()
    assert np.abs(planned_angles).max() > 20
    stated = [row.value.value for row in machine.constraints]
    for R, T, angles in zip(plan.R, plan.T, planned_angles, strict=True):
        assert values_at(moved(machine, chosen, angles), R, T) == pytest.approx(stated, rel=1e-9)
    assert drives.inverse(plan.R, plan.T) == pytest.approx(np.deg2rad(planned_angles), abs=1e-9)
    # Better known than by as many poses that come as they do.
    model = Model.of(machine, drives=True)
    noise = noise_of(model, sigma)
    places = candidates(drives, *home, 1, count=400)
    slopes = told_by(model, drives, places, None, noise)
    before = np.eye(int(model.free.sum())) / (PRIOR * model.length) ** 2

    def size(rows):
        known = before + np.einsum("kqa,kqb->ab", slopes[rows], slopes[rows])
        return np.linalg.slogdet(known)[1]

    assert size(d_optimal(slopes, 16, before)) > size(np.arange(16))


def test_values_that_stay_stay_in_a_plan():
    """Of a tripod three values have no motor: planned poses keep them."""
    machine = gspcli.example("three-rps")
    home = gspcli.solve(machine).home
    R, T, q = candidates(Machine.of(machine), home.R, home.T, 0, count=50)
    values = values_at(machine, R, T)
    still = Machine.of(machine).fixed
    assert 0 < still.sum() < 6
    stated = [row.value.value for row in machine.constraints]
    assert np.abs(values - stated)[:, still].max() < 1e-9
    assert np.ptp(q[:, ~still], axis=0).min() > 0


def test_ranges_without_room_are_told():
    from dataclasses import replace

    from gspcli.geometry.numbers import Number

    machine = gspcli.load(data_path("platforms", "rubin-m2.yaml"))

    def narrowed(part):
        rows = tuple(
            replace(row, limits=tuple(Number.of(row.value.value + s * part) for s in (-1, 1)))
            for row in machine.constraints
        )
        return replace(machine, constraints=rows)

    home = np.eye(3), np.zeros(3)
    with pytest.raises(ArgumentError, match="the ranges leave no room about home"):
        planned(narrowed(0.0), 6, *home)
    sigma = {"value": 1e-6, "position": 1e-6}
    with pytest.raises(IncompleteError, match="12 of them would tell no number even twice as well"):
        planned(narrowed(2e-4), 12, *home, sigma=sigma)
    some = planned(narrowed(2e-3), 12, *home, sigma=sigma)
    assert 0 < some.untold < len(some.names)
    assert f"{some.untold} of 42 numbers will not even be known twice" in some.sentences[-1]


def test_choices_of_few_against_all_of_them():
    """Three of eight."""
    from itertools import combinations_with_replacement

    slopes = np.random.default_rng(3).normal(size=(8, 2, 4))
    before = 0.1 * np.eye(4)

    def determinant(chosen):
        rows = slopes[list(chosen)]
        return np.linalg.det(before + np.einsum("kqa,kqb->ab", rows, rows))

    every = list(combinations_with_replacement(range(8), 3))
    greedy = d_optimal(slopes, 3, before)
    assert determinant(greedy) > 0.8 * max(map(determinant, every))


def test_an_offset_of_a_plane_is_refused_in_words():
    rng = np.random.default_rng(4)
    instance = gspcli.load(data_path("examples", "fixture-3-2-1.yaml"))
    from gspcli.geometry.quaternions import rotation_from_vector

    R = rotation_from_vector(0.2 * rng.normal(size=(40, 3)))
    T = 20 * rng.normal(size=(40, 3))
    values = gspcli.measure(instance, R, T)
    with pytest.raises(gspcli.GspError, match="the data determine 30 of 33 numbers"):
        gspcli.calibrate(instance, values, R, T, estimate=["offsets"])
