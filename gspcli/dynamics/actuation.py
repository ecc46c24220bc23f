"""How the drives of a platform act on it at poses, and where they do not.

Values are those of `gsp measure`: a distance of two lines is not negative.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL, DLP, DPL, DPP
from gspcli.dynamics.arrays import RowError, checked_array
from gspcli.dynamics.mass_model import MassModel
from gspcli.geometry.instance import Array
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers, measured, measured_between
from gspcli.geometry.quaternions import apply, cross, dot
from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.motion.poses.inverse_kinematics import refusals

Flags = NDArray[np.bool_]

#: A distance below this part of the platform's size is zero to doubles.
_ZERO = 1e-12
#: Up to this condition number a bound that costs less than the number itself is enough.
_GOOD = 1e8
#: Beyond this one the forces are not known: as in `gspcli.motion.statics`.
_SINGULAR = 1e14
_ROWS, _COLUMNS = np.triu_indices(6)
#: Sums of two unit twists, at which quadratic forms are evaluated, shape (21, 6).
PAIRS = np.eye(6)[_ROWS] + np.eye(6)[_COLUMNS]
#: The square of a gain is a difference of squared lengths: four sums and products of coordinates,
#: and their squares, are wrong by at most so many units of the sum of the lengths, squared.
_ROUNDING = 16 * np.finfo(float).eps
#: Lengths of rods are those of the instance up to this part of the size, and rates of what shares a
#: drive are the same up to this part of the largest one.
_SAME = 1e-6


def numbers_at(model: MassModel, R: Array, T: Array, given: ArrayLike | None) -> Array:
    """Return the numbers of the drives at poses, in metres and radians, shape (n, m).

    Parameters
    ----------
    model, R, T
        The platform, and poses in its unit of length, shapes (n, 3, 3) and (n, 3).
    given
        The readings of the drives, (n, m) or (m,); None for the numbers in the working modes of
        home.

    Raises
    ------
    RowError
        If a drive does not reach a pose, or rods of one drive ask for different numbers; if a rod
        has another length with its drive at such a number.
    """
    machine = model.machine
    if given is None:
        stated = Machine.of(model.instance)
        q = stated.inverse(R, T)
        if missing := refusals(stated, R, T, q):
            row = min(missing)
            raise RowError(row, missing[row])
        return np.asarray(q * (machine.units / stated.units))
    q = machine.from_readings(checked_array(given, (len(T), machine.count), "drives"))
    if machine.driven.any():
        off = np.abs(measured(machine.arrangement(q), R, T * model.metre) - machine.rods)
        wrong = machine.driven & (off > _SAME * model.bodies.length)
        for row, k in np.argwhere(wrong)[:1].tolist():
            raise RowError(
                row,
                f"with {machine.names[machine.index[k]]} so {machine.user(k)} has another length, "
                "expected numbers of this pose",
            )
    return q


class Actuation:
    """The drives of a platform at n poses, (n, 3, 3) and (n, 3), and at numbers, (n, m).

    In metres and radians.

    Attributes
    ----------
    at
        The machine at the poses: forces F along the rods are the wrench ``at.jacobian^T F``.
    pulls
        What each constraint asks of its drive, by a twist, shape (n, 6, 6): drives that push with F
        are the wrench ``pulls^T F``. The Jacobian matrix where all drives are values.

    Raises
    ------
    RowError
        If a value has no derivative at a pose: a distance of 0, parallel lines of a DLL, an angle
        at an end of its range. If a drive is at a dead point.
    """

    def __init__(self, model: MassModel, R: Array, T: Array, q: Array) -> None:
        self.model, self.R, self.T, self.q = model, R, T, q
        self.at = model.machine.at(R, T, q)
        self._check_derivatives()
        self._check_dead_points()
        self.pulls = self.at.jacobian
        if model.machine.moves:
            self.pulls = self.pulls / self.at.gains[..., None]

    def _check_derivatives(self) -> None:
        """Refuse values without a derivative."""
        bodies, w = self.at.arrangement, self.at.placed.w
        values = np.asarray(measured_between(bodies, self.at.placed))
        small = np.abs(values) < _ZERO * self.model.bodies.length
        distances = [kind in (DPP, DPL, DLP, DLL) for kind in bodies.kinds]
        wrong = small & distances
        directed = [kind is DLL or not kind.is_distance for kind in bodies.kinds]
        if any(directed):
            normal = cross(w, np.broadcast_to(bodies.v, w.shape))
            wrong |= (dot(normal, normal) < PARALLEL_SINE**2) & directed
        if wrong.any():
            pose, k = np.argwhere(wrong)[0].tolist()
            kind = bodies.kinds[k]
            what = "an angle at the end of its range"
            if kind.is_distance:
                what = "a distance of 0" if small[pose, k] else "a distance of parallel lines"
            message = f"constraint {k + 1} ({kind.name}) is {what}, which has no derivative"
            raise RowError(pose, message)

    def _check_dead_points(self) -> None:
        """Raise where a gain is zero up to the root of its rounding error.

        The gain times l is the root of a number D: for a slide D is a difference of squared
        lengths; for a crank with arm a it is a d times one, where d <= a + l is the distance of its
        centre from the other end of the rod. Where D is zero the gain has the root of its error. At
        a plane it is constant for a slide, and for a crank the root of a times a length.
        """
        machine, (r, _, arm) = self.model.machine, self.at.placed
        if not machine.driven.any():
            return
        length = _norm(r)
        size = _norm(arm) + _norm(np.broadcast_to(self.at.arrangement.x, arm.shape)) + length
        arms, turns = machine.arms, machine.turns[machine.index]
        reach = np.where(turns, np.sqrt(arms * (arms + length)), 1.0) * size / length
        reach = np.where(machine.planes, np.where(turns, np.sqrt(arms * size), 1.0), reach)
        dead = machine.driven & ~(np.abs(self.at.gains) > np.sqrt(_ROUNDING) * reach)
        for row, k in np.argwhere(dead)[:1].tolist():
            name = machine.names[machine.index[k]]
            what = f"it cannot move the rod of constraint {k + 1}"
            raise RowError(row, f"{name} is at a dead point: {what}")

    def check_rates(self, twists: Array) -> None:
        """Refuse motions, shape (n, 6), at which the rods of one drive ask for different rates.

        Raises
        ------
        RowError
            Naming the rods.
        """
        machine = self.model.machine
        if not machine.shared:
            return
        rates = apply(self.pulls, twists)
        off = np.abs(rates - machine.per_drive(rates)[..., machine.index])
        wrong = off > _SAME * np.abs(rates).max(axis=-1, keepdims=True)
        for row, k in np.argwhere(wrong)[:1].tolist():
            rods = " and ".join(str(one + 1) for one in machine.users(machine.index[k]))
            raise RowError(
                row,
                f"rods {rods} ask for different speeds of {machine.names[machine.index[k]]}: the "
                "platform cannot move so",
            )

    def bend(self, forces: Array) -> Array:
        """Return second derivatives by a twist of what constraints ask of drives, (n, 6, 6).

        Those of all constraints are multiplied by forces, shape (n, 6), and added. From quadratic
        forms at sums of two unit twists.
        """
        R, T, q = (part[:, None] for part in (self.R, self.T, self.q))
        form = self.model.machine.at(R, T, q).rates(PAIRS, np.zeros(6))[1]
        return polarized((form @ forces[..., None])[..., 0])

    def conditions(self) -> tuple[Flags, Array]:
        """Return which poses are singular, shape (n,), and the condition number where it matters.

        The numbers are those of `condition_numbers`, and NaN where they are below 1e8: that is
        known from a bound, for a fifth of the time.
        """
        found = np.full(len(self.T), np.nan)
        poor = ~(self._condition_bounds() < _GOOD)
        if poor.any():
            found[poor] = condition_numbers(self.at.arrangement, self.R, self.T)[poor]
        return poor & ~(found < _SINGULAR), np.where(found < _GOOD, np.nan, found)

    def _condition_bounds(self) -> Array:
        """Return bounds of the condition numbers, shape (n,), infinite if nothing is known.

        The matrix is that of `condition_numbers` before it is taken to the centre c of the
        platform: a shear by c, whose condition is at most ``(1 + |c|)^2`` in units of the length.
        Its own condition is at most the product of the norms of Frobenius of it and its inverse.
        Rows scaled to norm one after the shear, not before, differ by a factor of at most
        ``1 + |c|`` either way.
        """
        bodies = self.model.bodies
        length = bodies.length
        scaled = self.at.jacobian * np.repeat([1 / length, 1.0], 3)
        scaled = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
        try:
            inverse = np.linalg.inv(scaled)
        except np.linalg.LinAlgError:
            return np.full(len(scaled), np.inf)
        norms = [np.sqrt(np.einsum("nij,nij->n", a, a)) for a in (scaled, inverse)]
        shear = 1 + float(np.linalg.norm(bodies.platform_centre)) / length
        return np.asarray(norms[0] * norms[1] * shear**4)


def polarized(form: Array) -> Array:
    """Return the matrices of quadratic forms of a twist from their values at PAIRS, (..., 6, 6)."""
    values, form = form, np.empty((*form.shape[:-1], 6, 6))
    form[..., _ROWS, _COLUMNS] = form[..., _COLUMNS, _ROWS] = values
    own = np.einsum("...ii->...i", form) / 4
    return np.asarray((form - own[..., :, None] - own[..., None, :]) / 2)


def _norm(vectors: Array) -> Array:
    return np.asarray(np.sqrt(dot(vectors, vectors)))
