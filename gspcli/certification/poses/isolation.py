"""Proof of exactly one solution near a point, by the contraction mapping theorem in balls.

Let F be the seven equations in the seven free coordinates of a patch ``e_k = 1``, x a point and Y
a matrix, both exact, all norms maximum norms on C^7. Suppose

* ``|Y F(x)| <= delta``,
* ``|I - Y F'(x)| <= a < 1``,
* the second derivatives of F, summed by their moduli, weighted with ``|Y|`` and bounded over the
  ball of radius `REACH` about x, give ``|Y (F'(z) - F'(x))| <= b |z - x|`` there.

With ``r = min(REACH, (1 - a) / (2 b))`` the map ``z -> z - Y F(z)`` has a Lipschitz constant of
at most ``q = a + b r < 1`` on the closed ball of radius r. If ``delta <= (1 - q) r``, it maps that
ball into itself, so F has exactly one zero there (Y is regular because q < 1); the zero
is simple and within ``delta / (1 - q)`` of x. This is Krawczyk's test in norm form. It holds for
all F whose coefficients are in the balls that were used, so for the exact ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import acb, acb_mat, arb

from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.numbers.balls import floats_above, largest
from gspcli.certification.numbers.rounding import OUTWARD
from gspcli.records import dataclass

#: Largest radius of a uniqueness ball. Coordinates of e are at most about one.
REACH = 1 / 8
_IDENTITY = acb_mat(7, 7, 1)
#: Newton steps at one precision; a simple zero in reach needs fewer.
STEPS = 20


@dataclass(frozen=True)
class Isolation:
    """A ball of Study points with exactly one solution in it.

    Attributes
    ----------
    centre
        Eight exact coordinates; that of the patch is 1.
    patch
        Index of the coordinate of e that is fixed.
    sides
        For each constraint the index of its equation.
    error
        Exact upper bound of the distance of the solution from the centre, in the maximum norm.
    uniqueness
        Radius of the closed ball about the centre that has no other solution of these sides.
    precision
        Bits of the proof.
    """

    centre: tuple[acb, ...]
    patch: int
    sides: tuple[int, ...]
    error: arb
    uniqueness: float
    precision: int

    @property
    def point(self) -> list[acb]:
        """Balls that contain the coordinates of the solution."""
        return [
            x if k == self.patch else acb(arb(x.real, self.error), arb(x.imag, self.error))
            for k, x in enumerate(self.centre)
        ]

    @property
    def real(self) -> bool | None:
        """Whether the solution is real, in the patch and so as a pose; None if not decided.

        The equations are real, so the conjugate of the solution is a solution. If it is in the
        uniqueness ball, too, both are equal.
        """
        if any(abs(x.imag) > self.error for x in self.centre):
            return False
        imaginary = largest([x.imag for x in self.centre])
        return True if 2 * imaginary + self.error <= self.uniqueness else None

    def contains(self, other: Isolation) -> bool:
        """Whether the solution of `other` is proved to be the solution in this ball."""
        if self.sides != other.sides:
            return False
        return self.surrounds(other.point)

    def surrounds(self, point: Sequence[acb]) -> bool:
        """Whether a Study point of any norm is proved to be in the uniqueness ball."""
        unit = point[self.patch]
        gap = largest([x / unit - c for x, c in zip(point, self.centre, strict=True)])
        return bool(gap <= self.uniqueness)


@dataclass(frozen=True)
class _Newton:
    """The equations and an approximate inverse of their Jacobian at an exact point.

    `length` is a bound of Newton's step, and `noise` the part of it that is rounding.
    """

    centre: list[acb]
    jacobian: acb_mat
    inverse: acb_mat
    step: list[acb]
    length: arb
    noise: arb


def refine_point(
    system: BallSystem, centre: Sequence[acb], patch: int, sides: tuple[int, ...]
) -> list[acb] | Isolation:
    """Improve a point by Newton's method, then try to prove that a solution is near.

    Parameters
    ----------
    system
        The equations; the working precision is theirs.
    centre
        Eight exact coordinates, that of the patch being 1.
    patch
        Index of the coordinate to keep.
    sides
        For each constraint the index of its equation.

    Returns
    -------
    list[acb] | Isolation
        The proof, or the improved point if there is none.
    """
    good = arb(2) ** (-system.precision // 2)
    best = _newton(system, list(centre), patch, sides)
    if best is None:
        return list(centre)
    for _ in range(STEPS):
        # Shorter steps are rounding errors.
        if best.length < good or best.length < 4 * best.noise:
            break
        moved = [(x - dx).mid() for x, dx in zip(best.centre, best.step, strict=True)]
        following = _newton(system, moved, patch, sides)
        if following is None:
            break
        best = following
    return _prove(system, best, patch, sides) or best.centre


def step_length(
    system: BallSystem, centre: Sequence[acb], patch: int, sides: tuple[int, ...]
) -> float:
    """Return the length of Newton's step at a point; parameters are those of `refine_point`."""
    newton = _newton(system, list(centre), patch, sides)
    return float("inf") if newton is None else float(newton.length)


def _newton(
    system: BallSystem, centre: list[acb], patch: int, sides: tuple[int, ...]
) -> _Newton | None:
    values, full = system.at(centre, sides)
    entries = full.entries()
    del entries[patch::8]
    jacobian = acb_mat(7, 7, entries)
    try:
        # The theorem holds for any matrix.
        inverse = jacobian.solve(_IDENTITY, algorithm="approx").mid()
    except ZeroDivisionError:
        return None
    step = (inverse * values).entries()
    length = largest(step)
    if not length.is_finite():
        return None
    noise = max(arb(max(x.real.rad(), x.imag.rad())) for x in step)
    step.insert(patch, acb(0))
    return _Newton(centre, jacobian, inverse, step, length, noise)


def _prove(
    system: BallSystem, newton: _Newton, patch: int, sides: tuple[int, ...]
) -> Isolation | None:
    defect = (newton.inverse * newton.jacobian).entries()
    for k in range(7):
        defect[8 * k] -= 1
    # For a nearly singular matrix the sum may overflow.
    with np.errstate(over="ignore"):
        a = float(floats_above(defect).reshape(7, 7).sum(axis=1).max() * OUTWARD)
    if not a < 1:
        return None
    # Nothing is proved about points too far away for floats.
    with np.errstate(over="ignore", invalid="ignore"):
        curvatures = system.curvatures((floats_above(newton.centre) + REACH) * OUTWARD)
        sizes = floats_above(newton.inverse.entries()).reshape(7, 7)
        b = float((sizes @ curvatures).max() * OUTWARD)
    # Any radius may be tried: q is rounded up and tested below.
    radius = min(REACH, (1 - a) / (2 * b))
    q = (a + b * radius) * OUTWARD
    if not (q < 1 and newton.length <= (1 - arb(q)) * radius):
        return None
    error = (newton.length / (1 - arb(q))).upper()
    return Isolation(tuple(newton.centre), patch, sides, error, radius, system.precision)
