"""None"""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import PoseFormat, track
from gspcli.motion.files.value_files import nominal_values
from gspcli.motion.singularities.scans import (
    Axis,
    Scan,
    VariedNumbers,
    VariedPoses,
    boundaries,
    boundary,
    scan_grid,
    scanned,
)
from gspcli.motion.statics.wrenches import wrenches
from gspcli.resources import data_path

POSE = (0, 0, 0.5, 1, 0.2, 0.1, 0)


@pytest.fixture(scope="module")
def hexapod():
    return gspcli.load(data_path("examples", "platform-6-6.yaml"))


def axis(name, low, high, count):
    return Axis(name, tuple(np.linspace(low, high, count).tolist()))


def test_determinants_are_the_manipulability_with_a_sign(hexapod):
    rng = np.random.default_rng(3)
    other = random_instance(gspcli.parse_type("PL LP PH DLL ALL ALH"), rng)[0]
    for instance in (hexapod, other):
        axes = (axis("x", -2, 2, 7), axis("z", -1, 2, 5))
        varied = VariedPoses(instance, axes, POSE, PoseFormat())
        determinants, conditions = scan_grid(varied).numbers.values()
        R, T = varied.poses(varied.nodes.reshape(-1, 2))
        sizes = wrenches(instance, R, T).manipulability.reshape(7, 5)
        assert np.allclose(np.abs(determinants), sizes, rtol=1e-9)
        assert {-1, 1} == {*np.sign(determinants).ravel().tolist()}
        assert conditions.shape == (7, 5)


def test_the_singular_curve_separates_the_signs(hexapod):
    axes = (axis("x", -2, 2, 31), axis("y", -2, 2, 31))
    varied = VariedPoses(hexapod, axes, POSE, PoseFormat())
    found = scan_grid(varied)
    limits, signs = boundary(found), np.sign(found.numbers["determinant"])
    edges = sum(int((np.diff(signs, axis=k) != 0).sum()) for k in (0, 1))
    assert len(limits.crossings) == edges > 50
    points = np.concatenate([curve.values for curve in limits.curves])
    assert len(points) >= edges
    R, T = varied.poses(points)
    assert (wrenches(hexapod, R, T).conditions > 1e9).all()
    # The parts end on the border, or nowhere.
    for curve in limits.curves:
        ends = curve.values[[0, -1]]
        assert curve.closed or np.isclose(np.abs(ends), 2).any(axis=1).all()
        assert (np.linalg.norm(np.diff(curve.values, axis=0), axis=1) < 0.2).all()


def test_angles_and_one_coordinate(hexapod):
    form = PoseFormat("ZYX", (0.0, 0.0, 0.1), np.pi / 180)
    pose = (0, 0, 0.5, 10, 0, 0)
    found = scan_grid(VariedPoses(hexapod, (axis("rx", -180, 180, 73),), pose, form))
    determinants, limits = found.numbers["determinant"], boundary(found)
    assert determinants[0] == pytest.approx(determinants[-1])
    signs = np.diff(np.sign(determinants))
    assert [one.change for one in limits.crossings] == signs[signs != 0].tolist()
    assert len(limits.crossings) % 2 == 0
    assert limits.curves == []


@pytest.mark.parametrize(
    ("names", "pose", "error", "message"),
    [
        ("", POSE, ArgumentError, "expected one or two"),
        ("xx", POSE, ArgumentError, "expected one or two"),
        (["rx"], POSE, ArgumentError, "that the pose has: x y z qw"),
    ],
)
def test_mistakes(hexapod, names, pose, error, message):
    with pytest.raises(error, match=message):
        VariedPoses(hexapod, tuple(axis(name, 0, 1, 2) for name in names), pose, PoseFormat())


def grid(instance, axes, **more) -> Scan:
    return scan_grid(VariedNumbers(instance, axes), **more)


def test_counts_are_those_of_solve_and_change_at_proved_folds(hexapod):
    axis = Axis("1", tuple(np.linspace(2.3, 2.8, 11).tolist()))
    found = grid(hexapod, [axis])
    assert found.numbers["modes"].shape == (11,)
    for value, modes in zip(axis.values, found.numbers["modes"], strict=True):
        one = gspcli.solve(gspcli.set_values(hexapod, {1: value}))
        assert one.real.sum() == modes
    limits = boundary(found)
    assert not limits.unexplained
    assert not limits.curves
    assert len(list(boundaries(found))) == len(found.edges) + 1 > 1
    for edge in found.edges:
        low, high = edge[1], (edge[1][0] + 1,)
        here = [
            fold
            for fold in limits.crossings
            if axis.values[low[0]] <= fold.values[0] <= axis.values[high[0]]
        ]
        assert (
            sum(fold.change for fold in here)
            == found.numbers["modes"][high] - found.numbers["modes"][low]
        )
        for fold in here:
            (value,) = fold.values
            sides = [
                gspcli.solve(gspcli.set_values(hexapod, {1: value + step})).real.sum()
                for step in (-1e-7, 1e-7)
            ]
            assert sides[1] - sides[0] == fold.change


def test_two_values(hexapod):
    axes = [Axis("1", (2.4, 2.5, 2.6)), Axis("4", (1.9, 2.0))]
    found = grid(hexapod, axes)
    assert found.numbers["modes"].shape == found.numbers["condition"].shape == (3, 2)
    one = gspcli.set_values(hexapod, ["1=2.6", "4=2.0"])
    assert found.numbers["modes"][2, 1] == gspcli.solve(one).real.sum()


@pytest.mark.parametrize("axes", [[], [Axis("1", (1.0, 2.0))] * 2])
def test_mistakes_are_named(hexapod, axes):
    with pytest.raises(ArgumentError, match="axes: expected one or two different"):
        grid(hexapod, axes)


def test_the_discriminant_is_followed_as_curves_with_cusps(hexapod):
    axes = [
        Axis("1", tuple(np.linspace(1.9, 2.5, 7).tolist())),
        Axis("4", tuple(np.linspace(1.6, 2.2, 7).tolist())),
    ]
    found = grid(hexapod, axes)
    limits = boundary(found)
    assert not limits.unexplained
    assert 1 <= len(limits.curves) <= 5
    # On both sides of the curves, away from the folds that were proved, the numbers differ by two.
    sides = []
    for curve in limits.curves:
        values = curve.values[2:-2:20]
        ahead = curve.values[3:-1:20] - values
        normal = np.stack((-ahead[:, 1], ahead[:, 0]), axis=1)
        normal *= 1e-6 / np.linalg.norm(normal, axis=1, keepdims=True)
        for cusp in curve.cusps:
            # There the two sides are on the other branch, too.
            away = np.linalg.norm(values - cusp, axis=1) > 1e-4
            values, normal = values[away], normal[away]
        sides += [values - normal, values + normal]
    every = np.tile(nominal_values(hexapod), (sum(map(len, sides)), 1))
    every[:, [0, 3]] = np.concatenate(sides)
    batch = gspcli.solver.solve_batch(hexapod, every)
    assert batch.complete.all()
    modes = np.split(batch.real.sum(axis=1), np.cumsum([len(part) for part in sides])[:-1])
    for left, right in zip(modes[::2], modes[1::2], strict=True):
        assert (np.abs(left - right) == 2).all()
    # Where three modes meet the discriminant has a cusp.
    (cusp,) = np.concatenate([curve.cusps for curve in limits.curves if len(curve.cusps)])[:1]
    at = every[:1].copy()
    at[0, [0, 3]] = cusp
    (poses,) = gspcli.solve_values(hexapod, at + 1e-9)
    real, every_T = poses.T[poses.real].real, poses.T
    nearest = [np.sort(np.linalg.norm(every_T - T, axis=1))[:3].max() for T in real]
    assert min(nearest) < 0.02


def test_a_curve_that_the_numbers_at_the_nodes_do_not_tell_of_is_found(hexapod):
    # It enters the only cell through an edge and leaves through the same.
    axes = [Axis("1", (2.3162, 2.3562)), Axis("4", (1.6657, 1.6772))]
    found = grid(hexapod, axes)
    assert (found.numbers["modes"] == 0).all()
    limits = boundary(found)
    assert len(limits.curves) == 1
    assert not limits.unexplained
    first, last = sorted(limits.crossings, key=lambda one: one.values)
    assert (first.change, last.change) == (2, -2)
    assert first.values[1] == last.values[1] == 1.6772
    between = nominal_values(hexapod)
    between[[0, 3]] = (first.values[0] + last.values[0]) / 2, 1.6772
    assert gspcli.solver.solve_batch(hexapod, between[None]).real.sum() == 2
    (curve,) = limits.curves
    middle = curve.unknowns[len(curve.unknowns) // 2]
    # A pose and its direction have two signs each; elsewhere there is no curve.
    assert curve.contains(np.concatenate((-middle[:8], middle[8:])))
    assert not curve.contains(np.concatenate((middle[8:16], middle[:8], middle[16:])))


def test_pieces_can_be_done_apart(hexapod, monkeypatch):
    monkeypatch.setattr("gspcli.motion.singularities.scans._PIECE", 4)
    axes = [Axis("1", (2.4, 2.5, 2.6)), Axis("4", (1.9, 2.0))]
    whole = grid(hexapod, axes, clearance=True)
    part = Scan.of(VariedNumbers(hexapod, axes), clearance=True)
    assert part.pieces == 2
    assert not part.done.any()
    part.enter(scanned(part, 2003, 1))
    assert part.done.ravel().tolist() == [False] * 4 + [True] * 2
    assert np.array_equal(
        part.numbers["modes"].reshape(-1)[4:], whole.numbers["modes"].reshape(-1)[4:]
    )
    there = whole.numbers["modes"] > 0
    assert (whole.numbers["clearance"][there] > 0).all()
    assert np.isinf(whole.numbers["clearance"][~there]).all()


PLANAR = """
gsp: 1
name: planar platform, four poses
units: {length: m, angle: rad}
platform: {P1: {point: [0, 0, 0]}, P2: {point: [3, 0, 0]}, P3: {point: [3, 3, 0]}}
base:
  B1: {point: [0, 0, 0]}
  B2: {point: [5, 0, 0]}
  B3: {point: [0, 6, 0]}
  H: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
constraints:
  - {distance: [P1, B1], value: 5}
  - {distance: [P2, B2], value: 5}
  - {distance: [P3, B3], value: 3}
  - {distance: [P1, H], value: 0}
  - {distance: [P2, H], value: 0}
  - {distance: [P3, H], value: 0}
"""


def test_all_folds_of_a_planar_platform_whose_height_is_exactly_zero():
    """The sixth and seventh lie between the same two nodes, and cancel each other."""
    found = scan_grid(
        VariedNumbers(gspcli.loads(PLANAR), [Axis("2", tuple(np.linspace(3, 10, 141).tolist()))])
    )
    limits = boundary(found)
    assert not limits.unexplained
    values = sorted(fold.values[0] for fold in limits.crossings)
    known = [3.01858, 3.71053, 4.86372, 6.96734, 7.02234, 7.80001, 7.84909, 9.26238, 9.31023]
    assert np.allclose(values, known, atol=5.1e-6, rtol=0)
    changes = [fold.change for fold in sorted(limits.crossings, key=lambda fold: fold.values)]
    assert changes == [2, 2, 2, 2, -2, 2, -2, -2, -2]


def test_both_modes_of_a_fold_are_told_where_the_height_is_exactly_zero():
    rows = np.array([[5, 7.75, 3, 0, 0, 0], [5, 8.0, 3, 0, 0, 0]])
    events = track(gspcli.loads(PLANAR), rows).events
    assert {event.kind for event in events} == {"fold"}
    partners = {event.mode: event.partner for event in events}
    assert all(partners[other] == mode for mode, other in partners.items())


@pytest.mark.parametrize(
    ("name", "axis", "numbers", "poses", "folds"),
    [
        ("three-rps", Axis("1", (3.1, 3.2)), [], [], [2, 2]),
        ("delta", Axis("crank.B1", (-54.5, -54.3)), [(14, 16)], [(1, 3)], []),
    ],
)
def test_where_symmetries_let_several_modes_meet_their_numbers_are_told(
    name, axis, numbers, poses, folds
):
    instance = gspcli.example(name)
    limits = boundary(grid(instance, [axis]))
    assert not limits.unexplained
    assert [(one.before, one.after) for one in limits.meetings] == numbers
    assert [pose[:2] for one in limits.meetings for pose in one.poses] == poses
    assert [fold.change for fold in limits.crossings] == folds
    for one in limits.meetings:
        (low, high), (first, last) = (one.low[0], one.high[0]), axis.values
        assert first <= low < high <= last
        assert high - low < 1e-3 * (last - first)


BELOW = (
    PLANAR.replace("[P1, H], value: 0", "[P1, H], value: 0.5, side: negative")
    .replace("[P2, H], value: 0", "[P2, H], value: 0.2, side: positive")
    .replace("[P3, H], value: 0", "[P3, H], value: 0.1, side: positive")
    .replace("[3, 3, 0]", "[3, 3, 0.3]")
)


def test_folds_are_found_on_the_negative_side_of_a_plane():
    found = grid(gspcli.loads(BELOW), [Axis("4", (1.5, 1.75))])
    limits = boundary(found)
    assert found.numbers["modes"].tolist() == [6, 4]
    assert not limits.unexplained
    (fold,) = limits.crossings
    assert 1.5 < fold.values[0] < 1.75
    assert fold.T[2] == pytest.approx(-fold.values[0])


def test_a_negative_distance_is_no_value():
    with pytest.raises(ArgumentError, match="vary: found -1 for constraint 4, expected a distance"):
        grid(gspcli.loads(BELOW), [Axis("4", (-1.0, 1.0))])
