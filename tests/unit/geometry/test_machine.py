"""Drives against differences: points, gains, inverse, rates, shared carriages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.kinds import DLP, DPH, DPL, DPP, KINDS_BY_NAME
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.instance import AngleUnit, Constraint, HomePose, Instance, Side, Units
from gspcli.geometry.machine import Machine, value_machine
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Cone, Crank, Line, Plane, Point, Slide
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec.reading import load, loads
from tests.support.surface_machines import print_bed

UNITS = Units("mm", AngleUnit.DEGREE)
HOME = HomePose([0.01, -0.02, 0.6])


def rod(platform, base, k, home=HOME):
    """Return a rod of the length that it has at home."""
    length = np.linalg.norm(platform.point + home.T - base.point)
    return Constraint(
        DPP, platform, base, Number.of(float(length)), platform_name=f"P{k}", base_name=f"B{k}"
    )


def mixed():
    """Two cranks on the platform, two on the base, a slide on each, and one value."""
    rng = np.random.default_rng(11)
    turns = np.radians([-10, 10, 110, 130, 230, 250])
    base = np.stack((0.5 * np.cos(turns), 0.5 * np.sin(turns), np.full(6, 0.15)), 1)
    turns = np.radians([-45, 45, 75, 165, 195, 285])
    platform = np.stack((0.2 * np.cos(turns), 0.2 * np.sin(turns), np.zeros(6)), 1)
    rows = []
    for k, (p, b) in enumerate(zip(platform, base, strict=True)):
        on_platform, sort = k in (0, 1, 4), ("crank", "crank", "crank", "crank", "slide", "")[k]
        place = p if on_platform else b
        axis = rng.normal(size=3)
        drive = {}
        if sort == "crank":
            arm = np.cross(axis, rng.normal(size=3))
            drive = {"crank": Crank(place - 0.06 * arm / np.linalg.norm(arm), axis)}
        elif sort:
            drive = {"slide": Slide(axis)}
        ends = (
            Point(p, **(drive if on_platform else {})),
            Point(b, **({} if on_platform else drive)),
        )
        row = rod(*ends, k)
        # A value without a crank or slide has a motor only if it has a range.
        reach = None if sort else (Number.of(0.1), Number.of(2))
        rows.append(replace(row, limits=reach))
    return Instance(tuple(rows), UNITS, home=HOME)


DELTA = (
    """\
gsp: 1
units: {length: m, angle: deg}
platform:
  P1: {point: [-0.03, 0.05, 0]}
  P2: {point: [0.03, 0.05, 0]}
  P3: {point: [-0.02, -0.05, 0]}
  P4: {point: [-0.05, 0, 0]}
  P5: {point: [0.05, 0, 0]}
  P6: {point: [0.02, -0.05, 0]}
base:
  B1: {point: [-0.03, 0.2, 0], slide: {direction: [0, 0, 2], range: [-0.15, 0.15]}}
  B2: {point: [0.03, 0.2, 0], with: B1}
  B3: {point: [-0.17, -0.15, 0], slide: {direction: [0, 0, 1]}}
  B4: {point: [-0.2, -0.1, 0], with: B3}
  B5: {point: [0.2, -0.1, 0], slide: {direction: [0, 0, 1]}}
  B6: {point: [0.17, -0.15, 0], with: B5}
constraints:
"""
    + "".join(f"  - {{distance: [P{k}, B{k}], value: home}}\n" for k in range(1, 7))
    + """\
home: {position: [0, 0, -0.25]}
"""
)


def poses(count, spread=0.02, at=None, seed=3):
    rng = np.random.default_rng(seed)
    R = rotation_from_euler("xyz", rng.normal(size=(count, 3)) * spread * 3)
    return R, (HOME.T if at is None else at) + rng.normal(size=(count, 3)) * spread


def moved(R, T, twist, s):
    """Return a pose after a twist for a time."""
    omega, v = twist[:3], twist[3:]
    angle = np.linalg.norm(omega) * s
    x, y, z = omega / np.linalg.norm(omega)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return (np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K) @ R, T + s * v


def machines():
    heads = [load(instance_files()[name]) for name in ("reachy-mini-head", "t-top-head")]
    return [mixed(), *heads]


@pytest.mark.parametrize("instance", machines(), ids=["mixed", "reachy", "t-top"])
def test_poses_and_drives_agree(instance):
    drives = Machine.of(instance)
    size = instance.home.T[2] / 6
    R, T = poses(200, size / 20, instance.home.T)
    q = drives.inverse(R, T)
    reached = np.isfinite(q).all(axis=1)
    assert reached.mean() > 0.3
    R, T, q = R[reached], T[reached], q[reached]
    _, _, r = drives.ends(R, T, q)
    lengths = np.linalg.norm(r, axis=-1)
    known = drives.driven
    np.testing.assert_allclose(
        lengths[:, known], np.broadcast_to(drives.rods, lengths.shape)[:, known], rtol=1e-13
    )
    np.testing.assert_allclose(lengths[:, ~known], q[:, ~known], rtol=1e-13)
    # The working mode is the sign of the gain, at all poses.
    g = drives.gains(R, T, q)
    assert (np.sign(g) == drives.home_working_modes).all()
    both = drives.roots(R, T)
    for j, sign in ((0, 1), (1, -1)):
        signs = np.sign(drives.gains(R, T, both[..., j]))
        assert (signs[:, known] == sign).all()


@pytest.mark.parametrize("instance", machines(), ids=["mixed", "reachy", "t-top"])
def test_rates_and_the_matrix_against_differences(instance):
    drives = Machine.of(instance)
    R, T = instance.home.R(1.0), instance.home.T
    twist = np.array([0.3, -0.2, 0.25, *(0.1 * T[2] * np.array([1.0, -2, 0.5]))])
    q = drives.inverse(R, T)
    h = 1e-4
    before, after = (drives.inverse(*moved(R, T, twist, s)) for s in (-h, h))
    first, second = drives.rates(R, T, q, twist)
    np.testing.assert_allclose(first, (after - before) / (2 * h), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(second, (after - 2 * q + before) / h**2, rtol=1e-3, atol=1e-4)
    # J t = D q', and the motion of a moved instance measures the same.
    J, D = drives.jacobian(R, T, q), drives.matrix(drives.gains(R, T, q))
    np.testing.assert_allclose(J @ twist, D @ first, atol=1e-12)
    there = Arrangement.of(drives.instance_at(q))
    np.testing.assert_allclose(measured(there, R, T), there.values, rtol=1e-12)
    np.testing.assert_allclose(jacobian(there, R, T), J, atol=1e-12)


def test_the_change_of_the_twist_acts_on_the_second_derivative_as_the_twist_on_the_first():
    drives = Machine.of(mixed())
    R, T = HOME.R(1.0), HOME.T
    q = drives.inverse(R, T)
    twist, change = np.random.default_rng(5).normal(size=(2, 6))
    still = drives.rates(R, T, q, twist)[1]
    np.testing.assert_allclose(
        drives.rates(R, T, q, twist, change)[1] - still, drives.rates(R, T, q, change)[0], rtol=1e-9
    )


@pytest.mark.parametrize("name", ["DPP", "DPL", "DPH", "DLP", "DHP"])
@pytest.mark.parametrize("sort", ["crank", "slide"])
def test_gains_of_all_kinds_with_a_point_against_differences(name, sort):
    kind, rng = KINDS_BY_NAME[name], np.random.default_rng(8)
    drive = {
        sort: Crank(*rng.normal(size=(2, 3))) if sort == "crank" else Slide(rng.normal(size=3))
    }
    make = {"P": Point, "L": Line, "H": Plane}

    def primitive(letter, driven):
        vectors = rng.normal(size=(2, 3))
        return (
            Point(vectors[0], **(drive if driven else {}))
            if letter == "P"
            else make[letter](*vectors)
        )

    platform = primitive(name[1], driven=name[1] == "P")
    base = primitive(name[2], driven=name[1] != "P")
    rest = mixed().constraints[1:]
    instance = Instance((Constraint(kind, platform, base, Number.of(1)), *rest), UNITS)
    drives = Machine.of(instance)
    R, T = poses(1, 0.3)
    h, q = 1e-6, np.zeros((1, 6))
    step = np.eye(6)[0] * h
    more, less = (measured(drives.arrangement(q + s), R, T)[..., 0] for s in (step, -step))
    # The value changes by minus the gain when the drive moves and the pose stays.
    np.testing.assert_allclose(-drives.gains(R, T, q)[:, 0], (more - less) / (2 * h), rtol=1e-7)
    if kind in (DPL, DLP):
        with pytest.raises(
            ArgumentError, match=rf"^{sort}\.1: constraint 1 of its point is {name}"
        ):
            drives.inverse(R, T)
    if kind.has_sides:
        with pytest.raises(ArgumentError, match=r"on both sides of a plane, expected a side"):
            drives.inverse(R, T)
        for side in (Side.POSITIVE, Side.NEGATIVE):
            row = replace(instance.constraints[0], side=side, value=Number.of(0.05))
            on_side = Machine.of(replace(instance, constraints=(row, *rest)))
            both = on_side.roots(R, T)[:, 0]
            for j, sign in enumerate((1, -1)):
                q = np.concatenate((both[:, j : j + 1], np.zeros((1, 5))), axis=1)
                at = measured(on_side.arrangement(q), R, T)[0, 0]
                assert at == pytest.approx(0.05 if side is Side.POSITIVE else -0.05, abs=1e-12)
                if sort == "crank":
                    assert np.sign(on_side.gains(R, T, q)[0, 0]) == sign
                twist, step = rng.normal(size=6), 1e-4
                ways = [on_side.roots(*moved(R[0], T[0], twist, s))[0, j] for s in (-step, 0, step)]
                first, second = (part[0, 0] for part in on_side.rates(R, T, q, twist[None]))
                assert (ways[2] - ways[0]) / (2 * step) == pytest.approx(first, rel=1e-5)
                bent = (ways[2] - 2 * ways[1] + ways[0]) / step**2
                assert bent == pytest.approx(second, rel=1e-4, abs=1e-5)


def test_balls_in_grooves_of_a_bed():
    """The bed for slides at -0.695, 1.052 and 0.328, by `gsp track`, has these numbers again."""
    machine = print_bed()
    drives = Machine.of(machine)
    slides = np.array([-0.695, 1.052, 0.328])
    there = drives.instance_at(slides)
    T = np.array([0.00531032, 0.000997795, -1.57703])
    found = min(solve(there).real_solutions, key=lambda one: np.linalg.norm(one.T.real - T))
    np.testing.assert_allclose(found.T.real, T, atol=5e-6)
    np.testing.assert_allclose(drives.inverse(found.R.real, found.T.real), slides, atol=1e-10)
    # The two planes of a groove ask for two numbers where no bed can be.
    off = found.T.real + np.array([0, 0.01, 0])
    assert np.isnan(drives.inverse(found.R.real, off)).tolist() == [True, True, True]


def test_points_of_a_carriage_share_a_drive():
    instance = loads(DELTA)
    drives = Machine.of(instance)
    assert drives.names == ("slide.B1", "slide.B3", "slide.B5")
    assert drives.index.tolist() == [0, 0, 1, 1, 2, 2]
    R, T = np.eye(3), np.array([0.01, -0.005, -0.26])
    q = drives.inverse(R, T)
    assert q.shape == (3,)
    assert np.isfinite(q).all()
    J, D = drives.jacobian(R, T, q), drives.matrix(drives.gains(R, T, q))
    assert D.shape == (6, 3)
    # Motors move the platform without turning it, and the forces do the same work.
    twists = np.linalg.solve(J, D)
    np.testing.assert_allclose(twists[:3], 0, atol=1e-12)
    h = 1e-6
    for k in range(3):
        t = twists[:, k]
        rates = drives.rates(R, T, q, t)[0]
        np.testing.assert_allclose(rates, np.eye(3)[k], atol=1e-12)
        there = drives.inverse(R, T + h * t[3:])
        np.testing.assert_allclose((there - q) / h, np.eye(3)[k], atol=1e-4)
    # A turned platform asks for two numbers of one carriage.
    R = rotation_from_euler("xyz", np.array([0.02, 0.01, 0.03]))
    assert np.isnan(drives.inverse(R, T)).any()
    wanted = drives.wanted(R, T)
    assert np.ptp(wanted.reshape(3, 2), axis=1).max() > 1e-4


def test_out_of_reach_is_nan_and_the_edge_is_reached():
    row = rod(Point([0, 0, 0]), Point([1, 0, 0], slide=Slide([0, 0, 1])), 1, HomePose([0, 0, 0.5]))
    instance = Instance((row, *mixed().constraints[1:]), UNITS, home=HomePose([0, 0, 0.5]))
    drives = Machine.of(instance)
    length = row.value.value
    for off, reached in ((1e-3, False), (1e-14, True), (-1e-3, True)):
        T = np.array([1 - length * (1 + off), 0, 0.2])
        both = drives.roots(np.eye(3), T)[0]
        assert np.isfinite(both).all() == reached
        if abs(off) < 1e-9:
            np.testing.assert_allclose(both, 0.2, atol=1e-6)


def test_the_working_mode_is_that_of_home_or_of_the_first_pose():
    instance = load(instance_files()["t-top-head"])
    T = instance.home.T
    drives = Machine.of(instance)
    free = Machine.of(replace(instance, home=None))
    assert free.home_working_modes is None
    np.testing.assert_array_equal(free.inverse(np.eye(3), T), drives.inverse(np.eye(3), T))
    other = -drives.home_working_modes
    assert (np.sign(drives.gains(np.eye(3), T, drives.inverse(np.eye(3), T, other))) == other).all()
    assert (
        np.abs(drives.inverse(np.eye(3), T)).max()
        < np.abs(drives.inverse(np.eye(3), T, other)).min()
    )


def test_numbers_equally_near_to_the_stated_point_are_refused():
    # The arm is stated across its dead point: both angles are 30 degrees away.
    base = Point([0.1, 0, 0], crank=Crank([0, 0, 0], [0, 1, 0]))
    row = replace(
        rod(Point([0, 0, 0]), base, 1),
        value=Number.of(float(np.hypot(*(0.5 - 0.1 * np.cos(np.pi / 6), 0.1 * np.sin(np.pi / 6))))),
    )
    instance = Instance((row, *mixed().constraints[1:]), UNITS)
    with pytest.raises(
        ArgumentError, match=r"^crank.B1: home is reached at -30 and at 30, equally near"
    ):
        Machine.of(instance).working_modes(np.eye(3), np.array([0.5, 0, 0]), "home")
    with pytest.raises(ArgumentError, match=r"^crank.B1: rod 1 does not reach home"):
        Machine.of(instance).working_modes(np.eye(3), np.array([5, 0, 0]), "home")


def test_two_drives_on_a_constraint_are_refused():
    slide = Slide([0, 0, 1])
    row = rod(Point([0, 0, 0], slide=slide), Point([1, 0, 0], slide=slide), 1)
    instance = Instance((row, *mixed().constraints[1:]), UNITS)
    with pytest.raises(ArgumentError, match=r"constraint 1 has drives at both ends \(P1 and B1\)"):
        Machine.of(instance)


def test_ranges_tolerances_and_readings_have_the_units_of_the_file():
    crank = Crank([0, 0, 0], [0, 1, 0], limits=[-30, 90], tolerance=0.5, offset=10, scale="-0.5")
    row = rod(Point([0, 0, 0]), Point([0.1, 0, 0], crank=crank), 1)
    angle = Constraint(
        KINDS_BY_NAME["ALL"],
        *[Line([0, 0, 0], v) for v in ([1, 0, 0], [0, 1, 0])],
        Number.of(90),
        limits=(Number.of(60), Number.of(120)),
        tolerance=Number.of(1),
    )
    plane = Constraint(
        DPH,
        Point([0, 0, 1]),
        Plane([0, 0, 0], [0, 0, 1]),
        Number.of(2),
        limits=(Number.of(1), Number.of(3)),
    )
    instance = Instance((row, angle, plane, *mixed().constraints[3:]), UNITS)
    drives = Machine.of(instance)
    np.testing.assert_allclose(drives.low[:3], [-np.pi / 6, np.pi / 3, 1])
    np.testing.assert_allclose(drives.high[:3], [np.pi / 2, 2 * np.pi / 3, 3])
    np.testing.assert_allclose(drives.tolerances[:3], [np.pi / 360, np.pi / 180, np.nan])
    q = drives.from_readings([40, 90, 2, 0, 0, 1])
    np.testing.assert_allclose(q[:3], [np.radians(30), np.pi / 2, 2])
    np.testing.assert_allclose(drives.readings(q), [40, 90, 2, 0, 0, 1], atol=1e-13)


def test_angles_of_a_crank_with_a_range_are_nearest_to_its_middle():
    base = Point([0.1, 0, 0], crank=Crank([0, 0, 0], [0, 1, 0], limits=[100, 300]))
    row = rod(Point([0, 0, 0]), base, 1, HomePose([-0.5, 0.0, 0.3]))
    drives = Machine.of(Instance((row, *mixed().constraints[1:]), UNITS))
    both = np.degrees(drives.roots(np.eye(3), np.array([-0.5, 0.01, 0.31]))[0])
    assert (both > 20).all()
    assert (both < 380).all()


def test_a_cone_turns_with_its_arm_and_a_carriage_leaves_it():
    cone = Cone([1, 0, 0], 30)
    turned = Point([1, 0, 0], cone, Crank([0, 0, 0], [0, 0, 1])).moved(np.pi / 2)
    np.testing.assert_allclose(turned.cone.unit, [0, 1, 0], atol=1e-15)
    assert turned.drive is None
    shifted = Point([1, 0, 0], cone, slide=Slide([0, 0, 5])).moved(2.0)
    assert shifted == Point([1, 0, 2], cone)


def test_platforms_without_cranks_and_slides_have_their_values_as_drives():
    instance = load(instance_files()["nano-hexapod"])
    drives = Machine.of(instance)
    assert not drives.moves
    assert drives.names == ("1", "2", "3", "4", "5", "6")
    R, T = np.eye(3), np.array([0.001, 0, 0.1])
    arrangement = Arrangement.of(instance)
    np.testing.assert_array_equal(drives.inverse(R, T), measured(arrangement, R, T))
    assert (drives.gains(R, T, drives.inverse(R, T)) == 1).all()


def test_tilts_at_drives_are_those_of_the_moved_platform():
    base = [replace(row.base, cone=Cone([0.2, 0.1, 1], 40)) for row in mixed().constraints]
    rows = mixed().constraints
    platform = [replace(row.platform, cone=Cone([0.1, 0, -1], 40)) for row in rows]
    rows = [
        replace(row, base=b, platform=p) for row, b, p in zip(rows, base, platform, strict=True)
    ]
    instance = replace(mixed(), constraints=tuple(rows))
    drives = Machine.of(instance)
    R, T = poses(1, 0.004)
    q = drives.inverse(R, T)[0]
    assert np.abs(q).max() > 0.05
    there = drives.instance_at(q)
    tilts, still = drives.tilts(R, T, q), value_machine(instance)
    np.testing.assert_allclose(tilts, Machine.of(there).tilts(R, T), rtol=1e-12)
    assert np.rad2deg(np.abs(tilts - still.tilts(R, T))).max() > 1


def test_shares_of_motors_are_above_one_outside_and_infinite_out_of_reach():
    row = rod(Point([0, 0, 0]), Point([1, 0, 0], slide=Slide([0, 0, 1], [-0.2, 0.4])), 1)
    drives = Machine.of(Instance((row, *mixed().constraints[1:]), UNITS))
    q = np.zeros((6, 6))
    q[:, 0] = [0.1, 0.4, 0.4 * (1 + 1e-14), 0.4001, -0.35, np.nan]
    shares = drives.range_shares(q)
    np.testing.assert_allclose(shares[:, 0], [0, 1, 1, 1 + 0.0001 / 0.3, 1.5, np.inf])
    assert drives.outside(q)[:, 0].tolist() == [False, False, False, True, True, True]
    assert np.isnan(shares[:, 1:-1]).all()
    # A value of zero is outside the range of the last drive, which is one.
    assert (shares[:, -1] > 1).all()


def test_modes_in_another_working_mode_than_home_are_not_those_of_the_machine():
    instance = load(instance_files()["reachy-mini-head"])
    found = solve(instance)
    drives = Machine.of(instance)
    left = {
        k.number: {one.constraint for one in k.limits if one.kind == "working mode"}
        for k in found.real_solutions
    }
    assert left[found.home.number] == set()
    zero = np.zeros(6)
    for pose in found.real_solutions:
        gains = drives.gains(pose.R, pose.T, zero)
        assert left[pose.number] == set(np.flatnonzero(gains * drives.home_working_modes < 0))
        # In the working modes of home the inverse kinematics of the others has other angles.
        q = drives.inverse(pose.R, pose.T)
        assert set(np.flatnonzero(np.abs(q) > 1e-6)) == left[pose.number]
    assert any(left.values())
    free = solve(replace(instance, home=None))
    assert not any(
        one.kind == "working mode" for k in free.real_solutions for one in k.limits or ()
    )
