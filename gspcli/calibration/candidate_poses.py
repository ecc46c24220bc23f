"""Poses that a machine can take, from which those to measure are chosen.

They are spread over the box of poses that the travel from home spans. A pose is kept if all values
are in their ranges, all legs are in their cones, and the determinant has the sign that it has at
home, so that no singular pose lies between.

A leg that a crank or a slide moves keeps its length, and the drive moves to where the leg reaches.
Then the box is as wide as the cranks are long and the rails go, and poses that the legs do not
reach are left out. A machine whose legs share drives reaches almost none of these poses: its drives
are moved at random, and the platform follows them from home.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.parameters import Model
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import (
    has_limits,
    out_of_cone,
    out_of_motor_range,
    out_of_range,
    within_limits,
)
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import apply, rotation_from_vector
from gspcli.motion.poses.inverse_kinematics import drive_values, values_at
from gspcli.motion.workspace.travels import travels

Array = NDArray[np.float64]
Allowed = Callable[[Array, Array], NDArray[np.bool_]]

#: This many candidates at most.
_CANDIDATES = 3000
#: They are tried in this many rounds of this many.
_ROUNDS, _TRIED = 50, 4000
#: How far poses go where nothing limits them: in typical lengths, and radians.
_FREE_PLACE, _FREE_TURN = 0.1, np.deg2rad(15)
#: Drives without a range move no farther from where their points are stated: cranks in radians,
#: slides in typical lengths.
CRANK_TURN, SLIDE_SHIFT = np.pi / 2, 0.25
#: The platform follows drives from home in this many steps, each with this many of Newton's method.
#: It has arrived where values differ by less than this part of a typical length.
_STEPS, _NEWTON, _ARRIVED = 16, 3, 1e-11


class Places(NamedTuple):
    """Poses, shapes (n, 3, 3) and (n, 3), and readings of m drives, radians or lengths, (n, m)."""

    R: Array
    T: Array
    drives: Array | None

    def taken(self, rows: NDArray[np.intp] | NDArray[np.bool_] | slice) -> Places:
        """Return some of them."""
        return Places(
            self.R[rows], self.T[rows], None if self.drives is None else self.drives[rows]
        )


def candidates(
    instance: Instance,
    model: Model,
    R: Array,
    T: Array,
    seed: int,
    count: int | None = None,
    allowed: Allowed | None = None,
) -> Places:
    """Return poses that can be reached from home, at most ``count``.

    Parameters
    ----------
    instance, model
        The platform, and its model: with drives if cranks or slides move it.
    R, T
        Home, shapes (3, 3) and (3,).
    seed
        Of the random numbers.
    count
        How many; `_CANDIDATES` if None.
    allowed
        Which of some poses (R, T) are allowed besides, a mask; all if None.

    Raises
    ------
    ArgumentError
        If home does not keep the limits or is not allowed, or there are no others about it.
    """
    count = _CANDIDATES if count is None else count
    centre = Arrangement.of(instance).platform_centre
    home = _kept(instance, model, R[None], T[None])
    if not len(home.T):
        message = "home does not keep the limits: choose another with --mode"
        raise ArgumentError(message)
    if allowed is not None and not allowed(home.R, home.T).all():
        message = "home does not keep what is required of planned poses: require less"
        raise ArgumentError(message)
    low, high = _box(instance, model, R, T)
    if not (high > low).any():
        message = (
            "the ranges and cones leave no room about home: as stated the machine cannot move\n"
            "widen the ranges to those that it can have, or leave them out; where cranks or slides "
            "drive it, state them"
        )
        raise ArgumentError(message)
    random = np.random.default_rng(seed)
    sign = _signs(model, home)[0]
    shared = any(len(drive.carried) > 1 for drive in model.drives)
    found: list[Places] = []
    number = 0
    for _ in range(_ROUNDS):
        if shared:
            kept = _following(instance, model, R, T, random)
        else:
            change = random.uniform(low, high, (_TRIED, 6))
            turned = rotation_from_euler("ZYX", change[:, 3:]) @ R
            places = T + R @ centre + change[:, :3] - turned @ centre
            kept = _kept(instance, model, turned, places)
        kept = kept.taken(_signs(model, kept) == sign).taken(slice(0, count - number))
        if allowed is not None and len(kept.T):
            kept = kept.taken(allowed(kept.R, kept.T))
        found.append(kept)
        number += len(found[-1].T)
        if number >= count:
            break
    if not number:
        what = "the ranges and cones" if allowed is None else "ranges, cones and what is required"
        message = f"no pose about home keeps {what}: choose another with --mode"
        raise ArgumentError(message)
    turns, places = (
        np.concatenate(part)[:count] for part in zip(*(p[:2] for p in found), strict=True)
    )
    drives = [one.drives for one in found if one.drives is not None]
    return Places(turns, places, np.concatenate(drives)[:count] if drives else None)


def _box(instance: Instance, model: Model, R: Array, T: Array) -> tuple[Array, Array]:
    """Return how far candidates are from home, down and up: x, y, z and three turns."""
    arrangement = Arrangement.of(instance)
    if model.drives:
        reach = max(_reaches(instance, model))
        turn = min(reach / arrangement.extent, np.pi / 4) if arrangement.extent else np.pi / 4
        box = np.array([reach] * 3 + [turn] * 3)
        return -box, box
    if not has_limits(instance):
        box = np.array([_FREE_PLACE * arrangement.length] * 3 + [_FREE_TURN] * 3)
        return -box, box
    unit = np.array([1.0] * 3 + [arrangement.in_radians] * 3)
    span = np.array([one.reached for one in travels(instance, R, T, connected=True)])
    # Unlimited travel goes no farther than what is near.
    far = np.where(np.isfinite(span).all(axis=1) & (unit == 1.0), np.inf, np.pi / 2)
    return np.maximum(span[:, 0] * unit, -far), np.minimum(span[:, 1] * unit, far)


def _reaches(instance: Instance, model: Model) -> list[float]:
    """Return the lengths of the arms of cranks, and how far slides go at most."""
    points = {(b.body, b.name): b.point for b in model.blocks if b.sort == "point"}
    low, high = _spans(Drives.of(instance), model.length)
    numbers = _columns(Drives.of(instance), model)
    found = []
    for drive, k in zip(model.drives, numbers, strict=True):
        if drive.sort == "slide":
            found.append(float(max(abs(low[k]), abs(high[k]))))
            continue
        arms = [points[drive.body, name] - drive.point for name in drive.carried]
        found.append(max(float(np.linalg.norm(np.cross(arm, drive.unit))) for arm in arms))
    return found


def _spans(drives: Drives, length: float) -> tuple[Array, Array]:
    """Return between which numbers drives move, shapes (m,): their ranges, or as far as here."""
    usual = {"crank": CRANK_TURN, "slide": SLIDE_SHIFT * length, "value": np.inf}
    far = np.array([usual[sort] for sort in drives.sorts])
    return (
        np.where(np.isfinite(drives.low), drives.low, -far),
        np.where(np.isfinite(drives.high), drives.high, far),
    )


def _columns(drives: Drives, model: Model) -> list[int]:
    """Return which of the drives each drive of the model is."""
    return [drives.names.index(one.drive_name) for one in model.drives]


def _kept(instance: Instance, model: Model, R: Array, T: Array) -> Places:
    """Return those of some poses that drives reach and at which ranges and cones are kept."""
    if not model.drives:
        return Places(R, T, None).taken(within_limits(instance, values_at(instance, R, T), R, T))
    drives, q = drive_values(instance, R, T, along=False)
    return _allowed_by_drives(instance, model, drives, R, T, q)


def _allowed_by_drives(
    instance: Instance, model: Model, drives: Drives, R: Array, T: Array, q: Array
) -> Places:
    """Return those of some poses, with the drives at q, that ranges and cones allow."""
    low, high = _spans(drives, model.length)
    values = values_at(instance, R, T)
    values[:, drives.driven] = drives.rods[drives.driven]
    free = ~(np.isfinite(drives.low) & np.isfinite(drives.high))
    with np.errstate(invalid="ignore"):
        far = np.asarray(free & drives.moved & ~((q >= low) & (q <= high)))
    outside = (far, out_of_motor_range(drives, q), out_of_range(instance, values))
    kept: NDArray[np.bool_] = np.asarray(~np.concatenate(outside, axis=1).any(axis=1))
    some = np.flatnonzero(kept)
    kept[some] = ~out_of_cone(instance, R[some], T[some], q[some]).any(axis=1)
    readings = [
        one.readings(q[:, k]) for one, k in zip(model.drives, _columns(drives, model), strict=True)
    ]
    return Places(R, T, np.stack(readings, axis=1)).taken(kept)


def _following(
    instance: Instance, model: Model, R: Array, T: Array, random: np.random.Generator
) -> Places:
    """Return the poses that follow from home when all drives move to random numbers."""
    drives, start = drive_values(instance, R[None], T[None], along=False)
    low, high = _spans(drives, model.length)
    near = _FREE_PLACE * model.length
    low, high = (
        np.where(np.isfinite(e), e, start[0] + s * near) for e, s in ((low, -1), (high, 1))
    )
    q = random.uniform(low, high, (_TRIED // 4, drives.count))
    turned, places = np.tile(R, (len(q), 1, 1)), np.tile(T, (len(q), 1))
    off = np.zeros((len(q), 6))
    for step in np.linspace(0, 1, _STEPS + 1)[1:]:
        there = start + step * (q - start)
        bodies = drives.arrangement(there)
        wanted = np.where(drives.driven, drives.rods, there[:, drives.index])
        for _ in range(_NEWTON):
            J = jacobian(bodies, turned, places)
            inverse = np.linalg.pinv(np.nan_to_num(J))
            twist = apply(inverse, wanted - measured(bodies, turned, places))
            turned = rotation_from_vector(twist[:, :3]) @ turned
            places = places + twist[:, 3:]
        off = np.abs(wanted - measured(bodies, turned, places))
    arrived = off.max(axis=1) < _ARRIVED * model.length
    turned, places, q = turned[arrived], places[arrived], q[arrived]
    return _allowed_by_drives(instance, model, drives, turned, places, q)


def _signs(model: Model, places: Places) -> Array:
    """Return the signs of the determinants of the derivatives of values by pose, shape (n,)."""
    bodies = model.bodies(places.drives)
    with np.errstate(all="ignore"):
        signs: Array = np.linalg.slogdet(jacobian(bodies, places.R, places.T))[0]
    return signs
