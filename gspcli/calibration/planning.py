"""Which poses to measure: of those that the machine can take the ones that tell most.

Poses are chosen one by one so that the determinant of the information about the parameters is the
largest (D-optimal). Poses are eliminated as in the fit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
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
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine, value_machine
from gspcli.geometry.measurement import jacobian, measured, value_signs
from gspcli.geometry.quaternions import (
    apply,
    canonical_sign,
    quaternion_from_rotation,
    rotation_from_vector,
)
from gspcli.geometry.readings import readings_of
from gspcli.motion.poses.inverse_kinematics import drive_values
from gspcli.records import dataclass
from gspcli.ties import first_largest

Array = NDArray[np.float64]
Allowed = Callable[[Array, Array], NDArray[np.bool_]]

#: This many candidates at most; they are tried in this many rounds of this many.
_CANDIDATES = 3000
_ROUNDS, _TRIED = 200, 1000
#: Drives without a range move this far from home at most: values and slides in typical lengths,
#: angles and cranks in radians.
_FREE_VALUE, _FREE_SLIDE, _FREE_ANGLE, _FREE_CRANK = 0.1, 0.25, np.deg2rad(15), np.pi / 2
#: The platform follows its drives in this many steps of Newton's method, and some more at the end.
#: It is lost where values differ by more than the first, and has arrived where they differ by less
#: than the second of these parts of a typical length.
_STEPS, _POLISH, _NEAR, _ARRIVED = 16, 3, 0.1, 1e-11


class Places(NamedTuple):
    """Poses, shapes (n, 3, 3) and (n, 3), and the numbers q of the drives there, (n, m)."""

    R: Array
    T: Array
    q: Array

    def taken(self, rows: NDArray[np.intp] | NDArray[np.bool_] | slice) -> Places:
        """Return some of them."""
        return Places(self.R[rows], self.T[rows], self.q[rows])


def candidates(
    machine: Machine,
    R: Array,
    T: Array,
    seed: int,
    count: int | None = None,
    allowed: Allowed | None = None,
) -> Places:
    """Return poses that can be reached from home, at most ``count``.

    All drives move at once to random numbers in their ranges, and the platform follows them from
    home. A pose is kept if legs are in their cones.

    Values that stay do not move. Home has the shapes (3, 3) and (3,); `allowed` gives a mask of
    poses (R, T) that are allowed besides.

    Raises
    ------
    ArgumentError
        If home does not keep the limits or is not allowed, or there are no others about it.
    """
    count = _CANDIDATES if count is None else count
    _, q = drive_values(machine.instance, R[None], T[None], along=False)
    home = Places(R[None], T[None], q)
    if not machine.keeps(*home).all():
        raise ArgumentError("home does not keep the limits: choose another with --mode")
    if allowed is not None and not allowed(home.R, home.T).all():
        raise ArgumentError("home does not keep what is required of planned poses: require less")
    low, high = _spans(machine, q[0])
    if not (high > low).any():
        raise ArgumentError(
            "the ranges leave no room about home: as stated the machine cannot move\n"
            "widen the ranges to those that it can have, or leave them out; where cranks or slides "
            "drive it, state them"
        )
    random = np.random.default_rng(seed)
    found: list[Places] = []
    number = 0
    for _ in range(_ROUNDS):
        there = _followed(machine, home, random.uniform(low, high, (_TRIED, machine.count)))
        there = there.taken(machine.keeps(*there))
        if allowed is not None and len(there.T):
            there = there.taken(allowed(there.R, there.T))
        found.append(there)
        number += len(there.T)
        if number >= count:
            break
    if not number:
        what = "the ranges and cones" if allowed is None else "ranges, cones and what is required"
        raise ArgumentError(f"no pose about home keeps {what}: choose another with --mode")
    return Places(*map(np.concatenate, zip(*found, strict=True))).taken(slice(0, count))


def _spans(machine: Machine, home: Array) -> tuple[Array, Array]:
    """Return between which numbers drives move: their ranges, or as far as near home, (m,)."""
    length = machine.stated_arrangement.length
    values = np.where(machine.turns, _FREE_ANGLE, _FREE_VALUE * length)
    others = np.where(machine.turns, _FREE_CRANK, _FREE_SLIDE * length)
    far = np.where(machine.fixed[machine.first], 0.0, np.where(machine.moved, others, values))
    low, high = machine.low, machine.high
    beyond = machine.two_sided & (home < 0)
    low, high = np.where(beyond, -high, low), np.where(beyond, -low, high)
    stated = np.isfinite(high - low) & (far > 0)
    return np.where(stated, low, home - far), np.where(stated, high, home + far)


def _followed(machine: Machine, home: Places, q: Array) -> Places:
    """Return where the platform comes when all drives move straight from home to numbers.

    Those are left out that get lost, or pass a singular pose or a dead point.
    """
    n, length = len(q), machine.stated_arrangement.length
    there = Places(np.repeat(home.R, n, axis=0), np.repeat(home.T, n, axis=0), q)
    # Distances of two lines are followed with their sign.
    signs = value_signs(machine.arrangement(home.q), home.R, home.T)
    sides = _sides(machine, home)
    for step in (*np.linspace(0, 1, _STEPS + 1)[1:], *np.ones(_POLISH)):
        R, T, numbers = there.R, there.T, home.q + step * (there.q - home.q)
        bodies = machine.arrangement(numbers)
        wanted = np.where(machine.driven, machine.rods, signs * numbers[:, machine.index])
        inverse = np.linalg.pinv(np.nan_to_num(jacobian(bodies, R, T)))
        twist = apply(inverse, wanted - measured(bodies, R, T))
        R, T = rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]
        off = np.abs(wanted - measured(bodies, R, T)).max(axis=1)
        kept = (off < _NEAR * length) & (_sides(machine, Places(R, T, numbers)) == sides).all(
            axis=1
        )
        there = Places(R, T, there.q).taken(kept)
    return there.taken(np.asarray(off[kept] < _ARRIVED * length))


def _sides(machine: Machine, places: Places) -> Array:
    """Return the signs of the determinant of the Jacobian matrix and of the gains, (n, 7)."""
    with np.errstate(all="ignore"):
        determinants = np.linalg.slogdet(np.nan_to_num(machine.jacobian(*places)))[0]
        return np.column_stack((determinants, np.sign(machine.gains(*places))))


#: A number is hardly determined if its deviation stays above this part of the one before.
_HARDLY = 0.5


def d_optimal(slopes: Array, count: int, before: Array) -> NDArray[np.intp]:
    """Return the indices of poses, chosen one by one for the largest determinant of information.

    One may be chosen more than once. Slopes are whitened derivatives of what each of c poses tells,
    (c, q, f), `before` is the information matrix of what is known, (f, f).
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
    """Poses to measure, and what will be known then."""

    #: The platform as stated, with its drives where they are read.
    machine: Machine
    #: The poses, shapes (n, 3, 3) and (n, 3).
    R: Array
    T: Array
    #: What the machine reads there as it is stated, in the units of the instance, shape (n, 6).
    readings: Array
    #: The readings of its cranks and slides by their names, each (n,).
    drives: dict[str, Array]
    #: The numbers that will be found, and their standard deviations, shape (m,).
    names: tuple[str, ...]
    sigma: Array
    #: The same without the plan: what is known before, and from data if there are any.
    before: Array
    #: Of how many poses they were chosen.
    candidates: int
    #: How many of the numbers will not be known twice as well as before all measurements.
    untold: int

    def __repr__(self) -> str:
        return f"<Plan: {len(self.R)} poses of {self.candidates}, {self.sentences[-1]}>"

    def expressed(self, frame: PoseFrame) -> Array:
        """Return positions and unit quaternions of the poses in a frame, shape (n, 7)."""
        R, T = frame.from_platform(self.R, self.T)
        return np.hstack((T, canonical_sign(quaternion_from_rotation(R))))

    @property
    def limited(self) -> bool:
        """Whether all drives have ranges; others go no farther than near home."""
        return bool(np.isfinite(self.machine.high - self.machine.low).all())

    @cached_property
    def sentences(self) -> list[str]:
        """What will be known, in words."""
        unit = self.machine.instance.units.length
        how = "within ranges and cones"
        how += "" if self.limited else ", and near home where SPEC states no range"
        lines = [f"{len(self.R)} of {self.candidates} poses {how}"]
        lengths = [
            k for k, name in enumerate(self.names) if not any(w in name for w in _NO_LENGTHS)
        ]
        if lengths:
            sigma = self.sigma[lengths]
            worst = lengths[int(first_largest(sigma))]
            lines.append(
                f"then known: lengths to {np.median(sigma):.2g} {unit} (median), "
                f"{self.names[worst]} to {sigma.max():.2g} (worst; {self.before[worst]:.2g} before)"
            )
        if self.untold:
            lines.append(
                f"{self.untold} of {len(self.names)} numbers will not even be known twice as well "
                "as now: for that these poses are too few, or too much alike"
            )
        return lines

    def to_json(self) -> dict[str, Any]:
        """Return the plan as plain data."""
        parts = (self.R.tolist(), self.T.tolist(), self.readings.tolist())
        poses = [{"R": R, "T": T, "values": row} for R, T, row in zip(*parts, strict=True)]
        for k, pose in enumerate(poses if self.drives else ()):
            pose["drives"] = {name: float(read[k]) for name, read in self.drives.items()}
        known = zip(self.names, self.sigma.tolist(), self.before.tolist(), strict=True)
        return {
            **self.machine.instance.to_json(),
            "plan": poses,
            "limited": self.limited,
            "candidates": self.candidates,
            "expected": [{"name": name, "sigma": s, "before": b} for name, s, b in known],
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
    options, machine = options or Options(), Machine.of(instance)
    if seen is not None and seen.drives is None:
        machine = value_machine(instance)
    model = chosen_model(instance, options, drives=machine.moves)
    noise = noise_of(model, sigma or {})
    places = candidates(machine, R, T, seed, allowed=allowed)
    prior = prior_of(options, model)
    nothing = before = np.eye(int(model.free.sum())) / prior**2
    if seen is not None:
        # Where the machine is best known, the poses to come tell what they will.
        seen = constant_rods(instance, model, seen)
        found = fit(*started(instance, model, seen, noise)[:3], seen, noise, prior=prior)
        model = found.model
        scaled = found.directions * found.singular[:, None]
        before = before + scaled.T @ scaled
    slopes = told_by(model, machine, places, seen, noise)
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
    read = machine.readings(there.q).T
    return Plan(
        machine=machine,
        R=there.R,
        T=there.T,
        readings=readings_of(instance, machine.values(there.R, there.T)),
        drives={machine.names[k]: read[k] for k in np.flatnonzero(machine.moved).tolist()},
        names=tuple(np.array(numbers.names)[told].tolist()),
        sigma=known,
        before=deviations(before),
        candidates=len(places.T),
        untold=untold,
    )


def told_by(
    model: Model, machine: Machine, places: Places, seen: Measurements | None, noise: Noise
) -> Array:
    """Return the derivatives of what each pose tells by the scaled free parameters, (n, q, f).

    Without measurements before whole poses and all values are measured, but for constants.
    """
    if seen is None:
        readings = np.where(machine.driven | machine.fixed, np.nan, 0.0)[None]
        seen = Measurements(readings, np.eye(3)[None], np.zeros((1, 3)), np.zeros(3))
        seen = replace(seen, drives=np.zeros((1, 0)) if model.drives else None)
        seen = constant_rods(machine.instance, model, seen)
    drives = None
    if model.drives:
        columns = [machine.names.index(drive.drive_name) for drive in model.drives]
        drives = (machine.readings(places.q) * machine.units)[:, columns]
    there = alike(seen, places.R, places.T, drives)
    slopes = reduced(model, places.R, places.T, there, noise).slopes * model.sizes[model.free]
    return np.asarray(slopes.reshape(len(places.R), -1, slopes.shape[1]))
