"""."""

from __future__ import annotations

import itertools
from itertools import permutations
from math import cos, radians, sin

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gspcli.errors import GspError
from gspcli.geometry.euler import MAKERS, euler_from_rotation, named_order, rotation_from_euler
from gspcli.geometry.quaternions import (
    apply,
    conjugate,
    dot,
    made_real,
    pose_from_study,
    quaternion_from_rotation,
    quaternion_product,
    rotation_from_quaternion,
    rotation_from_vector,
    study_from_pose,
    vector_from_rotation,
)
from gspcli.motion.files.pose_files import PoseFormat, read_poses


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
