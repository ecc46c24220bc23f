from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli import _kernel
from gspcli.certification.branches import curves
from gspcli.errors import GspError
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import FollowOptions, MovingPlatform, measure, track
from gspcli.motion.following.branch_follower import at_values
from gspcli.motion.following.tracks import Run
from gspcli.motion.singularities.clearances import clearances
from gspcli.resources import data_path


@pytest.fixture(scope="module")
def hexapod():
    return gspcli.load(data_path("examples", "platform-6-6.yaml"))


#: One after the other; the two modes of the example meet on the way and vanish.
VALUES = np.array(
    [
        [2.53, 2.08, 0.93, 1.97, 1.46, 1.73],
        [2.6, 2.0, 1.0, 1.9, 1.46, 1.73],
        [2.2, 2.3, 1.2, 1.6, 1.46, 1.73],
    ]
)


def test_two_modes_meet_in_a_proved_fold(hexapod):
    result = track(hexapod, VALUES, t=[0, 1, 2])
    assert result.certified
    assert [event.kind for event in result.events] == ["fold", "fold"]
    first, second = result.events
    assert (first.mode, first.partner) == (1, 2)
    assert (second.mode, second.partner) == (2, 1)
    assert first.low == pytest.approx(0.718860610004, abs=1e-11)
    assert first.high - first.low < 1e-14
    # Before it there are two real poses, after it none.
    for t, count in ((first.low - 1e-9, 2), (first.high + 1e-9, 0)):
        values = VALUES[0] + t * (VALUES[1] - VALUES[0])
        (poses,) = gspcli.solve_values(hexapod, values[None])
        assert poses.real.sum() == count
    # The partner at the row before is the other mode.
    assert np.allclose(first.partner_T, result.T[1, 0], atol=1e-12)
    assert np.isnan(result.T[:, 1:]).all()


def test_modes_that_are_born_are_followed_back(hexapod):
    backwards = track(hexapod, VALUES[1::-1], everything=True)
    assert backwards.modes.tolist() == [1, 2]
    assert backwards.complete
    assert [event.begins for event in backwards.events] == [True, True]
    assert backwards.events[0].low == pytest.approx(2 - 0.718860610004, abs=1e-11)
    assert np.isnan(backwards.T[:, 0]).all()
    assert not np.isnan(backwards.T[:, 1]).any()


def test_one_mode_by_number_or_by_pose(hexapod):
    values = VALUES[:1] + np.linspace(0, 0.5, 6)[:, None] * (VALUES[1] - VALUES[0])
    both = track(hexapod, values)
    for result in (
        track(hexapod, values, modes=[2]),
        track(hexapod, values, near=(both.R[1, 0] + 0.01, both.T[1, 0])),
    ):
        assert result.modes.tolist() == [2]
        assert np.allclose(result.T[0], both.T[1], atol=1e-12)
    assert np.allclose(measure(hexapod, both.R, both.T), values, atol=1e-12)
    assert (np.einsum("mri,mri->mr", both.quaternions[:, 1:], both.quaternions[:, :-1]) > 0).all()
    assert np.isfinite(both.conditions).all()


def trajectories(gsp_type, seed, count=8, rows=41):
    """Smooth trajectories of poses of a random platform, and what they measure."""
    rng = np.random.default_rng(seed)
    instance, (R, T) = random_instance(gspcli.parse_type(gsp_type), rng)
    t = np.linspace(0, 1, rows)[None, :, None]
    turn, move = rng.normal(size=(2, count, 1, 3)) * 0.01
    R = rotation_from_vector(t * turn) @ R
    T = T + t * move
    return instance, R, T, measure(instance, R, T)


@pytest.mark.parametrize(
    "gsp_type",
    ["6PP", "6PL", "6LP", "6PH", "6DLL", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH", "3HP 3AHL"],
)
def test_followed_poses_are_those_that_were_measured(gsp_type):
    instance, R, T, values = trajectories(gsp_type, 1)
    platform = MovingPlatform(instance)
    followed = platform.follow(
        platform.internal(values), np.arange(len(R)), platform.points(R[:, 0], T[:, 0])
    )
    assert (followed.stop == 0).all()
    assert (followed.worst < 1).all()
    assert (followed.segments >= T.shape[1] - 1).all()
    found = platform.poses(followed.points)
    assert np.allclose(found[0], R, atol=1e-9)
    assert np.allclose(found[1], T, atol=1e-9)


def test_builds_for_all_processors_and_any_number_of_threads_agree():
    instance, R, T, values = trajectories("PP PL LP PH DLL ALL", 2, count=11)
    platform = MovingPlatform(instance)
    start = platform.points(R[:, 0], T[:, 0])
    one, two = (
        platform.follow(
            platform.internal(values), np.arange(11), start, FollowOptions(jobs=jobs)
        ).points
        for jobs in (1, 2)
    )
    assert np.array_equal(one, two)
    for build in ("portable", "avx2"):
        if build == "avx2" and _kernel.build() == "portable":
            continue
        other = platform.follow(
            platform.internal(values), np.arange(11), start, FollowOptions(build=build)
        )
        assert np.allclose(other.points, one, atol=1e-13)


def test_only_the_proof_keeps_a_mode_from_jumping(hexapod):
    """One step over a gap: Newton's method lands on another mode, which a proof never accepts."""
    instance = gspcli.load(data_path("examples", "dietmaier.yaml"))
    modes = gspcli.solve(instance)
    R, T = modes.R[modes.real].real, modes.T[modes.real].real
    rng = np.random.default_rng(0)
    base = np.array([c.value.value for c in instance.constraints])
    platform = MovingPlatform(instance)
    jumps = 0
    for _ in range(30):
        values = np.stack((base, base * (1 + 0.02 * rng.normal(size=6))))[None]
        runs = [
            platform.follow(
                platform.internal(values),
                np.zeros(len(R), int),
                platform.points(R, T),
                FollowOptions(certify=certify),
            )
            for certify in (True, False)
        ]
        proved, loose = runs
        ends = proved.points[proved.stop == 0, -1]
        overlaps = np.abs(ends @ ends.T) - np.eye(len(ends))
        # Different modes end at different poses.
        assert (overlaps < 1 - 1e-12).all()
        loose_ends = loose.points[loose.stop == 0, -1]
        same = np.abs(loose_ends @ loose_ends.T) - np.eye(len(loose_ends))
        jumps += int((same > 1 - 1e-12).any())
    assert jumps > 0


def test_branches_very_near_to_each_other_are_told_apart(hexapod):
    """Just before the fold both modes are 2e-5 apart, and each is followed away from it."""
    fold = track(hexapod, VALUES[:2], t=[0, 1]).events[0]
    near = VALUES[0] + (fold.low - 1e-9) * (VALUES[1] - VALUES[0])
    modes = gspcli.solve(gspcli.set_values(hexapod, near))
    R, T = modes.R[modes.real].real, modes.T[modes.real].real
    platform = MovingPlatform(hexapod)
    points = platform.points(R, T)
    gap = np.sqrt(max(0.0, 2 - 2 * abs(points[0] @ points[1])))
    assert gap < 3e-5
    values = platform.internal(np.stack((near, VALUES[0])))[None]
    followed = platform.follow(values, np.zeros(2, int), points)
    assert (followed.stop == 0).all()
    ends = platform.poses(followed.points[:, -1])[1]
    start = track(hexapod, VALUES[:1])
    expected = start.T[:, 0]
    assert {int(np.abs(expected - end).max(axis=1).argmin()) for end in ends} == {0, 1}


def test_rows_that_repeat_or_turn_around_are_no_events(hexapod):
    still = track(hexapod, np.stack([VALUES[0]] * 3), everything=True)
    assert (still.events, still.complete) == ((), True)
    assert np.allclose(still.T, still.T[:, :1], rtol=0, atol=1e-14)
    there = VALUES[0] + 0.7 * (VALUES[1] - VALUES[0])
    back = track(hexapod, np.stack([VALUES[0], there, there, VALUES[0]]), everything=True)
    assert (back.events, back.complete) == ((), True)
    assert np.allclose(back.T[:, -1], back.T[:, 0], atol=1e-12)


def test_modes_that_end_and_others_that_are_born_on_the_way_back(hexapod):
    path = track(hexapod, VALUES[[0, 1, 0]], everything=True)
    assert path.complete
    events = {(e.mode, e.partner, e.begins): e.low for e in path.events}
    assert set(events) == {(1, 2, False), (2, 1, False), (3, 4, True), (4, 3, True)}
    assert events[1, 2, False] - 1 == pytest.approx(3 - events[3, 4, True], abs=1e-11)


@pytest.mark.parametrize(
    ("shift", "kind", "row"),
    [(2e-15, "fold", 0), (-1e-9, "fold", 1), (-1e-12, "fold", 1), (0, "fold", 1)],
)
def test_a_fold_at_a_row_is_before_it_or_after_it(hexapod, shift, kind, row):
    fold = track(hexapod, VALUES[:2], modes=[1], t=[0, 1]).events[0]
    at = VALUES[0] + (fold.low + shift) * (VALUES[1] - VALUES[0])
    (event,) = track(hexapod, np.stack([VALUES[0], at, VALUES[1]]), modes=[1]).events
    assert (event.kind, event.row) == (kind, row)
    assert event.low == pytest.approx(2, abs=1e-8)


def test_a_fold_within_rounding_of_a_row_is_a_fold(hexapod):
    """Also where doubles see the row no better than to the root of their rounding."""
    fold = track(hexapod, VALUES[:2], modes=[1], t=[0, 1]).events[0]
    for shift in range(-40, 41):
        at = VALUES[0] + (fold.low + shift * 2.0**-53) * (VALUES[1] - VALUES[0])
        (event,) = track(hexapod, np.stack([VALUES[0], at, VALUES[1]]), modes=[1]).events
        assert event.kind == "fold"
        assert event.low == pytest.approx(2, abs=1e-13)


def near_miss(hexapod, offset):
    """Values on a line that touches the discriminant, but for an offset: towards more modes."""
    fold = track(hexapod, VALUES[:2], t=[0, 1]).events[0]
    at = VALUES[0] + fold.low * (VALUES[1] - VALUES[0])
    platform = MovingPlatform(hexapod)
    jacobian = platform.jacobian(platform.points(fold.R, fold.T), platform.internal(at))
    # The left null vector; squares of the values are what the equations are linear in.
    normal = np.linalg.svd(jacobian[1:].T)[2][-1] * at
    normal *= -np.sign(normal @ (VALUES[1] - VALUES[0])) / np.linalg.norm(normal)
    along = np.random.default_rng(7).normal(size=6)
    along -= along @ normal * normal
    along /= np.linalg.norm(along)
    return np.stack([at + offset * normal + step * along for step in (-1e-4, 0, 1e-4)])


def test_modes_that_pass_each_other_at_a_distance_of_1e_6_do_not_jump(hexapod):
    rows = near_miss(hexapod, 2.2e-13)
    passing = track(hexapod, rows[[0, 2]], everything=True)
    assert passing.events == ()
    assert passing.complete
    # Half way they are that near to each other, which solving shows, and come apart again.
    platform = MovingPlatform(hexapod)
    modes = gspcli.solve(at_values(hexapod, rows[1]))
    a, b = platform.points(modes.R[modes.real].real, modes.T[modes.real].real)
    assert 5e-7 < min(np.linalg.norm(a - b), np.linalg.norm(a + b)) < 1.5e-6
    # In the direction in which they differ, their order never changes; a jump would reverse it.
    ends = platform.points(passing.R, passing.T)
    ends *= np.sign(ends @ a)[..., None]
    order = (ends[0] - ends[1]) @ (a - b)
    assert (np.abs(order) > 1e-11).all()
    assert order[0] * order[1] > 0


def test_what_takes_too_many_arcs_is_undecided(hexapod, monkeypatch):
    monkeypatch.setattr(curves, "_MOST", 2)
    given_up = track(hexapod, near_miss(hexapod, 2.2e-13)[[0, 2]])
    assert {event.kind for event in given_up.events} == {"undecided"}
    assert np.isnan(given_up.T[:, -1]).all(axis=1).sum() == len(given_up.events) > 0


def test_modes_that_meet_at_a_distance_of_1e_6_from_being_born_again_do_not_jump(hexapod):
    rows = near_miss(hexapod, -2.2e-13)
    ending = track(hexapod, rows[[0, 2]], modes=[1], t=[-1, 1])
    assert [event.kind for event in ending.events] == ["fold"]
    assert -0.02 < ending.events[0].low < -0.001
    # Half way there are no modes, and then again two.
    assert not gspcli.solve(at_values(hexapod, rows[1])).real.any()
    assert gspcli.solve(at_values(hexapod, rows[2])).real.sum() == 2


def test_crossing_a_plane_is_no_fold():
    instance, _ = random_instance(gspcli.parse_type("6PH"), np.random.default_rng(3))
    R = rotation_from_quaternion(np.array([1.0, 0.2, -0.1, 0.3]))
    T = np.array([0.1, 0.2, 0.3])
    normal = instance.constraints[0].base.unit
    start = measure(instance, R, T)[0]
    # A translation through the first plane.
    poses = T + np.linspace(0, 2 * abs(start), 11)[:, None] * -np.sign(start) * normal
    values = measure(instance, np.broadcast_to(R, (11, 3, 3)), poses)
    assert values[0, 0] * values[-1, 0] < 0
    result = track(instance, values, near=(R, T))
    assert result.events == ()
    assert np.allclose(result.T[0], poses, atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"values": np.zeros(6)}, r"^values: found shape \(6,\), expected \(rows, 6\)"),
        (
            {"values": np.full((2, 6), np.nan)},
            r"^values\[0, 0\]: found nan, expected a finite number",
        ),
        ({"t": [1, 1, 2]}, "t must increase"),
        ({"t": [1, 2]}, r"^t: found shape \(2,\), expected \(3\)"),
        ({"modes": [3]}, "found mode 3, expected one of those at the first row: 1, 2"),
    ],
)
def test_mistakes_are_named(hexapod, changes, message):
    with pytest.raises(GspError, match=message):
        track(hexapod, **{"values": VALUES, **changes})


def lines_that_meet():
    """A random platform with a DLL, and its values with this distance zero."""
    rng = np.random.default_rng(1)
    kinds = gspcli.parse_type("DPP DPP DPP DPH DPH DLL")
    instance, (R, T) = random_instance(kinds, rng)
    values = measure(instance, R, T)
    k = [constraint.kind.name for constraint in instance.constraints].index("DLL")
    values[k] = 0
    return instance, values, k


def test_lines_that_meet_and_part_are_not_mistaken():
    # While they meet the mutual moment is their equation; it is none of the distance that grows.
    instance, values, k = lines_that_meet()
    parted = values.copy()
    parted[k] = 0.05
    leaving = track(instance, np.stack((values, parted)))
    assert np.isnan(leaving.T[:, -1]).all()
    assert {event.kind for event in leaving.events} == {"undecided"}
    # As long as they meet they can be followed.
    moved = values * 1.0001
    meeting = track(instance, np.stack((values, moved)))
    there = ~np.isnan(meeting.T[:, -1, 0])
    assert there.any()
    found = measure(instance, meeting.R[there, -1], meeting.T[there, -1])
    assert np.allclose(found, moved, atol=1e-9)


def test_there_is_no_clearance_where_lines_meet():
    instance, values, _ = lines_that_meet()
    meeting = at_values(instance, values)
    real = gspcli.solve(meeting)
    R, T = real.R[real.real].real, real.T[real.real].real
    assert len(R)
    assert (clearances(Machine.of(meeting), R, T)[0] == 0).all()


def test_conditions_are_those_of_solve():
    instance = gspcli.load(data_path("examples", "platform-6-6.yaml"))
    stated = np.array([row.value.value for row in instance.constraints])
    result = track(instance, [stated, stated + np.array([0.3, 0, 0, 0, 0, -0.2])])
    solved = gspcli.solve(instance)
    np.testing.assert_allclose(result.conditions[:, 0], solved.conditions[solved.real], rtol=1e-6)


def test_where_a_platform_goes_to_infinity_there_is_no_pose():
    instance = gspcli.load(data_path("examples", "figure-3.yaml"))
    platform = MovingPlatform(instance)
    R, T = platform.poses(np.eye(8)[4])
    assert not np.isfinite(T).any()
    values = np.array([[row.value.value for row in instance.constraints]] * 2)
    run = Run(instance, platform, np.array([1.0, 2.0]), values, FollowOptions())
    assert run._seen(0, R, T) == "the platform goes far away, to infinity"
