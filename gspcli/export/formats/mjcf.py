"""MuJoCo: a model with the platform in one assembly mode, held by chains of joints."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.export.format import ModeFormat

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.solver import Solution


def write(instance: Instance, pose: Solution) -> tuple[str]:
    """Return the model as XML."""
    from gspcli.export.mjcf import mjcf

    return (mjcf(instance, pose.R.real, pose.T.real),)


FORMAT = ModeFormat(
    write,
    "mjcf is a model for MuJoCo: the platform as a free body in one assembly mode, held by six "
    "chains of joints. The joint value_k is what constraint k measures, in metres or radians; the "
    "equality hold_k keeps it (its first coefficient is the change), and without it the actuator "
    "drive_k moves it. A crank or slide is the joint drive_k of an arm or a carriage.",
)
