"""Poses of Study points in balls."""

from flint import acb, arb

from gspcli.certification.equations.ball_system import pose_of_point


def test_a_ball_that_holds_a_point_without_norm_is_no_pose() -> None:
    """N is zero for (1, i, 0, 0): also away from the middle of the ball."""
    rest = [acb(0)] * 6
    for middle, radius, is_pose in ((1 + 1e-10, 1e-9, False), (1 + 1e-8, 1e-9, True)):
        point = [acb(1), acb(0, arb(middle, radius)), *rest]
        assert (pose_of_point(point) is not None) is is_pose
