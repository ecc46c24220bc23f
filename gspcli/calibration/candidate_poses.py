"""Poses that a machine can take, from which those to measure are chosen.

They are spread over the box of poses that the travel from home spans, and kept if all ranges and
cones are kept and no singular pose is between (the sign of the determinant is that of home). Where
cranks drive the machine, a leg with one keeps its length, and the crank turns to where the leg
reaches: the box is as wide as the cranks are long, and poses out of their reach are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.parameters import Model
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import moved
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import has_limits, joint_cones, out_of_cone, out_of_range, within_limits
from gspcli.geometry.measurement import jacobian
from gspcli.motion import crank_angles
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.workspace.travels import travels

Array = NDArray[np.float64]
Allowed = Callable[[Array, Array], NDArray[np.bool_]]

_CANDIDATES = 3000
#: Candidates are tried in so many rounds of so many.
_ROUNDS, _TRIED = 50, 4000
#: How far poses go where nothing limits them: in typical lengths, and radians.
_FREE_PLACE, _FREE_TURN = 0.1, np.deg2rad(15)
#: Cranks, whose angles have no range in a file, turn no farther from where they are stated.
CRANK_TURN = np.pi / 2


class Places(NamedTuple):
    """Poses, shapes (n, 3, 3) and (n, 3), and the angles of m cranks there, radians, (n, m)."""

    R: Array
    T: Array
    cranks: Array | None

    def taken(self, rows: NDArray[np.intp] | NDArray[np.bool_] | slice) -> Places:
        """Return some of them."""
        return Places(
            self.R[rows], self.T[rows], None if self.cranks is None else self.cranks[rows]
        )


def candidates(
    instance: Instance,
    model: Model,
    R: Array,
    T: Array,
    seed: int,
    count: int = _CANDIDATES,
    allowed: Allowed | None = None,
) -> Places:
    """Return poses that can be reached from home, at most ``count``.

    Parameters
    ----------
    instance, model
        The platform, and its model: with cranks if they drive it.
    R, T
        Home, shapes (3, 3) and (3,).
    seed
        Of the random numbers.
    count
        How many.
    allowed
        Which of some poses (R, T) are allowed besides, a mask; all if None.

    Raises
    ------
    ArgumentError
        If home does not keep the limits or is not allowed, or there are no others about it.
    """
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
            "widen the ranges to those that it can have, or leave them out; where cranks drive it, "
            "state them"
        )
        raise ArgumentError(message)
    random = np.random.default_rng(seed)
    sign = _signs(model, home)[0]
    found: list[Places] = []
    number = 0
    for _ in range(_ROUNDS):
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
    cranks = [one.cranks for one in found if one.cranks is not None]
    return Places(turns, places, np.concatenate(cranks)[:count] if cranks else None)


def _box(instance: Instance, model: Model, R: Array, T: Array) -> tuple[Array, Array]:
    """Return how far candidates are from home, down and up: x, y, z and three turns."""
    arrangement = Arrangement.of(instance)
    if model.cranks:
        points = {(b.body, b.name): b.point for b in model.blocks if b.sort == "point"}
        arms = [
            float(np.linalg.norm(np.cross(points[b.body, b.name] - b.point, b.unit)))
            for b in model.cranks
        ]
        turn = min(max(arms) / arrangement.extent, np.pi / 4) if arrangement.extent else np.pi / 4
        box = np.array([max(arms)] * 3 + [turn] * 3)
        return -box, box
    if not has_limits(instance):
        box = np.array([_FREE_PLACE * arrangement.length] * 3 + [_FREE_TURN] * 3)
        return -box, box
    unit = np.array([1.0] * 3 + [arrangement.in_radians] * 3)
    span = np.array([one.reached for one in travels(instance, R, T, connected=True)])
    # Unlimited travel goes no farther than what is near.
    far = np.where(np.isfinite(span).all(axis=1) & (unit == 1.0), np.inf, np.pi / 2)
    return np.maximum(span[:, 0] * unit, -far), np.minimum(span[:, 1] * unit, far)


def _kept(instance: Instance, model: Model, R: Array, T: Array) -> Places:
    """Return those of some poses that cranks reach and at which ranges and cones are kept."""
    values = values_at(instance, R, T)
    if not model.cranks:
        return Places(R, T, None).taken(within_limits(instance, values, R, T))
    chosen, degrees = crank_angles(instance, R, T, along=False)
    angles = degrees * model.in_radians
    for crank in model.cranks:
        rows = list(crank.rows)
        values[:, rows] = [instance.constraints[k].value.value for k in rows]
    with np.errstate(invalid="ignore"):
        near = np.abs(angles) <= CRANK_TURN
    kept = np.all(np.concatenate((near, ~out_of_range(instance, values)), axis=1), axis=1)
    if joint_cones(instance):
        for k in np.flatnonzero(kept).tolist():
            there = moved(instance, chosen, degrees[k])
            kept[k] = not out_of_cone(there, R[k : k + 1], T[k : k + 1]).any()
    return Places(R, T, angles).taken(kept)


def _signs(model: Model, places: Places) -> Array:
    """Return the signs of the determinants of the derivatives of values by pose, shape (n,)."""
    bodies = model.bodies(places.cranks)
    with np.errstate(all="ignore"):
        signs: Array = np.linalg.slogdet(jacobian(bodies, places.R, places.T))[0]
    return signs
