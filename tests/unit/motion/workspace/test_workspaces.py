"""Workspaces: laws, known volumes, random poses, mistakes."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.statics.wrenches import wrenches
from gspcli.motion.workspace.pose_boxes import PARAMETERS
from gspcli.motion.workspace.travels import travels
from gspcli.motion.workspace.workspaces import workspace
from gspcli.spec.reading import example
from tests.support.limited import limited, one_leg, study, turned
from tests.support.thick_legs import thick

HOME = np.eye(3), np.zeros(3)
ALL_KINDS = ["6PP", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH", "PP PP DLL AHL ALL AHH"]
NEAR = {"x": (-3, 3), "y": (-3, 3), "z": (-3, 3)}


def contains(bounds, volume):
    low, high = bounds
    return low <= volume <= high


@pytest.mark.parametrize(
    ("cones", "share"),
    [
        ({}, 1.0),
        ({"base_cone": gspcli.Cone([0, 3, -4], 35)}, (1 - math.cos(math.radians(35))) / 2),
        ({"platform_cone": gspcli.Cone([1, 1, 0], 140)}, (1 - math.cos(math.radians(140))) / 2),
    ],
)
def test_one_leg_reaches_a_shell_or_a_part_of_it(cones, share):
    found = workspace(one_leg((1, 2), base=(1, -2, 0.5), **cones), *HOME, tolerance=0.1)
    assert contains(found.volume, share * 4 / 3 * math.pi * (8 - 1))
    assert found.gap <= 0.1
    assert found.measure == "mm^3"


@pytest.mark.parametrize(
    ("free", "share", "unit", "gap"),
    [
        (("x", "y", "z", "rz"), 360.0, "mm^3 deg", 0.4),
        (PARAMETERS, 1.0, "mm^3 of all rotations", 0.95),
    ],
)
def test_turns_about_the_point_of_the_leg_multiply_the_volume(free, share, unit, gap):
    leg = one_leg((1, 2), base=(1, -2, 0.5))
    found = workspace(leg, *HOME, free=free, tolerance=gap, most_boxes=400_000)
    assert contains(found.volume, share * 4 / 3 * math.pi * (8 - 1))
    assert found.volume[0] > 0
    assert found.measure == unit


def test_two_legs_reach_a_lens():
    points = [[0, 0, 0], [1.5, 0, 0]]
    rows = [
        gspcli.distance(gspcli.Point([0, 0, 0]), gspcli.Point(p), 1, range=(0, 1)) for p in points
    ]
    rows += [gspcli.distance(gspcli.Point([k, 1, k]), gspcli.Point([1, k, 0]), 3) for k in range(4)]
    found = workspace(gspcli.instance(rows), *HOME, tolerance=0.05)
    # Two caps of height 1/4.
    cap = math.pi * 0.25**2 * (3 - 0.25) / 3
    assert contains(found.volume, 2 * cap)
    extents = found.extents[0]
    assert extents[1, 0] <= 0.5 <= extents[0, 0]
    assert extents[0, 1] <= 1.0 <= extents[1, 1]


def test_the_share_of_rotations_is_that_of_a_cone():
    instance = one_leg((1, 3), base=(0, 0, -2), platform_cone=gspcli.Cone([1, 2, 2], 60))
    angles = ("rx", "ry", "rz")
    found = workspace(instance, *HOME, free=angles, tolerance=0.1)
    assert contains(found.volume, 0.25)
    assert found.measure == "of all rotations"
    # Without the cone every rotation keeps the range of a leg from the pivot.
    everything = workspace(one_leg((1, 3), base=(0, 0, -2)), *HOME, free=angles)
    assert np.allclose(everything.volume, 1)
    assert everything.open.shape == (0, 3, 2)


def test_in_a_plane_and_along_a_line():
    instance = one_leg((1, 2))
    disc = workspace(instance, *HOME, free=("x", "z"), tolerance=0.01)
    assert contains(disc.volume, math.pi * 3)
    assert disc.measure == "mm^2"
    line = workspace(instance, *HOME, free=("y",), tolerance=1e-6)
    assert contains(line.volume, 2)
    assert line.judged < 500  # halved towards the four ends only


FREE = [("x", "y", "z"), ("x", "ry"), ("rx", "ry", "rz"), ("z", "rx", "rz")]


@pytest.mark.parametrize("name", ALL_KINDS)
@pytest.mark.parametrize("free", FREE, ids=" ".join)
@pytest.mark.parametrize("seed", [1, 2])
def test_inner_poses_keep_the_limits_and_outer_ones_leave_them(name, free, seed):
    instance, R, T = limited(name, seed)
    pivot = np.array([0.2, -0.3, 0.1])
    sequence = "ZYX" if seed == 1 else "yxz"
    within = {
        n: (T[k] - 2 + (R @ pivot)[k], T[k] + 2 + (R @ pivot)[k])
        for k, n in enumerate("xyz")
        if n in free
    }
    found = workspace(
        instance, R, T, free=free, pivot=pivot, sequence=sequence, within=within, tolerance=0.1,
        most_boxes=20_000,
    )  # fmt: skip
    rng = np.random.default_rng(seed)
    inside, outside = _compare(found, rng.uniform(0, 1, (6000, len(free))))
    # Random poses hit both, and near home the set has an interior.
    boxes = np.concatenate((found.inner, found.open))
    assert len(boxes)
    centres = boxes.mean(axis=2)
    widths = boxes[:, :, 1] - boxes[:, :, 0]
    shaken = centres[rng.integers(len(boxes), size=4000)]
    shaken += widths[rng.integers(len(boxes), size=4000)] * rng.uniform(-1, 1, shaken.shape)
    more = _compare(found, shaken, relative=False)
    assert outside + more[1] > 100
    assert inside + more[0] > (20 if len(found.inner) else -1)


def _compare(found, points, *, relative=True):
    """Compare the verdicts of boxes with the limits at poses; return how many were in and out."""
    if relative:
        low, high = (found.bounds / found.units[:, None]).T
        points = low + points * (high - low)
    verdicts = found.judged_at(points)
    parameters = np.tile(found.boxes.home, (len(points), 1))
    for k, name in enumerate(found.free):
        parameters[:, PARAMETERS.index(name)] = points[:, k] * found.units[k]
    R, T = found.boxes.poses(parameters)
    kept = Machine.of(found.instance).keeps(R, T)
    low, high = found.bounds.T
    within = ((points * found.units >= low) & (points * found.units <= high)).all(axis=1)
    assert kept[verdicts == 1].all()
    assert not kept[(verdicts == -1) & within].any()
    return int((verdicts == 1).sum()), int(((verdicts == -1) & within).sum())


def test_the_published_study():
    found = workspace(study(), *HOME, tolerance=0.08)
    assert found.gap <= 0.08
    inside, outside = _compare(found, np.random.default_rng(0).uniform(0, 1, (9000, 3)))
    assert inside > 100
    assert outside > 100
    # A lattice of poses estimates the volume independently.
    low, high = found.extents[:, 1].T
    grid = np.stack(np.meshgrid(*np.linspace(low, high, 30).T, indexing="ij"), axis=-1)
    T = grid.reshape(-1, 3)
    R = np.broadcast_to(np.eye(3), (len(T), 3, 3))
    part = Machine.of(study()).keeps(R, T).mean()
    estimate = part * np.prod((high - low) * 30 / 29)
    assert found.volume[0] * 0.97 < estimate < found.volume[1] * 1.03


def test_more_room_reaches_more():
    volumes = [
        workspace(study(base, 60, legs), *HOME, tolerance=0.1).volume
        for base, legs in ((24, (80, 160)), (30, (80, 160)), (30, (70, 175)))
    ]
    for less, more in pairwise(volumes):
        assert less[1] < more[0]


@pytest.mark.parametrize("free", [("x", "y", "z"), ("rx", "ry", "rz")], ids=" ".join)
def test_moving_the_base_changes_no_volume(free):
    instance, R, T = limited("6PP", 3)
    turn = rotation_from_vector(np.array([0.4, -1.1, 0.7]))
    shift = np.array([3.0, -2, 1])
    one = workspace(instance, R, T, free=free, tolerance=0.1, most_boxes=60_000).volume
    moved = turned(instance, turn, shift)
    other = workspace(
        moved, turn @ R, turn @ T + shift, free=free, tolerance=0.1, most_boxes=60_000
    ).volume
    assert max(one[0], other[0]) <= min(one[1], other[1])
    assert one[0] > 0
    # The gap excludes few poses, so the comparison is meaningful.
    assert (one[1] - one[0]) / one[1] < 0.5


def test_what_is_connected_has_one_sign_of_the_determinant():
    instance = study()
    home = np.eye(3), np.array([0, 0, 80.0])
    angles = ("rx", "ry")
    whole = workspace(instance, *home, free=angles, tolerance=0.02)
    part = workspace(instance, *home, free=angles, tolerance=0.02, connected=True)
    # A cone would let it tilt further, beyond a singularity.
    assert part.volume[1] < 0.97 * whole.volume[0]
    parameters = np.tile(part.boxes.home, (2000, 1))
    centres = part.inner.mean(axis=2)
    chosen = np.random.default_rng(1).integers(len(centres), size=2000)
    parameters[:, 3:5] = centres[chosen] * part.units
    R, T = part.boxes.poses(parameters)
    signs = np.sign(np.linalg.det(wrenches(instance, R, T).jacobian))
    assert np.all(signs == signs[0])
    parameters[:, 3:5] = whole.inner.mean(axis=2)[chosen % len(whole.inner)] * whole.units
    others = wrenches(instance, *whole.boxes.poses(parameters)).jacobian
    assert len(np.unique(np.sign(np.linalg.det(others)))) == 2


def test_only_the_part_of_home_is_connected():
    """Two legs of one joint leave two places on a line."""
    rows = [
        gspcli.distance(gspcli.Point([0, 0, 0]), gspcli.Point([0, 0, 0]), "3/2", range=(1, 2)),
        *(
            gspcli.distance(gspcli.Point(p), gspcli.Point(b), 3)
            for p, b in (
                ([1, 0, 0], [1, 0, 5]),
                ([0, 1, 0], [0, 1, 5]),
                ([0, 1, 0], [2, 5, 1]),
                ([1, 0, 0], [7, 1, 3]),
                ([0, 1, 2], [3, 1, -4]),
            )
        ),
    ]
    instance = gspcli.instance(rows)
    home = np.eye(3), np.array([1.5, 0.01, 0.02])
    both = workspace(instance, *home, free=("x",), tolerance=1e-3)
    one = workspace(instance, *home, free=("x",), tolerance=1e-3, connected=True)
    assert contains(both.volume, 2 * (math.sqrt(4 - 5e-4) - math.sqrt(1 - 5e-4)))
    assert one.volume[1] <= both.volume[1] / 2 * 1.01
    assert one.extents[0, 1, 0] > 0.9


def test_nothing_is_reachable():
    found = workspace(study(legs=(10, 20)), *HOME)
    assert found.volume == (0, 0)
    assert found.gap == 0
    assert np.isnan(found.extents).all()


def test_a_fixed_link_leaves_no_volume():
    found = workspace(one_leg((2, 2)), *HOME, tolerance=0.1, most_boxes=20_000)
    assert found.volume[0] == 0
    assert found.volume[1] > 0


def test_threads_change_nothing():
    one, two = (workspace(study(), *HOME, tolerance=0.2, jobs=jobs) for jobs in (1, 2))
    assert np.array_equal(one.inner, two.inner)
    assert np.array_equal(one.open, two.open)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"free": ()}, "free: found nothing, expected one or more of x, y, z, rx, ry, rz"),
        ({"free": ("x", "x")}, "free: found x, x, expected"),
        ({"free": ("x", "q")}, "free: found x, q, expected"),
        ({"free": ("x", "x")}, "expected one or more"),
        ({"within": {"rx": (0, 1)}}, "within: found rx, expected a parameter that varies: x, y, z"),
        ({"within": {"x": (1, 1)}}, r"within\[x\]: found \(1, 1\), expected a finite interval"),
        ({"free": ("rx",), "within": {"rx": (-200, 0)}}, "expected at most a whole turn"),
        ({"sequence": "xx"}, "Euler sequence"),
        ({"R": np.ones((3, 3))}, "R: found a matrix that is no rotation"),
        ({"R": np.full((3, 3), np.nan)}, "not finite"),
        ({"T": np.zeros(2)}, "expected"),
        ({"connected": True, "T": [0, 0, 900]}, "home does not keep the limits"),
    ],
)
def test_mistakes(arguments, message):
    given = {"R": np.eye(3), "T": np.array([0, 0, 80.0]), **arguments}
    R, T = given.pop("R"), given.pop("T")
    with pytest.raises((ArgumentError, gspcli.GspError), match=message):
        workspace(study(), R, T, **given)


def test_without_limits_or_bounds():
    instance, R, T = limited("6PL", 1)
    with pytest.raises(ArgumentError, match="no leg with a range bounds x"):
        workspace(instance, R, T)
    assert workspace(instance, R, T, within=NEAR, most_boxes=1000).volume[1] <= 216 * (1 + 1e-8)
    free = gspcli.set_values(gspcli.loads(gspcli.dumps(one_leg())), [])
    rows = [gspcli.distance(row.platform, row.base, row.value) for row in free.constraints]
    with pytest.raises(ArgumentError, match="no constraint has a range and no joint a cone"):
        workspace(gspcli.instance(rows), *HOME)


def test_a_rotation_is_judged_alike_by_all_its_angles():
    """With the middle angle beyond a right angle, and by whole turns."""
    angles = ("rx", "ry", "rz")
    instance = one_leg((1, 3), base=(0, 0, -2), platform_cone=gspcli.Cone([1, 2, 2], 60))
    found = workspace(instance, *HOME, free=angles, tolerance=0.5)
    low, high = (found.bounds / found.units[:, None]).T
    points = np.random.default_rng(3).uniform(low, high, (2000, 3))
    verdicts = found.judged_at(points)
    assert {-1, 1} <= set(verdicts.tolist())
    half = math.pi / found.units
    other = points + half
    other[:, 1] = half[1] - points[:, 1]
    assert (found.judged_at(other) == verdicts).all()
    assert (found.judged_at(points + 2 * half * [1, 0, -1]) == verdicts).all()


def test_a_pose_of_six_numbers_is_judged_alike_by_all_its_angles():
    leg = one_leg((1, 2), base=(1, -2, 0.5))
    found = workspace(leg, *HOME, free=PARAMETERS, tolerance=0.95, most_boxes=400_000)
    low, high = (found.bounds / found.units[:, None]).T
    points = np.random.default_rng(4).uniform(low, high, (500, 6))
    other = points.copy()
    other[:, 3:] += 180
    other[:, 4] = 180 - points[:, 4]
    assert {-1, 1} <= set(found.judged_at(points).tolist())
    assert (found.judged_at(other) == found.judged_at(points)).all()


# Poses at which legs and bodies are far enough apart: boxes and travels against samples.


HOME_OF_GAPS_OF_BOXES = np.eye(3), np.array([0.0, 0.0, 400.0])


@pytest.mark.parametrize(
    ("free", "gap", "near"),
    [
        (("x", "rz"), 12.0, None),
        (("z", "rz"), 10.0, None),
        (("rx", "ry"), 15.0, None),
        (("x", "rz"), 10.0, 30.0),
    ],
)
def test_no_sample_contradicts_a_box(free, gap, near):
    instance = thick("workspace-study", near)
    found = workspace(
        instance, *HOME_OF_GAPS_OF_BOXES, free=free, gap=gap, tolerance=0.1, most_boxes=20_000
    )
    points = np.random.default_rng(1).uniform(*found.bounds.T, (20_000, len(free)))
    judged = found.judged_at(points / found.units)
    parameters = np.tile(found.boxes.home, (len(points), 1))
    parameters[:, [PARAMETERS.index(name) for name in free]] = points
    R, T = found.boxes.poses(parameters)
    kept = Machine.of(instance).keeps(R, T)
    gaps = ComparedShapes(instance).bounds(R, T)
    apart, near_ = (gaps.low >= gap).all(axis=1), (gaps.high < gap).any(axis=1)
    # The gap matters: some poses violate nothing else.
    assert (kept & near_).sum() > 20
    assert (judged == 1).sum() > 20
    assert not (near_ & (judged == 1)).any()
    assert not (kept & apart & (judged == -1)).any()
    free_of_it = workspace(
        instance, *HOME_OF_GAPS_OF_BOXES, free=free, tolerance=0.1, most_boxes=20_000
    )
    assert found.volume[1] <= free_of_it.volume[1]


def test_travels_end_where_legs_are_too_near():
    instance, gap = thick("workspace-study"), 15.0
    compared = ComparedShapes(instance)
    (plain,) = travels(instance, *HOME_OF_GAPS_OF_BOXES, axes=["rz"])
    (found,) = travels(instance, *HOME_OF_GAPS_OF_BOXES, axes=["rz"], gap=gap)
    assert found.reached[1] < plain.reached[1]
    assert found.stops[1] == ("gap",)
    end = np.radians(found.reached[1])
    for share, ok in ((1 - 1e-6, True), (1 + 1e-4, False)):
        c, s = np.cos(end * share), np.sin(end * share)
        R = np.array([[[c, -s, 0], [s, c, 0], [0, 0, 1]]])
        assert (compared.bounds(R, HOME_OF_GAPS_OF_BOXES[1][None]).low.min() >= gap) == ok


def test_home_must_keep_the_gap_and_the_platform_must_state_shapes():
    with pytest.raises(ArgumentError, match="the gap between legs 1 and 6 is 23"):
        travels(thick("workspace-study"), *HOME_OF_GAPS_OF_BOXES, gap=30.0)
    with pytest.raises(ArgumentError, match="states no shapes"):
        workspace(example("workspace-study"), *HOME_OF_GAPS_OF_BOXES, gap=1.0)
    with pytest.raises(ArgumentError, match="expected a finite number"):
        workspace(thick("workspace-study"), *HOME_OF_GAPS_OF_BOXES, gap=np.nan)
    with pytest.raises(ArgumentError, match="home does not keep"):
        workspace(
            thick("workspace-study"), *HOME_OF_GAPS_OF_BOXES, free=("x",), gap=30.0, connected=True
        )


def test_part_connected_with_home():
    instance = thick("workspace-study")
    whole = workspace(instance, *HOME_OF_GAPS_OF_BOXES, free=("x", "rz"), gap=10.0, tolerance=0.05)
    part = workspace(
        instance, *HOME_OF_GAPS_OF_BOXES, free=("x", "rz"), gap=10.0, tolerance=0.05, connected=True
    )
    assert 0 < part.volume[0] <= whole.volume[1]
