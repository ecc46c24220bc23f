"""A file of poses followed straight in position and angles, each way between rows proved."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.coordinates import choose
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import joint_cones, out_of_cone, out_of_motor_range, out_of_range
from gspcli.geometry.machine import Machine
from gspcli.motion.following.tracks import Event, Track
from gspcli.motion.paths.limit_events import LimitEvent
from gspcli.motion.paths.pose_ways import PoseWays, WayProof
from gspcli.motion.poses.inverse_kinematics import refusals
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Poses of a way that are tested for the limit that it violates.
_LOOKS = 64


@dataclass(frozen=True, eq=False)
class PoseTrack:
    """A file of poses as a track.

    Attributes
    ----------
    track
        The poses as the only mode; it ends with an undecided event before the first way that is
        not proved to be regular.
    ways
        The straight ways in position and angles, in the frames of the poses.
    limits
        Where ranges and cones are left, or not proved to be kept.
    """

    track: Track
    ways: PoseWays
    limits: tuple[LimitEvent, ...]


def pose_track(
    instance: Instance,
    expressed: Instance,
    frame: PoseFrame,
    t: Array,
    R: Array,
    T: Array,
    *,
    sequence: str,
    mode: int,
    steps: int = 1,
) -> PoseTrack:
    """Prove the straight ways between the rows of a file of poses.

    Parameters
    ----------
    instance
        The platform, without offsets of readings.
    expressed
        The same in the frames in which poses are expressed.
    frame
        These frames; the position that changes linearly is that of their origin on the platform.
    t, R, T
        The n rows, poses of the platform.
    sequence
        The order of the axes of the angles that change linearly.
    mode
        The number of the mode.
    steps
        This many rows are made of each.
    """
    origin = np.zeros(3)
    machine = Machine.of(instance).at_home(R[0], T[0])
    regular, inside = (
        PoseWays(
            expressed, pivot=origin, sequence=sequence, limits=limits, working_modes=machine.signs
        )
        for limits in (False, True)
    )
    parameters = regular.continued(*frame.from_platform(R, T))
    if steps > 1:
        rows = np.arange(len(t))
        places = np.linspace(0, len(t) - 1, steps * (len(t) - 1) + 1)
        parameters = np.stack([np.interp(places, rows, one) for one in parameters.T], axis=1)
        t = np.interp(places, rows, t)
        R, T = frame.to_platform(*regular.poses(parameters))
    moving = _moving(machine, R, T, t)
    events: tuple[Event, ...] = ()
    cells, end = 0, len(t)
    for k in range(len(t) - 1):
        proof = regular.prove(parameters[k], parameters[k + 1])
        cells += proof.cells
        if not proof.sign:
            reason = _reason(proof)
            low, high = float(t[k]), float(t[k + 1])
            events = (Event("undecided", reason, False, mode, k, low, high, R[k], T[k]),)
            end = k + 1
            break
    if len(t) == 1 and not regular.at(parameters[0]).sign:
        reason = "the pose is nearly singular"
        here = float(t[0])
        events = (Event("undecided", reason, False, mode, 0, here, here, R[0], T[0]),)
    known = np.arange(len(t)) < end
    track = Track(
        instance,
        instance,
        t,
        machine.values(R, T),
        np.array([mode]),
        np.where(known[:, None, None], R, np.nan)[None],
        np.where(known[:, None], T, np.nan)[None],
        True,
        events,
        None,
        cells,
        known=mode,
        **moving,
    )
    limits = tuple(_limits(inside, parameters[:end], t, mode))
    return PoseTrack(track, regular, limits)


def _moving(machine: Machine, R: Array, T: Array, t: Array) -> dict[str, Any]:
    """Return the cranks and slides of a track and what they are at, as `Track` has them.

    Raises
    ------
    ArgumentError
        If the machine cannot take a row.
    """
    if not machine.moves:
        return {}
    q = machine.along(R, T)
    if missing := refusals(machine, R, T, q):
        row = min(missing)
        raise ArgumentError(missing[row], f"the pose at t = {t[row]:.10g}")
    moved = np.flatnonzero(machine.moved).tolist()
    chosen = choose(machine.instance, [machine.names[k] for k in moved])
    return {"coordinates": chosen, "places": (q / machine.units)[:, moved]}


def _reason(proof: WayProof) -> str:
    """Return why a way is not proved to be regular, in words."""
    if proof.shared:
        return "rods that share a motor are not parallel on the straight way"
    if proof.reason.startswith("reach"):
        return f"a rod may not reach its motor on the straight way ({proof.reason})"
    if proof.reason == "limit":
        return "a rod does not reach its motor on the straight way"
    return "a pose on the straight way may be singular"


def _limits(ways: PoseWays, parameters: Array, t: Array, mode: int) -> Iterator[LimitEvent]:
    """Yield each limit where it is first left on a way, or first not proved to be kept."""
    seen: set[tuple[str, int, str, str]] = set()
    for k in range(len(parameters) - 1):
        proof = ways.prove(parameters[k], parameters[k + 1])
        if not proof.sign:
            parts = np.linspace(0, 1, _LOOKS + 1)[:, None]
            way = parameters[k] + (parameters[k + 1] - parameters[k]) * parts
            times = t[k] + (t[k + 1] - t[k]) * parts[:, 0]
            for event in _on_way(ways, *ways.poses(way), times, mode, proof):
                name = event.kind, event.constraint, event.body, event.drive
                if name not in seen:
                    seen.add(name)
                    yield event


def _on_way(
    ways: PoseWays, R: Array, T: Array, t: Array, mode: int, proof: WayProof
) -> Iterator[LimitEvent]:
    """Yield the limits that samples of a way violate; if there are none, those not proved."""
    instance, machine = ways.instance, ways.machine
    q, low, high = machine.along(R, T), float(t[0]), float(t[-1])
    whole = LimitEvent("range", True, 0, "", None, low, high, False)
    ranges = [replace(whole, constraint=k) for k in range(len(instance.constraints))]
    moved = [
        replace(whole, constraint=int(k), drive=name)
        for k, name in zip(machine.first, machine.names, strict=True)
    ]
    cones = [
        LimitEvent("cone", True, one.constraint, one.body, mode, low, high, False)
        for one in joint_cones(instance)
    ]
    events = (*ranges, *moved, *cones)
    outside = out_of_range(instance, machine.values(R, T)), out_of_motor_range(machine, q)
    violated = np.concatenate((*outside, out_of_cone(instance, R, T, q)), axis=1)
    seen = np.flatnonzero(violated.any(axis=0)).tolist()
    for k in seen:
        first = int(violated[:, k].argmax())
        yield replace(events[k], low=float(t[max(first - 1, 0)]), high=float(t[first]))
    if seen:
        return
    # Of a way with a pose that violates some limit it is not known which one.
    left, driven = proof.left or int(ways.boxes.conditions), np.flatnonzero(machine.driven)
    for k, event in enumerate((*ranges, *cones)):
        drive = machine.names[machine.index[k]] if k in driven else ""
        stated = k >= len(ranges) or drive or instance.constraints[k].limits is not None
        if left >> k & 1 and stated:
            yield replace(event, drive=drive)
