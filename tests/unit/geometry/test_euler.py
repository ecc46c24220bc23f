from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gspcli.errors import GspError
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.geometry.quaternions import vector_from_rotation

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
