"""Tracking of solution paths between systems of one structure, by the native kernel."""

from __future__ import annotations

from dataclasses import fields
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.systems import Coefficients, System
from gspcli.records import dataclass


@dataclass(frozen=True)
class TrackerOptions:
    """Settings of the path tracker."""

    predictor_tolerance: float = 1e-4
    """Aimed length of the first Newton correction; points have norm 1."""
    contraction: float = 0.05
    """Largest accepted ratio of the second to the first Newton correction."""
    arrival: float = 1.0
    """Largest accepted second Newton correction at the target. Solutions that are nearer to each
    other than its square root attract Newton's method all alike from farther away."""
    radius_fraction: float = 0.7
    """Largest step, as a part of the estimated radius of convergence of the Taylor series."""
    min_step: float = 1e-14
    """A step in t below this fails."""
    waypoint: float = 1e-3
    """Distance 1 - t from which the endgame starts for paths that need it; 0 if there is to be
    none."""
    nearest: float = 1e-12
    """Distance 1 - t below which a path that still cannot step to the target needs it. Two
    regular solutions as near as 1e-6 are distinguished only if this is small."""
    max_steps: int = 1000
    """Accepted and rejected steps after which a path fails."""
    late_steps: int = 60
    """Steps beyond the waypoint after which a path needs the endgame."""
    digits: int = 16
    """Digits to compute with: 16, or 32, about 20 times slower. Start systems and start points stay
    doubles, taken as exact; of a target 32 digits may be given."""
    short_series: bool = False
    """Whether the Taylor series have few terms (with 16 digits): quicker where steps are few."""


#: For paths that are followed to the end, whatever becomes of them.
DEFAULT = TrackerOptions()
#: For paths that `DEFAULT` loses, and those that have jumped.
CAREFUL = TrackerOptions(
    predictor_tolerance=1e-6, contraction=0.02, radius_fraction=0.4, late_steps=1000
)
#: Longer steps and fewer terms, where lost paths are detected and followed again.
QUICK = TrackerOptions(
    predictor_tolerance=3e-3, contraction=0.1, min_step=1e-10, max_steps=200, short_series=True
)


class PathStatus(IntEnum):
    """The end of a path."""

    REGULAR = 0
    """It reached the target, and Newton's method was run there."""
    SINGULAR = 1
    """It was stopped in front of the target, where the Jacobian matrix degenerates; its point is
    that of the waypoint."""
    FAILED = 2
    """It was stopped on the way: the step became too small, or the steps too many. So are paths in
    front of the target that have passed no waypoint."""


# Rounding of the coefficients and the residual of Newton's step move a solution to first order by
# some d. The solution is clearly simple if the second-order terms move it much less, by the
# condition of Kantorovich's theorem, ``|J^-1 F''(d, d)| << |d|``. At a double solution that
# rounding has split both are of one size, also if Newton's step is small; so they are where both
# factors of a product vanish, although the Jacobian matrix with scaled rows is well-conditioned.
ROUNDING = 4e-16
#: Largest ratio of second to first order of a clearly simple solution, for bounds.
_CLEARLY = 1e-3
#: Newton's method has converged if its last correction is at most this part of e.
_CONVERGES = 1e-3

#: At most this many threads are started.
MOST_THREADS = 256


@dataclass(frozen=True, eq=False)
class PathResults:
    """The ends of P paths to each of B targets."""

    points: ComplexArray
    """Study points of norm 1, shape (B, P, 8)."""
    low: ComplexArray
    """What more digits add to the points: a double each, shape (B, P, 1, 8); (0, P, 1, 8) if
    16 were computed."""
    left: FloatArray
    """How much of the way from t = 0 to 1 was left at the points: 1 - t, shape (B, P)."""
    status: NDArray[np.uint8]
    """`PathStatus`, shape (B, P)."""
    steps: NDArray[np.int32]
    """Steps taken, shape (B, P)."""
    condition: FloatArray
    """Frobenius norm of the inverse of the Jacobian matrix, the equations divided by the size of
    the terms that cancel in them, shape (B, P); like the next three, -1 unless the status is
    `REGULAR`."""
    curvature: FloatArray
    """Likewise for the unscaled equations, whose factors have norm 1: it bounds the change of the
    Jacobian matrix, times its inverse, over a distance of one; shape (B, P)."""
    residual: FloatArray
    """Largest absolute value of the seven equations, divided likewise, shape (B, P)."""
    correction: FloatArray
    """Length of the last Newton correction, shape (B, P); negative if none was made."""

    @property
    def is_simple(self) -> NDArray[np.bool_]:
        """Which ends are clearly simple solutions by these numbers, shape (B, P)."""
        step = self.correction + ROUNDING * self.condition
        bounded = self.curvature * step < _CLEARLY
        return np.asarray((self.status == PathStatus.REGULAR) & bounded)

    @property
    def has_converged(self) -> NDArray[np.bool_]:
        """At which ends Newton's method converges, with these digits, shape (B, P)."""
        e = np.abs(self.points[..., :4]).max(axis=-1)
        return np.asarray((self.correction >= 0) & (self.correction < _CONVERGES * e))

    @property
    def more(self) -> ComplexArray:
        """What more digits add to the points of one target, shape (P, 1, 8); else (P, 0, 8)."""
        return self.low[:, :, 0].swapaxes(0, 1)

    def take(self, index: NDArray[np.bool_] | NDArray[np.intp]) -> PathResults:
        """Return the results of some of the paths."""
        return PathResults(*(getattr(self, field.name)[:, index] for field in fields(self)))


def track(
    start: System,
    targets: Coefficients | System,
    points: ComplexArray,
    *,
    more: Coefficients | None = None,
    low: ComplexArray | None = None,
    left: FloatArray | None = None,
    options: TrackerOptions = DEFAULT,
    jobs: int = 1,
    build: str = "",
) -> PathResults:
    """Track solutions of one system to each of many targets along straight lines.

    The coefficients move along the line from `start` to each target; scale them and multiply them
    by random phases before. Paths that meet or jump are not detected: compare the number of
    distinct ends with that of the paths.

    Parameters
    ----------
    start
        One system.
    targets
        The numbers of B systems of the same structure, with a leading axis; or one such system.
    points
        Solutions of the start system, shape (P, 8), nonzero.
    more
        A double to add to each number of a single target, for more than 16 digits; leading axis
        (1,).
    low
        A double to add to each coordinate of the points, shape (P, 1, 8).
    left
        The rest of the way, 1 - t, at the points, shape (P,): they are solutions at t. It is 1 by
        default. If it is 0, Newton's method improves the point.
    options
        Settings.
    jobs
        The most threads; the result does not depend on them.
    build
        Name of a build of the kernel (``portable``, ``avx2``, ``avx512``); the quickest if empty.

    Returns
    -------
    PathResults
        In the order of targets and points.
    """
    if isinstance(targets, System):
        targets = Coefficients.stacked([targets])
    further = targets.take(slice(0)) if more is None else more
    rest = np.zeros((0, 1, points.shape[1]), complex) if low is None else low
    given = (*start.coefficients, *targets, *further, points, rest)
    begun = np.zeros(0) if left is None else np.ascontiguousarray(left, dtype=np.float64)
    arrays = [np.ascontiguousarray(x, dtype=np.complex128) for x in given]
    return PathResults(
        *_kernel.track(
            start.structure.is_product,
            *arrays,
            left=begun,
            predictor_tolerance=options.predictor_tolerance,
            contraction=options.contraction,
            arrival=options.arrival,
            radius_fraction=options.radius_fraction,
            min_step=options.min_step,
            waypoint=options.waypoint,
            nearest=options.nearest,
            max_steps=options.max_steps,
            late_steps=options.late_steps,
            digits=options.digits,
            short_series=options.short_series,
            jobs=helpful(jobs, len(arrays[3]) * len(points)),
            build=build,
        )
    )


def helpful(jobs: int, paths: int) -> int:
    """Return the number of threads to start: at most the number of paths."""
    return max(1, min(jobs, paths, MOST_THREADS))
