"""The six values as coordinates of the drives: rates by the pose, and where they have none.

They are the values of `gsp measure`: a distance of two lines is not negative (`value_signs`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, DLP, DPL, DPP
from gspcli.dynamics.arrays import RowError
from gspcli.dynamics.mass_model import MassModel
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


class Drives:
    """The six values at n poses, shapes (n, 3, 3) and (n, 3), in metres and radians.

    Attributes
    ----------
    rows
        Their derivatives by a twist, shape (n, 6, 6): a force F of the drives is the wrench
        ``rows^T F`` on the platform.

    Raises
    ------
    RowError
        If a value has no derivative at a pose: a distance of 0, parallel lines of a DLL, an angle
        at an end of its range.
    """

    def __init__(self, model: MassModel, R: Array, T: Array) -> None:
        self.model, self.R, self.T = model, R, T
        self._check_derivatives()
        self._signs = value_signs(model.bodies, R, T)
        self.rows = self._signs[..., None] * np.asarray(jacobian(model.bodies, R, T))

    def _check_derivatives(self) -> None:
        """Refuse values without a derivative."""
        bodies = self.model.bodies
        values = np.asarray(measured(bodies, self.R, self.T))
        small = np.abs(values) < _ZERO * bodies.length
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
        signed: Array = self._signs[..., None, None] * hessian(self.model.bodies, self.R, self.T)
        return signed

    def bends(self, twists: Array) -> Array:
        """Return the second derivatives of the values along constant twists, shape (n, 6)."""
        signed: Array = self._signs * curvature(self.model.bodies, self.R, self.T, twists)
        return signed

    def inertial(self, twists: Array, accelerations: Array) -> Array:
        """Return what the rotors of the drives need by themselves, N and N m, shape (n, 6)."""
        if not self.model.rotors.any():
            return np.zeros(self.rows.shape[:-1])
        rates = apply(self.rows, accelerations) + self.bends(twists)
        return np.asarray(self.model.rotors * rates)

    def conditions(self) -> tuple[Flags, Array]:
        """Return which poses are singular, shape (n,), and the condition number where it matters.

        The numbers are those of `condition_numbers`, and NaN where they are below 1e8: that is
        known from a bound, for a fifth of the time.
        """
        found = np.full(len(self.T), np.nan)
        poor = ~(self._condition_bounds() < _GOOD)
        if poor.any():
            found[poor] = condition_numbers(self.model.bodies, self.R[poor], self.T[poor])
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
        scaled = self.rows * np.repeat([1 / length, 1.0], 3)
        scaled = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
        try:
            inverse = np.linalg.inv(scaled)
        except np.linalg.LinAlgError:
            return np.full(len(scaled), np.inf)
        norms = [np.sqrt(np.einsum("nij,nij->n", a, a)) for a in (scaled, inverse)]
        shear = 1 + float(np.linalg.norm(bodies.platform_centre)) / length
        return np.asarray(norms[0] * norms[1] * shear**4)
