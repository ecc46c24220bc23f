from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gspcli.errors import GspError
from gspcli.geometry.euler import rotation_from_euler

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
