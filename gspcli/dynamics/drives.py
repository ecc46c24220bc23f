"""The numbers of the drives as coordinates: rates by the pose, and where they have none.

Values are those of `gsp measure`: a distance of two lines is not negative (`value_signs`). The
number of a crank or slide follows from the pose (`gspcli.dynamics.moved_points`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, DLP, DPL, DPP
from gspcli.dynamics.arrays import RowError
from gspcli.dynamics.mass_model import MassModel
from gspcli.dynamics.moved_points import MovedPoints
from gspcli.geometry.measurement import curvature, hessian, jacobian, measured
from gspcli.geometry.quaternions import apply, cross, dot
from gspcli.geometry.residuals import condition_numbers
from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.motion.poses.inverse_kinematics import value_signs

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: A distance below this part of the platform's size is zero to doubles.
_ZERO = 1e-12
#: Up to this condition number a bound that costs less than the number itself is enough.
_GOOD = 1e8
#: Beyond this one the forces are not known: as in `gspcli.motion.statics`.
_SINGULAR = 1e14
#: Sums of two unit twists, at which quadratic forms are evaluated.
PAIRS = np.eye(6)[:, None] + np.eye(6)[None]


class DrivesAtPoses:
    """The six values at n poses, shapes (n, 3, 3) and (n, 3), in metres and radians.

    Attributes
    ----------
    rows
        Their derivatives by a twist with cranks and slides still, shape (n, 6, 6): forces F along
        the rods are the wrench ``rows^T F`` on the platform.
    pulls
        The derivatives of the numbers of the drives, by constraints, shape (n, 6, 6): what drives
        push with, F, is the wrench ``pulls^T F``. The same where all drives are values.
    points
        What cranks and slides move; None if all drives are values.

    Raises
    ------
    RowError
        If a value has no derivative at a pose: a distance of 0, parallel lines of a DLL, an angle
        at an end of its range.
    """

    def __init__(self, model: MassModel, R: Array, T: Array, numbers: Array | None = None) -> None:
        self.model, self.R, self.T = model, R, T
        self.points = None if numbers is None else MovedPoints(model, R, T, numbers)
        self._bodies = model.bodies if self.points is None else self.points.bodies
        self._check_derivatives()
        self._signs = value_signs(model.bodies, R, T)
        self.rows = self._signs[..., None] * np.asarray(jacobian(self._bodies, R, T))
        self.pulls = self.rows
        if self.points is not None:
            self.pulls = self.rows / self.points.gains[..., None]

    def _check_derivatives(self) -> None:
        """Refuse values without a derivative."""
        bodies = self._bodies
        values = np.asarray(measured(bodies, self.R, self.T))
        small = np.abs(values) < _ZERO * self.model.bodies.length
        distances = [kind in (DPP, DPL, DLP, DLL) for kind in bodies.kinds]
        wrong = small & distances
        directed = [kind is DLL or not kind.is_distance for kind in bodies.kinds]
        if any(directed):
            w = np.asarray(bodies.placed(self.R, self.T).w)
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

    @property
    def second(self) -> Array:
        """Second derivatives by a twist, shape (n, 6, 6, 6)."""
        signed: Array = self._signs[..., None, None] * hessian(self._bodies, self.R, self.T)
        if self.points is None:
            return signed
        # Quadratic forms of a twist, from their values at sums of two unit twists.
        numbers = self.points.numbers[:, None, None]
        points = MovedPoints(self.model, self.R[:, None, None], self.T[:, None, None], numbers)
        form = np.moveaxis(points.motion(PAIRS, np.zeros(6)).second_rates, -1, 1)
        driven = self.points.drives.driven[:, None, None]
        return np.where(driven, polarized(form), signed)

    def bends(self, twists: Array) -> Array:
        """Return the second derivatives of the values along constant twists, shape (n, 6)."""
        signed: Array = self._signs * curvature(self._bodies, self.R, self.T, twists)
        if self.points is None:
            return signed
        own = self.points.motion(twists, np.zeros_like(twists)).second_rates
        return np.where(self.points.drives.driven, own, signed)

    def inertial(self, twists: Array, accelerations: Array) -> Array:
        """Return the forces that accelerate the rotors of the drives, N and N m, shape (n, 6)."""
        if not self.model.rotors.any():
            return np.zeros(self.rows.shape[:-1])
        rates = apply(self.pulls, accelerations) + self.bends(twists)
        return np.asarray(self.model.rotors * rates)

    def conditions(self) -> tuple[Flags, Array]:
        """Return which poses are singular, shape (n,), and the condition number where it matters.

        The numbers are those of `condition_numbers`, and NaN where they are below 1e8: that is
        known from a bound, for a fifth of the time.
        """
        found = np.full(len(self.T), np.nan)
        poor = ~(self._condition_bounds() < _GOOD)
        if poor.any() and self.points is None:
            found[poor] = condition_numbers(self.model.bodies, self.R[poor], self.T[poor])
        elif poor.any():
            found[poor] = self._moved_conditions()[poor]
        return poor & ~(found < _SINGULAR), np.where(found < _GOOD, np.nan, found)

    def _moved_conditions(self) -> Array:
        """Return the condition numbers, (n,), with the points where the drives have moved them."""
        found = np.empty(len(self.T))
        assert self.points is not None
        for k, (x, y) in enumerate(zip(self.points.x, self.points.y, strict=True)):
            bodies = replace(self.model.bodies, x=x, y=y)
            found[k] = condition_numbers(bodies, self.R[k], self.T[k])
        return found

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
        scaled = self.rows * np.repeat([1 / length, 1.0], 3)
        scaled = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
        try:
            inverse = np.linalg.inv(scaled)
        except np.linalg.LinAlgError:
            return np.full(len(scaled), np.inf)
        norms = [np.sqrt(np.einsum("nij,nij->n", a, a)) for a in (scaled, inverse)]
        # The centre moves with cranks on the platform, by less than it is away from the farthest.
        centre = np.linalg.norm(bodies.platform_centre)
        if self.points is not None and self.points.drives.on_platform.any():
            centre = np.linalg.norm(self.points.y, axis=-1).max()
        shear = 1 + float(centre) / length
        return np.asarray(norms[0] * norms[1] * shear**4)


def polarized(form: Array) -> Array:
    """Return the matrices of quadratic forms of a twist from their values at PAIRS, (..., 6, 6)."""
    own = np.einsum("...ii->...i", form) / 4
    return np.asarray((form - own[..., :, None] - own[..., None, :]) / 2)
