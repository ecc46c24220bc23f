"""Machines that are stated as legs between points: two balls and a driven slide each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.machines.frames import frame, place
from gspcli.machines.graph import Body, Graph, Joint, Part, ball
from gspcli.records import dataclass

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RowLeg:
    """A leg.

    Attributes
    ----------
    name
        What the file calls it.
    base, platform
        Its joints, each in the frame of its body, shape (3,).
    length
        Its length; None for the length at the pose of the file.
    low, high
        The range of the length.
    """

    name: str
    base: Array
    platform: Array
    length: float | None = None
    low: float = 0.0
    high: float = math.inf


def legs_graph(
    format: str,
    name: str,
    legs: Sequence[RowLeg],
    pose: Array | None,
    *,
    length: str,
    platform: Body | None = None,
    notes: Sequence[str] = (),
    remarks: Mapping[str, str] | None = None,
) -> Graph:
    """Return the graph of a machine with legs.

    Parameters
    ----------
    format, name
        The format of the file, and the name of the machine.
    legs
        The legs.
    pose
        The pose of the platform that the file states, shape (4, 4), or None.
    length
        The unit of length.
    platform
        The mass of the platform with centre and inertia, if known.
    notes, remarks
        As `Graph` has them.
    """
    X = _above(legs) if pose is None else pose
    bodies = {"base": Body("base", np.eye(4))}
    bodies["platform"] = Body("platform", X) if platform is None else replace(platform, pose=X)
    names = [leg.name for leg in legs]
    made: list[Joint] = []
    for number, leg in enumerate(legs, 1):
        said = leg.name if names.count(leg.name) == 1 else f"{leg.name} ({number})"
        end = place(X, leg.platform)
        apart = float(np.linalg.norm(end - leg.base))
        e = (end - leg.base) / apart if apart > 0 else np.eye(3)[2]
        value = apart if leg.length is None else leg.length
        for part in ("foot", "head"):
            bodies[f"{said}, {part}"] = Body(f"{said}, {part}", np.eye(4))
        slide = Part("P", e, leg.base, value, leg.low, leg.high, True, said)
        made += [
            Joint(f"{said}, base", "base", f"{said}, foot", np.eye(4), (ball(leg.base, said),)),
            # The length is that of the file, for any pose that the file states.
            Joint(
                said,
                f"{said}, foot",
                f"{said}, head",
                frame(T=e * (value - apart)),
                (slide,),
            ),
            Joint(
                f"{said}, platform",
                f"{said}, head",
                "platform",
                X,
                (ball(end, said),),
                True,
                abs(value - apart),
            ),
        ]
    return Graph(
        format,
        name,
        bodies,
        tuple(made),
        world="base",
        length=length,
        drives_known=True,
        has_home=pose is not None,
        notes=tuple(notes),
        remarks={} if remarks is None else remarks,
    )


def _above(legs: Sequence[RowLeg]) -> Array:
    """Return a pose as far above the base as the longest leg, where the file states none."""
    longest = max((leg.length or leg.low for leg in legs), default=1.0)
    return frame(T=(0, 0, longest or 1.0))
