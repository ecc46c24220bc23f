"""The sign that a matrix of screws is proved to have is that of its determinant."""

import numpy as np

from gspcli.motion.singularities.pose_clearances import regular


def test_the_sign_is_that_of_the_determinant() -> None:
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(40, 6, 6))
    nothing = np.zeros((40, 6, 6, 6)), np.zeros((40, 6, 6))
    found, _ = regular(rows, *nothing, cube=True)
    np.testing.assert_array_equal(found, np.sign(np.linalg.det(rows)))
