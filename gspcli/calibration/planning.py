"""Which poses to measure: of those that the machine can take the ones that tell most.

Poses are chosen one by one so that the determinant of the information about the parameters is the
largest (D-optimal). Poses are eliminated as in the fit.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.candidate_poses import (
    CRANK_TURN,
    SLIDE_SHIFT,
    Allowed,
    Places,
    candidates,
)
from gspcli.calibration.fitting import fit, reduced
from gspcli.calibration.measurements import (
    Measurements,
    Noise,
    alike,
    constant_rods,
)
from gspcli.calibration.numbers import file_numbers
from gspcli.calibration.options import Options, chosen_model, noise_of, prior_of
from gspcli.calibration.parameters import Model
from gspcli.calibration.starts import started
from gspcli.defaults import SEED
from gspcli.errors import IncompleteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives, is_driven
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import has_limits
from gspcli.geometry.quaternions import canonical_sign, quaternion_from_rotation
from gspcli.geometry.readings import readings_of
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.records import dataclass
from gspcli.ties import first_largest

Array = NDArray[np.float64]

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
        drives = Drives.of(self.instance)
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

    def _driven_json(self, readings: list[float]) -> dict[str, dict[str, float]]:
        """Return the readings of the drives of a pose by their names; those of cranks twice."""
        if not readings:
            return {}
        drives = dict(zip(self.drive_names, readings, strict=True))
        cranks = {name: angle for name, angle in drives.items() if name.startswith("crank.")}
        return {"drives": drives} | ({"cranks": cranks} if cranks else {})

    def to_json(self) -> dict[str, Any]:
        """Return the plan as plain data."""
        return {
            **self.instance.to_json(),
            "plan": [
                {"R": R, "T": T, "values": row} | self._driven_json(drives)
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


def _too_much_alike(count: int) -> IncompleteError:
    message = (
        f"the poses within ranges and cones are so much alike that {count} of them would tell "
        "no number even twice as well as it is known now\n"
        "widen the ranges to those that the machine can have, or measure more exactly (--sigma)"
    )
    return IncompleteError(message)


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
    driven = is_driven(instance) if seen is None else seen.drives is not None
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
        raise _too_much_alike(count)
    there = places.taken(chosen)
    return Plan(
        instance=instance,
        R=there.R,
        T=there.T,
        readings=readings_of(instance, _values(instance, model, there)),
        drive_names=tuple(one.drive_name for one in model.drives),
        driven=tuple(k for one in model.drives for k in one.rows),
        drives=np.zeros((count, 0)) if there.drives is None else there.drives / _units(model),
        names=tuple(np.array(numbers.names)[told].tolist()),
        sigma=known,
        before=deviations(before),
        limited=has_limits(instance),
        candidates=len(places.T),
        untold=untold,
    )


def _units(model: Model) -> Array:
    """Return the units of the readings of drives in radians and lengths, shape (m,)."""
    return np.array([model.in_radians if one.sort == "crank" else 1.0 for one in model.drives])


def _values(instance: Instance, model: Model, places: Places) -> Array:
    """Return the values at poses; those of legs with drives are as stated."""
    values = values_at(instance, places.R, places.T)
    for drive in model.drives:
        rows = list(drive.rows)
        values[:, rows] = [instance.constraints[k].value.value for k in rows]
    return values


def told_by(model: Model, places: Places, seen: Measurements | None, noise: Noise) -> Array:
    """Return the derivatives of what each pose tells by the scaled free parameters, (n, q, f)."""
    R, T, _ = places
    n = len(R)
    one = _whole(model, places) if seen is None else alike(seen, *places)
    slopes = reduced(model, R, T, one, noise).slopes * model.sizes[model.free]
    found: Array = slopes.reshape(n, -1, slopes.shape[1])
    return found


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
