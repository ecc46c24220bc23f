"""Gaps between legs and bodies: distances, pairs, and how much gaps can change."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import gspcli
from gspcli import _kernel
from gspcli.errors import ArgumentError, SpecError
from gspcli.geometry.expressed_instances import expressed_instance
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Instance, Shapes
from gspcli.geometry.machine import Machine
from gspcli.motion import gaps
from gspcli.motion.collisions.compared import ComparedShapes, point_moves, slips_near
from gspcli.motion.paths.planned_paths import DriveGuide, PathEnd
from gspcli.motion.paths.planner import path
from gspcli.motion.paths.ways import PoseWays
from gspcli.motion.poses.inverse_kinematics import drive_values
from gspcli.motion.workspace.workspaces import workspace
from gspcli.solver import solve
from gspcli.spec.reading import example
from tests.support.independent_machines import upside_down
from tests.support.thick_legs import MACHINES, poses_near, thick

SEGMENTS, PAIR = np.array([0, 2, 4]), np.array([[0, 1]])
HOME = np.eye(3), np.array([0.0, 0.0, 400.0])


def of_segments(points):
    low, high = _kernel.hull_gaps(np.ascontiguousarray(points, float), SEGMENTS, PAIR)
    return low[:, 0], high[:, 0]


def by_cases(points):
    """Return distances of segments by cases: each end to the other segment, and both lines."""
    a, b, c, d = (points[:, k] for k in range(4))

    def to_segment(p, u, v):
        way = v - u
        along = np.einsum("ni,ni->n", p - u, way) / np.maximum((way**2).sum(axis=1), 1e-300)
        return np.linalg.norm(p - u - np.clip(along, 0, 1)[:, None] * way, axis=1)

    ends = np.min(
        [to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)], axis=0
    )
    u, v = b - a, d - c
    n = np.cross(u, v)
    with np.errstate(all="ignore"):
        square = (n**2).sum(axis=1)
        s = (np.cross(c - a, v) * n).sum(axis=1) / square
        t = (np.cross(c - a, u) * n).sum(axis=1) / square
        inside = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
        lines = np.abs(((c - a) * n).sum(axis=1)) / np.sqrt(square)
    return np.where(inside, np.minimum(ends, lines), ends)


def test_distances_of_segments_are_those_of_the_cases():
    points = np.random.default_rng(1).normal(size=(50_000, 4, 3))
    low, high = of_segments(points)
    expected = by_cases(points)
    assert (low <= expected + 1e-15).all()
    assert (high >= expected - 1e-15).all()
    assert (high - low).max() < 1e-12


@pytest.mark.parametrize("exponent", range(1, 17, 3))
def test_nearly_parallel_segments(exponent):
    draw = np.random.default_rng(exponent)
    points = draw.normal(size=(5000, 4, 3))
    points[:, 3] = points[:, 2] + (points[:, 1] - points[:, 0]) * draw.normal(size=(5000, 1))
    points[:, 3] += 10.0**-exponent * draw.normal(size=(5000, 3))
    # Half of them nearly touch.
    points[:2500, 2:] += (points[:2500, 0] - points[:2500, 2])[:, None]
    points[:2500, 2:] += 1e-9 * draw.normal(size=(2500, 1, 3))
    low, high = of_segments(points)
    expected = by_cases(points)
    assert (low <= expected + 1e-14).all()
    assert (high >= expected - 1e-14).all()
    assert (high - low).max() < 1e-8


def test_segments_of_small_integers():
    """Many are parallel, touch, lie in each other or are points."""
    points = np.random.default_rng(5).integers(-2, 3, size=(50_000, 4, 3)).astype(float)
    low, high = of_segments(points)
    assert np.abs(high - by_cases(points)).max() < 1e-12
    assert (high - low).max() < 1e-12
    assert (low >= 0).all()


@pytest.mark.parametrize("size", [1e-300, 1e-60, 1e60, 1e150, 1e300])
def test_tiny_and_huge_segments(size):
    points = np.random.default_rng(2).normal(size=(1000, 4, 3))
    low, high = of_segments(points * size)
    assert np.abs(high / size - by_cases(points)).max() < 1e-12
    assert (high - low).max() < 1e-12 * size


def test_what_is_not_finite_has_no_distance():
    points = np.ones((3, 4, 3))
    points[0, 1, 2], points[1, 3, 0] = np.nan, np.inf
    low, high = of_segments(points)
    assert np.isnan(low).tolist() == [True, True, False]
    assert np.isnan(high).tolist() == [True, True, False]
    assert of_segments(np.zeros((1, 4, 3))) == ([0.0], [0.0])


def test_wrong_arrays_are_refused():
    points = np.zeros((1, 4, 3))
    for starts, pairs in (
        ([0, 2], [[0, 0]]),
        ([1, 4], [[0, 0]]),
        ([0, 0, 4], [[0, 1]]),
        ([0, 4], [[0, 1]]),
        ([0, 4], [[0, -1]]),
    ):
        with pytest.raises(ValueError, match="hull"):
            _kernel.hull_gaps(points, np.array(starts), np.array(pairs))


def test_hulls_that_overlap_have_distance_zero_and_others_a_plane_between_them():
    draw = np.random.default_rng(3)
    points = draw.normal(size=(2000, 24, 3))
    points[:, 12:] += 3 * draw.normal(size=(2000, 1, 3))
    starts = np.array([0, 12, 24])
    low, high = (one[:, 0] for one in _kernel.hull_gaps(points, starts, PAIR))
    assert (high - low).max() < 1e-7
    assert 100 < (low == 0).sum() < 1900
    # No two points of random combinations are nearer.
    parts = draw.dirichlet(np.full(12, 0.3), size=(2, 2000))
    first, second = (
        np.einsum("nk,nki->ni", part, points[:, 12 * k : 12 * k + 12])
        for k, part in enumerate(parts)
    )
    assert (low <= np.linalg.norm(first - second, axis=1)).all()


def test_legs_that_share_a_joint_are_compared_beyond_a_length_only():
    # Of the 15 pairs of an octahedral hexapod six share a joint of a body each.
    octahedral = example("platform-6-3")
    rows = octahedral.constraints
    shared = [
        (i + 1, j + 1)
        for i in range(6)
        for j in range(i + 1, 6)
        if rows[i].platform_name == rows[j].platform_name
    ]
    assert len(shared) == 3
    apart = ComparedShapes(replace(octahedral, shapes=Shapes(0)))
    assert len(apart.names) == 12
    assert not {f"legs {i} and {j}" for i, j in shared} & {*apart.names}
    beyond = ComparedShapes(replace(octahedral, shapes=Shapes(0, near_joint=0.25)))
    assert len(beyond.names) == 15
    T = np.array([0.1, 0.2, 1.5])
    a = np.array([[x.value for x in row.platform.position] for row in rows]) + T
    b = np.array([[x.value for x in row.base.position] for row in rows])
    found = gaps(beyond.instance, np.eye(3), T)
    u = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    i, j = (k - 1 for k in shared[0])
    assert found.values[0, found.pairs.index(f"legs {i + 1} and {j + 1}")] == pytest.approx(
        0.25 * np.linalg.norm(u[i] - u[j])
    )


def test_nothing_to_compare_is_an_error():
    with pytest.raises(ArgumentError, match="states no shapes"):
        gaps(example("workspace-study"), *HOME)
    with pytest.raises(ArgumentError, match="no distance of two points"):
        gaps(replace(example("six-planes"), shapes=Shapes(1)), *HOME)
    with pytest.raises(ArgumentError, match=r"shapes.diameters\[1\]: found -2"):
        gaps(replace(example("workspace-study"), shapes=Shapes([1, -2, 3, 4, 5, 6])), *HOME)


def test_a_leg_of_length_zero_and_touching_legs():
    instance = thick("workspace-study", diameter=0)
    rows = instance.constraints
    # The platform's first joint is at that of the base.
    joints = rows[0].platform.point, rows[0].base.point
    T = joints[1] - joints[0]
    found = gaps(instance, np.eye(3), T)
    assert np.isfinite(found.values).all()
    wide = gaps(thick("workspace-study", diameter=53.0 + 1e-9), np.eye(3), [0, 0, 400])
    thin = gaps(thick("workspace-study"), np.eye(3), [0, 0, 400])
    assert np.allclose(wide.values, thin.values - 33, atol=1e-8)
    for diameter in (0, 20, 53.0):
        one = ComparedShapes(thick("workspace-study", diameter=diameter))
        bounds = one.bounds(np.eye(3)[None], np.array([[0, 0, 400.0]]))
        for bound in bounds:
            assert np.allclose(bound, thin.values + 20 - diameter, atol=1e-8)


@pytest.mark.parametrize("near", [None, 0.0, 1.0])
@pytest.mark.parametrize("name", MACHINES)
def test_gaps_change_at_most_by_what_is_bounded(name, near):
    instance = thick(name, None if near is None else near * MACHINES[name][0])
    compared = ComparedShapes(instance)
    home = np.array([x.value for x in instance.home.position]) if instance.home else None
    T = np.array([0, 0, 400.0]) if home is None else home
    size = MACHINES[name][1]
    for seed, (move, turn) in enumerate([(0.1, 0.1), (0.3, 1.5), (0.0, 0.4), (0.5, 0.0), (0, 3.1)]):
        R, first = poses_near(np.eye(3), T, 40, size, 1.0, seed)
        centre = np.array([0.1, 0.2, -0.1]) * size
        for k in range(40):
            # The centre moves, and the platform turns about it.
            turned, moved = poses_near(R[k], R[k] @ centre + first[k], 25, move * size, turn, k)
            at = compared.bounds(R[k][None], first[k][None])
            there = compared.bounds(turned, moved - turned @ centre)
            far = np.array([move * size]), np.array([turn])
            bound = compared.moves(R[k][None], first[k][None], None, *far, centre)
            assert (there.low <= at.high + bound).all()
            assert (there.high >= at.low - bound).all()


# Arms of cranks with a diameter: which pairs are compared, their gaps, and how far they move.


PLATES = {
    body: [[x * side, y * side, z] for x in (-1, 1) for y in (-1, 1) for z in heights]
    for body, side, heights in (("platform", 0.02, (0, 0.01)), ("base", 0.05, (-0.2, -0.15)))
}


def armed(
    name: str, *, near: float | None = None, plates: bool = False, diameter: float = 0.004
) -> tuple[Instance, np.ndarray, np.ndarray]:
    """Return a machine whose rods and arms have shapes, and its home."""
    solved = gspcli.solve(gspcli.example(name))
    home = 0 if solved.home is None else solved.home.number - 1
    rows = []
    for row in solved.instance.constraints:
        crank = row.base.crank
        base = replace(row.base, crank=replace(crank, diameter=gspcli.Number.of(diameter)))
        rows.append(replace(row, base=base))
    shapes = Shapes(0.002, **(PLATES if plates else {}), near_joint=near)
    instance = replace(solved.instance, constraints=tuple(rows), shapes=shapes)
    return instance, solved.R[home].real, solved.T[home].real


def swapped(instance: Instance) -> Instance:
    """Return the machine upside down: its motors are on the platform."""
    rows, shapes = upside_down(instance), instance.shapes
    turned = Shapes(shapes.diameters, shapes.base, shapes.platform, shapes.near_joint)
    return replace(instance, constraints=rows, shapes=turned, home=None)


def sampled_distance(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> float:
    """Return the distance of two segments, from many points of both."""
    part = np.linspace(0, 1, 401)[:, None]
    first, second = a + (b - a) * part, c + (d - c) * part
    return float(np.linalg.norm(first[:, None] - second, axis=-1).min())


def test_an_arm_leads_from_the_axis_to_the_point() -> None:
    instance, R, T = armed("t-top-head")
    compared = ComparedShapes(instance)
    drives = Machine.of(instance)
    R, T = poses_near(R, T, 4, 0.01, 0.1, 3)
    q = Machine.of(instance).at_home().along(R, T)
    found = compared.gaps(R, T, q)
    b, arm, _ = drives.ends(R, T, q)
    for pose in range(4):
        axis, tip, top = drives.middle, b[pose], arm[pose] + T[pose]
        for name, gap in zip(compared.names, found[pose], strict=True):
            numbers = [int(x) - 1 for x in name.replace("B", " ").split() if x.isdecimal()]
            first, second = numbers
            if name.startswith("legs"):
                expected = sampled_distance(top[first], tip[first], top[second], tip[second])
                assert gap == pytest.approx(expected - 0.002, abs=1e-6)
            elif name.startswith("leg"):
                expected = sampled_distance(top[first], tip[first], axis[second], tip[second])
                assert gap == pytest.approx(expected - 0.003, abs=1e-6)
            else:
                assert name.startswith("the arm of B")
                expected = sampled_distance(axis[first], tip[first], axis[second], tip[second])
                assert gap == pytest.approx(expected - 0.004, abs=1e-6)
    kinds = [name.split(" ")[0] for name in compared.names]
    assert (kinds.count("legs"), kinds.count("leg"), kinds.count("the")) == (15, 30, 15)
    assert "leg 1 and the arm of B1" not in compared.names


def test_what_is_joined_is_compared_beyond_the_joint() -> None:
    instance, R, T = armed("t-top-head", near=0.005, plates=True)
    names = ComparedShapes(instance).names
    assert {"leg 1 and the arm of B1", "the arm of B1 and the base"} <= set(names)
    assert "the arm of B1 and the platform" in names
    # The arm and the rod are at an angle: 5 mm from the joint they are apart.
    compared = ComparedShapes(instance)
    k = names.index("leg 1 and the arm of B1")
    gap = compared.gaps(R[None], T[None])[0, k]
    drives = Machine.of(instance)
    b, _, r = drives.ends(R, T, np.zeros(6))
    out = drives.middle[0] - b[0]
    along, out = r[0] / np.linalg.norm(r[0]), out / np.linalg.norm(out)
    expected = 0.005 * np.linalg.norm(along - out) - 0.003
    assert gap == pytest.approx(expected, abs=1e-9)


def test_arms_of_one_motor_are_one_body() -> None:
    """In a delta two rods share a crank; both ends have an arm."""
    instance, R, T = armed("delta", diameter=20)
    compared = ComparedShapes(replace(instance, shapes=Shapes(10)))
    assert len(compared.arms) == 6
    assert "the arms" not in " ".join(compared.names)
    assert "the arm of B1 and the arm of B3" in compared.names
    assert "the arm of B1 and the arm of B2" not in compared.names
    assert np.isfinite(compared.gaps(R[None], T[None])).all()


def test_only_arms_with_a_diameter_are_looked_at() -> None:
    instance, *_ = armed("t-top-head")
    plain = gspcli.example("t-top-head")
    assert ComparedShapes(replace(plain, shapes=Shapes(0.002))).arms == []
    rows = [row if k == 2 else other for k, (row, other) in enumerate(
        zip(instance.constraints, plain.constraints, strict=True))]  # fmt: skip
    compared = ComparedShapes(replace(instance, constraints=tuple(rows)))
    assert [one[0] for one in compared.arms] == [2]


@pytest.mark.parametrize("upside_down", [False, True])
@pytest.mark.parametrize("move", [1e-2, 1e-4])
def test_gaps_of_arms_change_no_more_than_is_proved(move: float, *, upside_down: bool) -> None:
    instance, R0, T0 = armed("reachy-mini-head", near=0.004, plates=True)
    R, T = poses_near(R0, T0, 3000, move * 0.05, move, 1)
    if upside_down:
        instance = swapped(instance)
        T, R = -np.einsum("nji,nj->ni", R, T), np.swapaxes(R, 1, 2)
        T0, R0 = -R0.T @ T0, R0.T
    motors = Machine.of(instance).at_home(R0, T0)
    compared = ComparedShapes(instance)
    q, q0 = motors.along(R, T), motors.along(R0[None], T0[None])
    centre = np.array([0.01, 0, 0])
    places, place = T + R @ centre, T0 + R0 @ centre
    shift = np.array([np.linalg.norm(places - place, axis=1).max()])
    moved = compared.moves(R0[None], T0[None], q0, shift, np.array([move]), centre)
    change = np.abs(compared.bounds(R, T, q).high - compared.bounds(R0[None], T0[None], q0).high)
    change = change.max(axis=0)
    arms = np.array(["arm" in name for name in compared.names])
    assert np.isfinite(moved).all()
    assert (change <= moved[0] + 1e-12).all()
    if not upside_down:
        assert change[arms].max() > moved[0][arms].max() / 12


def test_gaps_of_arms_do_not_depend_on_frames() -> None:
    instance, R, T = armed("t-top-head", near=0.005, plates=True)
    pivot = (0.02, 0.01, -0.05)
    frame, other = PoseFrame.of(instance, pivot=pivot), expressed_instance(instance, pivot=pivot)
    q = Machine.of(instance).at_home().along(R[None], T[None])
    R_there, T_there = frame.from_platform(R[None], T[None])
    found = ComparedShapes(other).gaps(R_there, T_there, q)
    assert found == pytest.approx(ComparedShapes(instance).gaps(R[None], T[None], q), abs=1e-9)


def test_diameters_of_arms_are_read_and_written() -> None:
    instance, *_ = armed("t-top-head", diameter=0.0125)
    text = gspcli.dumps(instance)
    assert text.count("diameter: 0.0125}") == 6
    assert gspcli.loads(text).constraints == instance.constraints
    wrong = text.replace("diameter: 0.0125}", "diameter: -1}", 1)
    line = next(k for k, one in enumerate(wrong.splitlines(), 1) if "diameter: -1" in one)
    with pytest.raises(SpecError) as error:
        gspcli.loads(wrong)
    message = str(error.value)
    assert f":{line}:" in message
    assert "base.B1.crank.diameter: found '-1', expected a diameter of at least 0" in message
    with pytest.raises(SpecError, match="diameter"):
        gspcli.loads(text.replace("diameter: 0.0125}", "diameter: thick}", 1))


def test_a_negative_diameter_of_an_arm_is_refused() -> None:
    instance, *_ = armed("t-top-head", diameter=-1.0)
    with pytest.raises(ArgumentError, match="B1: found -1, expected a diameter of at least 0"):
        ComparedShapes(instance)


# Gaps of machines with motors that move points: paths and workspaces, against samples.


#: Of the machine: the length of its rods.
SIZE = Machine.of(example("reachy-mini-head")).rods.max()


def thick_machine() -> tuple[Instance, np.ndarray, np.ndarray, float]:
    """Return cranks whose rods are thick, their home, and the gap there."""
    result = solve(example("reachy-mini-head"))
    assert result.home is not None
    R, T = result.R[result.home.number - 1].real, result.T[result.home.number - 1].real
    instance = replace(result.instance, shapes=Shapes(SIZE / 25))
    least = ComparedShapes(instance).bounds(R[None], T[None]).low.min()
    return instance, R, T, float(least)


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_samples_of_a_path_keep_the_gap(share: float) -> None:
    instance, R, T, least = thick_machine()
    goal = R, T + np.array([0.1, 0.05, 0.02]) * SIZE
    found = path(instance, "home", goal, along="poses", gap=share * least, time=5)
    assert (found.verdict, found.along) == ("proved", "poses")
    assert len(found.T) >= 2
    assert found.gaps is not None
    motors = Machine.of(instance).at_home()
    ways = PoseWays(instance, limits=False)
    numbers = ways.parameters(found.R, found.T)
    for a, b in pairwise(numbers):
        part = np.linspace(0, 1, 200)[:, None]
        R_there, T_there = ways.poses(a + (ways.nearest(a, b) - a) * part)
        q = motors.along(R_there, T_there)
        low = ComparedShapes(instance).bounds(R_there, T_there, q).low
        assert (low >= share * least - 1e-9).all()


def test_samples_of_a_path_of_drives_keep_the_gap() -> None:
    instance, R, T, least = thick_machine()
    goal = T + np.array([0.1, 0.05, 0.02]) * SIZE
    found = path(instance, "home", (R, goal), gap=least / 2, time=5)
    assert (found.verdict, found.along) == ("proved", "drives")
    ends = [PathEnd("", found.values[k], found.R[k], found.T[k]) for k in (0, -1)]
    guide = DriveGuide(Machine.of(instance).at_home(), *ends)
    samples = guide.trace(guide.corners, np.array([300]))
    assert samples is not None
    low = (
        ComparedShapes(instance)
        .bounds(samples.rows.R, samples.rows.T, samples.rows.drive_numbers())
        .low
    )
    least_proved = min(part.gap for part in found.parts if part.gap is not None)
    assert least / 2 <= least_proved <= low.min() + 1e-9


def test_a_gap_that_home_does_not_keep_is_impossible() -> None:
    instance, R, T, least = thick_machine()
    found = path(instance, "home", (R, T + 0.01 * SIZE), gap=2 * least, time=1)
    assert found.verdict == "impossible"
    assert "the gap between legs" in found.reason


def test_samples_of_a_workspace_keep_the_gap_inside_and_not_outside() -> None:
    instance, R, T, least = thick_machine()
    x, y = T[:2].tolist()
    within = {"x": (x - 0.5 * SIZE, x + 0.5 * SIZE), "y": (y - 0.5 * SIZE, y + 0.5 * SIZE)}
    asked = 0.8 * least
    given = {"free": "xy", "within": within, "tolerance": 0.05, "connected": False}
    found = workspace(instance, R, T, gap=asked, **given)
    without = workspace(instance, R, T, **given)
    assert 0 < found.volume[0] <= found.volume[1] < without.volume[1]
    draw = np.random.default_rng(3).uniform(size=(3000, 2))
    low, high = np.array(list(within.values())).T
    places = np.tile(T, (3000, 1))
    places[:, :2] = low + (high - low) * draw
    turned = np.tile(R, (3000, 1, 1))
    judged, plain = (one.judged_poses(turned, places) for one in (found, without))
    inside = judged == judged.max()
    q = Machine.of(instance).at_home().inverse(turned, places)
    gaps = ComparedShapes(instance).bounds(turned, places, q)
    assert inside.sum() > 100
    assert (gaps.low.min(axis=1)[inside] >= asked - 1e-9).all()
    # Nothing that is known to keep all limits and the gap is left out.
    out = (judged == judged.min()) & (plain == plain.max())
    assert (gaps.low.min(axis=1)[out] < asked).all()


# How far motors move their points while the platform moves a little: bounds and samples.


#: Machines with cranks, slides, and shared carriages on base and platform.
NAMES = ("reachy-mini-head", "modified-paradex", "delta", "hexaglide")


def at_home(name: str) -> tuple[Instance, np.ndarray, np.ndarray]:
    result = solve(example(name))
    home = 0 if result.home is None else result.home.number - 1
    return result.instance, result.R[home].real, result.T[home].real


def reached(
    instance: Instance, R: np.ndarray, T: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    q = drive_values(instance, R, T)[1]
    good = np.isfinite(q).all(axis=1)
    return R[good], T[good], q[good]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("move", [1e-2, 1e-5])
def test_points_and_gaps_change_no_more_than_is_proved(name: str, move: float) -> None:
    instance, R0, T0 = at_home(name)
    drives = Machine.of(instance)
    size = float(drives.rods[drives.driven].max())
    instance = replace(instance, shapes=Shapes(size / 50, near_joint=size / 10))
    compared = ComparedShapes(instance)
    R, T, q = reached(instance, *poses_near(R0, T0, 4000, move * size, move, 1))
    if drives.count == 6:
        assert len(R) > 3000
    # Machines with shared drives reach few poses near by: those turn about no axis.
    else:
        draw = np.random.default_rng(2).normal(size=(400, 3))
        draw *= move * size / np.linalg.norm(draw, axis=1).max()
        R, T, q = reached(instance, np.tile(R0, (400, 1, 1)), T0 + draw)
        assert len(R) > 0
    centre = np.zeros(3)
    away = np.linalg.norm(T - T0, axis=1).max()
    shift, turn = np.array([away]), np.array([move])
    home = R0[None], T0[None], drive_values(instance, R0[None], T0[None])[1]
    moved = compared.moves(*home, shift, turn, centre)
    change = np.abs(compared.bounds(R, T, q).high - compared.bounds(*home).high).max(axis=0)
    assert (change <= moved[0] + 1e-12 * size).all()
    assert np.isfinite(moved).all()
    if name in NAMES[:2]:
        # The bounds are no more than some times what is seen.
        assert change.max() > moved.max() / 12
    own = np.linalg.norm(drives.points(q) - drives.points(home[2]), axis=-1).max(axis=0)
    b, a, _ = drives.ends(R0[None], T0[None], home[2])
    arms = np.where(drives.on_platform, np.linalg.norm(b - T0, axis=-1), np.linalg.norm(a, axis=-1))
    found = point_moves(drives, *home, shift + turn * arms)
    assert (own <= found[0] + 1e-12 * size).all()


def test_nothing_is_proved_where_a_rod_may_not_reach() -> None:
    instance, R, T = at_home("reachy-mini-head")
    drives = Machine.of(instance)
    q = drive_values(instance, R[None], T[None])[1]
    far = np.full((1, 6), float(drives.arms.max()) * 10)
    assert np.isinf(point_moves(drives, R[None], T[None], q, far)).all()


def test_values_move_no_points() -> None:
    instance, R, T = at_home("three-prs")
    drives = Machine.of(instance)
    q = drive_values(instance, R[None], T[None])[1]
    found = point_moves(drives, R[None], T[None], q, np.full((1, 6), 1e-3))
    assert (found[0][~drives.driven] == 0).all()
    assert (found[0][drives.driven] > 0).all()


def test_the_wrong_working_mode_is_not_proved() -> None:
    """Of the other number of a crank the length passes its value in the other direction."""
    instance, R, T = at_home("reachy-mini-head")
    drives = Machine.of(instance)
    q = drive_values(instance, R[None], T[None])[1]
    moves = np.full((1, 6), 1e-4 * float(drives.arms.max()))
    assert np.isfinite(point_moves(drives, R[None], T[None], q, moves)).all()
    # A number that fits no rod is proved for none, however near it is.
    bound = point_moves(drives, R[None], T[None], q + 1e-2, moves)
    assert np.isinf(bound).any()


@pytest.mark.parametrize("name", ["reachy-mini-head", "hexaglide"])
def test_points_near_dead_points_move_no_more_than_is_proved(name: str) -> None:
    """The platform moves straight, so all joints move as far; some rods then do not reach."""
    instance, R0, T0 = at_home(name)
    drives = Machine.of(instance)
    working_modes = drives.working_modes(R0, T0)
    size = float(drives.rods.max())
    R, T = poses_near(R0, T0, 400, 0.6 * size, 1.2, 4)
    q = drives.inverse(R, T, working_modes)
    reached_ = np.isfinite(q).all(axis=1)
    R, T, q = R[reached_], T[reached_], q[reached_]
    draw = np.random.default_rng(5)
    far = size * 10 ** draw.uniform(-3, -0.7, len(T))
    found = point_moves(drives, R, T, q, np.tile(far[:, None], 6))
    # Of each rod the worst ways are along it.
    rods = drives.ends(R, T, q)[2] / drives.rods[:, None]
    ways = np.concatenate([rods, -rods, draw.normal(size=(len(T), 100, 3))], axis=1)
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    moved = drives.wanted(R[:, None], T[:, None] + far[:, None, None] * ways, working_modes)
    slips = np.linalg.norm(drives.points(moved) - drives.points(q)[:, None], axis=-1)
    unreached = np.isnan(slips).any(axis=1)
    assert np.isinf(found[unreached]).all()
    assert unreached.sum() > 10
    known = ~unreached
    most = np.nanmax(np.where(np.isnan(slips), 0.0, slips), axis=1)
    assert (most[known] <= found[known] + 1e-9 * size).all()
    # Where a gain is small twice and four times the linear change count.
    assert (found / most)[known & np.isfinite(found)].min() < 1.2


def test_points_move_with_the_turn_of_the_platform() -> None:
    instance, R0, T0 = at_home("reachy-mini-head")
    drives, turn = Machine.of(instance), 1e-3
    R, T = poses_near(R0, T0, 200, 0.0, turn, 6)
    start = R0[None], T0[None], drives.inverse(R0[None], T0[None])
    found = slips_near(drives, *start, np.zeros(1), np.full(1, turn), np.zeros(3))[0]
    moved = np.linalg.norm(drives.points(drives.inverse(R, T)) - drives.points(start[2]), axis=-1)
    assert (moved.max(axis=0) <= found).all()
    assert (moved.max(axis=0) > found / 10).all()
