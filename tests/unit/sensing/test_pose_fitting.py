"""Poses of more than six measurements: their law, all modes, and the outlier."""

from __future__ import annotations

import json
import math
import pickle

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.sensing.pose_fitting import (
    PoseNumbers,
    _in_order,
    _minima,
    _pose,
    candidates_of,
    chance,
    fit_poses,
    next_choice,
    parsed_readings,
    platform_of,
    value_sigmas,
)
from gspcli.sensing.sensor_kinds import parse_sensor

SENSORS = ("leg P1 B2", "leg P3 B6", "leg P1 (0, 1, -9)", "inclinometer", "joint 1 base about x")
SIGMA = 1e-3


def measured(name, sensors=SENSORS, *, noise=SIGMA, seed=0, wrong=None, by=0.2, mode=0):
    """Return a machine with noisy values, noisy readings, and the true pose."""
    rng, machine = np.random.default_rng(seed), gspcli.example(name)
    found = gspcli.solve(machine)
    R, T = found.R[found.real].real[mode], found.T[found.real].real[mode]
    values = np.abs(gspcli.measure(machine, R, T)) + noise * rng.normal(size=6)
    if wrong is not None and wrong < 6:
        values[wrong] += by
    texts = []
    for k, text in enumerate(sensors):
        sensor = parse_sensor(text, machine, repeated=True)
        count = 2 if sensor.kind == "inclinometer" else 1
        read = sensor.read(machine, R, T) + noise * rng.normal(size=count)
        read = read + (by if wrong == 6 + k else 0)
        texts.append(f"{text} = {', '.join(f'{x:.12g}' for x in read)} ± {SIGMA}")
    settings = {k: abs(round(float(x), 9)) for k, x in enumerate(values, 1)}
    return gspcli.set_values(machine, settings), texts, R, T


@pytest.mark.parametrize("name", ["workspace-study", "three-rps", "sdss-primary"])
def test_the_true_pose_fits(name):
    """Of legs, and of machines with planes; noise of the size that is stated."""
    sensors = ["leg (0, 0, 10) (7, 3, -90)", "inclinometer", "leg (9, 5, 0) (90, 4, 2)"]
    noise = 0 if name == "three-rps" else SIGMA / 2
    machine, texts, R, T = measured(name, sensors, noise=noise)
    fit = fit_poses(machine, texts, sigma={"value": SIGMA, "angle": SIGMA})
    best = fit.poses[0]
    assert best.fits
    assert best.freedom == 4
    assert np.abs((best.T - T) / best.sigma[3:]).max() < 4
    assert np.abs(best.R - R).max() < 5 * best.sigma[:3].max() + 1e-12
    costs = [pose.chi_squared for pose in fit.poses]
    assert costs == sorted(costs)


def test_chi_squared_and_deviations_have_their_law():
    """Mean and variance of 40 fits, and the scatter of the pose in its deviations."""
    exact, _, R, T = measured("workspace-study", noise=0)
    chi, z = [], []
    for seed in range(40):
        machine, texts, _, _ = measured_about(exact, R, T, seed)
        numbers = PoseNumbers(
            machine, tuple(parsed_readings(machine, texts)), value_sigmas(machine, {"value": SIGMA})
        )
        found = _minima(numbers, R[None], T[None])
        pose = _pose(numbers, found.R[0], found.T[0], float(found.cost[0]))
        chi.append(pose.chi_squared)
        z.append((pose.T - T) / pose.sigma[3:])
    assert np.mean(chi) == pytest.approx(6, abs=4 * math.sqrt(12 / 40))
    assert np.var(chi) == pytest.approx(12, rel=0.6)
    assert np.std(z, axis=0) == pytest.approx(1, abs=0.25)


def measured_about(exact, R, T, seed):
    """Return noisy measurements of a platform at a pose that is known."""
    rng = np.random.default_rng(seed)
    texts = []
    values = {
        k: float(row.value.value + SIGMA * rng.normal())
        for k, row in enumerate(exact.constraints, 1)
    }
    for text in SENSORS:
        sensor = parse_sensor(text, exact)
        count = 2 if sensor.kind == "inclinometer" else 1
        read = sensor.read(exact, R, T) + SIGMA * rng.normal(size=count)
        texts.append(f"{text} = {', '.join(f'{x:.12g}' for x in read)} ± {SIGMA}")
    return gspcli.set_values(exact, values), texts, R, T


def test_slopes_are_the_derivatives_of_residuals():
    machine, texts, R, T = measured("sdss-primary", ("leg (9, 0, 0) (3, 5, -90)", "inclinometer"))
    numbers = PoseNumbers(
        machine, tuple(parsed_readings(machine, texts)), value_sigmas(machine, {"value": 1.0})
    )
    slopes, h = numbers.slopes(R[None], T[None])[0], 1e-6
    for k in range(6):
        step = np.eye(6)[k] * h
        ends = [
            numbers.residuals(rotation_from_vector(s * step[:3]) @ R, T + s * step[3:])
            for s in (1, -1)
        ]
        assert slopes[:, k] == pytest.approx(
            (ends[1] - ends[0]) / (2 * h), abs=1e-6 * np.abs(slopes).max()
        )


@pytest.mark.parametrize("wrong", [1, 6, 8])
def test_the_outlier_is_named(wrong):
    """A value or a leg that is off by 200 deviations; the fit without it is right."""
    machine, texts, _, T = measured("rubin-camera", wrong=wrong, noise=SIGMA / 2)
    fit = fit_poses(machine, texts, sigma={"value": SIGMA})
    assert fit.fitting == []
    assert fit.without is not None
    assert (fit.without.measurement, fit.without.alike) == (wrong, ())
    pose = fit.without.pose
    assert pose.fits
    assert pose.freedom == fit.poses[0].freedom - 1
    assert np.abs((pose.T - T) / pose.sigma[3:]).max() < 4
    # The pose with it is off by much more.
    assert np.abs(fit.poses[0].T - T).max() > 10 * np.abs(pose.T - T).max()
    assert "the outlier is " in fit.sentences[2]


def test_one_number_too_many_tells_no_outlier():
    machine, texts, _, _ = measured("rubin-camera", ("leg P1 B2",), wrong=6)
    fit = fit_poses(machine, texts, sigma={"value": SIGMA})
    assert fit.fitting == []
    assert fit.without is not None
    assert fit.without.alike
    assert "the data do not show which" in fit.sentences[2]
    sizes = fit.poses[0].measurement_sizes
    assert np.nanmax(sizes) == pytest.approx(np.nanmin(sizes), rel=0.05)


def test_two_modes_that_fit():
    """A leg with a coarse scale tells none of the modes apart."""
    machine = gspcli.example("rubin-m2")
    fit = fit_poses(machine, ["leg P1 B2 = 2.913 ± 5"], sigma={"value": 1e-5})
    assert len(fit.fitting) >= 2
    assert fit.sentences[0].startswith("2 poses fit the 7 numbers: 1 and 2")
    # These are the modes of the six values, with exact values nearly.
    modes = gspcli.solve(machine)
    for T in modes.T[modes.real].real:
        assert min(np.abs(pose.T - T).max() for pose in fit.poses) < 1e-4


def test_choices_of_six():
    """Each measurement is missing in some choice, and each choice determines the pose."""
    machine, texts, R, T = measured("rubin-camera")
    readings = parsed_readings(machine, texts)
    candidates = candidates_of(machine, readings)
    # An inclinometer is two constraints, an angle of a joint none.
    assert [one.owner for one in candidates] == [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9]
    for one in candidates[6:]:
        platform = platform_of(machine, [*candidates[:5], one])
        assert platform is not None
        value = gspcli.measure(platform, R, T)[5]
        assert abs(abs(value) - one.constraint.value.value) < 0.01
    numbers = PoseNumbers(machine, tuple(readings), value_sigmas(machine, {"value": SIGMA}))
    slopes = numbers.slopes(R[None], T[None])[0]
    used = np.zeros(len(candidates), int)
    missing = set()
    for _ in range(4):
        chosen = next_choice(candidates, slopes, used)
        assert chosen is not None
        assert len(chosen) == 6
        assert np.linalg.matrix_rank(slopes[[one.number for one in chosen]]) == 6
        for k, one in enumerate(candidates):
            used[k] += one in chosen
        missing |= set(range(11)) - {one.owner for one in chosen}
    assert missing >= set(range(9))
    fit = fit_poses(machine, texts, sigma={"value": SIGMA})
    assert len(fit.choices) >= 3
    assert not set.intersection(*map(set, fit.choices))


def test_values_of_further_kinds_are_constraints():
    """A signed distance to a plane and an angle of lines take part in choices of six."""
    machine = gspcli.example("sdss-primary")
    found = gspcli.solve(machine)
    R, T = found.R[found.real].real[0], found.T[found.real].real[0]
    body = machine.named("base")
    plane = next(name for name, one in body.items() if isinstance(one, gspcli.Plane))
    text = f"distance (1, 2, 3) {plane}"
    value = float(parse_sensor(text, machine).read(machine, R, T)[0])
    readings = parsed_readings(machine, [f"{text} = {value:.12g} ± 0.01"])
    (*_, last) = candidates_of(machine, readings)
    assert (last.constraint.side.value == "negative") == (value < 0)
    assert last.constraint.value.value == pytest.approx(abs(value))
    fit = fit_poses(machine, readings, sigma={"value": 0.01})
    assert fit.poses[0].chi_squared < 1e-6


def test_chance_is_that_of_chi_squared():
    """Tables of the law: quantiles of 5 % and 0.1 %."""
    for freedom, five, thousandth in (
        (1, 3.841459, 10.827566),
        (2, 5.991465, 13.815511),
        (3, 7.814728, 16.266236),
        (6, 12.591587, 22.457744),
        (9, 16.918978, 27.877165),
    ):
        assert chance(five, freedom) == pytest.approx(0.05, rel=1e-5)
        assert chance(thousandth, freedom) == pytest.approx(0.001, rel=1e-5)
    assert chance(3.0, 0) == 1
    assert chance(1e5, 3) == 0
    assert chance(0.0, 3) == 1


def test_deviations_of_values():
    machine = gspcli.example("example-6.8")
    found = value_sigmas(machine, {"angle": 0.1, "value": 0.2, "2": 0.3})
    assert found.tolist() == [0.1, 0.3, 0.1, 0.2, 0.2, 0.2]
    for sigma, message in (
        ({}, r"--sigma angle=NUMBER and value=NUMBER, or `tolerance`"),
        ({"value": 1.0}, "the values 1, 2 and 3"),
        ({"leg": 1.0}, "found 'leg', expected value, angle"),
        ({"value": 0.0, "angle": 1.0}, r"sigma\['value'\]: found 0"),
        ({"value": math.nan, "angle": 1.0}, "found nan"),
    ):
        with pytest.raises(ArgumentError, match=message):
            value_sigmas(machine, sigma)


def test_readings_of_a_file(tmp_path):
    text = gspcli.dumps(gspcli.example("rubin-m2")) + "readings:\n  - leg P1 B2 = 2.913 ± 0.002\n"
    machine = gspcli.loads(text)
    assert machine.readings == ("leg P1 B2 = 2.913 ± 0.002",)
    assert gspcli.loads(gspcli.dumps(machine)) == machine
    fit = fit_poses(machine, sigma={"value": 1e-5})
    assert fit.fitting == [1]
    assert pickle.loads(pickle.dumps(fit)).sentences == fit.sentences
    json.dumps(fit.to_json())
    assert list(fit.to_frame()["fits"]) == [True, *[False] * (len(fit.poses) - 1)]


def test_wrong_readings():
    machine = gspcli.example("rubin-m2")
    with pytest.raises(ArgumentError, match="found none, expected at least one"):
        fit_poses(machine, sigma={"value": 1.0})
    with pytest.raises(ArgumentError, match=r"readings\[0\], column 5"):
        fit_poses(machine, ["leg P9 B1 = 1 ± 1"], sigma={"value": 1.0})
    # A leg of a constraint is a second measurement here, and no new sensor.
    assert fit_poses(machine, ["leg P1 B1 = 0.6 ± 9"], sigma={"value": 1e-3}).poses
    with pytest.raises(GspError, match="expected another leg"):
        gspcli.fit_readings(gspcli.solve(machine), ["leg P1 B1 = 0.6 ± 9"])


def test_a_minimum_is_right_to_its_last_digits():
    """The gradient is rounding there, also where residuals are large: 18 deviations."""
    machine = gspcli.example("rubin-m2")
    fit = fit_poses(machine, ["leg P1 B2 = 2.953 ± 0.002"], sigma={"value": SIGMA})
    assert fit.poses[0].chi_squared > 300
    for pose in fit.poses:
        slopes = fit.numbers.slopes(pose.R[None], pose.T[None])[0]
        terms = np.abs(slopes * pose.residuals[:, None]).sum(axis=0)
        assert np.abs(slopes.T @ pose.residuals).max() < 1e-10 * terms.max()


def test_a_minimum_in_a_narrow_valley_is_reached():
    """After 100 steps no descent to the last one has come to its end."""
    machine = gspcli.example("rubin-m2")
    found = fit_poses(machine, ["leg P1 B2 = 2.913 ± 0.002"], sigma={"value": 1e-5})
    assert [f"{pose.chi_squared:.4g}" for pose in found.poses] == [
        "0.04197", "3762", "1.671e+06", "2.523e+06",
    ]  # fmt: skip


def test_the_first_of_equal_suspects_is_named():
    """Six numbers fit exactly without any of the seven: the smallest sum of squares is rounding."""
    machine = gspcli.example("rubin-m2")
    fit = fit_poses(machine, ["leg P1 B2 = 2.953 ± 0.002"], sigma={"value": SIGMA})
    assert fit.without.measurement == 0
    assert fit.without.alike == (1, 3, 4, 5, 6)


@pytest.mark.parametrize("noise", [0, 1e-13, 1e-8])
def test_equal_sums_of_squares_keep_their_order(noise):
    cost = np.array([2, 5, 2, 1e-3, 5, 2]) + noise * np.array([3, 1, 2, 4, 0, 1])
    assert _in_order(cost) == [3, 0, 2, 5, 1, 4]


def test_a_choice_of_six_does_not_depend_on_rounding():
    """All numbers tell as much alone: the first is taken, not the one that rounding favours."""
    machine, texts, R, T = measured("workspace-study")
    candidates = candidates_of(machine, parsed_readings(machine, texts))
    numbers = PoseNumbers(
        machine, tuple(parsed_readings(machine, texts)), value_sigmas(machine, {"value": SIGMA})
    )
    slopes, used = numbers.slopes(R[None], T[None])[0], np.zeros(len(candidates), int)
    rng = np.random.default_rng(0)
    owners = {
        tuple(
            one.owner
            for one in next_choice(
                candidates, slopes * (1 + 1e-15 * rng.normal(size=slopes.shape)), used
            )
        )
        for _ in range(20)
    }
    assert len(owners) == 1
    assert 0 in owners.pop()
