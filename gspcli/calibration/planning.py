"""Which poses to measure: of those that the machine can take the ones that tell most.

Candidates are spread over the box of poses that the travel from home spans, and kept if all ranges
and cones are kept and no singular pose is between (the sign of the determinant is that of home).
Poses are chosen one by one so that the determinant of the information about the parameters is the
largest (D-optimal), and then exchanged one for one (Fedorov 1972) so that the mean square error of
the platform's points, over the candidates, is the least (I-optimal). With D-optimal exchanges 12
poses are 5 % worse than 30 random ones in the pose, though better in the numbers; with these they
are better in both. Poses are eliminated as in the fit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.fitting import fit, reduced
from gspcli.calibration.measurements import Measurements, Noise, hat, value_rows
from gspcli.calibration.numbers import file_numbers
from gspcli.calibration.options import PRIOR, Options, chosen_model, noise_of
from gspcli.calibration.parameters import Model
from gspcli.calibration.starts import started
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import has_limits, within_limits
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.quaternions import canonical_sign, quaternion_from_rotation
from gspcli.geometry.readings import readings_of
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.workspace.travels import travels
from gspcli.records import dataclass

Array = NDArray[np.float64]

_CANDIDATES = 3000
#: Candidates are tried in so many rounds of so many.
_ROUNDS, _TRIED = 50, 4000
#: How far poses go where nothing limits them: in typical lengths, and radians.
_FREE_PLACE, _FREE_TURN = 0.1, np.deg2rad(15)
#: So often each pose is exchanged for a better one.
_EXCHANGES = 5
#: Errors of the pose are averaged over so many candidates.
_ERRORS = 300


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
    names, sigma
        The numbers that will be found, and their standard deviations, shape (m,).
    before
        The same without the plan: what is known before, and from data if there are any.
    limited
        Whether the poses are limited by ranges and cones, and not only by what is near home.
    candidates
        Of how many poses they were chosen.
    """

    instance: Instance
    R: Array
    T: Array
    readings: Array
    names: tuple[str, ...]
    sigma: Array
    before: Array
    limited: bool
    candidates: int

    def __repr__(self) -> str:
        return f"<Plan: {len(self.R)} poses of {self.candidates}, {self.sentences[-1]}>"

    @cached_property
    def pose_numbers(self) -> Array:
        """Positions and unit quaternions of the poses, shape (n, 7)."""
        return np.hstack((self.T, canonical_sign(quaternion_from_rotation(self.R))))

    @cached_property
    def sentences(self) -> list[str]:
        """What will be known, in words."""
        units = self.instance.units
        how = "within ranges and cones" if self.limited else "near home: SPEC states no limits"
        lines = [f"{len(self.R)} of {self.candidates} poses {how}"]
        lengths = [
            k for k, name in enumerate(self.names) if not any(w in name for w in _NO_LENGTHS)
        ]
        if lengths:
            sigma = self.sigma[lengths]
            worst = lengths[int(sigma.argmax())]
            lines.append(
                f"then known: lengths to {np.median(sigma):.2g} {units.length} (median), "
                f"{self.names[worst]} to {sigma.max():.2g} (worst; {self.before[worst]:.2g} before)"
            )
        return lines

    def to_json(self) -> dict[str, Any]:
        """Return the plan as plain data."""
        return {
            **self.instance.to_json(),
            "plan": [
                {"R": R, "T": T, "values": row}
                for R, T, row in zip(
                    self.R.tolist(), self.T.tolist(), self.readings.tolist(), strict=True
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


_NO_LENGTHS = ("direction.", "normal.", "axis.", "scale.", ".rx", ".ry", ".rz")


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

    Raises
    ------
    ArgumentError
        If home does not keep the limits, or there are no poses about it.
    """
    options = options or Options()
    model = chosen_model(instance, options, cranks=False)
    noise = noise_of(model, sigma or {})
    places = candidates(instance, R, T, seed)
    prior = options.prior or PRIOR * model.length
    before = np.eye(int(model.free.sum())) / prior**2
    if seen is not None:
        # Where the machine is best known, the poses to come tell what they will.
        found = fit(*started(instance, model, seen, noise), seen, noise, prior=prior)
        model = found.model
        scaled = found.directions * found.singular[:, None]
        before = before + scaled.T @ scaled
    slopes = told_by(model, *places, seen, noise)
    errors = pose_errors(model, *places)
    chosen = exchanged(slopes, d_optimal(slopes, count, before), before, errors)
    after = before + np.einsum("kqa,kqb->ab", slopes[chosen], slopes[chosen])
    numbers = file_numbers(instance, model)
    by = numbers.slopes[:, model.free] * model.sizes[model.free]
    told = (by != 0).any(axis=1)

    def deviations(known: Array) -> Array:
        inverse = np.linalg.inv(known)
        return np.asarray(np.sqrt(np.einsum("ma,ab,mb->m", by[told], inverse, by[told])))

    R, T = places[0][chosen], places[1][chosen]
    return Plan(
        instance=instance,
        R=R,
        T=T,
        readings=readings_of(instance, values_at(instance, R, T)),
        names=tuple(np.array(numbers.names)[told].tolist()),
        sigma=deviations(after),
        before=deviations(before),
        limited=has_limits(instance),
        candidates=len(places[0]),
    )


def candidates(
    instance: Instance, R: Array, T: Array, seed: int, count: int = _CANDIDATES
) -> tuple[Array, Array]:
    """Return poses that can be reached from home, at most ``count``, shapes (n, 3, 3), (n, 3).

    Raises
    ------
    ArgumentError
        If home does not keep the limits, or there are no others about it.
    """
    arrangement = Arrangement.of(instance)
    box = np.array([_FREE_PLACE * arrangement.length] * 3 + [_FREE_TURN] * 3)
    low, high = -box, box
    if has_limits(instance):
        unit = np.array([1.0] * 3 + [arrangement.in_radians] * 3)
        span = np.array([one.reached for one in travels(instance, R, T, connected=True)])
        # Unlimited travel goes no farther than what is near.
        far = np.where(np.isfinite(span).all(axis=1) & (unit == 1.0), np.inf, np.pi / 2)
        low = np.maximum(span[:, 0] * unit, -far)
        high = np.minimum(span[:, 1] * unit, far)
    random = np.random.default_rng(seed)
    centre = arrangement.platform_centre
    sign = np.linalg.slogdet(jacobian(arrangement, R, T))[0]
    found: list[tuple[Array, Array]] = []
    number = 0
    for _ in range(_ROUNDS):
        change = random.uniform(low, high, (_TRIED, 6))
        turned = rotation_from_euler("ZYX", change[:, 3:]) @ R
        moved = T + R @ centre + change[:, :3] - turned @ centre
        kept = within_limits(instance, values_at(instance, turned, moved), turned, moved)
        with np.errstate(all="ignore"):
            kept &= np.linalg.slogdet(jacobian(arrangement, turned, moved))[0] == sign
        found.append((turned[kept], moved[kept]))
        number += int(kept.sum())
        if number >= count:
            break
    if not number:
        message = "no pose about home keeps the ranges and cones: choose another with --mode"
        raise ArgumentError(message)
    turns, places = (np.concatenate(part)[:count] for part in zip(*found, strict=True))
    return turns, places


def told_by(model: Model, R: Array, T: Array, seen: Measurements | None, noise: Noise) -> Array:
    """Return the derivatives of what each pose tells by the scaled free parameters, (n, q, f)."""
    n = len(R)
    one = Measurements(np.zeros((n, 6)), R, T, np.zeros(3), lines=("",) * n)
    if seen is not None:
        one = _alike(seen, R, T)
    slopes = reduced(model, R, T, one, noise).slopes * model.sizes[model.free]
    found: Array = slopes.reshape(n, -1, slopes.shape[1])
    return found


def _alike(seen: Measurements, R: Array, T: Array) -> Measurements:
    """Return measurements at poses of the sorts that were made, as they would be without errors."""
    n, nothing = len(R), np.nan
    readings = np.where(np.isfinite(seen.readings).any(axis=0), 0.0, nothing)
    turned = bool(np.isfinite(seen.rotations).any())
    placed = bool(np.isfinite(seen.positions).any())
    return replace(
        seen,
        readings=np.tile(readings, (n, 1)),
        rotations=R if turned else np.full((n, 3, 3), nothing),
        positions=T + R @ seen.pivot if placed else np.full((n, 3), nothing),
        points={name: np.zeros((n, 3)) for name in seen.points},
        inclinations=np.zeros((n if len(seen.inclinations) else 0, 2)),
        lines=("",) * n,
    )


def pose_errors(model: Model, R: Array, T: Array) -> Array:
    """Return the mean square error of the platform's points as a form of the parameters' errors.

    Of the machine that has the parameters found and is asked for poses; the twentieth of the poses
    at which it is worst, next to singular ones, is left out. Shape (f, f), scaled parameters.
    """
    some = slice(0, _ERRORS)
    R, T = R[some], T[some]
    readings = np.zeros((len(R), 6))
    here = Measurements(readings, R, T, np.zeros(3), lines=("",) * len(R))
    _, by_model, by_pose = value_rows(model, R, T, here, Noise(1, 1, 1, 1, 1, 1))
    free = model.free.copy()
    free[model.geometry + 6 :] = False
    scaled = np.where(free, by_model * model.sizes, 0.0)[..., model.free]
    twists = np.linalg.solve(by_pose, scaled)
    form = np.zeros((len(R), twists.shape[2], twists.shape[2]))
    points = [block.point for block in model.blocks if block.body == "platform"]
    for point in points:
        moved = twists[:, 3:] - hat(R @ point) @ twists[:, :3]
        form += np.swapaxes(moved, 1, 2) @ moved / len(points)
    sizes = np.trace(form, axis1=1, axis2=2)
    mean: Array = form[sizes <= np.quantile(sizes, 0.95)].mean(axis=0)
    return mean


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
        best = int(np.linalg.slogdet(told)[1].argmax())
        chosen.append(best)
        # Woodbury's formula.
        moved = inverse @ slopes[best].T
        inverse = inverse - moved @ np.linalg.solve(eye + slopes[best] @ moved, moved.T)
    return np.array(chosen, np.intp)


def exchanged(
    slopes: Array, chosen: NDArray[np.intp], before: Array, errors: Array
) -> NDArray[np.intp]:
    """Return poses after exchanges, as long as they make the mean square error less.

    Parameters
    ----------
    slopes, before
        As for `d_optimal`.
    chosen
        Which poses to begin with, shape (n,).
    errors
        The mean square error as a form of the parameters' errors (`pose_errors`), shape (f, f).
    """
    eye, best = np.eye(slopes.shape[1]), chosen.tolist()
    for _ in range(_EXCHANGES):
        changed = False
        for k in range(len(best)):
            others = best[:k] + best[k + 1 :]
            known = before + np.einsum("kqa,kqb->ab", slopes[others], slopes[others])
            inverse = np.linalg.inv(known)
            told = eye + slopes @ inverse @ np.swapaxes(slopes, 1, 2)
            less = slopes @ (inverse @ errors @ inverse) @ np.swapaxes(slopes, 1, 2)
            gain = np.trace(np.linalg.solve(told, less), axis1=1, axis2=2)
            pose = int(gain.argmax())
            if gain[pose] > gain[best[k]] * (1 + 1e-9):
                best[k], changed = pose, True
        if not changed:
            break
    return np.array(best, np.intp)
