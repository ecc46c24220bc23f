"""Files of poses of machines with motors, proved between rows; and what their tracks keep there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Shapes
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.paths.between import (
    PathRows,
    ValueParts,
    _rows,
    can_be_bounded,
    largest_conditions,
    least_gaps,
    least_transmissions,
    pose_track,
    worst_between,
)
from gspcli.motion.paths.ways import PoseWays, WayProof

ROWS, SAMPLES = 3, 60


def thick(name):
    """Return a machine with rods and arms that have shapes, its home, and the length of its rods.

    The arms are nearer to each other than the rods.
    """
    solved = gspcli.solve(gspcli.example(name))
    home = 0 if solved.home is None else solved.home.number - 1
    size = float(Machine.of(solved.instance).rods[0])
    shapes = Shapes(size / 60, near_joint=size / 10)
    rows = []
    for row in solved.instance.constraints:
        crank = getattr(row.base, "crank", None)
        arm = gspcli.Number.of(size / 8)
        turned = crank and replace(row.base, crank=replace(crank, diameter=arm))
        rows.append(replace(row, base=turned or row.base))
    instance = replace(solved.instance, constraints=tuple(rows), shapes=shapes)
    return instance, solved.R[home].real, solved.T[home].real, size


def tracked(instance, R, T, steps=1):
    """Return the straight ways of poses between rows."""
    return pose_track(
        instance, instance, PoseFrame(), np.arange(float(len(T))), R, T,
        sequence="ZYX", mode=1, steps=steps,
    )  # fmt: skip


def along_rows(numbers):
    """Return numbers at the samples between rows."""
    places = np.linspace(0, ROWS - 1, SAMPLES * (ROWS - 1) + 1)
    return np.stack([np.interp(places, range(ROWS), one) for one in numbers.T], axis=1)


def rows_and_samples(name, along, seed=1, spread=0.05):
    """Return rows of a track about home, and poses with drives at samples of its ways."""
    instance, R0, T0, size = thick(name)
    draw = np.random.default_rng(seed)
    turned = [rotation_from_vector(spread * draw.normal(size=3)) @ R0 for _ in range(ROWS - 1)]
    shifts = spread * size * draw.normal(size=(ROWS - 1, 3))
    R, T = np.stack([R0, *turned]), np.concatenate((T0[None], T0 + shifts))
    motors = Machine.of(instance).at_home(R[0], T[0])
    drives, q = motors, motors.along(R, T)
    if along == "poses":
        found = tracked(instance, R, T)
        assert found.track.ends == ()
        samples = found.ways.poses(along_rows(found.ways.continued(R, T)))
        rows = _rows(found.track, 0, np.arange(ROWS), found.ways, None)
        return rows, *samples, motors.along(*samples)
    values = motors.values(R, T)

    def follow(values, q):
        columns = {one: drives.readings(q)[:, k] for k, one in enumerate(drives.names)}
        return gspcli.track(instance, values, coordinates=columns, near=(R0, T0))

    coarse, fine = follow(values, q), follow(along_rows(values), along_rows(q))
    assert can_be_bounded(coarse)
    rows = _rows(coarse, 0, np.arange(ROWS), None, None)
    return rows, fine.R[0], fine.T[0], along_rows(q)


def sampled(instance, R, T, q):
    """Return gaps, transmissions and condition numbers with a minus, at samples."""
    drives = Machine.of(instance)
    length = Arrangement.of(instance).length
    return {
        least_gaps: ComparedShapes(instance).bounds(R, T, q).high.min(axis=1),
        least_transmissions: drives.transmission(drives.gains(R, T, q)).min(axis=1),
        largest_conditions: -condition_numbers(drives.arrangement(q), R, T, length),
    }


@pytest.mark.parametrize("along", ["poses", "drives"])
@pytest.mark.parametrize("name", ["reachy-mini-head", "modified-paradex"])
def test_no_sample_is_worse_than_what_is_proved(name, along):
    rows, *samples = rows_and_samples(name, along)
    for bound, numbers in sampled(rows.instance, *samples).items():
        worse = -1 if bound is largest_conditions else 1
        least = np.minimum(numbers[:-1].reshape(-1, SAMPLES).min(axis=1), numbers[SAMPLES::SAMPLES])
        room = 1e-9 * np.abs(least)
        for wanted in (least.min() - 2e-3 * abs(least.min()), least.max(), -1e9):
            proved = worse * bound(rows, worse * wanted)[1]
            assert (proved <= least + room).all()
            assert not (proved >= wanted)[least < wanted - room].any()
            # What is well above is proved.
            assert (proved >= wanted)[least > wanted + 1e-3 * abs(wanted)].all()


def test_rows_have_the_numbers_of_their_motors():
    instance, R0, T0, size = thick("three-prs")
    T = T0 + np.array([[0, 0, 0], [0, 0, 0.1 * size]])
    found = tracked(instance, np.stack([R0, R0]), T, steps=4)
    track = found.track
    assert [one.name for one in track.coordinates] == ["slide.B1", "slide.B2", "slide.B3"]
    motors = Machine.of(instance).at_home(R0, T0)
    assert (track.places == motors.along(track.R[0], track.T[0])[:, :3]).all()
    assert (track.values[:, :3] == motors.rods[:3]).all()
    assert (found.limits, track.events, len(track.t)) == ((), (), 5)


def test_a_range_that_a_slide_leaves():
    instance, R0, T0, _ = thick("three-prs")
    T = T0 + np.array([[0, 0, 0], [0, 0, 1.5]])
    found = tracked(instance, np.stack([R0, R0]), T)
    assert sorted(one.drive for one in found.limits) == ["slide.B1", "slide.B2", "slide.B3"]
    for one in found.limits:
        assert one.proved
        assert (one.low, one.high) == pytest.approx((1 / 1.5, 1 / 1.5), abs=1e-9)
    assert found.track.ends == ()


def test_a_way_beyond_the_reach_of_the_rods_ends():
    """A row that is not reached is refused; of two that are the way between them may not be."""
    instance, R0, T0, size = thick("reachy-mini-head")
    T = T0 + size * np.array([[0, 0, 0], [0, 0, 10]])
    with pytest.raises(ArgumentError, match=r"at t = 1: the leg of crank.B1 does not reach"):
        tracked(instance, np.stack([R0, R0]), T)
    delta = gspcli.example("delta")
    T = np.array([[-890.0, 811.0, -732.0], [585.0, -1107.0, -112.0]])
    (event,) = tracked(delta, np.tile(np.eye(3), (2, 1, 1)), T).track.ends
    assert event.reason == "a rod does not reach its motor on the straight way"


def test_rods_that_share_a_motor_do_not_turn():
    delta = gspcli.example("delta")
    R0, T0 = delta.home.R(1.0), np.array([delta.home.T] * 2)
    R = np.stack([R0, rotation_from_vector([0, 0, 1e-12]) @ R0])
    (event,) = tracked(delta, R, T0 + np.eye(3)[:2]).track.ends
    assert event.reason == "rods that share a motor are not parallel on the straight way"


def test_a_range_that_is_left_and_kept_again_on_one_way():
    """Of a way up and down the slides leave their range in between; samples show where."""
    instance = gspcli.example("workspace-study")
    T = np.array([[-100, 0, 401], [100, 0, 401.0]])
    R = np.tile(np.eye(3), (2, 1, 1))
    t = np.linspace(0, 1, 2001)
    lengths = gspcli.measure(
        instance, np.tile(np.eye(3), (2001, 1, 1)), T[0] + t[:, None] * (T[1] - T[0])
    )
    least = (lengths[[0, -1]].min(axis=0) + lengths.min(axis=0)) / 2
    rows = [
        replace(row, limits=(gspcli.Number.of(low), gspcli.Number.of(600)))
        for row, low in zip(instance.constraints, least.tolist(), strict=True)
    ]
    found = tracked(replace(instance, constraints=tuple(rows)), R, T)
    outside = lengths < least
    for k in range(6):
        events = [one for one in found.limits if one.constraint == k]
        changes = np.flatnonzero(np.diff(outside[:, k]))
        assert [one.leaves for one in events] == outside[changes + 1, k].tolist()
        for one, j in zip(events, changes.tolist(), strict=True):
            assert one.proved
            assert t[j] <= one.low <= one.high <= t[j + 1]
            assert one.high - one.low < 1e-8


def test_a_wider_change_of_drives_leaves_a_way_undecided(monkeypatch):
    """A range is kept on a way only if the drives are proved to move no farther."""
    instance, R0, T0, size = thick("three-prs")
    T = T0 + np.array([[0, 0, 0], [0, 0, 0.1 * size]])
    prove = PoseWays.prove

    def open_(ways, *ends):
        inside = ways._conditions == ways.boxes.conditions
        return WayProof(0, 0, "limit") if inside else prove(ways, *ends)

    monkeypatch.setattr(PoseWays, "prove", open_)
    assert tracked(instance, np.stack([R0, R0]), T).limits == ()
    monkeypatch.setattr(
        PathRows, "moved", lambda self, begins, _: np.full((len(begins), 6), np.inf)
    )
    limits = tracked(instance, np.stack([R0, R0]), T).limits
    assert [(one.drive, one.proved) for one in limits] == [
        ("slide.B1", False), ("slide.B2", False), ("slide.B3", False)
    ]  # fmt: skip


def test_drives_that_stay_have_their_points_where_the_file_states_them():
    """The lengths of rods change: nothing is asked of the cranks."""
    instance, R0, T0, size = thick("reachy-mini-head")
    base = gspcli.measure(instance, R0, T0)
    values = np.stack([base, base + 0.02 * size * np.array([1, -1, 1, -1, 1, -1])])
    track = gspcli.track(instance, values, near=(R0, T0))
    assert can_be_bounded(track)
    drives = Machine.of(instance)
    q = np.zeros((2, drives.count))
    ends = ComparedShapes(instance).bounds(track.R[0], track.T[0], q).low.min()
    found = worst_between(track, "gap", ends + size)
    assert found is None or found.bound <= ends
    assert worst_between(track, "gap", ends - 0.2 * abs(ends)) is None


def test_a_planned_path_of_drives_keeps_a_gap():
    instance, R, T, size = thick("reachy-mini-head")
    goal = rotation_from_vector([0.08, -0.05, 0.06]) @ R, T + 0.05 * size
    compared = ComparedShapes(instance)
    ends = min(compared.gaps(one[None], two[None]).min() for one, two in ((R, T), goal))
    found = gspcli.path(instance, (R, T), goal, along="values", gap=ends - size / 10)
    assert (found.verdict, found.along) == ("proved", "drives")
    assert ends - size / 10 <= min(part.gap for part in found.parts) <= found.gaps.min()
    between = gspcli.path(instance, (R, T), goal, along="values", gap=ends + size / 10)
    assert between.verdict == "impossible"


def test_joints_on_a_piece_of_a_way_of_drives_are_as_near_as_is_said():
    rows, *_ = rows_and_samples("reachy-mini-head", "drives")
    drives = rows.machine
    parts = ValueParts(rows, np.array([0]), 4)
    which = np.arange(len(parts.way))
    low, high = parts.begin, parts.end
    middle = parts.near(which, low, high)
    assert (middle.slips > 0).all()
    for place in (-0.5, -0.2, 0.4, 0.5):
        here = (low + high) / 2 + place * (high - low)
        there = parts.near(which, here, here)
        moved = np.linalg.norm(drives.points(there.q) - drives.points(middle.q), axis=-1)
        assert (moved <= middle.slips).all()
        assert (moved > 0.3 * abs(place) * middle.slips).all()
    first_and_last = np.array([0.0, 1.0])
    ends = parts.near(which[[0, -1]], first_and_last, first_and_last).q
    assert ends == pytest.approx(rows.numbers[[0, 1]], abs=1e-12)
