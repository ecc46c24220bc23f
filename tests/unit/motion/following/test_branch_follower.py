"""Branches of made-up equations whose solutions are known: nothing false is proved of a segment.

On the points (1, x, 0, ..., 0) five equations and the Study condition say that all other
coordinates are zero. The sixth is about x^2 = v^2, in each form that an equation can have: two
branches cross at v = 0, and the solution there is double. No segment across it can be proved.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import gspcli
from gspcli import _kernel
from gspcli.certification.branches import curves
from gspcli.certification.branches.parametric_quadrics import Shape, ValueFunction
from gspcli.errors import GspError
from gspcli.geometry.coordinates import choose, coordinates, moved
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import (
    rotation_from_quaternion,
    rotation_from_vector,
    vector_from_rotation,
)
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import FollowOptions, MovingPlatform, measure, track
from gspcli.motion.following.branch_follower import MovingGeometry, Stop, at_values
from gspcli.motion.following.follower import RowFollower
from gspcli.motion.following.tracks import Run, track_from
from gspcli.motion.singularities.clearances import clearances
from gspcli.resources import data_path
from tests.support.systems import quadric

NORM = quadric(e00=1, e11=1, e22=1, e33=1)
OTHERS = [quadric(**{f"e0{k}": 1}) for k in (2, 3, 5, 6, 7)]
#: Shape and law of the sixth equation, its quadrics A and B, and bounds of c and of A - c N.
EQUATIONS = {
    "square": (Shape.PLAIN, ValueFunction.SQUARE, quadric(e11=1), None),
    "cosine": (Shape.PLAIN, ValueFunction.COSINE, quadric(e00=1), None),
    "product": (Shape.PRODUCT, ValueFunction.SQUARE, quadric(e11=2), quadric(e01=1)),
    "product of squares": (Shape.PRODUCT, ValueFunction.SQUARE, quadric(e11=1), quadric(e11=3)),
    "product without A": (Shape.PRODUCT, ValueFunction.COSINE, NORM, quadric(e01=1)),
    "lines": (Shape.LINES, ValueFunction.SQUARE, quadric(e01=1), quadric(e01=1)),
    "lines that turn": (Shape.LINES, ValueFunction.SQUARE, quadric(e01=1), quadric(e11=3)),
}
#: Up to there all of the equations have solutions.
FARTHEST = 0.16
SPANS = [(1, 0.1), (1, 0.5), (1, 1), (1, 2), (1, 3), (1, 6), (0.3, 3)]


def point(x: float) -> np.ndarray:
    z = np.array([1.0, x, 0, 0, 0, 0, 0, 0])
    return z / np.linalg.norm(z)


def follow(name: str, rows, x: float, *, near=0.0, halvings=0, moduli=1.0, build=""):
    """Follow the branch near x while v takes the values of the rows."""
    shape, law, a, b = EQUATIONS[name]
    hessians = np.zeros((6, 2, 8, 8))
    hessians[0, 0], hessians[1:, 0] = a, OTHERS
    if b is not None:
        hessians[0, 1] = b
    sizes = np.linalg.norm(hessians, ord=2, axis=(2, 3))
    values = np.zeros((1, len(rows), 6))
    values[0, :, 0] = rows
    laws = np.array([law, *[ValueFunction.LINEAR] * 5], np.int32)
    most = 1.0 if law is ValueFunction.COSINE else np.max(np.square(rows))
    largest = np.array([most, *[0.0] * 5])
    found = _kernel.follow(
        np.array([shape, *[Shape.PLAIN] * 5], np.int32),
        laws,
        np.ones(6),
        largest,
        np.maximum(sizes[:, 0], np.abs(sizes[:, 0] - 2 * largest))
        + 2 * largest * (law is ValueFunction.COSINE),
        hessians,
        sizes,
        sizes * moduli,
        values,
        np.zeros(1, np.int64),
        point(x)[None],
        np.array([near]),
        certify=True,
        most_halvings=halvings,
        jobs=1,
        build=build,
    )
    names = "points stop reached fraction last previous segments tries worst near alone"
    return SimpleNamespace(**{key: part[0] for key, part in zip(names.split(), found, strict=True)})


@pytest.mark.parametrize("name", EQUATIONS)
@pytest.mark.parametrize("size", [1e-3, 0.05])
def test_away_from_the_crossing_branches_are_followed(name: str, size: float) -> None:
    for sign in (1, -1):
        found = follow(name, [size, 1.1 * size, 2 * size], sign * size, halvings=10)
        assert found.stop == Stop.END
        assert found.last[0] * found.last[1] * sign > 0
        assert found.alone < 2 * abs(found.last[1])
        assert found.near < 0.01 * size


@pytest.mark.parametrize("name", EQUATIONS)
@pytest.mark.parametrize("size", [1e-3, 0.02, 0.1])
@pytest.mark.parametrize("halvings", [0, 2, 12])
def test_no_branch_is_followed_across_the_crossing(name: str, size: float, halvings: int) -> None:
    for (before, after), sign in ((span, sign) for span in SPANS for sign in (1, -1)):
        found = follow(
            name, [-before * size, after * size], sign * size * before, halvings=halvings
        )
        assert found.stop != Stop.END


@pytest.mark.parametrize("name", EQUATIONS)
def test_where_the_pose_may_be_another_one_no_branch_begins(name: str) -> None:
    """The pose is given up to a distance: no other pose may be within it."""
    x = solution(name, 0.05, 1)
    alone = follow(name, [0.05, 0.052], x).alone
    assert follow(name, [0.05, 0.052], x, near=alone / 8).stop == Stop.END
    for share in (0.3, 0.5, 0.9, 1.1, 3):
        assert follow(name, [0.05, 0.052], x, near=share * alone, halvings=3).stop != Stop.END


@pytest.mark.parametrize(
    "name", [x for x, row in EQUATIONS.items() if row[1] is ValueFunction.SQUARE]
)
def test_terms_that_cancel_make_errors(name: str) -> None:
    """Entries are sums of terms whose moduli may be much larger than the entries."""
    exact, rough = (follow(name, [0.1, 0.103], 0.1, moduli=m) for m in (1.0, 1e4))
    assert exact.stop == rough.stop == Stop.END
    assert rough.near > 100 * exact.near
    assert follow(name, [0.1, 0.103], 0.1, moduli=1e15, halvings=3).stop != Stop.END


def solution(name: str, v: float, sign: int) -> float:
    """Return x for a value."""
    shape, law, a, b = EQUATIONS[name]
    c = 1 - v * v / 2 if law is ValueFunction.COSINE else v * v

    def value(x: float) -> float:
        z = np.array([1, x, 0, 0, 0, 0, 0, 0])
        n, first = 1 + x * x, z @ a @ z / 2
        second = 0.0 if b is None else z @ b @ z / 2
        return {
            Shape.PLAIN: first - c * n,
            Shape.PRODUCT: n * (first - c * n) - second**2,
            Shape.LINES: first**2 - c * (n * n - second**2),
        }[shape]

    low, high = 0.0, 1.5 * abs(v)
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (low, middle) if value(middle) * value(1.5 * abs(v)) > 0 else (middle, high)
    return sign * low


MIXED = ["6PP", "6DLL", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH"]


def random_platform(gsp_type, seed=1):
    rng = np.random.default_rng(seed)
    instance, (R, T) = random_instance(gspcli.parse_type(gsp_type), rng)
    return rng, instance, R, T


def nominal_values(instance):
    return np.array([constraint.value.value for constraint in instance.constraints])


def matrix_about(axis, angle):
    return rotation_from_vector(np.asarray(axis) / np.linalg.norm(axis) * angle)


@pytest.mark.parametrize("gsp_type", MIXED)
def test_both_proofs_agree_where_only_values_move(gsp_type):
    rng, instance, R, T = random_platform(gsp_type)
    t = np.linspace(0, 1, 6)[:, None]
    turn, move = rng.normal(size=(2, 1, 3)) * 0.03
    values = measure(instance, rotation_from_vector(t * turn) @ R, T + t * move)
    one, other = MovingPlatform(instance), MovingGeometry(instance, ())
    branch = np.zeros(1, int)
    start = one.points(R[None], T[None])
    quick = one.follow(one.internal(values)[None], branch, start)
    slow = other.follow(values[None], branch, start, FollowOptions())
    assert quick.stop == slow.stop == 0
    assert np.allclose(quick.points, slow.points, atol=1e-12)


def test_cranks_about_one_axis_turn_everything():
    text = data_path("examples", "platform-6-6.yaml").read_text(encoding="utf-8")
    head, tail = text.split("base:\n")
    crank = ", crank: {centre: [1, 2, 0.5], axis: [1, -2, 2]}}"
    points, constraints = tail.split("constraints:")
    turning = "\n".join(
        line.replace("]}", "]" + crank) if "{point" in line else line for line in points.split("\n")
    )
    instance = gspcli.loads(f"{head}base:\n{turning}constraints:{constraints}")
    assert gspcli.loads(gspcli.dumps(instance)) == instance
    names = [c.name for c in coordinates(instance)]
    assert len(names) == 6
    angles = np.array([0, 25, -70, 120.0])
    values = np.tile(nominal_values(instance), (4, 1))
    found = track(instance, values, coordinates=dict.fromkeys(names, angles), modes=[1])
    assert found.certified
    assert not found.events
    for k, angle in enumerate(np.radians(angles)):
        Q, centre = matrix_about([1, -2, 2], angle), np.array([1, 2, 0.5])
        assert np.allclose(found.R[0, k], Q @ found.R[0, 0], atol=1e-11)
        assert np.allclose(found.T[0, k], Q @ (found.T[0, 0] - centre) + centre, atol=1e-11)
    # The same in one step as in the other three, and the claim is about the circle, not the chord.
    direct = track(
        instance, values[[0, 3]], coordinates=dict.fromkeys(names, angles[[0, 3]]), modes=[1]
    )
    assert np.allclose(direct.R[0, -1], found.R[0, -1], atol=1e-11)
    assert direct.segments > 3


def test_following_from_given_poses_needs_no_coordinates():
    _, instance, R, T = random_platform("6PP")
    values = measure(instance, R, T)
    found = track_from(instance, np.stack((values, values * 1.001)), R[None], T[None])
    assert found.coordinates == ()
    assert np.isfinite(found.conditions).all()


def random_twist(rng, size):
    x = rng.normal(size=6)
    return x * size / np.linalg.norm(x)


@pytest.mark.parametrize("far", [0.1, 1.0, 30.0])
@pytest.mark.parametrize("size", [1e-3, 1e-6])
def test_distances_of_study_points_are_bounded_by_those_of_poses_and_conversely(far, size):
    rng = np.random.default_rng(7)
    _, instance, R, _ = random_platform("6PP")
    geometry = MovingGeometry(instance, ())
    rows = geometry.rows
    for _ in range(50):
        start = R, far * rng.normal(size=3)
        x = random_twist(rng, size)
        turned = rotation_from_vector(x[:3]) @ R
        middle = start[1] + R @ rows.middle + x[3:] * rows.reach
        points = geometry.points(
            np.stack((R, turned)), np.stack((start[1], middle - turned @ rows.middle))
        )
        apart = min(np.linalg.norm(points[0] - sign * points[1]) for sign in (1, -1))
        assert apart <= geometry._distance(size * rows.reach)
        assert size * rows.reach <= geometry._twist(points[0], start[1], apart)


DRIVEN = {
    "t-top-head": [f"crank.B{k}" for k in range(1, 7)],
    "delta": ["crank.B1", "crank.B3", "crank.B5"],
}


@pytest.mark.parametrize("name", [*DRIVEN, "6PP", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH"])
def test_poses_on_a_segment_are_within_its_radius(name):
    rng = np.random.default_rng(3)
    if name in DRIVEN:
        instance = gspcli.example(name)
        solved = gspcli.solve(instance)
        # One that is far from the folds of @delta.
        R, T = (x[solved.real][4].real for x in (solved.R, solved.T))
        chosen = choose(instance, DRIVEN[name])
        ends = np.tile(nominal_values(instance), (2, 1))
        rows = np.column_stack((ends, [np.zeros(len(chosen)), 8 * rng.normal(size=len(chosen))]))
    else:
        _, instance, R, T = random_platform(name)
        goal = rotation_from_vector(0.02 * rng.normal(size=3)) @ R, T + 0.01 * rng.normal(size=3)
        rows, chosen = np.stack((measure(instance, R, T), measure(instance, *goal))), ()
    follower = RowFollower(instance, chosen)
    found = follower.follow(rows, R, T, keep=True)
    assert found.reached == 1
    segments = found.segments
    assert (segments.end[:-1] == segments.begin[1:]).all()
    assert (segments.begin[0], segments.end[-1]) == (0, 1)
    shares = []
    for k in range(len(segments.row)):
        for s in (0.0, 0.3, 0.5, 0.8, 1.0):
            part = segments.begin[k] + s * (segments.end[k] - segments.begin[k])
            there = rows[0] + part * (rows[1] - rows[0])
            at = follower.follow(np.stack((rows[0], there)), R, T)
            assert at.reached == 1
            chord, place = (x[0] for x in segments.chord(np.array([k]), np.array([s])))
            turn = np.linalg.norm(vector_from_rotation(at.R[1] @ chord.T))
            centre = at.T[1] + at.R[1] @ follower.middle - follower.origin
            away = np.hypot(turn, np.linalg.norm(centre / follower.reach - place))
            assert away <= segments.radius[k] + 1e-12
            shares.append(away / segments.radius[k])
    # Not by far too much.
    assert max(shares) > 0.05


def test_drives_that_the_step_does_not_know_are_followed_in_arcs():
    """A rod whose length changes while its crank turns, against the same in many short rows."""
    instance = gspcli.example("t-top-head")
    solved = gspcli.solve(instance)
    R, T = (x[solved.real][:1].real for x in (solved.R, solved.T))
    chosen = choose(instance, ["crank.B1"])
    values = nominal_values(instance)
    rows = np.array([[*values, 0.0], [*(values * 1.001), 2.0]])
    geometry = MovingGeometry(instance, chosen)
    assert not geometry.rows.knows(rows)
    start = geometry.points(R, T)
    found = geometry.follow(rows[None], np.zeros(1, int), start, FollowOptions())
    assert found.stop[0] == Stop.END
    there = moved(instance, chosen, rows[1, 6:])
    assert np.allclose(
        measure(there, *(x[0] for x in geometry.poses(found.points[:, 1]))), rows[1, :6], atol=1e-12
    )


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
