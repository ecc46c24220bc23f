"""The derivatives of all that can be measured, by all parameters and by the pose."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf

import gspcli
from gspcli.calibration.calibrating import calibrated_text, likely_cause
from gspcli.calibration.measurements import Measurements, Noise, constant_rods, value_rows
from gspcli.calibration.model import Model, calibrated, file_numbers
from gspcli.errors import ArgumentError
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import cross_matrix, rotation_from_vector
from gspcli.resources import data_path
from tests.support.driven_machines import driven
from tests.support.driven_measurements import SIGMA, noisy, reached, wrong_machine

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


# Calibrations of machines with rails, shared carriages and arms.


MACHINES_OF_DRIVES = ("6-PUS", "delta", "mixed", "t-top-head")


def _rotation(vector):
    """Return the matrix of a rotation by a vector, with mpmath."""
    angle = mp.sqrt(sum(x * x for x in vector))
    x, y, z = vector
    K = mpmath.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    if angle == 0:
        return mpmath.eye(3)
    return mpmath.eye(3) + mp.sin(angle) / angle * K + (1 - mp.cos(angle)) / angle**2 * K * K


def _vector(numbers):
    return mpmath.matrix([mpf(float(x)) for x in numbers])


def _length(model, k, step, readings, R, T):
    """Return the length of leg k after a step of the parameters, stated again with mpmath.

    Written from the words: a crank turns its points about its axis, a slide moves them along it.
    """
    ends = {}
    for body in ("platform", "base"):
        own = next(
            (b, s) for b, s in model.spans() if b.body == body and b.sort == "point" and k in b.rows
        )
        point = _vector(own[0].point)
        for shift, x in zip(own[0].shifts, step[own[1]], strict=True):
            point += x * _vector(shift)
        for number, drive in enumerate(model.drives):
            if drive.body != body or own[0].name not in drive.carried:
                continue
            part = list(step[next(s for b, s in model.spans() if b is drive)])
            s, t = len(drive.shifts), len(drive.tilts)
            centre, tilt = _vector(drive.point), _vector((0, 0, 0))
            for shift, x in zip(drive.shifts, part[:s], strict=True):
                centre += x * _vector(shift)
            for turn, x in zip(drive.tilts, part[s : s + t], strict=True):
                tilt += x * _vector(turn)
            unit = _rotation(tilt) * _vector(drive.unit)
            offset, scale = (
                mpf(float(c)) + x for c, x in zip(drive.corrections, part[s + t :], strict=True)
            )
            q = mpf(float(readings[number])) * (1 + scale) + offset
            if drive.sort == "slide":
                point += q * unit
            else:
                point = centre + _rotation(q * unit) * (point - centre)
        ends[body] = point
    rotated = mpmath.matrix(R.tolist()) * ends["platform"] + _vector(T)
    return mp.norm(rotated - ends["base"])


@pytest.mark.parametrize("name", MACHINES_OF_DRIVES)
def test_derivatives_are_those_of_differences_with_40_digits(name):
    rng = np.random.default_rng(1)
    instance, truth = wrong_machine(name, rng, zeros=("slide.B1",))
    readings, legs, R, T = reached(instance, truth, rng, 1, 0.05)
    model = replace(
        truth,
        blocks=tuple(
            replace(b, corrections=np.array([1e-2, 3e-3])) if b.is_drive else b
            for b in truth.blocks
        ),
    )
    seen = Measurements(legs, R, T, np.zeros(3), drives=readings, rods=np.isnan(legs[0]))
    seen = replace(seen, readings=np.nan_to_num(legs))
    found = value_rows(model, R, T, seen, Noise(1, 1, 1, 1, 1, 0, 0)).by_model[0]
    mp.dps, h = 40, mpf("1e-16")
    try:
        for block, p in [(b, p) for b, s in model.spans() for p in range(s.start, s.stop)]:
            others = [k for k in range(6) if k not in block.rows]
            assert not found[others, p].any()
            for k in block.rows:
                ends = []
                for sign in (1, -1):
                    step = np.full(len(model.free), mpf(0), object)
                    step[p] = sign * h
                    ends.append(_length(model, k, step, readings[0], R[0], T[0]))
                assert float((ends[0] - ends[1]) / (2 * h)) == pytest.approx(
                    found[k, p], abs=1e-12, rel=1e-12
                ), (model.names[p], k)
    finally:
        mp.dps = 15


def _tells(model, truth, instance, rng):
    """Return how far apart two machines are: the largest difference of values, in lengths."""
    readings, _, R, T = reached(instance, truth, rng, 40)
    apart = measured(model.bodies(readings), R, T) - model.offsets
    apart -= measured(truth.bodies(readings), R, T) - truth.offsets
    return float(np.abs(apart).max()) / truth.length


@pytest.mark.parametrize("name", ["6-PUS", "mixed"])
def test_exact_measurements_give_the_machine(name):
    """Nine numbers a leg with a rail: its direction (2), rod, and the two joints (6)."""
    rng = np.random.default_rng(2)
    instance, truth = wrong_machine(name, rng)
    readings, legs, R, T = reached(instance, truth, rng, 60)
    drives, _, _ = noisy(truth, readings, R, T, rng, dict.fromkeys(SIGMA, 0.0))
    found = gspcli.calibrate(instance, legs, R, T, drives=drives)
    assert truth.free.sum() == (54 if name == "6-PUS" else 4 * 11 + 9 + 7)
    assert found.unknowns.count == 0
    assert not found.doubts
    assert _tells(found.fit.model, truth, instance, rng) < 1e-10


def test_intervals_of_a_6_pus_contain_the_truth():
    """Chi-squared has its mean, and intervals of 95 % contain nearly this many true numbers."""
    rng = np.random.default_rng(3)
    instance, truth = wrong_machine("6-PUS", rng)
    readings, legs, R, T = reached(instance, truth, rng, 30)
    inside, chi = [], []
    for _ in range(30):
        drives, turns, places = noisy(truth, readings, R, T, rng)
        found = gspcli.calibrate(instance, legs, turns, places, drives=drives, sigma=SIGMA)
        true = file_numbers(instance, truth).values[found.estimated]
        inside.append(np.abs(found.after - true) < 1.96 * found.sigma)
        chi.append(found.chi_squared / found.freedom)
        assert not found.doubts
    shares = np.mean(inside, axis=0)
    assert 0.93 < shares.mean() < 0.97
    assert shares.min() > 0.75
    assert abs(np.mean(chi) - 1) < 4 * np.sqrt(2 / (30 * found.freedom))


def test_a_linear_delta_is_found_from_its_carriages():
    """Its rods are read by three carriages; the platform turns as far as its errors let it.

    Points of the platform are held: poses that do not turn move both ends of a rod alike.
    """
    rng = np.random.default_rng(4)
    instance, truth = wrong_machine("delta", rng, 5e-4)
    platform = np.array([one.startswith("platform.") for one in truth.names])
    stated = Model.of(instance, drives=True)
    blocks = tuple(
        new if new.body == "base" else old
        for new, old in zip(truth.blocks, stated.blocks, strict=True)
    )
    truth = replace(truth, blocks=blocks, free=truth.free & ~platform)
    readings, legs, R, T = reached(instance, truth, rng, 40, 0.5)
    apart, chi = [], []
    for _ in range(20):
        drives, turns, places = noisy(truth, readings, R, T, rng)
        assert drives.shape == (40, 3)
        given = {"drives": drives, "sigma": SIGMA, "hold": ["platform"]}
        found = gspcli.calibrate(instance, legs, turns, places, **given)
        assert len(found.fit.model.free[found.fit.model.free]) == 6 * 3 + 3 * 2 + 6
        assert found.unknowns.count == 0
        off = found.after - file_numbers(instance, truth).values[found.estimated]
        # Of 33 numbers, three directions have two parameters each.
        apart.append(off @ np.linalg.pinv(found.covariance, rcond=1e-10) @ off / 30)
        chi.append(found.chi_squared / found.freedom)
    assert abs(np.mean(apart) - 1) < 4 * np.sqrt(2 / (20 * 30))
    # Two rods have one reading, and one error: chi-squared says so.
    assert abs(np.mean(chi) - 1) < 4 * np.sqrt(2 / (20 * found.freedom))


def test_errors_of_a_shared_carriage_are_common():
    """Whitened rows of the two rods have the covariance one, for any geometry."""
    rng = np.random.default_rng(5)
    instance, truth = wrong_machine("delta", rng)
    readings, _, R, T = reached(instance, truth, rng, 1)
    rods = np.array([row.value.value for row in instance.constraints])
    noise = Noise(1e-4, 1, 1, 1, 1, 0, 1e-3)
    many = 4000
    off = noise.slide * rng.normal(size=(many, 3))
    values = rods + noise.value * rng.normal(size=(many, 6))
    seen = Measurements(
        values, np.tile(R, (many, 1, 1)), np.tile(T, (many, 1)), np.zeros(3),
        drives=readings + off,
    )  # fmt: skip
    left = value_rows(truth, seen.rotations, seen.positions, seen, noise).residual
    covariance = np.cov(left.T)
    assert np.abs(covariance - np.eye(6)).max() < 5 / np.sqrt(many)
    # A rod without a reading says nothing of its carriage.
    values[:, 0] = np.nan
    left = value_rows(truth, seen.rotations, seen.positions, seen, noise).residual
    assert np.isnan(left[:, 0]).all()
    assert np.var(left[:, 1]) == pytest.approx(1, abs=5 * np.sqrt(2 / many))


def test_scales_and_zeros_of_rails():
    """The scale of a rail's readings, and its zero in place of a shift of the point along it."""
    rng = np.random.default_rng(6)
    names = [f"base.B{k}.slide.{what}" for k in range(1, 7) for what in ("offset", "scale")]
    zeros = [f"slide.B{k}" for k in range(1, 7)]
    instance, truth = wrong_machine("6-PUS", rng, zeros=zeros)
    blocks = tuple(
        replace(b, corrections=np.array([b.corrections[0], 2e-3 * rng.normal()]))
        if b.is_drive
        else b
        for b in truth.blocks
    )
    truth = replace(truth, blocks=blocks)
    readings, legs, R, T = reached(instance, truth, rng, 60)
    asked = ["scales", *(name for name in names if name.endswith("offset"))]
    found = gspcli.calibrate(instance, legs, R, T, drives=readings, estimate=asked)
    numbers = dict(zip(found.names, found.after.tolist(), strict=True))
    for drive in truth.drives:
        offset, scale = (numbers[f"base.{drive.name}.slide.{w}"] for w in ("offset", "scale"))
        assert offset == pytest.approx(drive.corrections[0], abs=1e-8)
        assert scale == pytest.approx(drive.corrections[1], abs=1e-8)
    # The file says both, and a machine that states them reads as it did.
    again = gspcli.loads(calibrated_text(found))
    assert again.constraints == found.instance.constraints
    assert again.constraints[0].base.slide.scale.value == pytest.approx(numbers[names[1]])
    values = Machine.of(again).inverse(R, T)
    assert np.abs(Machine.of(again).readings(values) - readings).max() < 1e-8
    kept = gspcli.calibrate(again, legs, R, T, drives=readings)
    assert kept.instance.constraints[0].base.slide.scale == again.constraints[0].base.slide.scale
    with pytest.raises(gspcli.GspError, match="do not determine"):
        # Without a position nothing says how long the machine is.
        gspcli.calibrate(instance, legs, R, None, drives=readings, estimate=["scales"])


def test_what_a_file_states_of_its_drives_stays():
    """Ranges, tolerances and corrections of cranks and rails come back; ranges as readings."""
    instance = driven("6-PUS")
    rows = []
    for row in instance.constraints:
        slide = gspcli.Slide(row.base.slide.direction, [-0.1, 0.2], 1e-4, 0.01, 0.001)
        rows.append(replace(row, base=replace(row.base, slide=slide)))
    instance = replace(instance, constraints=tuple(rows))
    model = Model.of(instance, drives=True)
    same = calibrated(instance, model, {}).constraints[0].base.slide
    assert same == instance.constraints[0].base.slide
    step = np.zeros(len(model.free))
    step[model.names.index("base.B1.slide.offset")] = 0.002
    moved = calibrated(instance, model.moved(step), {"base.B1.slide.offset": 1e-6})
    slide, other = (one.constraints[0].base.slide for one in (moved, instance))
    assert slide.offset.value == pytest.approx(0.012)
    assert slide.tolerance == other.tolerance
    for end, before in zip(slide.limits, other.limits, strict=True):
        assert slide.reading_of(end).value == pytest.approx(other.reading_of(before).value)
        assert end.value == pytest.approx(before.value + 0.002)


@pytest.mark.parametrize(
    ("wrong", "cause"),
    [
        (lambda x: x * 1000, "the places of slides are too large by 1000, as in another unit"),
        (lambda x: -x, "the places of slides have the wrong sign"),
        (lambda x: x[:, [1, 0, 2, 3, 4, 5]], "the readings of slide.B1 and slide.B2 are exchanged"),
    ],
)
def test_mistakes_of_files_of_rails_are_recognized(wrong, cause):
    rng = np.random.default_rng(7)
    instance, truth = wrong_machine("6-PUS", rng, 1e-4)
    readings, legs, R, T = reached(instance, truth, rng, 20)
    drives, turns, places = noisy(truth, readings, R, T, rng)
    names = tuple(map(str, range(20)))
    seen = Measurements(legs, turns, places, np.zeros(3), drives=drives, lines=names)
    model = Model.of(instance, drives=True)
    seen = constant_rods(instance, model, seen)
    prior = model.length / 200
    assert likely_cause(model, seen, prior, "m") is None
    assert cause in likely_cause(model, replace(seen, drives=wrong(drives)), prior, "m")


def test_exchanged_rails_are_doubted():
    rng = np.random.default_rng(7)
    instance, truth = wrong_machine("6-PUS", rng, 1e-4)
    readings, legs, R, T = reached(instance, truth, rng, 16)
    given = {"sigma": SIGMA, "hold_unknown": True}
    drives, turns, places = noisy(truth, readings, R, T, rng)
    assert gspcli.calibrate(instance, legs, turns, places, drives=drives, **given).doubts == ()
    drives = drives[:, [1, 0, 2, 3, 4, 5]]
    found = gspcli.calibrate(instance, legs, turns, places, drives=drives, **given)
    assert found.doubts
    assert "the readings of slide.B1 and slide.B2 are exchanged" in found.cause


def test_poses_of_less_than_a_pose_are_found_by_solving():
    """Rows with points of the platform start at a pose of the machine with its carriages moved."""
    rng = np.random.default_rng(8)
    instance, truth = wrong_machine("6-PUS", rng, 1e-4)
    readings, legs, R, T = reached(instance, truth, rng, 20)
    at = {"Q1": [0, 0, 0.1], "Q2": [0.1, 0, 0], "Q3": [0, 0.1, 0]}
    points = {name: T + R @ np.array(place) for name, place in at.items()}
    found = gspcli.calibrate(
        instance, legs, drives=readings, points=points, targets=at, hold_unknown=True
    )
    assert np.abs(found.T - T).max() < 1e-6


def test_arguments_that_do_not_fit():
    instance, blank = driven("6-PUS"), np.full((8, 6), np.nan)
    R, T = np.tile(np.eye(3), (8, 1, 1)), np.zeros((8, 3))
    with pytest.raises(ArgumentError, match=r"found shape \(8, 3\), expected \(8, 6\)"):
        gspcli.calibrate(instance, blank, R, T, drives=np.zeros((8, 3)))
    with pytest.raises(ArgumentError, match="found both value and slide zero"):
        gspcli.calibrate(instance, blank, R, T, drives=blank, sigma={"value": 0, "slide": 0})
