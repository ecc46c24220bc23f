"""Which real pose is home: nearest to the stated one, else the least turned, then the highest."""

from __future__ import annotations

import itertools
from dataclasses import replace
from itertools import combinations_with_replacement, permutations
from math import cos, radians, sin
from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gspcli import _kernel
from gspcli.catalogue.kinds import ALL, DISTANCE_KINDS, DLL, DLP, DPL, DPP
from gspcli.catalogue.types import GspType
from gspcli.errors import GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import MAKERS, euler_from_rotation, named_order, rotation_from_euler
from gspcli.geometry.home_mode import home_mode
from gspcli.geometry.instance import HomePose
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import (
    apply,
    conjugate,
    dot,
    made_real,
    normalized,
    pose_from_study,
    quaternion_from_rotation,
    quaternion_product,
    rotation_from_quaternion,
    rotation_from_vector,
    stable_order,
    study_from_pose,
    vector_from_rotation,
)
from gspcli.geometry.random_instances import random_instance
from gspcli.geometry.three_angles import Measures, measures
from gspcli.motion.files.pose_files import PoseFormat, read_poses
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load

HEXAPOD = load(instance_files()["simmechanics-hexapod"])
LOOSE = replace(HEXAPOD, home=None)


def test_the_pose_nearest_to_the_stated_home():
    result = solve(HEXAPOD)
    R, T = result.R[result.real].real, result.T[result.real].real
    for k in range(len(R)):
        near = HomePose(list(T[k] + [0.01, 0, -0.02]), list(result.quaternions[k].real))
        found = home_mode(replace(HEXAPOD, home=near), R, T)
        assert (found.number, found.stated, found.count) == (k + 1, True, len(R))
        assert (R[k] == found.R).all()
        assert (T[k] == found.T).all()
        assert found.reason.startswith("nearest to the stated home, 0.0224 m and ")


def test_a_stated_home_in_angles_is_the_same_pose():
    given = HomePose([0, 0, 2], euler="xyz", angles=[10, -20, 30])
    turn = given.R(np.pi / 180)
    x, y, z = (
        rotation_from_vector(np.deg2rad(a) * e)
        for a, e in zip((10, -20, 30), np.eye(3), strict=True)
    )
    assert turn == pytest.approx(z @ y @ x, abs=1e-15)


def test_without_one_the_least_turned_and_then_the_highest():
    upper, lower = np.array([[0, 0, 2.0], [0, 0, -2.0]])
    turned = rotation_from_vector(np.array([0, 0, 0.1]))
    R = np.stack([turned, np.eye(3), np.eye(3)])
    found = home_mode(LOOSE, R, np.stack([upper, lower, upper]))
    assert (found.number, found.stated, found.equal) == (3, False, 2)
    found = home_mode(LOOSE, R[:2], np.stack([upper, lower]))
    assert (found.number, found.equal) == (2, 1)
    assert home_mode(LOOSE, R[:0], np.zeros((0, 3))) is None


def test_equal_is_what_differs_by_less_than_a_millionth():
    T = np.array([[0, 0, -2.0], [0, 0, 2.0]])
    for turn, number in ((0.5e-6, 2), (2e-6, 1)):
        R = np.stack([np.eye(3), rotation_from_vector(np.array([turn, 0, 0]))])
        assert home_mode(LOOSE, R, T).number == number


def test_the_mode_is_marked_in_every_form():
    result = solve(HEXAPOD)
    number = result.home.number
    assert [s.number for s in result.solutions if s.home] == [number]
    frame = result.to_frame()
    assert frame.index[frame["home"]].tolist() == [number]
    document = result.to_json()
    assert document["home"] == {
        "mode": number,
        "stated": True,
        "reason": "nearest to the stated home",
    }
    assert [s["number"] for s in document["solutions"] if s["home"]] == [number]


@pytest.mark.parametrize(
    ("quaternion", "euler"), [([0, 0, 0, 0], None), ([1, 0, 0], None), ([1, 0, 0, 0], "ZYX")]
)
def test_what_is_no_home(quaternion, euler):
    with pytest.raises(ValueError, match="quaternion"):
        HomePose([0, 0, 0], quaternion, euler=euler)


# The order of poses, against NumPy's sort of the same rounded numbers.


def test_poses_are_sorted_by_what_is_rounded_to_nine_decimals_then_by_the_rest():
    rng = np.random.default_rng(5)
    # Few different numbers, off by less than what counts: ties of every sort.
    numbers = rng.integers(-1, 2, (400, 7)) + 1j * rng.integers(0, 2, (400, 7))
    numbers = numbers + rng.uniform(-1e-10, 1e-10, numbers.shape)
    real = rng.random(400) < 0.5
    q, T = numbers[:, :4], 250.0 * numbers[:, 4:]
    rounded = np.concatenate((q, T / 100.0), axis=1).view(float).round(9)
    exact = np.concatenate((q, T), axis=1).view(float)
    parts = ~real[:, None], rounded[:, ::2], rounded[:, 1::2], exact[:, ::2], exact[:, 1::2]
    expected = np.lexsort(np.concatenate(parts, axis=1).T[::-1])
    np.testing.assert_array_equal(stable_order(real, q, T, 250.0), expected)


def test_the_order_in_which_poses_were_found_does_not_matter():
    rng = np.random.default_rng(6)
    q = np.tile([0.6, 0.8, 0, 0], (20, 1)) + 1e-13j * rng.integers(-2, 3, (20, 4))
    T, real = np.ones((20, 3), complex), np.zeros(20, bool)
    shuffled = rng.permutation(20)
    first, second = (q[k][stable_order(real, q[k], T, 1.0)] for k in (np.arange(20), shuffled))
    np.testing.assert_array_equal(first, second)


def test_real_poses_come_first_and_none_is_no_order():
    q = np.array([[1, 0, 0, 0], [2, 0, 0, 0]], complex)
    T = np.zeros((2, 3), complex)
    assert stable_order(np.array([False, True]), q, T, 1.0).tolist() == [1, 0]
    assert stable_order(np.zeros(0, bool), q[:0], T[:0], 1.0).tolist() == []


# .


def quaternions(field: str, count: int = 20) -> np.ndarray:
    rng = np.random.default_rng(3)
    e = rng.normal(size=(count, 4))
    return e + 1j * rng.normal(size=e.shape) if field == "complex" else e


@pytest.mark.parametrize("field", ["real", "complex"])
class TestPoses:
    def test_rotations_are_orthogonal(self, field):
        R = rotation_from_quaternion(quaternions(field))
        np.testing.assert_allclose(
            np.swapaxes(R, -1, -2) @ R, np.tile(np.eye(3), (20, 1, 1)), atol=1e-12
        )
        np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-12)

    def test_a_rotation_turns_as_its_quaternion(self, field):
        e = quaternions(field)
        x = np.random.default_rng(4).normal(size=(20, 3))
        pure = np.concatenate((np.zeros((20, 1)), x), axis=1)
        turned = quaternion_product(quaternion_product(e, pure), conjugate(e))
        R = rotation_from_quaternion(e)
        np.testing.assert_allclose(turned[:, 1:] / dot(e, e)[:, None], apply(R, x), rtol=1e-9)

    def test_quaternion_round_trip(self, field):
        R = rotation_from_quaternion(quaternions(field))
        e = quaternion_from_rotation(R)
        np.testing.assert_allclose(dot(e, e), 1, atol=1e-12)
        np.testing.assert_allclose(rotation_from_quaternion(e), R, atol=1e-12)

    def test_study_round_trip(self, field):
        R = rotation_from_quaternion(quaternions(field))
        T = quaternions(field)[:, 1:]
        e, f = study_from_pose(R, T)
        np.testing.assert_allclose(dot(e, f), 0, atol=1e-12)
        back_R, back_T = pose_from_study((2 - 1j) * e, (2 - 1j) * f)
        np.testing.assert_allclose(back_R, R, atol=1e-12)
        np.testing.assert_allclose(back_T, T, atol=1e-12)

    def test_batches_equal_loops(self, field):
        e = quaternions(field, 6).reshape(2, 3, 4)
        R = rotation_from_quaternion(e)
        assert R.shape == (2, 3, 3, 3)
        np.testing.assert_allclose(R[1, 2], rotation_from_quaternion(e[1, 2]), rtol=1e-12)
        np.testing.assert_allclose(
            quaternion_from_rotation(R)[1, 2], quaternion_from_rotation(R[1, 2]), rtol=1e-12
        )


def test_quaternions_of_half_turns_have_a_canonical_sign():
    for axis in np.eye(3):
        R = 2 * np.outer(axis, axis) - np.eye(3)
        np.testing.assert_allclose(quaternion_from_rotation(R), [0, *axis], atol=1e-15)


def test_rotation_vector_about_an_axis():
    turn = rotation_from_vector(np.array([0, 0, np.pi / 2]))
    np.testing.assert_allclose(turn, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
    np.testing.assert_array_equal(rotation_from_vector(np.zeros(3)), np.eye(3))


SEQUENCES = ["".join(axes) for axes in itertools.permutations("xyz")]


@pytest.mark.parametrize("sequence", SEQUENCES + [s.upper() for s in SEQUENCES])
def test_sequences_are_those_of_scipy(sequence):
    angles = np.random.default_rng(1).uniform(-3, 3, (20, 3))
    in_order = angles[:, ["xyz".index(axis) for axis in sequence.lower()]]
    expected = Rotation.from_euler(sequence, in_order).as_matrix()
    assert np.allclose(rotation_from_euler(sequence, angles), expected, atol=1e-15)


def test_each_angle_belongs_to_its_axis_whatever_the_order():
    quarter = rotation_from_euler("ZYX", [np.pi / 2, 0, 0])
    assert np.allclose(quarter @ [0, 1, 0], [0, 0, 1])


@pytest.mark.parametrize("sequence", ["", "xy", "xyx", "xyZ", "abc", "xyzx"])
def test_other_sequences_are_refused(sequence):
    with pytest.raises(GspError, match="expected three different axes"):
        rotation_from_euler(sequence, np.zeros(3))


@pytest.mark.parametrize("sequence", SEQUENCES + [s.upper() for s in SEQUENCES])
def test_angles_of_a_rotation_are_those_of_scipy(sequence):
    rotations = Rotation.random(50, rng=1)
    in_order = rotations.as_euler(sequence)
    found = euler_from_rotation(sequence, rotations.as_matrix())
    assert np.allclose(found[:, ["xyz".index(a) for a in sequence.lower()]], in_order, atol=1e-12)


@pytest.mark.parametrize("sequence", SEQUENCES + [s.upper() for s in SEQUENCES])
def test_angles_that_are_not_determined_still_make_the_rotation(sequence):
    angles = np.array([0.3, 0.4, 0.5])
    angles["xyz".index(sequence[1].lower())] = np.pi / 2
    R = rotation_from_euler(sequence, angles)
    assert np.allclose(rotation_from_euler(sequence, euler_from_rotation(sequence, R)), R)


def test_rotation_vectors_are_those_of_scipy():
    rotations = Rotation.concatenate([Rotation.random(50, rng=1), Rotation.identity()])
    assert np.allclose(vector_from_rotation(rotations.as_matrix()), rotations.as_rotvec())


# Orders of makers, against formulas of their sources, written again.


ANGLES = np.random.default_rng(3).uniform(-80, 80, (20, 3))


def of_posemath(a, b, c):
    """Return the rotation of A B C, degrees, as `pmRpyMatConvert` of LinuxCNC's posemath has it.

    Its matrix has columns x, y, z; `genhexkins.c` takes A, B, C as roll, pitch, yaw.
    """
    roll, pitch, yaw = map(radians, (a, b, c))
    x = (cos(yaw) * cos(pitch), sin(yaw) * cos(pitch), -sin(pitch))
    y = (
        cos(yaw) * sin(pitch) * sin(roll) - sin(yaw) * cos(roll),
        sin(yaw) * sin(pitch) * sin(roll) + cos(yaw) * cos(roll),
        cos(pitch) * sin(roll),
    )
    z = (
        cos(yaw) * sin(pitch) * cos(roll) + sin(yaw) * sin(roll),
        sin(yaw) * sin(pitch) * cos(roll) - cos(yaw) * sin(roll),
        cos(pitch) * cos(roll),
    )
    return np.column_stack((x, y, z))


def one_after_the_other(turns):
    """Return the rotation of turns about axes that move with the platform, each (axis, degrees).

    By Rodrigues' formula about the moved axes.
    """
    R = np.eye(3)
    for axis, angle in turns:
        k = R[:, axis]
        K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        s, c = sin(radians(angle)), cos(radians(angle))
        R = (np.eye(3) + s * K + (1 - c) * K @ K) @ R
    return R


def test_linuxcnc():
    for angles in ANGLES:
        found = rotation_from_euler(named_order("LinuxCNC"), np.deg2rad(angles))
        assert np.allclose(found, of_posemath(*angles), rtol=0, atol=1e-15)


def test_pi_turns_u_then_v_then_w_about_axes_that_move():
    for u, v, w in ANGLES:
        found = rotation_from_euler(named_order("pi"), np.deg2rad((u, v, w)))
        assert np.allclose(found, one_after_the_other([(0, u), (1, v), (2, w)]), rtol=0, atol=1e-14)
        assert not np.allclose(found, of_posemath(u, v, w), atol=1e-3)


def pose(order, numbers):
    """Return the matrix of x y z, Rx Ry Rz in degrees."""
    X = np.eye(4)
    X[:3, :3] = rotation_from_euler(order, np.deg2rad(numbers[3:]))
    X[:3, 3] = numbers[:3]
    return X


def test_symetrie():
    """Numbers of `test_puna.py` of the control software of KU Leuven, to 1e-4 as there.

    The frames User and Object are set, the platform stays at zero: where Object is in User. Only
    one order gives these numbers.
    """
    user, tool = (-2, -2, -2, -3, -4, -5), (0, 0, 3, 30, 30, 0)
    wanted = (2.162431533, 1.9093265385, 4.967732082, 34.01008683, 33.65884585, 7.22137656)

    def reading(order):
        X = np.linalg.inv(pose(order, user)) @ pose(order, tool)
        return (*X[:3, 3], *np.rad2deg(euler_from_rotation(order, X[:3, :3])))

    agree = [
        order
        for order in map("".join, permutations("XYZ"))
        if np.allclose(reading(order), wanted, rtol=1e-4, atol=1e-4)
    ]
    assert agree == [named_order("Symetrie")] == [named_order("symétrie")]


@pytest.mark.parametrize("name", MAKERS)
def test_angles_come_back(name):
    order = named_order(name.upper())
    turned = rotation_from_euler(order, np.deg2rad(ANGLES))
    assert np.rad2deg(euler_from_rotation(order, turned)) == pytest.approx(ANGLES, abs=1e-9)


def test_what_no_source_states_is_not_claimed():
    with pytest.raises(GspError, match="found in no public source"):
        named_order("SimHub")


def test_kuka_is_refused_with_the_columns_to_write():
    """Its A is about z: to read the columns A B C as turns about x y z would be another pose."""
    with pytest.raises(GspError, match="Name the columns rz, ry, rx in the place of A, B, C"):
        named_order("KUKA")
    form = PoseFormat("ZYX", in_radians=np.pi / 180, columns=("x", "y", "z", "rz", "ry", "rx"))
    found = read_poses("X,Y,Z,A,B,C\n1,2,3,10,20,30\n", "f", form)
    assert np.allclose(found.R[0], one_after_the_other([(2, 10), (1, 20), (0, 30)]), atol=1e-14)


@pytest.mark.parametrize(
    ("heading", "order", "words"),
    [
        ("X,Y,Z,U,V,W", "XYZ", "U V W: turns about x, y, z in the order XYZ, as controllers of PI"),
        ("x,y,z,a,b,c", "ZYX", "A B C: turns about x, y, z in the order ZYX, as LinuxCNC has it"),
        ("X,Y,Z,Roll,Pitch,Yaw", "ZYX", "roll pitch yaw: turns about x, y, z in the order ZYX"),
    ],
)
def test_headings_say_their_order_once_and_yield_to_another(heading, order, words):
    said = []
    text = f"{heading}\n1,2,3,10,20,30\n"
    form = PoseFormat(in_radians=np.pi / 180, note=said.append)
    found = read_poses(text, "f", form)
    wanted = rotation_from_euler(order, np.deg2rad([10, 20, 30]))
    assert np.allclose(found.R[0], wanted, rtol=0, atol=1e-15)
    assert len(said) == 1
    assert said[0].startswith(words)
    other = PoseFormat("zxy", in_radians=np.pi / 180, note=said.append)
    wanted = rotation_from_euler("zxy", np.deg2rad([10, 20, 30]))
    assert np.allclose(read_poses(text, "f", other).R[0], wanted, rtol=0, atol=1e-15)
    assert len(said) == 1


def test_three_letters_without_a_position_are_no_turns():
    with pytest.raises(GspError, match="expected x y z"):
        read_poses("u,v,w,qw,qx,qy,qz\n1,2,3,1,0,0,0\n", "f", PoseFormat())


def test_real_points_have_real_representatives_of_norm_one():
    np.testing.assert_allclose(made_real(np.array([1j, 3j])), np.array([1, 3]) / np.sqrt(10))


# The surfaces of distances against what the constraints mean.


TRIPLES = list(combinations_with_replacement(DISTANCE_KINDS, 3))


class Surfaces(NamedTuple):
    """Surfaces at f rotations (native/closed_form.cpp)."""

    planes: np.ndarray
    """Of each combination of sides: of heights, then of circles; (f, s, planes, 4)."""
    quadrics: np.ndarray
    """Spheres, then cylinders, (f, squares, 4, 4)."""
    basis: np.ndarray
    """Of the f with ``e.f = 0``, (f, 4, 3)."""
    skewness: np.ndarray


def surfaces(shapes: Measures, e: np.ndarray, distances: np.ndarray) -> Surfaces:
    """Return the surfaces at quaternions (f, 4) of norm 1 for distances (f, 3)."""
    found = _kernel.surfaces(
        shapes.forms,
        shapes.spheres,
        shapes.skew,
        shapes.signs,
        shapes.basis,
        np.ascontiguousarray(e),
        np.ascontiguousarray(distances[:, shapes.flat]),
        np.ascontiguousarray(distances[:, shapes.curved]),
    )
    return Surfaces(*found)


def arrangement_of(kinds, seed: int) -> Arrangement:
    instance, _ = random_instance(GspType.of((*kinds, ALL, ALL, ALL)), np.random.default_rng(seed))
    return Arrangement.of(instance).normalized


@pytest.mark.parametrize("kinds", TRIPLES, ids=lambda kinds: "-".join(kind.name for kind in kinds))
@pytest.mark.parametrize("field", ["real", "complex"])
def test_surfaces_at_random_poses(kinds, field):
    """Each form is N, or for cylinders N^2, times what it should be."""
    given = arrangement_of(kinds, 1)
    rng = np.random.default_rng(2)
    e, T = rng.normal(size=(5, 4)), rng.normal(size=(5, 3))
    if field == "complex":
        e, T = e + 1j * rng.normal(size=e.shape), T + 1j * rng.normal(size=T.shape)
    e = normalized(e)
    shapes = measures(given)
    distances = rng.uniform(1, 2, size=(5, 3))
    found = surfaces(shapes, e.astype(complex), distances)
    N = dot(e, e)
    R = rotation_from_quaternion(e)
    if field == "real":
        assert not found.planes.imag.any()
        assert not found.quadrics.imag.any()
    # The place of T in the coordinates of the surfaces, and e.f = 0.
    f = quaternion_product(np.concatenate((np.zeros((5, 1)), T), axis=1), e) / 2
    t = (np.linalg.pinv(found.basis) @ f[..., None])[..., 0]
    X = np.concatenate((np.ones((5, 1)), t), axis=1)
    np.testing.assert_allclose(np.einsum("fk,fkc->fc", e, found.basis), 0, atol=1e-14)
    r, w, _ = given.placed(R, T)
    for j, position in enumerate(shapes.flat):
        i = given.distances[position]
        length = distances[:, position]
        height = measured(given, R, T)[:, i]
        if given.kinds[i] is DLL:
            normal = np.cross(w[:, i], given.v[i])
            length = length * np.sqrt(dot(normal, normal) * N**2) / N
            height = dot(r[:, i], normal)
        for sign, planes in zip(shapes.signs[:, j], found.planes.swapaxes(0, 1), strict=True):
            value = dot(planes[:, j], X)
            assert np.abs(
                np.array([value - N * (height - s * sign * length) for s in (1, -1)])
            ).min(axis=0).max() < 1e-12 * (1 + np.abs(height).max())
    for j, position in enumerate(shapes.curved):
        i = given.distances[position]
        axis = {DPP: np.zeros(3), DPL: given.v[i], DLP: w[:, i]}[given.kinds[i]]
        square = dot(r[:, i], r[:, i]) - dot(r[:, i], axis + 0 * r[:, i]) ** 2
        scale = N if j < shapes.spheres else N**2
        value = np.einsum("fa,fab,fb->f", X, found.quadrics[:, j], X)
        expected = scale * (square - distances[:, position] ** 2)
        np.testing.assert_allclose(value, expected, atol=1e-12 * (1 + np.abs(T).max()) ** 2)
    circles = found.planes[:, 0, len(shapes.flat) :]
    for j in range(1, shapes.spheres):
        difference = found.quadrics[:, j] - found.quadrics[:, 0]
        np.testing.assert_allclose(
            dot(circles[:, j - 1], X), np.einsum("fa,fab,fb->f", X, difference, X), atol=1e-12
        )


def test_skewness_is_the_squared_sine():
    given = arrangement_of((DPP, DLL, DLL), 3)
    e = normalized(np.random.default_rng(4).normal(size=(6, 4)))
    found = surfaces(measures(given), e.astype(complex), np.ones((6, 3)))
    w = given.u[1:3] @ rotation_from_quaternion(e).swapaxes(1, 2)
    sines = np.linalg.norm(np.cross(w, given.v[1:3]), axis=-1)
    np.testing.assert_allclose(found.skewness, (sines**2).min(axis=1))


def test_shapes_are_checked():
    shapes = measures(arrangement_of((DLL, DPL, DPP), 5))
    e = np.ones((1, 4), complex) / 2
    with pytest.raises(ValueError, match="must have shapes"):
        surfaces(shapes, e[:, :3], np.ones((1, 3)))
    with pytest.raises(ValueError, match="must have shapes"):
        surfaces(shapes, e, np.ones((2, 3)))
