"""URDF: a robot whose tree has the platform in one assembly mode, with its loops in YAML."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.export.format import ModeFormat

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.solver import Solution


def write(instance: Instance, pose: Solution) -> tuple[str, str]:
    """Return the loops in YAML and the robot as XML."""
    from gspcli.export.urdf import urdf

    return urdf(instance, pose.R.real, pose.T.real)


FORMAT = ModeFormat(
    write,
    "urdf is NAME.urdf, a tree in which the first chain carries the platform, and NAME.yaml, which "
    "has the loops of the others: closed_loop, type and name_mot, as the robots of "
    "example-parallel-robots have them.",
    (".yaml", ".urdf"),
)
