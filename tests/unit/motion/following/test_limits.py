"""The slacks of limits, against other formulas and differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.catalogue.kinds import DPH
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose
from gspcli.geometry.instance import Side
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Cone
from gspcli.geometry.quaternions import (
    quaternion_from_rotation,
    rotation_from_vector,
    vector_from_rotation,
)
from gspcli.motion import measure, track
from gspcli.motion.following.branch_follower import FollowOptions
from gspcli.motion.following.follower import RowFollower, limit_numbers, platform_numbers
from gspcli.motion.following.tracks import Track, track_from
from gspcli.motion.paths.between import (
    Near,
    PathRows,
    ValueParts,
    cone_margins,
    cones_kept,
    limit_events,
)
from gspcli.motion.paths.nearest_poses import MARGIN, NearestPoses
from gspcli.motion.paths.ways import ValueWays
from tests.support import independent_machines
from tests.support.independent_machines import machines
from tests.support.limited import limited, one_leg, study

LEGS = ["workspace-study-cones", "rubin-m2", "three-rps"]
DRIVEN = ["reachy 60", "t-top 60", "paradex", "6-PUS", "mixed"]


def machine_of(name: str) -> independent_machines.Machine:
    if name in LEGS:
        instance = gspcli.example(name)
        home = gspcli.solve(instance).home
        return independent_machines.Machine(name, instance, home.R.real, home.T.real, (0, 0))
    machine = machines()[name]()
    side = -1 if name == "paradex" else 1  # hangs from its base
    up, down = Cone((0, 0, side), 60), Cone((0, 0, -side), 60)
    rows = tuple(
        replace(row, base=replace(row.base, cone=up), platform=replace(row.platform, cone=down))
        for row in machine.instance.constraints
    )
    return replace(machine, instance=replace(machine.instance, constraints=rows))


def about(machine: independent_machines.Machine, search: NearestPoses, draw, size: float):
    R = rotation_from_vector(size * draw.normal(size=3)) @ machine.R
    return R, machine.T + size * search.length * draw.normal(size=3)


@pytest.mark.parametrize("name", [*LEGS, *DRIVEN])
def test_the_slopes_are_those_of_the_slack(name):
    """Where rods do not reach, too."""
    machine = machine_of(name)
    search = NearestPoses(machine.instance, machine.R, machine.T)
    middle = platform_numbers(machine.instance).middle
    draw = np.random.default_rng(3)
    for _ in range(10):
        R, T = about(machine, search, draw, 0.15)
        twist, step = draw.normal(size=6), 1e-6 * search.length
        twist[:3] /= search.length
        ends = []
        for sign in (1, -1):
            turn = rotation_from_vector(sign * step * twist[:3])
            # A twist is about the middle of the platform.
            place = T + R @ middle + sign * step * twist[3:] - turn @ R @ middle
            ends.append(search.slack(turn @ R, place))
        room, slopes = search._kernel.slack(np.concatenate((T, quaternion_from_rotation(R))))
        stated = slopes[room < search._far] @ twist
        assert np.abs((ends[0] - ends[1]) / (2 * step) - stated).max() < 1e-3


@pytest.mark.parametrize("name", DRIVEN)
def test_slacks_of_motors_and_cones_change_sign_at_their_limits(name):
    """By the numbers of the drives, and the tilts of cones that turn with the arms."""
    machine = machine_of(name)
    instance, drives = machine.instance, Machine.of(machine.instance)
    search = NearestPoses(instance, machine.R, machine.T)
    working_modes = drives.working_modes(machine.R, machine.T)
    draw = np.random.default_rng(4)
    seen = set()
    for _ in range(200):
        R, T = about(machine, search, draw, 0.12)
        q = drives.inverse(R, T, working_modes)
        room = search._room(R, T)
        for k in np.flatnonzero(drives.driven):
            drive = drives.index[k]
            inside = bool(drives.low[drive] < q[drive] < drives.high[drive])
            assert inside == bool(room[2 * k : 2 * k + 2].min() > 0), k
            seen.add(inside)
        if np.isfinite(q).all():
            radians = Machine.of(instance).tilts(R, T, q)
            assert np.allclose(room[12:], search.length * (np.pi / 3 - MARGIN - radians))
    assert seen == {True, False}


def test_signed_distances_keep_their_side():
    instance = gspcli.example("three-rps")
    numbers = platform_numbers(instance)
    side = [row.side for row in instance.constraints]
    limits = limit_numbers(instance, numbers)
    for k, row in enumerate(instance.constraints):
        low, high = (limit.value / numbers.reach for limit in row.limits)
        wanted = (-high, -low) if side[k] is Side.NEGATIVE else (low, high)
        assert np.allclose((limits.low[k], limits.high[k]), wanted)


# Limits along trajectories: where ranges and cones are left.


def test_ranges_are_left_at_the_exact_time():
    machine = study(legs=(85, 95))
    home = measure(machine, np.eye(3), np.array([0, 0, 60.0]))
    values = np.stack((home, home + 8 * np.eye(6)[1], home))
    found = limit_events(track(machine, values, t=[0, 1, 3], near=(np.eye(3), [0, 0, 60.0])))
    ranges = [event for event in found if event.kind == "range"]
    assert [(event.constraint, event.leaves) for event in ranges] == [(1, True), (1, False)]
    part = (95 - home[1]) / 8
    assert ranges[0].low == ranges[0].high == pytest.approx(part)
    assert ranges[1].low == pytest.approx(1 + 2 * (1 - part))


def sideways(count=6):
    """Poses that move to the side, and the values there as a study measures them."""
    T = np.array([[k * 15.0 / (count - 1), 0, 60] for k in range(count)])
    R = np.broadcast_to(np.eye(3), (count, 3, 3))
    return R, T, measure(study(), R, T)


def test_where_cones_are_left_is_proved():
    machine = study(base_angle=5)
    R, T, values = sideways()
    path = track_from(machine, values, R[:1], T[:1])
    cones = [event for event in limit_events(path) if event.kind == "cone"]
    assert len(cones) == 6
    assert all(event.leaves and event.body == "base" and event.proved for event in cones)
    assert all(0 < event.high - event.low < 1e-8 for event in cones)
    # At these times the tilt is five degrees.
    for event in cones:
        row = int(event.low) - 1
        at = values[row] + (event.low - 1 - row) * (values[row + 1] - values[row])
        there = track_from(machine, np.stack((values[row], at)), R[[row]], T[[row]])
        joint = [
            k
            for k, one in enumerate(Machine.of(machine).cones)
            if (one.constraint, one.body) == (event.constraint, event.body)
        ]
        tilted = np.rad2deg(Machine.of(machine).tilts(there.R[0, 1], there.T[0, 1])[joint])
        assert tilted == pytest.approx(5, abs=1e-6)


def test_cones_that_are_kept_all_along_leave_no_event():
    R, T, values = sideways()
    assert limit_events(track_from(study(), values, R[:1], T[:1])) == []


def test_without_proof_cones_are_looked_at_where_the_rows_are():
    R, T, values = sideways()
    unproved = FollowOptions(certify=False)
    path = track_from(study(base_angle=5), values, R[:1], T[:1], options=unproved)
    cones = limit_events(path)
    assert len(cones) == 6
    assert all(event.high - event.low == 1 and not event.proved for event in cones)


def test_a_cone_that_is_left_between_two_rows_that_keep_it_is_seen():
    """The first leg is not allowed within five degrees of where it is halfway."""
    machine = study(legs=(60, 180))
    first = machine.constraints[0]
    halfway = first.platform.point - first.base.point + np.array([0, 0, 60])
    base = replace(first.base, cone=gspcli.Cone((-halfway).tolist(), 175))
    machine = replace(machine, constraints=(replace(first, base=base), *machine.constraints[1:]))
    T = np.array([[-15.0, 0, 60], [15, 0, 60]])
    R = np.broadcast_to(np.eye(3), (2, 3, 3))
    values = measure(machine, R, T)
    unproved = FollowOptions(certify=False)
    assert limit_events(track_from(machine, values, R[:1], T[:1], options=unproved)) == []
    events = limit_events(track_from(machine, values, R[:1], T[:1]))
    assert [(event.constraint, event.leaves) for event in events] == [(0, True), (0, False)]
    assert all(1 < event.low < event.high < 2 for event in events)
    assert not cones_kept(PathRows.of_values(ValueWays(machine, np.ones(6)), values, R, T))
    base = replace(first.base, cone=gspcli.Cone(halfway.tolist(), 60))
    wide = replace(machine, constraints=(replace(first, base=base), *machine.constraints[1:]))
    assert cones_kept(PathRows.of_values(ValueWays(wide, np.ones(6)), values, R, T))


@pytest.mark.parametrize(
    ("name", "seed"),
    [("6D PP PP PP PP PP PP", 0), ("6D PP PP PP PP PL LP", 1), ("6D PP PP PP PP PP PH", 4)],
)
def test_what_is_seen_at_many_rows_is_among_the_events(name, seed):
    instance, R, T = limited(name, seed, half_angle=30)
    rng = np.random.default_rng(seed)
    home = measure(instance, R, T)
    rows = np.stack([home, *(home + 0.3 * np.abs(home) * rng.normal(size=(2, 6)))])
    rows = np.where(home > 0, np.abs(rows), rows)
    events = [e for e in limit_events(track(instance, rows, everything=True)) if e.kind == "cone"]
    parts = np.linspace(0, 2, 161)
    many = np.stack([np.interp(parts, range(3), column) for column in rows.T], axis=1)
    seen = limit_events(track(instance, many, t=parts + 1, everything=True, certify=False))
    seen = [event for event in seen if event.kind == "cone" and event.low < event.high]
    assert seen

    def alike(a, b):
        same = (a.mode, a.constraint, a.body) == (b.mode, b.constraint, b.body)
        same &= a.leaves == b.leaves or not a.proved
        return same and a.low <= b.high and b.low <= a.high

    assert all(any(alike(event, other) for event in events) for other in seen)


@pytest.mark.parametrize(
    ("side", "changes"),
    [
        (Side.POSITIVE, {0: True, 10 / 3: False}),
        (Side.NEGATIVE, {0: True, 2 / 3: False, 2: True}),
        (Side.BOTH, {0: True, 2 / 3: False, 2: True, 10 / 3: False}),
    ],
)
def test_signed_distances_cross_ranges_on_their_side(side, changes):
    """From -2 to 1 in four seconds, with a range from 1/2 to 3/2."""
    machine = one_leg((1, 2))
    planar = replace(
        machine.constraints[0], kind=DPH, side=side, limits=(Number.of("0.5"), Number.of("1.5"))
    )
    machine = replace(machine, constraints=(planar, *machine.constraints[1:]))
    rows = np.ones((2, 6))
    rows[:, 0] = -2, 1
    poses = np.full((1, 2, 3, 3), np.nan), np.full((1, 2, 3), np.nan)
    path = Track(
        machine, machine, np.array([0.0, 4]), rows, np.ones(1, int), *poses, True, (), None, 0
    )
    found = {event.low: event.leaves for event in limit_events(path) if event.constraint == 0}
    assert list(found.values()) == list(changes.values())
    assert list(found) == pytest.approx(list(changes))


def near_poses(name, moved):
    """A machine with cones, and a pose near which something moves."""
    rng = np.random.default_rng(1)
    machine = study() if name == "study" else gspcli.example("t-top-head")
    constraints = []
    for row in machine.constraints:
        cone = gspcli.Cone(rng.normal(size=3).tolist(), 80)
        base = replace(row.base, cone=cone)
        platform = replace(row.platform, cone=gspcli.Cone(rng.normal(size=3).tolist(), 70))
        constraints.append(replace(row, base=base, platform=platform))
    machine = replace(machine, constraints=tuple(constraints))
    if name == "study":
        R, T = np.eye(3), np.array([0, 0, 60.0])
    else:
        solved = gspcli.solve(gspcli.example("t-top-head"))
        R, T = (x[solved.real][0].real for x in (solved.R, solved.T))
    return Machine.of(machine), R, T, rng


@pytest.mark.parametrize(
    ("name", "moved", "reached"),
    [
        ("study", "shift", 0.9),
        ("study", "turn", 0.5),
        ("arms", "shift", 0.9),
        ("arms", "turn", 0.5),
        ("arms", "drive", 0.5),
    ],
)
def test_cones_lean_by_no_more_than_their_measure_says(name, moved, reached):
    """The platform only shifts, only turns about its centre, or only the arms turn."""
    machine, R, T, rng = near_poses(name, moved)
    a, size = machine.stated_arrangement, 0.02
    shift = size * a.length if moved == "shift" else 0.0
    turn = size if moved == "turn" else 0.0
    angle = size if moved == "drive" else 0.0
    zero = np.zeros(1)
    near = Near(R[None], T[None], zero + shift, zero + turn, lambda: np.zeros((1, 6)))
    if machine.moves:
        slips = np.where(machine.driven, machine.arms * angle, 0.0)[None]
        near = near._replace(q=np.zeros((1, machine.count)), slips=slips)
    measure = cone_margins(machine)
    middle, change = measure(near)
    largest = np.zeros_like(middle)
    for _ in range(400):
        axes = rng.normal(size=(2, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        there = rotation_from_vector(turn * axes[0]) @ R
        place = T + (R - there) @ a.platform_centre + shift * axes[1]
        exact = Near(there[None], place[None], zero, zero, near.changes)
        if machine.moves:
            q = angle * rng.choice([-1, 1], (1, machine.count))
            exact = exact._replace(q=q, slips=np.zeros((1, 6)))
        largest = np.maximum(largest, np.abs(measure(exact)[0] - middle))
    assert (largest <= change).all()
    assert (largest / change).max() > reached


@pytest.mark.parametrize("moved", ["values", "drives"])
def test_pieces_of_a_way_are_as_near_as_they_say(moved):
    """Angles, shifts and slips of arms between two rows, and parts that are followed again."""
    rng = np.random.default_rng(2)
    given, R, T, _ = near_poses("study" if moved == "values" else "arms", "")
    machine, drives = given.instance, given if given.moves else None
    chosen, values = (), np.array([row.value.value for row in machine.constraints])
    if drives is None:
        goal = rotation_from_vector([0.1, -0.2, 0.15]) @ R, T + np.array([10, -8, 6])
        rows = np.stack((measure(machine, R, T), measure(machine, *goal)))
        numbers = rows
    else:
        chosen = choose(machine, [f"crank.B{k}" for k in range(1, 7)])
        rows = np.column_stack(([values, values], [np.zeros(6), 8 * rng.normal(size=6)]))
        numbers = np.deg2rad(rows[:, 6:])
    follower = RowFollower(machine, chosen)
    centre = Arrangement.of(machine).platform_centre
    path = PathRows(given, rows[:, :6], R[None], T[None], numbers, None, follower, rows)
    parts = ValueParts(path, np.arange(1))
    assert parts.whole.tolist() == [0]
    finer = parts.finer(0)
    assert len(finer) > 1
    assert (parts.begin[finer][0], parts.end[finer][-1]) == (parts.begin[0], parts.end[0])

    def at(s):
        mode = follower.follow(np.stack((rows[0], rows[0] + s * (rows[1] - rows[0]))), R, T)
        assert mode.reached == 1
        return mode.R[1], mode.T[1]

    part = np.concatenate((np.arange(3), finer[:3]))
    width = parts.end[part] - parts.begin[part]
    low, high = parts.begin[part] + width / 4, parts.end[part]
    near = parts.near(part, low, high)
    nearest = []
    for k in range(len(part)):
        for share in (0.0, 0.3, 1.0):
            s = low[k] + share * (high[k] - low[k])
            there, place = at(s)
            shift = np.linalg.norm((place + there @ centre) - (near.T[k] + near.R[k] @ centre))
            turn = np.linalg.norm(vector_from_rotation(there @ near.R[k].T))
            nearest.append((shift / near.shifts[k], turn / near.turns[k]))
            if drives is not None:
                q = numbers[0] + s * (numbers[1] - numbers[0])
                slips = drives.arms * np.abs(q - near.q[k])[drives.index]
                assert (slips <= near.slips[k]).all()
                assert share == 0.3 or (slips > 0.999 * near.slips[k] - 1e-12).all()
    assert np.max(nearest) <= 1
    assert np.max(nearest, axis=0) == pytest.approx(1, abs=0.4)
