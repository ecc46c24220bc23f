"""Boxes of values about an angle of zero, where a cosine changes to second order alone."""

import numpy as np

from gspcli.certification.branches.parametric_quadrics import MovingEquations, Shape, ValueFunction
from gspcli.motion.following.branch_follower import MovingPlatform
from gspcli.motion.singularities.neighbourhoods import Neighbourhood


def test_a_cosine_changes_at_an_angle_of_zero() -> None:
    """x^2 / (1 + x^2) = cos v - 0.99 has a double solution at cos v = 0.99."""
    hessians = np.zeros((6, 2, 8, 8))
    hessians[0, 0, :4, :4] = np.diag([1.98, 3.98, 1.98, 1.98])
    for k, j in enumerate((2, 3, 5, 6, 7), 1):
        hessians[k, 0, 0, j] = hessians[k, 0, j, 0] = 1
    sizes = np.linalg.norm(hessians, ord=2, axis=(2, 3))
    platform = MovingPlatform.__new__(MovingPlatform)
    laws = np.array([ValueFunction.COSINE, *[ValueFunction.LINEAR] * 5], np.int32)
    shapes = np.full(6, Shape.PLAIN, np.int32)
    platform.equations = MovingEquations(1.0, shapes, laws, np.ones(6), hessians, sizes, sizes)
    x = np.sqrt(0.01 / 0.99)
    point = np.array([1, x, 0, 0, 0, 0, 0, 0]) / np.hypot(1, x)
    there = Neighbourhood(platform, point[None], np.zeros((1, 6)))
    singular = np.arccos(0.99)
    for share, proved in ((0.3, True), (1.01, False), (1.5, False)):
        box = there.box(np.array([share * singular, 0, 0, 0, 0, 0]))
        assert (box.measure[0] < 1) == proved
