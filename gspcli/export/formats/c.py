"""C99: the next pose in a controller, proved."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.export.format import ControllerFormat

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.solver import Solution


def write(
    instance: Instance,
    prefix: str,
    tries: int,
    name: str,
    home: Solution | None,
    margin: float,
) -> tuple[str, str]:
    """Return the header and the source."""
    from gspcli.export.controller.writing import controller

    return controller(instance, prefix, tries=tries, name=name, home=home, margin=margin)


FORMAT = ControllerFormat(
    write,
    (".h", ".c"),
    "c is a header and a source in C99 for the controller of this platform: inverse kinematics, "
    "Jacobian matrix, and the next pose from six new values. It is proved that this pose continues "
    "the last one; else it is refused. Of a pose out of reach it finds the nearest one within "
    "ranges and cones. No allocation, bounded time. -o NAME.c writes "
    "NAME.h beside it; the pose of --mode is a constant in it. Values of cranks and slides are "
    "their angles and ways.",
)
