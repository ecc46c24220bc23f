"""Proofs with 64 digits of poses far away, near ends of paths with 32 digits.

A platform that is special up to the rounding of its numbers has poses at which its equations are
nearly dependent and N nearly vanishes. The kernel (native/finer_ends.cpp) evaluates the equations
there with 64 digits and applies the theorem of `isolation` with derivatives of 32 digits. Up to
1e16 lengths away this proves and rounds the poses in a quarter of the time of balls
(`gspcli.certification.poses.locator`). Balls took a third of the time of a first solution
(`tools.verify.realistic`, hexapods with six joints a body). What this cannot decide goes to balls.

The equations are those of `ball_system`. Far away f is large, and ``f.f`` is the largest term in
the equations of points at a distance. It has the same coefficient in each of them, so the first of
these equations is subtracted from the others. The solutions are the same, and rounding errors are
smaller by the size of f (1e8 if a pose is 1e16 lengths away).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np
from flint import arb, arb_mat, ctx
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DLL
from gspcli.certification.equations import study
from gspcli.certification.equations.ball_system import BallEquation, BallSystem
from gspcli.certification.equations.frames import OWN, StudyFrames
from gspcli.certification.equations.skew_lines import are_skew
from gspcli.certification.numbers.rounding import OUTWARD
from gspcli.certification.poses.locator import Locator
from gspcli.certification.poses.many_values import ProvedPoses, proved_bits
from gspcli.defaults import TOLERANCE

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: Bits of the balls that are written as sums of four doubles.
_BITS, _PARTS = 320, 4
#: A coefficient errs by less than this part of its bound; the kernel allows for 2^-190.
_ERROR = 2.0**-195


class FinerProofs:
    """The equations of an instance with 64 digits, and proofs with these.

    Parameters
    ----------
    locator, sides
        The equations, and the index of that of each constraint (`BallSystem.equations`).
    """

    def __init__(self, locator: Locator, sides: tuple[int, ...]) -> None:
        with ctx.workprec(_BITS):
            system = locator.system(_BITS)
            chosen = [each[side] for each, side in zip(system.equations, sides, strict=True)]
            self._numbers = _coefficients(system, chosen)
        table = [(each.main, *each.squares, -1, -1)[:3] for each in chosen]
        self._table = np.array(table, np.int32)
        self._instance, self._scale = locator.instance, locator.scale

    def near(self, R: Complex, T: Complex) -> tuple[ProvedPoses, Complex]:
        """Prove poses near given ones, shapes (n, 3, 3) and (n, 3); the results are as of `at`."""
        points, _ = study.study_points(R, T)
        return self.at(points, np.zeros((len(points), 0, 8), complex), OWN)

    def at(self, points: Complex, low: Complex, frames: StudyFrames) -> tuple[ProvedPoses, Complex]:
        """Prove poses near points.

        Parameters
        ----------
        points, low
            Study points of any norm, shape (n, 8), and doubles to add to them, shape (n, k, 8),
            k < 4.
        frames
            The frames of the points.

        Returns
        -------
        tuple[ProvedPoses, Complex]
            The poses, shapes (1, n, ...), and the Study points that Newton's method has reached as
            sums of four doubles, in the frames of the instance and its length scale, (4, n, 8).
        """
        scale = self._scale
        R, T, quaternions, deviation, bits, reached = _kernel.decide_finer(
            *self._numbers,
            self._table,
            np.concatenate((points[None], np.moveaxis(low, 1, 0))),
            unit=frames.length / scale,
            origins=np.array((frames.base, frames.platform)) / scale,
            scale=scale,
            tolerance=TOLERANCE,
        )
        certified, real, rounded = proved_bits(bits)
        if any(row.kind is DLL for row in self._instance.constraints):
            skew = are_skew(self._instance, R, deviation)
            certified, real, rounded = certified & skew, real & skew, rounded & skew
        found = ProvedPoses(
            R=R[None],
            T=T[None],
            quaternions=quaternions[None],
            certified=certified[None],
            real=real[None],
            rounded=rounded[None],
            deviation=deviation[None],
            complete=np.zeros(1, np.bool_),
        )
        return found, reached


def _coefficients(system: BallSystem, chosen: Sequence[BallEquation]) -> tuple[Array, Array]:
    """Return the coefficients of the quadrics as sums of four doubles, and bounds of these.

    The shapes are (4, quadrics, 27) and (quadrics, 27), the order is that of the kernel
    (native/fine_points.hpp).
    """
    rows = system.monomial_rows
    points = [
        each.main
        for each in chosen
        if not each.squares and system.forms[each.main].get(study.RHO) is not None
    ]
    if len(points) > 1:
        across = arb_mat(len(system.forms), len(system.forms), 1)
        for k in points[1:]:
            across[k, points[0]] = -1
        rows = across * rows
    entries = rows.entries()
    found, bounds = np.zeros((len(entries), _PARTS)), np.zeros(len(entries))
    for k, ball in enumerate(entries):
        if not ball.is_zero():
            found[k], bounds[k] = _sum_of_doubles(ball)
    shape = len(system.forms), -1
    return np.ascontiguousarray(found.T).reshape(_PARTS, *shape), bounds.reshape(shape)


def _sum_of_doubles(ball: arb) -> tuple[list[float], float]:
    """Return the middle of a ball as a sum of four doubles, and a bound of which it errs a part."""
    if not ball.is_finite():
        return [inf] * _PARTS, inf
    parts, rest = [], ball.mid()
    for _ in range(_PARTS):
        if rest.is_zero():
            parts.append(0.0)
            continue
        parts.append(float(rest))
        # Exact: it has fewer bits.
        rest -= parts[-1]
    error = float((abs(rest) + ball.rad()).abs_upper())
    return parts, (abs(parts[0]) + error / _ERROR) * OUTWARD
