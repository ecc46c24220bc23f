"""Proofs that a pose with many digits violates a constraint."""

from __future__ import annotations

from itertools import chain

from flint import acb, arb, ctx

from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.pose_balls import PoseBall
from gspcli.certification.poses.refinement import RefinedPose
from gspcli.geometry.instance import Instance

#: Bits for each decimal of a pose, and for rounding.
_BITS_A_DIGIT, _GUARD = 4, 64


def excluded(instance: Instance, pose: RefinedPose) -> bool:
    """Return whether it is proved that a pose violates a constraint of an instance.

    Parameters
    ----------
    instance
        The constraints, of any number.
    pose
        A real pose; the proof is about all poses that its decimals may stand for.
    """
    digits = max(_places(x) for x in chain(*pose.R, pose.T))
    precision = _BITS_A_DIGIT * digits + _GUARD
    with ctx.workprec(precision):
        system = BallSystem(instance, precision)
        rotation = [[_ball(x) for x in row] for row in pose.R]
        return system.excludes(PoseBall(rotation, [_ball(x) / system.scale for x in pose.T]))


def _places(text: str) -> int:
    return len(text.partition(".")[2])


def _ball(text: str) -> acb:
    """Return the numbers for which a decimal of `RefinedPose` may stand."""
    return acb(arb(text) + arb(0, 0.51) / arb(10) ** _places(text))
