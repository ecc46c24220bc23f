"""Orders of makers, against formulas of their sources written anew."""

from math import cos, radians, sin

import numpy as np
import pytest

from gspcli.errors import GspError
from gspcli.geometry.euler import MAKERS, euler_from_rotation, named_order, rotation_from_euler
from gspcli.motion.files.pose_files import PoseFormat, read_poses

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

    By Rodrigues' formula about where each axis has come.
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


@pytest.mark.parametrize("name", MAKERS)
def test_angles_come_back(name):
    order = named_order(name.upper())
    turned = rotation_from_euler(order, np.deg2rad(ANGLES))
    assert np.rad2deg(euler_from_rotation(order, turned)) == pytest.approx(ANGLES, abs=1e-9)


@pytest.mark.parametrize("name", ["Symetrie", "Symétrie", "SimHub"])
def test_what_no_source_states_is_not_claimed(name):
    with pytest.raises(GspError, match="found in no public source"):
        named_order(name)


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
