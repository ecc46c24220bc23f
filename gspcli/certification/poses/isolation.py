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

from collections.abc import Iterator, Sequence

import numpy as np
from flint import acb, acb_mat, arb
from numpy.typing import NDArray

from gspcli.certification.equations.ball_system import BallSystem, PoseBall
from gspcli.certification.numbers.balls import float_ends, floats_above, largest
from gspcli.geometry.enclosures import above, roundings
from gspcli.records import dataclass

#: Fractional parts of multiples of the golden ratio: a linear form without symmetries.
_WEIGHTS = tuple((k * 0.6180339887498949) % 1 for k in range(1, 25))


def close_pairs(poses: Sequence[PoseBall]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of poses, by ascending indices, whose balls have a common point.

    All other pairs are proved to be different poses. A linear form of the 24 real numbers of a
    pose sorts them first, so that n poses do not cost n^2 comparisons.
    """
    ends = [float_ends(_linear_form(pose)) for pose in poses]
    order = sorted(range(len(poses)), key=lambda k: ends[k][0])
    for position, first in enumerate(order):
        for second in order[position + 1 :]:
            if ends[second][0] > ends[first][1]:
                break
            if _overlap(poses[first], poses[second]):
                yield min(first, second), max(first, second)


@np.errstate(all="ignore")
def all_different(entries: NDArray[np.complex128], deviations: NDArray[np.float64]) -> bool:
    """Whether poses with error bounds are proved to be pairwise different.

    Parameters
    ----------
    entries
        The entries of R, and of T divided by the scale, shape (n, 12).
    deviations
        Bounds of their errors, shape (n,).
    """
    low, high = _intervals(entries, deviations)
    if not np.isfinite(high - low).all():
        return False
    order = np.argsort(low)
    following = np.searchsorted(low[order], high[order], side="right")
    for position, end in enumerate(following.tolist()):
        others = order[position + 1 : end]
        if len(others):
            first = order[position]
            gaps = np.abs(entries[others] - entries[first]).max(axis=1)
            if not (gaps > above(deviations[others] + deviations[first])).all():
                return False
    return True


def _intervals(
    entries: NDArray[np.complex128], deviations: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the ends of the intervals in which a linear form of each pose is, shapes (..., n)."""
    parts = np.concatenate((entries.real, entries.imag), axis=-1)
    weights = np.array(_WEIGHTS)
    forms = parts @ weights
    # The error of the form, with its few roundings.
    reach = above(weights.sum() * deviations + roundings(1, np.abs(parts) @ weights))
    return forms - reach, forms + reach


@np.errstate(all="ignore")
def places(
    entries: NDArray[np.complex128], deviations: NDArray[np.float64], known: int
) -> NDArray[np.intp]:
    """Return for each of n poses the first one from which it is not proved different, shape (n,).

    Parameters
    ----------
    entries, deviations
        As for `all_different`.
    known
        The first poses, in this number, are proved to be different.
    """
    low, high = _intervals(entries, deviations)
    unknown = ~np.isfinite(high - low)
    low, high = np.where(unknown, -np.inf, low), np.where(unknown, np.inf, high)
    order = np.argsort(low)
    following = np.searchsorted(low[order], high[order], side="right")
    alike: dict[int, list[int]] = {}
    for position in np.flatnonzero(following > np.arange(len(order)) + 1).tolist():
        first, others = int(order[position]), order[position + 1 : following[position]]
        gaps = np.abs(entries[others] - entries[first]).max(axis=1)
        apart = gaps > above(deviations[others] + deviations[first])
        for other in others[~apart].tolist():
            alike.setdefault(max(first, other), []).append(min(first, other))
    found = np.arange(len(entries))
    for k in sorted(alike):
        if k >= known:
            # Only poses that have a place of their own.
            there = [j for j in alike[k] if found[j] == j]
            found[k] = min(there, default=k)
    return found


def same(first: Isolation, second: Isolation) -> bool:
    """Whether two isolated solutions are proved to be the same."""
    return first.contains(second) or second.contains(first)


def _linear_form(pose: PoseBall) -> arb:
    total = arb(0)
    for k, entry in enumerate(pose.entries):
        total += entry.real * _WEIGHTS[2 * k] + entry.imag * _WEIGHTS[2 * k + 1]
    return total


def _overlap(first: PoseBall, second: PoseBall) -> bool:
    return all(x.overlaps(y) for x, y in zip(first.entries, second.entries, strict=True))


#: Largest radius of a uniqueness ball. Coordinates of e are at most about one.
REACH = 1 / 8
_IDENTITY = acb_mat(7, 7, 1)
#: Newton steps at one precision; a simple zero in reach needs fewer.
STEPS = 20


@dataclass(frozen=True)
class Isolation:
    """A ball of Study points with exactly one solution in it."""

    #: Eight exact coordinates; that of the patch is 1.
    centre: tuple[acb, ...]
    #: Index of the coordinate of e that is fixed.
    patch: int
    #: For each constraint the index of its equation.
    sides: tuple[int, ...]
    #: Exact upper bound of the distance of the solution from the centre, in the maximum norm.
    error: arb
    #: Radius of the closed ball about the centre that has no other solution of these sides.
    uniqueness: float
    #: Bits of the proof.
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
        a = float(above(floats_above(defect).reshape(7, 7).sum(axis=1).max()))
    if not a < 1:
        return None
    # Nothing is proved about points too far away for floats.
    with np.errstate(over="ignore", invalid="ignore"):
        curvatures = system.curvatures(above(floats_above(newton.centre) + REACH))
        sizes = floats_above(newton.inverse.entries()).reshape(7, 7)
        b = float(above((sizes @ curvatures).max()))
    # Any radius may be tried: q is rounded up and tested below.
    radius = min(REACH, (1 - a) / (2 * b))
    q = above(a + b * radius)
    if not (q < 1 and newton.length <= (1 - arb(q)) * radius):
        return None
    error = (newton.length / (1 - arb(q))).upper()
    return Isolation(tuple(newton.centre), patch, sides, error, radius, system.precision)
