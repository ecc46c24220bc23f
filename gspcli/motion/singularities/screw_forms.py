"""Proofs that the six screws of a platform are independent over sets of poses.

Over a ball or box of poses, in the coordinates of `gspcli.motion.singularities.displacements`, the
rows of the matrix of screws are enclosed by `gspcli.motion.singularities.taylor_forms`. With
approximate factors of that in the middle, ``M = U S V^T``, let b be bounds of the moduli of the
entries of ``S^-1 U^T M' V - 1`` for all M' there. If ``b p < p`` for a positive vector p, then all
M' are regular, by the norm ``max |x_k| / p_k``, and their determinants have the sign of ``det U det
V``. The best p is the eigenvector of b of Perron and Frobenius.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.quaternions import apply, rotation_from_quaternion
from gspcli.motion.singularities.displacements import Displacements
from gspcli.motion.singularities.taylor_forms import ROUNDING, Form
from gspcli.records import dataclass
from gspcli.ties import definite_pairs

Array = NDArray[np.float64]

#: Squarings of the matrix of bounds on the way to its positive eigenvector.
_SQUARINGS = 5
_OUTWARD = 1 + 2.0**-30
#: A power of two by which derivatives are scaled.
_STEP = 2.0**-20
#: The weight of the length of a side beside its share.
_SIDE = 1e-9


@dataclass(frozen=True, eq=False)
class Regular:
    """Proofs about n sets of poses.

    Attributes
    ----------
    sign
        The sign of the determinant of all matrices, 0 if they are not proved to be regular, shape
        (n,).
    shares
        The contribution of each coordinate to the bound, shape (n, 6).
    """

    sign: Array
    shares: Array


class ScrewForms:
    """The screws about home poses.

    Parameters
    ----------
    home
        The home poses, and the platform.
    """

    def __init__(self, home: Displacements) -> None:
        self.home = home
        self.arrangement = home.arrangement

    def matrices(self, s: Array) -> Array:
        """Return matrices of screws about the centres, of any positive strength, (n, 6, 6)."""
        with np.errstate(all="ignore"):
            return self._rows(self._inputs(s, np.zeros_like(s), cube=True))[0]

    def derivatives(self, s: Array) -> Array:
        """Return derivatives of `matrices` by the coordinates, ``(n, 6) -> (n, 6, 6, 6)``."""
        with np.errstate(all="ignore"):
            return self._rows(self._inputs(s, np.full_like(s, _STEP), cube=True))[1] / _STEP

    def judge(self, s: Array, half: Array, *, cube: bool) -> Regular:
        """Prove that no pose of a set is singular.

        Parameters
        ----------
        s
            The middles, shape (n, 6).
        half
            Half sides of boxes, or semi-axes of ellipsoids, shape (n, 6).
        cube
            Whether the sets are boxes; otherwise they are ellipsoids.
        """
        with np.errstate(all="ignore"):
            rows, linear, rest = self._rows(self._inputs(s, half, cube=cube))
            finite = [np.isfinite(part).reshape(len(s), -1) for part in (rows, linear, rest)]
            safe = np.concatenate(finite, axis=1).all(axis=1).reshape(-1, 1, 1)
            rows, rest = np.where(safe, rows, np.eye(6)), np.where(safe, rest, np.inf)
            linear = np.where(safe[..., None], linear, 0.0)
            sign, shares = self._compare(rows, linear, rest, cube=cube)
        # Without a bound the longest side counts.
        return Regular(sign, np.where(safe[:, 0], np.nan_to_num(shares), 0.0) + _SIDE * half)

    def _compare(
        self, rows: Array, linear: Array, rest: Array, *, cube: bool
    ) -> tuple[Array, Array]:
        sizes = np.linalg.norm(rows, axis=2, keepdims=True)
        scales = 1 / np.where(sizes > 0, sizes, 1.0)
        u, s, vt = np.linalg.svd(rows * scales)
        # At symmetric poses any basis for equal singular values is right; bounds depend on it.
        u, vt = definite_pairs(u, s, vt)
        inverse = np.swapaxes(u, 1, 2) / s[:, :, None] * np.swapaxes(scales, 1, 2)
        basis = np.swapaxes(vt, 1, 2)
        moved = np.einsum("njm,nmli,nlk->njki", inverse, linear, basis, optimize=True)
        errors = rest + ROUNDING * (np.abs(rows) + np.abs(linear).sum(axis=3))
        left_out = np.abs(inverse) @ errors @ np.abs(basis)
        left_out += np.abs(inverse @ rows @ basis - np.eye(6))
        bound = np.linalg.norm(moved, ord=1 if cube else 2, axis=3) + left_out
        bound = np.where(np.isfinite(bound), bound, 1e30)
        power = bound + 1e-300
        for _ in range(_SQUARINGS):
            power = power @ power
            power /= power.max(axis=(1, 2), keepdims=True)
        p = power.sum(axis=2) + 1e-9
        ratio = (bound @ p[..., None])[..., 0] / p
        proved = ratio.max(axis=1) * _OUTWARD < 1
        sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
        worst = ratio.argmax(axis=1)
        each = np.arange(len(p))
        parts = np.abs(moved[each, worst]) * p[:, :, None]
        return np.where(proved, sign, 0.0), parts.sum(axis=1) / p[each, worst, None]

    def _inputs(self, s: Array, half: Array, *, cube: bool) -> tuple[Form, Form, Form, Form]:
        """Return arms and r less these, (n, 6, 3), and directions of the platform and the base."""
        count, at, a = len(s), self.home, self.arrangement
        e = at.quaternions(s)
        R = rotation_from_quaternion(e) @ at.R
        # The derivatives of t and v. The last factor contains the rounding of boxes.
        half = half * _OUTWARD
        shift, turn = np.zeros((count, 1, 3, 6)), np.zeros((count, 1, 3, 6))
        shift[:, 0, range(3), range(3)] = half[:, :3]
        turn[:, 0, :, 3:] = at.axes * (half[:, 3:] / (2 * at.radii))[:, None]
        zero, nothing = np.zeros((count, 1, 3)), np.zeros((count, 1))
        v = self._turn(e, Form(zero, turn, nothing, cube))
        far = v.reach
        # 1 - w for the turn from the middle.
        flat = far**2 / (1 + np.sqrt(1 - far**2)) * _OUTWARD
        w = Form(np.ones((count, 1, 1)), np.zeros((count, 1, 1, 6)), flat, cube)
        # Near half a turn w is less accurate.
        blurred = ROUNDING * (1 + 1 / e[:, :1])

        def turned(vectors: Array, sizes: Array) -> Form:
            fixed = Form.constant(apply(R[:, None], vectors), cube).loosened(blurred * sizes)
            across = v.cross(fixed)
            return fixed + 2.0 * (across * w + v.cross(across))

        centre, sizes = float(np.linalg.norm(at.centre)), np.linalg.norm(a.y, axis=1)
        homes = np.broadcast_to(at.centres, (count, 3))[:, None]
        far_off = np.linalg.norm(at.T, axis=1)[:, None] + centre + np.linalg.norm(a.x, axis=1)
        arms = turned(a.y - at.centre, sizes + centre)
        arms = arms + Form.constant(s[:, None, :3], cube) + Form(zero, shift, nothing, cube)
        offsets = Form.constant(homes - a.x, cube).loosened(ROUNDING * far_off)
        fixed = Form.constant(np.broadcast_to(a.v, (count, 6, 3)), cube)
        return arms, offsets, turned(a.u, np.ones(6)), fixed

    @staticmethod
    def _turn(e: Array, dv: Form) -> Form:
        """Return the vector part of the turns from those of the middles, e, when v moves by dv.

        It is ``w dv - v dw - dv x v`` with dw, the change of w, to first order ``-v . dv / w``.
        """
        w, v = e[:, None, :1], e[:, None, 1:]
        most = np.linalg.norm(v, axis=-1) + dv.reach
        least = np.sqrt(1 - most**2)
        curved = dv.reach**2 / (2 * least**3) * _OUTWARD
        dw = dv.dot(Form.constant(-v / w, dv.cube)).loosened(curved)
        v_form, w_form = Form.constant(v, dv.cube), Form.constant(w, dv.cube)
        return dv * w_form - v_form * dw - dv.cross(v_form)

    def _rows(self, given: tuple[Form, Form, Form, Form]) -> tuple[Array, Array, Array]:
        """Return the matrices of screws: values, derivatives and rests, entry by entry.

        Shapes (n, 6, 6), (n, 6, 6, 6) and (n, 6, 6); columns are moments about the principal axes
        in units of the radii, then forces.
        """
        count = len(given[0].value)
        value = np.zeros((count, 6, 6))
        linear = np.zeros((count, 6, 6, 6))
        rest = np.zeros((count, 6, 6))
        kinds = self.arrangement.kinds
        axes = np.broadcast_to(self.home.axes, (count, 3, 3)) / self.home.radii
        for kind in set(kinds):
            k = [i for i, other in enumerate(kinds) if other is kind]
            parts = screw(
                kind, *(Form(f.value[:, k], f.linear[:, k], f.rest[:, k], f.cube) for f in given)
            )
            for at, part in zip((0, 3), parts, strict=True):
                if part is None:
                    continue
                columns = axes if at == 0 else np.eye(3) + np.zeros_like(axes)
                value[:, k, at : at + 3] = part.value @ columns
                linear[:, k, at : at + 3] = np.einsum("nkai,nab->nkbi", part.linear, columns)
                error = part.rest + ROUNDING * (part.size + part.reach)
                rest[:, k, at : at + 3] = error[..., None] * (
                    1 / self.home.radii if at == 0 else 1.0
                )
        return value, linear, rest


def screw(kind: Kind, arm: Form, offset: Form, w: Form, v: Form) -> tuple[Form, Form | None]:
    """Return moment and force of a constraint, of some positive strength and either sense.

    Parameters
    ----------
    kind
        Of the constraint.
    arm
        From the point that moments are about to the point of the platform.
    offset
        From the point of the base to the one that moments are about; their sum is r.
    w, v
        Directions of the platform and of the base.
    """
    r = arm + offset
    if kind is DPP:
        return arm.cross(offset), r
    if kind is DPL:
        force = r - v * v.dot(r)
        return arm.cross(force), force
    if kind is DLP:
        along = w.dot(r)
        return arm.cross(offset) - w.cross(offset) * along, r - w * along
    if kind is DPH:
        return arm.cross(v), v
    if kind is DHP:
        return w.cross(offset), w
    if kind is DLL:
        # Of the moment m over the sine s, times s^3, with the cosine c: s^2 m' + m c c'.
        normal = w.cross(v)
        square, moment, cosine = normal.dot(normal), r.dot(normal), w.dot(v)
        turning = arm.cross(normal) + w.cross(v.cross(r))
        return turning * square + normal * (moment * cosine), normal * square
    return w.cross(v), None
