"""Arms and rails of machines whose motors move points: strokes, and where the drives are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gspcli.geometry.coordinates import BODIES
from gspcli.geometry.drive_numbers import is_driven
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.pictures.scene import Stroke, StrokeStyle
from gspcli.pictures.shown_poses import Poses

#: Half of what is drawn of a rail without a range, in sizes of the scene.
_RAIL = 0.2


def with_drives(instance: Instance, poses: Poses) -> Poses:
    """Return poses with the numbers of the drives at each, where an instance has cranks or slides.

    Poses that state coordinates, or that the rods do not reach, are not changed: their points stay
    where they are stated, and the rods change their lengths.
    """
    if poses.coordinates or not len(poses.T) or not is_driven(instance):
        return poses
    drives = Drives.of(instance)
    moved = [k for k, sort in enumerate(drives.sorts) if sort != "value"]
    q = drives.inverse(poses.R, poses.T)[:, moved] / drives.units[moved]
    if np.isnan(q).any():
        return poses
    names = tuple(drives.names[k] for k in moved)
    return replace(poses, coordinates=names, places=q)


def arm_strokes(instance: Instance, poses: Poses, size: float) -> list[tuple[Stroke, ...]]:
    """Return what is drawn of the arm or rail of each constraint at poses; nothing of values.

    An arm leads from the axis of its crank to the point, a rail along the range of its slide.

    Parameters
    ----------
    instance
        The platform as it is stated.
    poses
        The poses, perhaps with coordinates; drives that are none of them are where it states them.
    size
        Of the scene.
    """
    count = len(poses.T)
    if not is_driven(instance) or not count:
        return [()] * len(instance.constraints)
    drives = Drives.of(instance)
    q = np.zeros((count, drives.count))
    for name, column in zip(poses.coordinates, poses.places.T, strict=False):
        if name in drives.names:
            k = drives.names.index(name)
            q[:, k] = column * drives.units[k]
    points = drives.points(q)
    found: list[tuple[Stroke, ...]] = []
    for k in range(len(instance.constraints)):
        sort = drives.sorts[drives.index[k]]
        if not drives.driven[k]:
            found.append(())
            continue
        start = np.broadcast_to(drives.middle[k], (count, 3))
        ends = start, points[:, k]
        if sort == "slide":
            low, high = _rail(drives, k, size)
            ends = start + low * drives.beside[k], start + high * drives.beside[k]
        line = np.stack(ends, axis=1)
        if drives.on_platform[k]:
            line = line @ np.swapaxes(poses.R, -1, -2) + poses.T[:, None]
        style = StrokeStyle.PERPENDICULAR if sort == "crank" else StrokeStyle.GUIDE
        found.append((Stroke(style, line),))
    return found


def drawn_drives(instance: Instance) -> list[dict[str, Any] | None]:
    """Return of each constraint the crank or slide that moves its point, as data for a page.

    Returns
    -------
    list
        None without one, else its ``sort``, the ``body`` of the point, ``middle``, ``across`` and
        ``beside``, ``unit``, ``factor`` and ``offset`` (`gspcli.geometry.drives.Drives`), and its
        ``range`` in radians or lengths, or None.
    """
    if not is_driven(instance):
        return [None] * len(instance.constraints)
    drives = Drives.of(instance)
    found: list[dict[str, Any] | None] = []
    for k, driven in enumerate(drives.driven.tolist()):
        drive = drives.index[k]
        ends = [drives.low[drive].item(), drives.high[drive].item()]
        one = {
            "sort": drives.sorts[drive],
            "body": BODIES[0] if drives.on_platform[k] else BODIES[1],
            **{name: getattr(drives, name)[k].tolist() for name in ("middle", "across", "beside")},
            "range": ends if np.isfinite(ends).all() else None,
            "unit": drives.units[drive].item(),
            "factor": drives.factors[drive].item(),
            "offset": drives.offsets[drive].item(),
        }
        found.append(one if driven else None)
    return found


def _rail(drives: Drives, k: int, size: float) -> tuple[float, float]:
    """Return the ends of a rail from its stated point."""
    low, high = drives.low[drives.index[k]], drives.high[drives.index[k]]
    if np.isfinite([low, high]).all():
        return float(low), float(high)
    return -_RAIL * size, _RAIL * size


def joined(
    strokes: Sequence[tuple[Stroke, ...]], more: Sequence[tuple[Stroke, ...]]
) -> tuple[tuple[Stroke, ...], ...]:
    """Return the strokes of each constraint with further ones."""
    return tuple((*each, *added) for each, added in zip(strokes, more, strict=True))
