"""Numbers are found from measurements: exact ones exactly, noisy ones as well as is predicted."""

from __future__ import annotations

import re
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from measured_machines import (
    ROTARY_SIGMA,
    SIGMA,
    noisy,
    noisy_rotary,
    nominal,
    numbers,
    reachable,
    readings,
    real,
    rotary,
    seen_of,
)

import gspcli
from gspcli.calibration import fitting
from gspcli.calibration.calibrating import calibrated_text
from gspcli.calibration.fitting import reduced
from gspcli.calibration.measurements import Measurements, Noise
from gspcli.calibration.model import Model
from gspcli.calibration.planning import candidates
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.instance import HomePose
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.resources import data_path

EXACT = {"position": 0, "rotation": 0}


def _errors(result):
    return numbers(result.fit.model) - numbers(real())


@pytest.mark.parametrize("sigma", [None, EXACT])
def test_seven_exact_poses_give_all_42_numbers(sigma):
    """The bar is 1e-8 mm, a hundred-millionth of what is looked for."""
    R, T = reachable(7, np.random.default_rng(0))
    result = gspcli.calibrate(nominal(), readings(real(), R, T), R, T, sigma=sigma, prior=1e6)
    assert result.fit.model.free.sum() == result.estimated.sum() == 42
    assert np.abs(_errors(result)).max() < 1e-8
    assert np.abs(_errors(gspcli.calibrate(nominal(), readings(real(), R, T), R, T))).max() < 1e-8


def test_six_poses_are_refused_with_how_many_more():
    R, T = reachable(6, np.random.default_rng(0))
    with pytest.raises(
        IncompleteError, match="determine 36 of 42 numbers\nmeasure at least 1 more pose;"
    ):
        gspcli.calibrate(nominal(), readings(real(), R, T), R, T)


def test_noise_is_predicted():
    rng = np.random.default_rng(1)
    R, T = reachable(60, rng)
    values, R_seen, T_seen = noisy(real(), R, T, rng)
    result = gspcli.calibrate(nominal(), values, R_seen, T_seen, sigma=SIGMA)
    assert result.freedom == 60 * 12 - 60 * 6 - 42
    assert abs(result.chi_squared - result.freedom) < 4 * np.sqrt(2 * result.freedom)
    order = [f"platform.P{k}." for k in range(1, 7)]
    assert all(any(name.startswith(p) for name in result.names) for p in order)
    truth = dict(zip(result.names, result.after - result.sigma * 0, strict=True))
    for k, offset in enumerate(real().offsets, 1):
        assert abs(truth[f"offset.{k}"] - offset) < 5 * result.deviations[f"offset.{k}"]
    # Poses are found better than they were measured.
    assert np.abs(result.T - T).max() < np.abs(T_seen - T).max()
    # Without a stated noise the scatter gives it, if its parts have the usual proportions.
    assert result.scatter == 1
    same = gspcli.calibrate(nominal(), values, R_seen, T_seen)
    assert 0 < same.scatter < 1


def test_the_new_file_is_the_machine():
    rng = np.random.default_rng(2)
    R, T = reachable(20, rng)
    values = readings(real(), R, T)
    result = gspcli.calibrate(nominal(), values, R, T)
    again = gspcli.loads(gspcli.dumps(result.instance))
    assert np.abs(gspcli.measure(again, R, T) - values).max() < 1e-8
    assert np.abs(gspcli.measure(nominal(), R, T) - values).max() > 1
    assert again.constraints[0].reading_of(again.constraints[0].value).value == pytest.approx(
        nominal().constraints[0].value.value
    )
    # A second calibration changes nothing.
    second = gspcli.calibrate(again, values, R, T)
    assert np.abs(second.after - second.before).max() < 1e-7


def test_translations_only_are_refused_by_name():
    """The rank is 24 of 42; with noise it is full, and 18 directions have deviations of 100 mm."""
    rng = np.random.default_rng(3)
    R, T = reachable(40, rng, tilt=0.0)
    for values, turns, places in ((readings(real(), R, T), R, T), noisy(real(), R, T, rng)):
        with pytest.raises(IncompleteError) as caught:
            gspcli.calibrate(nominal(), values, turns, places, sigma=SIGMA)
        text = str(caught.value)
        assert text.startswith("the data determine 24 of 42 numbers")
        assert "a combination of " in text
        assert "measure poses that turn the platform" in text
        assert text.count("\n") < 5
        kept = gspcli.calibrate(nominal(), values, turns, places, sigma=SIGMA, hold_unknown=True)
        assert kept.unknowns.missing == 18
        # Undetermined numbers are not moved: no number changes by more than its error.
        assert np.abs(kept.after - kept.before).max() < 10


def test_outliers():
    """2 % of the values off by 0.5 mm, 500 deviations."""
    rng = np.random.default_rng(4)
    R, T = reachable(60, rng)
    values, turns, places = noisy(real(), R, T, rng)
    wrong = values + 0.5 * (rng.random(values.shape) < 0.02)
    assert (wrong != values).any()
    rms = [
        np.sqrt(
            np.mean(
                _errors(gspcli.calibrate(nominal(), v, turns, places, sigma=SIGMA, robust=r)) ** 2
            )
        )
        for v, r in ((values, False), (wrong, False), (wrong, True))
    ]
    assert rms[2] < 2 * rms[0] < rms[1]


def test_blank_cells_and_rows_of_less():
    rng = np.random.default_rng(5)
    R, T = reachable(40, rng)
    values = readings(real(), R, T)
    values[::2, 2] = np.nan
    R[3::4] = np.nan
    values[3::4] = readings(real(), *reachable(40, np.random.default_rng(5)))[3::4]
    result = gspcli.calibrate(nominal(), values, R, T)
    assert np.abs(_errors(result)).max() < 1e-7


@pytest.mark.parametrize("frames", [False, True])
def test_any_cell_may_be_blank(frames):
    """Rows without z and a reading, without a rotation and two readings, without both poses."""
    rng = np.random.default_rng(5)
    R, T = reachable(40, rng)
    values, turns, places = readings(real(), R, T), R.copy(), T.copy()
    values[0, 3], places[0, 2] = np.nan, np.nan
    values[1, 5], places[1] = np.nan, np.nan
    values[2, :2], turns[2] = np.nan, np.nan
    values[3, 4], places[3, :2], turns[3] = np.nan, np.nan, np.nan
    places[4], turns[4] = np.nan, np.nan
    machine = replace(nominal(), home=HomePose((0, 0, 800))) if frames else nominal()
    estimate = ["frames"] if frames else []
    result = gspcli.calibrate(machine, values, turns, places, estimate=estimate)
    assert result.scatter < 1e-6
    if frames:
        return
    # The fourth row has six numbers, and the fifth six readings: more than one pose has them.
    assert np.abs(result.T[:3] - T[:3]).max() < 1e-6
    alone = np.full_like(places, np.nan)
    alone[:, :2] = places[:, :2]
    alone[::2, 2] = places[::2, 2]
    values[5:, 1] = np.nan
    result = gspcli.calibrate(nominal(), values, turns, alone, hold_unknown=True)
    assert result.scatter < 1e-6


def test_points_of_a_target_are_as_good_as_poses():
    rng = np.random.default_rng(6)
    R, T = reachable(12, rng)
    targets = {"C": [0, 0, 0], "D": [80, 0, 0], "E": [0, 80, 10]}
    points = {name: R @ np.array(at) + T for name, at in targets.items()}
    result = gspcli.calibrate(nominal(), readings(real(), R, T), points=points, targets=targets)
    assert np.abs(_errors(result)).max() < 1e-8


@pytest.mark.parametrize(
    ("what", "count", "hint"),
    [("positions", 39, "three points of the platform"), ("inclinations", 35, "measure positions")],
)
def test_part_of_a_pose_tells_part_of_the_numbers(what, count, hint):
    rng = np.random.default_rng(7)
    R, T = reachable(60, rng)
    values = readings(real(), R, T)
    tilts = np.arcsin(R[:, 2, :2])
    given = {"T": T} if what == "positions" else {"inclinations": np.rad2deg(tilts)}
    blank = np.full_like(R, np.nan)
    seen = seen_of(values, blank, T) if what == "positions" else seen_of(
        values, blank, blank[:, 0], inclinations=tilts
    )  # fmt: skip
    assert _rank(R, T, seen) == count
    with pytest.raises(IncompleteError, match=rf"(?s)determine \d+ of 42 numbers;.*{hint}"):
        gspcli.calibrate(nominal(), values, **given)


@pytest.mark.parametrize(
    ("given", "hint"),
    [
        (lambda R, T: {"points": _three_points(R, T)}, r"say where points are .*\(--target\)"),
        (lambda R, T: {"R": R}, "measure positions of the platform, too"),
    ],
)
def test_what_no_number_of_poses_tells_is_said(given, hint):
    """36 of 42: the frame of the platform, or the origins of both."""
    R, T = reachable(30, np.random.default_rng(7))
    with pytest.raises(IncompleteError) as caught:
        gspcli.calibrate(nominal(), readings(real(), R, T), **given(R, T))
    text = str(caught.value)
    assert "farther apart" not in text
    assert re.search(rf"(?s)determine \d+ of 42 numbers;.*\n{hint}", text)


def _rank(R, T, seen):
    """How many numbers measurements of a sort tell, however many there are."""
    model = Model.of(nominal())
    slopes = reduced(model, R, T, seen, Noise.usual(model.length)).slopes
    singular = np.linalg.svd(slopes * model.sizes[model.free], compute_uv=False)
    return int((singular > 1e-5 * singular[0]).sum())


def _three_points(R, T):
    blocks = {b.name: b.point for b in real().blocks if b.body == "platform"}
    return {name: R @ blocks[name] + T for name in ("P1", "P3", "P5")}


def test_a_leg_that_is_never_read():
    R, T = reachable(20, np.random.default_rng(7))
    values = readings(real(), R, T)
    values[:, 3] = np.nan
    with pytest.raises(IncompleteError) as caught:
        gspcli.calibrate(nominal(), values, R, T)
    text = str(caught.value)
    assert text.startswith("the data determine 35 of 42 numbers; they do not determine\n")
    assert "no row has a reading of 4; " in text.replace("\n  ", "; ")
    assert "\ngive readings of 4, or hold what" in text
    held = gspcli.calibrate(nominal(), values, R, T, hold=["platform.P4", "base.P4", "offset.4"])
    assert held.unknowns.count == 0


def test_unknown_frames():
    """Distances within each body do not depend on where device and target are."""
    rng = np.random.default_rng(8)
    R, T = reachable(30, rng)
    values = readings(real(), R, T)
    A, B = rotation_from_vector(np.array([[0.5, -1.2, 2.0], [0.02, 0.3, 0.01]]))
    a, b = np.array([5000, 3, -2000.0]), np.array([1, 20, 30.0])
    seen = A @ R @ B, (T + R @ b) @ A.T + a
    result = gspcli.calibrate(nominal(), values, *seen, estimate=["frames"])
    assert result.unknowns.frames == result.unknowns.count == 12
    for body in ("platform", "base"):
        found, true = (
            np.array([block.point for block in model.blocks if block.body == body])
            for model in (result.fit.model, real())
        )
        apart = [np.linalg.norm(p[:, None] - p, axis=-1) for p in (found, true)]
        assert np.abs(apart[0] - apart[1]).max() < 1e-6
    assert np.abs(result.fit.model.offsets - real().offsets).max() < 1e-6


def test_unknown_frames_of_a_machine_that_hangs():
    """The least turned real pose is the mirror image of what it does: all modes are tried."""
    rng = np.random.default_rng(8)
    mirror = np.diag([1.0, 1.0, -1.0])
    R, T = reachable(20, rng)
    R, T = mirror @ R @ mirror, T @ mirror
    A, B = rotation_from_vector(np.array([[0.5, -1.2, 2.0], [0.02, 0.3, 0.01]]))
    a, b = np.array([5000, 3, -2000.0]), np.array([1, 20, 30.0])
    seen = readings(real(), R, T), A @ R @ B, (T + R @ b) @ A.T + a
    found = gspcli.calibrate(nominal(), *seen, estimate=["frames"])
    assert found.scatter < 1e-6
    assert found.fit.converged
    assert "no home is stated, and mode " in found.home
    assert found.home.endswith("`home` in SPEC says which is right")
    stated = replace(nominal(), home=HomePose((0, 0, -800)))
    same = gspcli.calibrate(stated, *seen, estimate=["frames"])
    assert same.home == ""
    assert np.allclose(same.after, found.after, atol=1e-6)


def _near(instance, count, rng, turn=0.3, shift=0.15):
    home = gspcli.solve(instance)
    R, T = home.R[home.real].real, home.T[home.real].real
    best = int(np.lexsort((T[:, 2], np.trace(R, axis1=1, axis2=2).round(6)))[-1])
    length = Model.of(instance).length
    turns = rotation_from_vector(turn / 1.7 * rng.normal(size=(count, 3)))
    return turns @ R[best], T[best] + shift * length * rng.uniform(-1, 1, (count, 3))


@pytest.mark.parametrize(
    ("folder", "name"),
    [
        ("examples", "fixture-3-2-1"),
        ("platforms", "three-vee-250mm"),
        ("platforms", "sdss-primary"),
        ("examples", "surfaces-psc"),
        ("examples", "example-6.8"),
        ("examples", "parallel-edges"),
        ("examples", "figure-2"),
    ],
)
def test_other_machines(folder, name):
    """Fixtures, couplings, mixtures with lines: what was found reads as the true machine does."""
    rng = np.random.default_rng(9)
    instance = gspcli.load(data_path(folder, f"{name}.yaml"))
    model = Model.of(instance)
    step = np.where(
        model.free, 0.002 * model.length * model.sizes * rng.normal(size=len(model.free)), 0
    )
    truth = model.moved(step)
    R, T = _near(instance, 60, rng)
    values = readings(truth, R, T)
    angles = [k for k, kind in enumerate(model.kinds) if not kind.is_distance]
    values[:, angles] /= model.in_radians
    result = gspcli.calibrate(instance, values, R, T, hold_unknown=True)
    new_R, new_T = _near(instance, 20, rng)
    found, true = (readings(m, new_R, new_T) for m in (result.fit.model, truth))
    assert np.abs(found - true).max() < 1e-9 * model.length
    assert np.abs(readings(model, new_R, new_T) - true).max() > 1e-4 * model.length


def test_a_rotary_hexapod():
    """Eleven numbers a leg: axis and point of the crank (7), rod, joint of the platform (3)."""
    instance, truth, angles, R, T = rotary(np.random.default_rng(10), 60)
    assert Model.of(instance, drives=True).free.sum() == 66
    stated = [float(row.value.value) for row in instance.constraints]
    values = np.tile(stated, (len(T), 1))
    result = gspcli.calibrate(instance, values, R, T, drives=np.rad2deg(angles))
    assert result.unknowns.count == 0
    found, true = (readings(m, R, T, angles + 0.1) for m in (result.fit.model, truth))
    assert np.abs(found - true).max() < 1e-9 * truth.length


def test_values_of_a_tripod_that_stay_are_constants():
    """Nobody reads the three distances to planes of a 3-RPS: all numbers are found nevertheless."""
    instance, rng = gspcli.example("three-rps"), np.random.default_rng(3)
    machine, home = Machine.of(instance), gspcli.solve(instance).home
    R, T, _ = candidates(machine, home.R, home.T, 0, count=60)
    model = Model.of(instance)
    step = 1e-3 * model.length * model.sizes * rng.normal(size=len(model.free))
    truth = model.moved(np.where(model.free, step, 0.0))
    stated = np.array([float(row.value.value) for row in instance.constraints])
    bodies = truth.bodies()
    read = np.where(machine.fixed, stated, readings(truth, R, T))
    for _ in range(20):
        short = measured(bodies, R, T) - truth.offsets - read
        twist = np.linalg.solve(jacobian(bodies, R, T), -short[..., None])[..., 0]
        R, T = rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]
    blank = np.where(machine.fixed, np.nan, read)
    result = gspcli.calibrate(instance, blank, R, T)
    assert result.unknowns.count == 0
    assert np.abs(readings(result.fit.model, R, T) - read).max() < 1e-9 * model.length
    # Another constant than the stated one is another machine.
    moved = gspcli.calibrate(instance, np.where(machine.fixed, read + 0.1, read), R, T, prior=10)
    assert np.abs(moved.after - result.after).max() > 0.05


def test_rods_that_nobody_reads_have_no_noise():
    """Chi-squared is right with the right sigmas; noise of rods that is made up halves it."""
    rng = np.random.default_rng(12)
    instance, _, angles, R, T = rotary(rng, 60)
    cranks, turns, places = noisy_rotary(angles, R, T, rng)
    blank = np.full((len(T), 6), np.nan)
    given = {"drives": cranks, "prior": 0.1}
    found = gspcli.calibrate(instance, blank, turns, places, sigma=ROTARY_SIGMA, **given)
    spread = np.sqrt(2 * found.freedom)
    assert abs(found.chi_squared - found.freedom) < 3 * spread
    stated = np.tile([float(row.value.value) for row in instance.constraints], (len(T), 1))
    exact = gspcli.calibrate(
        instance, stated, turns, places, sigma=ROTARY_SIGMA | {"value": 0}, **given
    )
    assert exact.chi_squared == pytest.approx(found.chi_squared, rel=1e-6)
    assert np.allclose(exact.sigma, found.sigma, rtol=1e-6)
    # A deviation of readings does not count where nothing is read.
    loud = gspcli.calibrate(
        instance, blank, turns, places, sigma=ROTARY_SIGMA | {"value": 1.0}, **given
    )
    assert loud.chi_squared == found.chi_squared
    read = gspcli.calibrate(
        instance, stated, turns, places, sigma=ROTARY_SIGMA | {"value": 1e-5}, **given
    )
    assert read.chi_squared < found.chi_squared
    with pytest.raises(ArgumentError, match="found both value and crank zero"):
        gspcli.calibrate(instance, blank, R, T, drives=cranks, sigma={"value": 0, "crank": 0})


def test_scales_and_held_numbers():
    rng = np.random.default_rng(11)
    truth = replace(real(), scales=1e-4 * rng.normal(size=6))
    R, T = reachable(40, rng)
    values = readings(truth, R, T)
    result = gspcli.calibrate(nominal(), values, R, T, estimate=["scales"])
    assert np.abs(result.fit.model.scales - truth.scales).max() < 1e-10
    # The file keeps the readings, and says the scale that was found.
    row = result.instance.constraints[0]
    before = nominal().constraints[0].value.value
    assert row.value.value - row.offset.value == pytest.approx(before * (1 + truth.scales[0]))
    assert row.scale.value == pytest.approx(truth.scales[0], abs=1e-9)
    assert row.reading_of(row.value) == nominal().constraints[0].value
    # What was found is where the next calibration begins, and kept if it asks for no scales.
    again = gspcli.loads(calibrated_text(result))
    assert again.constraints == result.instance.constraints
    kept = gspcli.calibrate(again, values, R, T)
    assert kept.instance.constraints[0].scale == row.scale
    assert kept.chi_squared < 1e-6
    held = gspcli.calibrate(
        nominal(), values, R, T, hold=["platform", "offset.2"], hold_unknown=True
    )
    assert not any(name.startswith("platform") or name == "offset.2" for name in held.names)
    assert held.instance.constraints[0].platform == nominal().constraints[0].platform


def test_the_result_is_plain_and_read_only():
    R, T = reachable(12, np.random.default_rng(12))
    result = gspcli.calibrate(nominal(), readings(real(), R, T), R, T, sigma=SIGMA)
    assert repr(result).startswith("<Calibration: 42 numbers from 12 rows, chi-squared ")
    frame = result.to_frame()
    assert list(frame.columns) == ["stated", "found", "sigma", "change_over_sigma"]
    assert frame.shape == (42, 4)
    document = result.to_json()
    assert len(document["numbers"]) == len(document["covariance"]) == 42
    for array in (result.after, result.sigma, result.covariance, result.R, result.residuals):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    assert result.worst is not None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"hold": ["platfrom"]}, "hold: found 'platfrom', .*did you mean platform"),
        ({"estimate": ["scale.7"]}, "estimate: found 'scale.7'"),
        ({"sigma": {"valu": 1}}, "sigma: found 'valu', .*did you mean value"),
        ({"sigma": {"value": 0}}, "found 0, expected a positive number"),
        ({"sigma": {"position": 0}}, "expected both"),
        *(({"prior": number}, "prior: found") for number in (np.nan, np.inf, 0, -1)),
        ({"sigma": {"value": np.nan}}, "found nan, expected a positive number"),
        ({"T": np.zeros((3, 2))}, r"T: found shape \(3, 2\)"),
        ({"points": {"Q": np.zeros((12, 3))}}, "unknown point 'Q'"),
        ({"values": "no"}, "values: found shape"),
    ],
)
def test_wrong_arguments(change, message):
    R, T = reachable(12, np.random.default_rng(12))
    given = {"values": readings(real(), R, T), "R": R, "T": T} | change
    with pytest.raises(ArgumentError, match=message):
        gspcli.calibrate(nominal(), **given)


def test_nothing_measured_but_poses_or_values():
    R, T = reachable(12, np.random.default_rng(12))
    for given in (
        {"values": readings(real(), R, T)},
        {"values": np.full((12, 6), np.nan), "R": R, "T": T},
    ):
        with pytest.raises(IncompleteError, match="no row has more than six numbers"):
            gspcli.calibrate(nominal(), **given)


def test_outliers_are_left_out_and_change_no_interval():
    rng = np.random.default_rng(4)
    values, R, T = noisy(real(), *reachable(40, rng), rng)
    plain = gspcli.calibrate(nominal(), values, R, T, sigma=SIGMA)
    clean = gspcli.calibrate(nominal(), values, R, T, sigma=SIGMA, robust=True)
    assert not clean.outliers.any()
    assert np.allclose(clean.after, plain.after, atol=1e-9)
    wrong = rng.random(values.shape) < 0.03
    values = values + 0.05 * rng.choice([-1, 1], values.shape) * wrong
    robust = gspcli.calibrate(nominal(), values, R, T, sigma=SIGMA, robust=True)
    assert (robust.outliers[:, :6] == wrong).all()
    assert robust.doubts == ()
    assert 1 < np.median(robust.sigma / plain.sigma) < 1.1
    assert (np.abs(robust.residuals[wrong]) > 25).all()


def test_the_file_states_the_scatter_where_no_deviation_was_stated():
    rng = np.random.default_rng(4)
    found = gspcli.calibrate(nominal(), *noisy(real(), *reachable(40, rng), rng))
    head = calibrated_text(found).splitlines()[0]
    assert "by the scatter" in head
    assert "chi-squared" not in head


def test_blocks_of_rows_give_the_same(monkeypatch):
    """Also where a block has no rotation, or no position."""
    rng = np.random.default_rng(4)
    values, R, T = noisy(real(), *reachable(20, rng), rng)
    R[:5], T[5:10] = np.nan, np.nan
    given = {"sigma": SIGMA, "hold_unknown": True}
    whole = gspcli.calibrate(nominal(), values, R, T, **given)
    monkeypatch.setattr(fitting, "_BLOCK", 5)
    parts = gspcli.calibrate(nominal(), values, R, T, **given)
    assert np.allclose(parts.after, whole.after, atol=1e-7)
    assert np.allclose(parts.sigma, whole.sigma, rtol=1e-6)
    assert np.allclose(parts.T, whole.T, atol=1e-7)


def test_memory_does_not_grow_with_the_derivatives():
    """Of 12 000 rows they are 70 MB, of which there were several copies."""
    R, T = reachable(100, np.random.default_rng(4))
    values = readings(real(), R, T)
    many = [np.tile(part, (120, *[1] * (part.ndim - 1))) for part in (values, R, T)]
    seen = Measurements(*many, np.zeros(3), lines=("",) * 12_000)
    model = Model.of(nominal())
    tracemalloc.start()
    system = fitting._equations(model, *many[1:], seen, Noise.usual(model.length), None)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert system.slopes.shape == (6 * 43, 42)
    assert peak < 1e8


def test_rows_that_are_there_twice_are_told():
    R, T = reachable(20, np.random.default_rng(4))
    values = readings(real(), R, T)
    once = gspcli.calibrate(nominal(), values, R, T)
    assert once.repeated == 0
    twice = [np.concatenate((part, part[:5])) for part in (values, R, T)]
    assert gspcli.calibrate(nominal(), *twice).repeated == 5


def test_outliers_where_the_noise_is_not_stated():
    """Ten times the usual noise: the scatter decides which rows are outliers."""
    rng = np.random.default_rng(13)
    R, T = reachable(60, rng)
    values = readings(real(), R, T) + 0.05 * rng.normal(size=(60, 6))
    turns = rotation_from_vector(1e-4 * rng.normal(size=(60, 3))) @ R
    places = T + 0.05 * rng.normal(size=(60, 3))
    wrong = values + 3 * (rng.random(values.shape) < 0.02)
    results = [
        gspcli.calibrate(nominal(), v, turns, places, robust=r, hold_unknown=True)
        for v, r in ((values, False), (wrong, False), (wrong, True))
    ]
    rms = [np.sqrt(np.mean(_errors(result) ** 2)) for result in results]
    assert rms[2] < 2 * rms[0] < rms[1]
    assert 0.7 < results[2].scatter / results[0].scatter < 1.4
