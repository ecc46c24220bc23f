"""The travel of a platform from home along each axis: the table that makers of hexapods print."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.poses.inverse_kinematics import changed_value, values_at
from gspcli.motion.workspace.pose_boxes import NEGATIVE, PARAMETERS, REGULAR, PoseBoxes
from gspcli.records import dataclass
from gspcli.ties import first_smallest

Array = NDArray[np.float64]

#: The search ends at this many typical lengths if nothing bounds the position.
_FAR = 100.0
#: The interval in which a travel ends is halved at most so often.
_DEEPEST = 46
#: More open intervals than this are not divided: a limit is nearly violated along the whole axis.
_MOST_OPEN = 500


@dataclass(frozen=True)
class Travel:
    """The travel of one parameter from home while the others stay constant."""

    #: The parameter, one of x, y, z, rx, ry, rz.
    axis: str
    #: Two changes, at most 0 and at least 0, in the units of the instance: every pose between them
    #: is proved to keep the limits.
    reached: tuple[float, float]
    #: Two changes: a limit is proved to be violated between home and each of them. Infinite if no
    #: such change was found (within a whole turn, or a hundred typical lengths for positions).
    ends: tuple[float, float]
    #: The limits that end the travel, in words: those that are undecided between ``reached`` and
    #: ``ends``.
    stops: tuple[tuple[str, ...], tuple[str, ...]]


def moved(
    R: ArrayLike,
    T: ArrayLike,
    offset: Mapping[str, float],
    *,
    pivot: ArrayLike = (0.0, 0.0, 0.0),
    sequence: str = "ZYX",
    in_radians: float = 1.0,
) -> tuple[Array, Array]:
    """Return a pose whose parameters differ from those of another pose.

    Parameters
    ----------
    R, T
        The pose, shapes (3, 3) and (3,).
    offset
        The numbers that are added to some of x, y, z, rx, ry, rz; angles turn about axes of the
        base.
    pivot, sequence
        As in `gspcli.motion.workspace.workspaces.workspace`.
    in_radians
        The unit of angles.
    """
    unknown = [name for name in offset if name not in PARAMETERS]
    if unknown:
        message = f"found {unknown[0]}, expected one of {', '.join(PARAMETERS)}"
        raise ArgumentError(message, "offset")
    R, T, pivot = (np.asarray(part, float) for part in (R, T, pivot))
    change = np.array([offset.get(name, 0.0) for name in PARAMETERS])
    turned = rotation_from_euler(sequence, change[3:] * in_radians) @ R
    return turned, T + R @ pivot + change[:3] - turned @ pivot


def travels(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    axes: Sequence[str] = PARAMETERS,
    pivot: ArrayLike = (0.0, 0.0, 0.0),
    sequence: str = "ZYX",
    connected: bool = False,
    working_modes: ArrayLike | None = None,
    gap: float | None = None,
) -> list[Travel]:
    """Return the travel of each parameter from home while the others stay constant.

    Parameters
    ----------
    instance
        The platform with its ranges and cones.
    R, T
        The home pose, shapes (3, 3) and (3,).
    axes
        Which of x, y, z (the position of the pivot) and rx, ry, rz (turns about axes through the
        pivot parallel to those of the base).
    connected
        Whether a singular pose ends the travel.
    pivot, sequence, working_modes, gap
        As for `gspcli.motion.workspace.pose_boxes.PoseBoxes`.

    Raises
    ------
    ArgumentError
        If home does not keep the limits, or an argument is wrong.
    """
    boxes = PoseBoxes(
        instance,
        R,
        T,
        pivot=pivot,
        sequence=sequence,
        regular=connected,
        working_modes=working_modes,
        gap=gap,
    )
    if not boxes.conditions & ~REGULAR and not connected:
        message = "no constraint has a range and no joint a cone: every pose can be reached"
        raise ArgumentError(message)
    boxes.refuse_shared(boxes.R, axes)
    wrong = violations(instance, boxes.R, np.asarray(T, float), working_modes)
    wrong += [] if gap is None else too_near(instance, boxes.R, np.asarray(T, float), gap)
    if wrong:
        message = f"home does not keep the limits: {'; '.join(wrong)}"
        raise ArgumentError(message)
    found = []
    for axis in axes:
        if axis not in PARAMETERS:
            message = f"found {axis}, expected one of {', '.join(PARAMETERS)}"
            raise ArgumentError(message, "axes")
        k = PARAMETERS.index(axis)
        unit = instance.units.angle.in_radians if k > 2 else 1.0
        (left, low, below), (right, high, above) = (_way(boxes, k, way) for way in (-1, 1))
        reached, ends = (-left / unit, right / unit), (-low / unit, high / unit)
        found.append(Travel(axis, reached, ends, (below, above)))
    return found


def too_near(instance: Instance, R: Array, T: Array, gap: float) -> list[str]:
    """Return which legs or bodies are proved to be nearer than a gap at a pose, in words.

    Only the nearest two are named. The pose has shapes (3, 3) and (3,).
    """
    compared = ComparedShapes(instance)
    gaps = compared.bounds(R[None], T[None]).high[0]
    which = int(first_smallest(gaps))
    if gaps[which] >= gap:
        return []
    unit = instance.units.length
    return [
        f"the gap between {compared.names[which]} is {gaps[which]:.6g} {unit}, at least {gap:g} "
        "is asked for"
    ]


def violations(
    instance: Instance, R: Array, T: Array, working_modes: ArrayLike | None = None
) -> list[str]:
    """Return the limits that a pose violates by more than rounding, in words.

    Parameters
    ----------
    instance, R, T
        The platform and the pose, shapes (3, 3) and (3,).
    working_modes
        As for `travels`.

    Raises
    ------
    ArgumentError
        If no home is stated and a rod does not reach the pose, so that the working modes are not
        known.
    """
    machine = Machine.of(instance)
    signs = machine.at_home(R, T).signs if working_modes is None else np.asarray(working_modes)
    assert signs is not None
    found = list(_of_drives(machine, signs, R, T))
    q = machine.inverse(R, T, signs)
    if np.isnan(q).any():
        return found
    readings = machine.readings(q)
    for k in np.flatnonzero(machine.outside(q) & ~machine.moved).tolist():
        row = instance.constraints[machine.first[k]]
        assert row.limits is not None
        low, high = map(row.reading_of, row.limits)
        found.append(
            f"the value {readings[k]:.6g} of constraint {machine.names[k]} is outside its range "
            f"from {low} to {high}"
        )
    angles = machine.tilts(R, T, q) / instance.units.angle.in_radians
    for k in np.flatnonzero(machine.out_of_cones(R, T, q)).tolist():
        cone = machine.cones[k]
        found.append(
            f"leg {cone.constraint + 1} is tilted by {angles[k]:.6g} at the {cone.body}, "
            f"at most {cone.cone.half_angle} is allowed"
        )
    return found


def _of_drives(
    drives: Machine, working_modes: NDArray[np.int64], R: Array, T: Array
) -> Iterator[str]:
    """Yield drives out of reach or range at a pose, and values that stay and do not, in words."""
    wanted = drives.wanted(R, T, working_modes)
    for k in np.flatnonzero(drives.driven).tolist():
        drive = drives.index[k]
        name = drives.names[drive].replace(".", " ")
        q, low, high = (float(x) for x in (wanted[k], drives.low[drive], drives.high[drive]))
        if np.isnan(q):
            yield f"{drives.user(k)} does not reach {name}"
        elif drives.outside(np.full(drives.count, q))[drive]:
            here, first, last = (
                float(drives.readings(np.full(drives.count, x))[drive]) for x in (q, low, high)
            )
            yield f"{name} at {here:.6g} is outside its range from {first:.10g} to {last:.10g}"
    there = values_at(drives.instance, R, T)
    for k in np.flatnonzero(drives.stays & np.isnan(wanted)).tolist():
        yield changed_value(drives, k, there[k])


def _way(boxes: PoseBoxes, k: int, direction: int) -> tuple[float, float, tuple[str, ...]]:
    """Return the travel of a parameter in one direction, a bound, and the limits at its end."""
    home, far = boxes.home, np.pi
    if k < 3:
        far = direction * (boxes.bounds(turning=False)[k, int(direction > 0)] - home[k])
    endless = k > 2 or not np.isfinite(far)
    if not np.isfinite(far):
        far = _FAR * Arrangement.of(boxes.instance).length
    if not far > 0:
        return 0.0, 0.0, ()
    bounds = np.stack((home, home), axis=1)
    bounds[k] = np.sort((home[k], home[k] + direction * far))
    width = float(bounds[k, 1] - bounds[k, 0])
    sign: np.uint32 | None = None
    # Intervals (start, end, open conditions) from home in parts of the width; keys of open ones.
    inner: list[tuple[float, float]] = []
    keys, left = np.zeros(1, np.uint64), np.array([boxes.conditions])
    gap, stops = 1.0, 0
    for level in range(_DEEPEST + 1):
        found = boxes.judge(bounds, [k], level, keys, left, split=level > 0)
        part = 2.0**-level
        kept = found.inside
        if boxes.regular and len(kept):
            starts = _starts(kept, level, direction)
            if sign is None and starts.min() == 0.0:
                sign = found.inside_signs[starts.argmin()] & NEGATIVE
            if sign is not None:
                kept = kept[found.inside_signs & NEGATIVE == sign]
        inner += [(s, s + part) for s in _starts(kept, level, direction).tolist()]
        starts = _starts(found.open, level, direction)
        gap = _first_gap(sorted([*inner, *((s, s + part) for s in starts.tolist())]))
        order = np.argsort(starts)
        near = order[starts[order] < gap]
        keys, left = found.open[near], found.open_left[near]
        # Where regularity is not proved, a motor may be near a dead point, and so near the end of
        # its reach.
        stops = int(left[-1 if boxes.rows else 0]) if len(left) else stops
        if not len(keys) or len(keys) > _MOST_OPEN:
            break
    # Where a value that stays is not proved to be the same, home alone keeps it.
    reached = 0.0 if stops & boxes.fixed else _first_gap(sorted(inner))
    whole = gap >= 1.0 and endless
    names = () if reached >= 1.0 else tuple(boxes.names(stops & ~int(NEGATIVE)))
    return reached * width, np.inf if whole else gap * width, names


def _starts(keys: NDArray[np.uint64], level: int, direction: int) -> Array:
    """Return the distances of intervals from home, in parts of the whole."""
    place = keys.astype(np.float64)
    if direction < 0:
        place = 2.0**level - 1 - place
    return np.asarray(place * 2.0**-level)


def _first_gap(intervals: list[tuple[float, float]]) -> float:
    """Return the end of the part from 0 that sorted intervals cover without a gap."""
    end = 0.0
    for start, stop in intervals:
        if start > end:
            break
        end = max(end, stop)
    return end
