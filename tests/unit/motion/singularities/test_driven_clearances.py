"""Clearances of machines whose motors move points: what is proved, and each bound of the proof.

Bounds are compared with the equations of the machine with its motors elsewhere.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pytest

import gspcli
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion.following.branch_follower import MovingPlatform
from gspcli.motion.singularities.clearances import clearances, each_clearance, weights_of
from gspcli.motion.singularities.neighbourhoods import Box, MachineNeighbourhood, Norm
from gspcli.spec import loads
from tests.support.driven_clearances import examine
from tests.support.independent_machines import machines
from tests.support.surface_machines import cranked_bed, print_bed

#: A dead point is near home.
MIXED = """\
gsp: 1
name: mixed
units: {length: mm, angle: deg}
platform:
  P1: {point: [42.576062, -30.249146, 16.091117],
     crank: {centre: [63.602222, -46.986798, 0.607175], axis: [0.184, 0.139, -0.178],
      range: [-66.17, 56.69], offset: 2.126, scale: 0.0181}}
  P2: {point: [38.811105, 25.276231, 1.223771],
     slide: {direction: [0.951, 0.094, 0.153],
      range: [-58.8, 25.4], offset: 1.839, scale: -0.0358}}
  P3: {point: [12.128141, 76.800788, 0.338227]}
  P4: {point: [-66.937986, 1.833038, 1.139919],
     crank: {centre: [-68.10899, 28.844384, 0.803946], axis: [-1.487, -0.603, -0.165],
      range: [-68.89, 68.86]}}
  P5: {point: [-69.538327, -31.466816, -0.959097]}
  P6: {point: [30.52, -52.038, -7.317]}
base:
  B1: {point: [81.578478, -28.693209, 0.186669]}
  B2: {point: [78.401216, 28.689324, -1.618209]}
  B3: {point: [-32.142931, 71.127587, 0.693238],
     slide: {direction: [-0.66, 0.386, 0.327],
      range: [-57.7, 32.3]}}
  B4: {point: [-66.568881, 56.85693, 3.016455]}
  B5: {point: [-67.634617, -38.332776, -6.090122],
     crank: {centre: [-64.698303, -55.349713, -1.453277], axis: [-0.96, -0.077, -0.185],
      range: [-58.98, 64.85], offset: -2.77, scale: -0.0638}}
  B6: {point: [-14.167377, -86.044877, 3.019187]}
home: {position: [5.359109, 5.07488, 165.684429],
  quaternion: [0.9999727911105257, -0.0015999564657768414, 0.0030999156524426303,
  -0.006499823142218418]}
constraints:
  - {distance: [P1, B1], value: 184.59558960451068}
  - {distance: [P2, B2], value: 171.59050799750227}
  - {distance: [P3, B3], value: 172.9223693878272}
  - {distance: [P4, B4], value: 171.46530533429623}
  - {distance: [P5, B5], value: 171.85493853084944}
  - {distance: [P6, B6], value: 161.78877605547288,
     range: [128.99, 194.58], offset: 2.228, scale: 0.0215}
"""

MACHINES = ("reachy 60", "paradex", "6-PUS", "mixed")
#: Points at distances to planes.
BEDS = {
    "slides": print_bed,
    "cranks": cranked_bed,
    "slides of the platform": partial(cranked_bed, exchanged=True),
}


@pytest.fixture(params=[*MACHINES, *BEDS], scope="module")
def near(request) -> tuple[MachineNeighbourhood, Machine, np.ndarray]:
    if request.param in BEDS:
        drives, R, T = Machine.of(BEDS[request.param]()), np.eye(3), np.zeros(3)
    else:
        machine = machines()[request.param]()
        drives, R, T = Machine.of(machine.instance), machine.R, machine.T
    q = drives.inverse(R, T)
    return MachineNeighbourhood(drives, R, T, q), drives, q


def moved_hessians(near, drives, q, step) -> np.ndarray:
    """Return the matrices of the quadrics with all motors moved by a step, (6, 8, 8)."""
    there = drives.instance_at(q + step)
    platform = MovingPlatform(there, near.platform.local_frames)
    assert platform.scale == near.platform.scale
    return platform.equations.hessians[:, 0]


def steps(near, drives, size):
    """Yield moves of the motors, and how far they are in units of the equations."""
    for sign in (1, -1):
        step = sign * size * np.where(np.array(drives.sorts) == "slide", near.platform.scale, 1.0)
        yield step, near.widths(np.abs(step)[drives.index])


@pytest.mark.parametrize("size", [0.3, 0.03])
def test_bounds_hold_when_motors_move(near, size: float) -> None:
    near, drives, q = near
    z, driven = near.points[0], near.driven
    before = near.platform.equations.hessians[:, 0]
    for step, widths in steps(near, drives, size):
        change = moved_hessians(near, drives, q, step) - before
        first, whole = near._changes(widths[None])
        residual = np.abs(np.einsum("kij,i,j->k", change, z, z)) / 2
        assert (residual <= (whole * near.factors)[0] + 1e-12)[driven].all()
        # To first order it is the printed number; so the bounds are no larger than necessary.
        if size < 0.1:
            assert (residual >= (first * near.factors)[0] * 0.8 - 1e-3 * size)[driven].all()
        left, scales, _ = np.linalg.svd(near.inverse, full_matrices=False)
        for exponent in (0.0, 0.7):
            norm = Norm(left, (scales[:, :1] / scales) ** exponent, near.inverse)
            slopes = near._gradients(norm, whole, widths[None])
            exact = norm.slopes(np.einsum("kij,j->ki", change, z)[None])
            assert (exact <= slopes * whole + 1e-12)[0, driven].all()
        spread = near._spreads(whole, widths[None])[-1, 0, 1:]
        norms = np.abs(np.linalg.eigvalsh(change)).max(axis=1)
        assert (norms <= spread)[driven].all()


def test_working_modes_are_kept_where_that_is_said(near) -> None:
    """At the largest proved box some gain is nearly zero."""
    near, _, _ = near
    driven = near.driven
    rng = np.random.default_rng(2)
    closest = 1.0
    for radius in (0.0, 0.01, 0.05, 0.2, 0.4):
        number = np.array([radius])
        box = Box(np.array([0.5]), number, number, number, np.zeros((1, 6, 8)), number)

        def kept(size, box=box):
            return near.keeps_working_modes(size * np.ones((1, 6)), box)[0]

        low, high = 0.0, 4.0
        for _ in range(40):
            size = (low + high) / 2
            low, high = (size, high) if kept(size) else (low, size)
        if low == 0.0:
            continue
        for _ in range(150):
            part = rng.choice([-1.0, 1.0]) * rng.choice([1.0, rng.uniform()])
            cranks = near._cranks[:, None, None]
            turned = np.cos(low * part) * near.first + np.sin(low * part) * near.second
            slid = near.first + low * part * near.second
            gains = np.where(cranks, turned, slid)
            way = rng.normal(size=8)
            if rng.integers(2):
                way = np.einsum("kij,j->ki", gains, near.points[0])[rng.integers(6)]
            size = np.linalg.norm(way)
            z = near.points[0] + (radius * rng.choice([-1, 1]) * way / size if size else 0)
            now = np.einsum("kij,i,j->k", gains, z, z)[driven] / 2 / near._rates[0, driven]
            assert (now > 0).all()
            closest = min(closest, now.min())
    assert closest < 0.5


def test_gains_change_to_second_order_with_the_pose(near) -> None:
    """Where the pose moves along one line, what the gains differ from their linear part by."""
    near, _, _ = near
    z = near.points[0]
    for k in np.flatnonzero(near.driven):
        sizes, ways = np.linalg.eigh(near.first[k])
        way, far = ways[:, np.abs(sizes).argmax()], 0.1
        shifts = np.zeros((1, 6, 8))
        shifts[0, k] = far * way
        number = np.array([0.5])
        box = Box(number, number, number, np.array([far]), shifts, np.zeros(1))
        found = near.gains(np.zeros((1, 6)), box)
        for u in (-1, 1):
            x = z + u * far * way
            off = x @ near.first[k] @ x / 2 - found.mid[0, k, 0] - u * found.lin[0, k, 0, k]
            assert abs(off) <= found.rad[0, k] * (1 + 1e-12)
            assert abs(off) >= 0.99 * found.rad[0, k]


@pytest.mark.parametrize("name", MACHINES)
def test_no_random_change_contradicts(name: str) -> None:
    row = examine(name, 400)
    assert row.wrong == 0
    assert 0 < row.working_modes <= row.lower < row.fold_found
    assert row.working_modes < row.dead_point_found


def test_what_is_not_reached_has_no_clearance() -> None:
    machine = machines()["reachy 60"]()
    R, T = np.stack([machine.R] * 2), np.stack([machine.T, machine.T + 1.0])
    lower, working_modes = clearances(Machine.of(machine.instance), R, T)
    assert lower[0] > 0
    assert working_modes[0] > 0
    assert (lower[1], working_modes[1]) == (0, 0)
    far = each_clearance(Machine.of(machine.instance), R, T)[1]
    assert (far.lower, far.upper, far.ratio) == (0.0, np.inf, np.inf)


def _gains_at(drives, R, T, q, to):
    """Return the signs of the gains where all drives have moved straight, by small steps."""
    for part in np.linspace(0, 1, 61)[1:]:
        here = q + part * to
        arrangement = drives.arrangement(here)
        wanted = np.where(drives.driven, drives.rods, here[drives.index])
        for _ in range(6):
            twist = np.linalg.solve(
                drives.jacobian(R, T, here), wanted - measured(arrangement, R, T)
            )
            R, T = rotation_from_vector(twist[:3]) @ R, T + twist[3:]
    return np.sign(drives.gains(R, T, here))


def test_the_dead_point_is_the_nearest_on_the_lines_to_the_corners() -> None:
    instance = loads(MIXED)
    home = instance.home
    R, T = home.R(np.pi / 180), home.T
    drives = Machine.of(instance)
    units = weights_of(drives)[0]
    found = each_clearance(drives, R[None], T[None])[0]
    assert found.dead_point == pytest.approx(0.04324, abs=1e-5)
    assert drives.names[found.drive] == "slide.P2"
    q = drives.inverse(R, T)
    before = np.sign(drives.gains(R, T, q))
    nearer = []
    for signs in product((1.0, -1.0), repeat=6):
        size = 0.999 * found.dead_point
        assert (_gains_at(drives, R, T, q, size * np.array(signs) * units) == before).all()
        beyond = _gains_at(drives, R, T, q, 1.002 * found.dead_point * np.array(signs) * units)
        if (beyond != before).any():
            nearer.append(signs)
    assert nearer == [(-1.0, 1.0, 1.0, -1.0, 1.0, 1.0)]


@pytest.mark.parametrize("name", ["hexaglide", "delta"])
def test_the_fold_of_a_symmetric_machine_is_the_same_for_rounding_errors(name: str) -> None:
    """Its pose there is as good as singular, and the values that stay have not moved."""
    instance = gspcli.example(name)
    home = instance.home
    R, T = np.tile(home.R(instance.units.angle.in_radians), (4, 1, 1)), np.tile(home.T, (4, 1))
    T += 1e-15 * np.linalg.norm(T[0]) * np.random.default_rng(3).normal(size=T.shape)
    found = each_clearance(Machine.of(instance), R, T)
    assert np.allclose([one.numbers for one in found], found[0].numbers, rtol=1e-6)
    drives, one = Machine.of(instance), found[0]
    J = drives.jacobian(one.R, one.T, one.numbers)
    assert np.linalg.cond(J) > 1e4


def test_values_that_stay_do_not_move_towards_a_fold() -> None:
    instance = gspcli.example("three-prs")
    home = instance.home
    (found,) = each_clearance(Machine.of(instance), np.eye(3)[None], np.array([home.T]))
    there = Machine.of(instance).inverse(np.eye(3), home.T)
    assert np.abs(found.numbers[3:] - there[3:]).max() == 0
    assert found.upper == pytest.approx(0.6457513110, rel=1e-8)


@pytest.mark.parametrize(
    ("name", "by"),
    [
        ("three-prs", "fold"),
        ("reachy-mini-head", "fold"),
        ("t-top-head", "fold"),
        ("delta", "singular pose"),
        ("hexaglide", "singular pose"),
    ],
)
def test_simple_folds_at_the_ends_of_lines_are_proved(name: str, by: str) -> None:
    """Of symmetric machines more than two modes meet, which is seen only."""
    instance = gspcli.example(name)
    home, drives = instance.home, Machine.of(instance)
    R = home.R(instance.units.angle.in_radians)
    (found,) = each_clearance(drives, R[None], np.array([home.T]))
    assert found.by == by
    singular = np.linalg.svd(drives.jacobian(found.R, found.T, found.numbers), compute_uv=False)
    assert singular[-1] < (1e-6 if by == "fold" else 1e-3) * singular[0]
    assert gspcli.clearance(instance, R[None], home.T[None]).rows()[0]["by"] == by


def test_a_dead_point_close_to_the_end_of_a_line_is_found() -> None:
    instance = gspcli.example("reachy-mini-head")
    home = instance.home
    (found,) = each_clearance(Machine.of(instance), home.R(1.0)[None], np.array([home.T]))
    assert found.dead_point == pytest.approx(0.774095, abs=1e-5)


@pytest.mark.parametrize(("name", "without"), [("three-prs", 0.0935), ("three-rps", 0.1606)])
def test_values_that_stay_have_no_weight_in_the_proof(name: str, without: float) -> None:
    """With them able to change less was proved; still nothing within the bound is singular."""
    instance = gspcli.example(name)
    home, drives = instance.home, Machine.of(instance)
    R0, T0 = home.R(instance.units.angle.in_radians), home.T
    (found,) = each_clearance(drives, R0[None], np.array([T0]))
    assert 1.5 * without < found.lower < found.upper
    q, units = drives.inverse(R0, T0), weights_of(drives)[0]
    still = drives.fixed[drives.first]
    assert np.abs(found.numbers - q)[still].max() == 0
    sign = np.sign(np.linalg.det(drives.jacobian(R0, T0, q)))
    for way in product((-1.0, 1.0), repeat=3):
        R, T = R0, T0
        for part in np.linspace(0, found.lower, 21)[1:]:
            there = q + part * units * np.array([*way, 0, 0, 0])
            wanted = np.where(drives.driven, drives.rods, there[drives.index])
            for _ in range(8):
                off = wanted - measured(drives.arrangement(there), R, T)
                twist = np.linalg.solve(drives.jacobian(R, T, there), off)
                R, T = rotation_from_vector(twist[:3]) @ R, T + twist[3:]
            assert np.abs(off).max() < 1e-9
            assert np.sign(np.linalg.det(drives.jacobian(R, T, there))) == sign


@pytest.mark.parametrize("bed", [print_bed, cranked_bed], ids=["slides", "cranks"])
def test_within_the_clearance_of_a_bed_no_pose_is_singular(bed) -> None:
    """Followed by Newton's method to random corners of the box that is proved."""
    drives, rng = Machine.of(bed()), np.random.default_rng(3)
    R0, T0 = np.eye(3), np.zeros(3)
    (found,) = each_clearance(drives, R0[None], T0[None])
    assert found.lower > 0.01
    assert found.upper == np.inf
    q, units = drives.inverse(R0, T0), weights_of(drives)[0]
    sign = np.sign(np.linalg.det(drives.jacobian(R0, T0, q)))
    gains = np.sign(drives.gains(R0, T0, q))
    for way in rng.choice([-1.0, 1.0], size=(12, drives.count)):
        R, T = R0, T0
        for part in np.linspace(0, found.lower, 21)[1:]:
            there = q + part * way * units
            for _ in range(8):
                arrangement = drives.arrangement(there)
                off = drives.rods - measured(arrangement, R, T)
                twist = np.linalg.solve(drives.jacobian(R, T, there), off)
                R, T = rotation_from_vector(twist[:3]) @ R, T + twist[3:]
            assert np.abs(off).max() < 1e-9
            assert np.sign(np.linalg.det(drives.jacobian(R, T, there))) == sign
            assert (np.sign(drives.gains(R, T, there)) == gains).all()


def test_rods_of_one_length_change_where_nothing_else_does() -> None:
    """The values of a machine of cranks whose rods state a range of one number."""
    instance = gspcli.example("t-top-head")
    home = instance.home
    found = gspcli.clearance(instance, home.R(np.pi / 180)[None], home.T[None], of="values")
    assert 0 < found.lower[0] < found.upper[0] < 0.1
