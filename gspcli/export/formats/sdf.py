"""SDF: a model with the platform in one assembly mode, its loops closed by joints."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.export.format import ModeFormat

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.solver import Solution


def write(instance: Instance, pose: Solution) -> tuple[str]:
    """Return the model as XML."""
    from gspcli.export.sdf import sdf

    return (sdf(instance, pose.R.real, pose.T.real),)


FORMAT = ModeFormat(
    write,
    "sdf is a model for Gazebo and other readers of SDF 1.9: six chains of joints from the base to "
    "the platform, which close loops. The joint value_k is what constraint k measures, less its "
    "value.",
)
