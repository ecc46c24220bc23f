"""Which poses to measure: of those that the machine can take the ones that tell most.

Poses are chosen one by one so that the determinant of the information about the parameters is the
largest (D-optimal). Poses are eliminated as in the fit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.calibrating import Options, chosen_model, noise_of, prior_of
from gspcli.calibration.fitting import fit, reduced, started
from gspcli.calibration.measurements import Measurements, Noise, alike, constant_rods
from gspcli.calibration.model import Model, file_numbers
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import (
    apply,
    canonical_sign,
    quaternion_from_rotation,
    rotation_from_vector,
)
from gspcli.geometry.readings import readings_of
from gspcli.motion.poses.inverse_kinematics import drive_values, values_at
from gspcli.motion.workspace.travels import travels
from gspcli.records import dataclass
from gspcli.ties import first_largest

# Poses that a machine can take, from which those to measure are chosen.
#
# They are spread over the box of poses that the travel from home spans. A pose is kept if all
# values are in their ranges, all legs are in their cones, and the determinant has the sign that it
# has at home, so that no singular pose lies between.
#
# A leg that a crank or a slide moves keeps its length, and the drive moves to where the leg
# reaches. Then the box is as wide as the cranks are long and the rails go, and poses that the legs
# do not reach are left out. A machine whose legs share drives reaches almost none of these poses:
# its drives are moved at random, and the platform follows them from home.


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
        raise ArgumentError("home does not keep the limits: choose another with --mode")
    if allowed is not None and not allowed(home.R, home.T).all():
        raise ArgumentError("home does not keep what is required of planned poses: require less")
    low, high = _box(instance, model, R, T)
    if not (high > low).any():
        raise ArgumentError(
            "the ranges and cones leave no room about home: as stated the machine cannot move\n"
            "widen the ranges to those that it can have, or leave them out; where cranks or slides "
            "drive it, state them"
        )
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
        raise ArgumentError(f"no pose about home keeps {what}: choose another with --mode")
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
    if not Machine.of(instance).limited:
        box = np.array([_FREE_PLACE * arrangement.length] * 3 + [_FREE_TURN] * 3)
        return -box, box
    unit = np.array([1.0] * 3 + [arrangement.in_radians] * 3)
    span = np.array([one.reached for one in travels(instance, R, T, connected=True)])
    if not span.any():
        raise ArgumentError("the ranges leave no room about home: every change leaves one")
    # Unlimited travel goes no farther than what is near.
    far = np.where(np.isfinite(span).all(axis=1) & (unit == 1.0), np.inf, np.pi / 2)
    return np.maximum(span[:, 0] * unit, -far), np.minimum(span[:, 1] * unit, far)


def _reaches(instance: Instance, model: Model) -> list[float]:
    """Return the lengths of the arms of cranks, and how far slides go at most."""
    points = {(b.body, b.name): b.point for b in model.blocks if b.sort == "point"}
    low, high = _spans(Machine.of(instance), model.length)
    numbers = _columns(Machine.of(instance), model)
    found = []
    for drive, k in zip(model.drives, numbers, strict=True):
        if drive.sort == "slide":
            found.append(float(max(abs(low[k]), abs(high[k]))))
            continue
        arms = [points[drive.body, name] - drive.point for name in drive.carried]
        found.append(max(float(np.linalg.norm(np.cross(arm, drive.unit))) for arm in arms))
    return found


def _spans(drives: Machine, length: float) -> tuple[Array, Array]:
    """Return between which numbers drives move, shapes (m,): their ranges, or as far as here."""
    usual = {"crank": CRANK_TURN, "slide": SLIDE_SHIFT * length, "value": np.inf}
    far = np.array([usual[sort] for sort in drives.sorts])
    return (
        np.where(np.isfinite(drives.low), drives.low, -far),
        np.where(np.isfinite(drives.high), drives.high, far),
    )


def _columns(drives: Machine, model: Model) -> list[int]:
    """Return which of the drives each drive of the model is."""
    return [drives.names.index(one.drive_name) for one in model.drives]


def _kept(instance: Instance, model: Model, R: Array, T: Array) -> Places:
    """Return those of some poses that drives reach and at which ranges and cones are kept."""
    if not model.drives:
        return Places(R, T, None).taken(Machine.of(instance).keeps(R, T))
    drives, q = drive_values(instance, R, T, along=False)
    return _allowed_by_drives(instance, model, drives, R, T, q)


def _allowed_by_drives(
    instance: Instance, model: Model, drives: Machine, R: Array, T: Array, q: Array
) -> Places:
    """Return those of some poses, with the drives at q, that ranges and cones allow."""
    low, high = _spans(drives, model.length)
    free = ~(np.isfinite(drives.low) & np.isfinite(drives.high))
    with np.errstate(invalid="ignore"):
        far = np.asarray(free & drives.moved & ~((q >= low) & (q <= high)))
    kept = drives.keeps(R, T, q) & ~far.any(axis=1)
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


#: A number is hardly determined if its deviation stays above this part of the one before.
_HARDLY = 0.5


def d_optimal(slopes: Array, count: int, before: Array) -> NDArray[np.intp]:
    """Return the indices of poses, chosen one by one for the largest determinant of information.

    Parameters
    ----------
    slopes
        Whitened derivatives of what each of c poses tells, shape (c, q, f).
    count
        How many poses; one may be chosen more than once.
    before
        What is known before, an information matrix, shape (f, f).
    """
    eye = np.eye(slopes.shape[1])
    inverse, chosen = np.linalg.inv(before), []
    for _ in range(count):
        told = eye + slopes @ inverse @ np.swapaxes(slopes, 1, 2)
        best = int(first_largest(np.linalg.slogdet(told)[1]))
        chosen.append(best)
        # Woodbury's formula.
        moved = inverse @ slopes[best].T
        inverse = inverse - moved @ np.linalg.solve(eye + slopes[best] @ moved, moved.T)
    return np.array(chosen, np.intp)


@dataclass(frozen=True, eq=False)
class Plan:
    """Poses to measure, and what will be known then.

    Attributes
    ----------
    instance
        The platform as stated.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    readings
        What the machine reads there as it is stated, in the units of the instance, shape (n, 6).
    drive_names, driven, drives
        The cranks and slides that drive it, the constraints of their legs, from 0, and their
        readings, in the units of the instance, shape (n, m); m is 0 where none does.
    names, sigma
        The numbers that will be found, and their standard deviations, shape (m,).
    before
        The same without the plan: what is known before, and from data if there are any.
    limited
        Whether the poses are limited by ranges and cones, and not only by what is near home.
    candidates
        Of how many poses they were chosen.
    untold
        How many of the numbers will not be known twice as well as before all measurements.
    """

    instance: Instance
    R: Array
    T: Array
    readings: Array
    drive_names: tuple[str, ...]
    driven: tuple[int, ...]
    drives: Array
    names: tuple[str, ...]
    sigma: Array
    before: Array
    limited: bool
    candidates: int
    untold: int

    def __repr__(self) -> str:
        return f"<Plan: {len(self.R)} poses of {self.candidates}, {self.sentences[-1]}>"

    @cached_property
    def pose_numbers(self) -> Array:
        """Positions and unit quaternions of the poses, shape (n, 7)."""
        return self.expressed(IDENTITY)

    def expressed(self, frame: PoseFrame) -> Array:
        """Return positions and unit quaternions of the poses in a frame, shape (n, 7)."""
        R, T = frame.from_platform(self.R, self.T)
        return np.hstack((T, canonical_sign(quaternion_from_rotation(R))))

    @cached_property
    def sentences(self) -> list[str]:
        """What will be known, in words."""
        units = self.instance.units
        how = "within ranges and cones" if self.limited else "near home: SPEC states no limits"
        if self.drive_names:
            how = f"within reach of the {self._how_far()}"
        lines = [f"{len(self.R)} of {self.candidates} poses {how}"]
        lengths = [
            k for k, name in enumerate(self.names) if not any(w in name for w in _NO_LENGTHS)
        ]
        if lengths:
            sigma = self.sigma[lengths]
            worst = lengths[int(first_largest(sigma))]
            lines.append(
                f"then known: lengths to {np.median(sigma):.2g} {units.length} (median), "
                f"{self.names[worst]} to {sigma.max():.2g} (worst; {self.before[worst]:.2g} before)"
            )
        if self.untold:
            lines.append(
                f"{self.untold} of {len(self.names)} numbers will not even be known twice as well "
                "as now: for that these poses are too few, or too much alike"
            )
        return lines

    def _how_far(self) -> str:
        """Return which drives there are, and how far those without a range move."""
        drives = Machine.of(self.instance)
        free = ~(np.isfinite(drives.low) & np.isfinite(drives.high))
        open_ended = {sort for sort, one in zip(drives.sorts, free, strict=True) if one}
        sorts = [sort for sort in ("crank", "slide") if sort in drives.sorts]
        parts = {
            "crank": f"turned by up to {np.rad2deg(CRANK_TURN):g} deg",
            "slide": f"moved by up to {SLIDE_SHIFT * Arrangement.of(self.instance).length:.3g} "
            f"{self.instance.units.length}",
        }
        limits = [parts[sort] for sort in sorts if sort in open_ended]
        return ", ".join([" and ".join(f"{sort}s" for sort in sorts), *limits])

    def to_json(self) -> dict[str, Any]:
        """Return the plan as plain data."""
        return {
            **self.instance.to_json(),
            "plan": [
                {"R": R, "T": T, "values": row}
                | ({"drives": dict(zip(self.drive_names, drives, strict=True))} if drives else {})
                for R, T, row, drives in zip(
                    self.R.tolist(),
                    self.T.tolist(),
                    self.readings.tolist(),
                    self.drives.tolist(),
                    strict=True,
                )
            ],
            "limited": self.limited,
            "candidates": self.candidates,
            "expected": [
                {"name": name, "sigma": s, "before": b}
                for name, s, b in zip(
                    self.names, self.sigma.tolist(), self.before.tolist(), strict=True
                )
            ],
        }


_NO_LENGTHS = ("direction.", "normal.", "axis.", "scale", "crank.offset", ".rx", ".ry", ".rz")


def planned(
    instance: Instance,
    count: int,
    R: Array,
    T: Array,
    *,
    seen: Measurements | None = None,
    sigma: Mapping[str, float] | None = None,
    options: Options | None = None,
    seed: int = SEED,
    allowed: Allowed | None = None,
) -> Plan:
    """Return the poses to measure that tell most of the numbers of a platform.

    Parameters
    ----------
    instance
        The platform as stated.
    count
        How many poses.
    R, T
        Home: a pose from which they can be reached, shapes (3, 3) and (3,).
    seen
        What has been measured already; the sorts of what was measured are those of the poses to
        come. Whole poses and all six values if None.
    sigma, options
        As for `gspcli.calibration.calibrate_rows`.
    seed
        Of the candidates.
    allowed
        Which of some poses R, T may be planned, besides ranges and cones; returns a mask.

    Raises
    ------
    ArgumentError
        If home does not keep the limits, or there are no poses about it.
    IncompleteError
        If the poses there are so much alike that they tell nothing.
    """
    options = options or Options()
    machine = Machine.of(instance)
    driven = machine.moves if seen is None else seen.drives is not None
    model = chosen_model(instance, options, drives=driven)
    noise = noise_of(model, sigma or {})
    places = candidates(instance, model, R, T, seed, allowed=allowed)
    prior = prior_of(options, model)
    nothing = before = np.eye(int(model.free.sum())) / prior**2
    if seen is not None:
        # Where the machine is best known, the poses to come tell what they will.
        seen = constant_rods(instance, model, seen)
        found = fit(*started(instance, model, seen, noise)[:3], seen, noise, prior=prior)
        model = found.model
        scaled = found.directions * found.singular[:, None]
        before = before + scaled.T @ scaled
    slopes = told_by(model, places, seen, noise)
    chosen = d_optimal(slopes, count, before)
    after = before + np.einsum("kqa,kqb->ab", slopes[chosen], slopes[chosen])
    numbers = file_numbers(instance, model)
    by = numbers.slopes[:, model.free] * model.sizes[model.free]
    told = (by != 0).any(axis=1)

    def deviations(known: Array) -> Array:
        inverse = np.linalg.inv(known)
        return np.asarray(np.sqrt(np.einsum("ma,ab,mb->m", by[told], inverse, by[told])))

    known = deviations(after)
    untold = int((known > _HARDLY * deviations(nothing)).sum())
    if untold == len(known) and 6 * count >= len(nothing):
        raise IncompleteError(
            f"the poses within ranges and cones are so much alike that {count} of them would tell "
            "no number even twice as well as it is known now\n"
            "widen the ranges to those that the machine can have, or measure more exactly (--sigma)"
        )
    there = places.taken(chosen)
    return Plan(
        instance=instance,
        R=there.R,
        T=there.T,
        readings=readings_of(instance, _values(instance, model, there)),
        drive_names=tuple(one.drive_name for one in model.drives),
        driven=tuple(k for one in model.drives for k in one.rows),
        drives=np.zeros((count, 0)) if there.drives is None else there.drives / model.drive_units,
        names=tuple(np.array(numbers.names)[told].tolist()),
        sigma=known,
        before=deviations(before),
        limited=machine.limited,
        candidates=len(places.T),
        untold=untold,
    )


def _values(instance: Instance, model: Model, places: Places) -> Array:
    """Return the values at poses; those of legs with drives are as stated."""
    values = values_at(instance, places.R, places.T)
    for drive in model.drives:
        rows = list(drive.rows)
        values[:, rows] = [instance.constraints[k].value.value for k in rows]
    return values


def told_by(model: Model, places: Places, seen: Measurements | None, noise: Noise) -> Array:
    """Return the derivatives of what each pose tells by the scaled free parameters, (n, q, f)."""
    one = _whole(model, places) if seen is None else alike(seen, *places)
    slopes = reduced(model, places.R, places.T, one, noise).slopes * model.sizes[model.free]
    return np.asarray(slopes.reshape(len(places.R), -1, slopes.shape[1]))


def _whole(model: Model, places: Places) -> Measurements:
    """Return measurements of whole poses and of all values; rods that drives move are not read."""
    n, rods = len(places.T), np.zeros(len(model.kinds), bool)
    rods[[k for drive in model.drives for k in drive.rows]] = True
    return Measurements(
        np.zeros((n, 6)),
        places.R,
        places.T,
        np.zeros(3),
        drives=places.drives,
        rods=rods,
        lines=("",) * n,
    )
