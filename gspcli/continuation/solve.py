"""All solutions of a target system, with an account of every path."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.systems import TargetSystem
from gspcli.continuation.tracker import DEFAULT, TrackerOptions

DEFAULT_SEED = 20031


@dataclass(frozen=True, eq=False)
class SolutionCurve:
    """A positive-dimensional part of the solution set that paths ended on.

    The evidence is numerical: the Jacobian matrix has a kernel, and moving along it and
    correcting on a slice arrives at other solutions.
    """

    dimension: int
    """Local dimension of the solution set at `points`."""
    points: ComplexArray
    """The ends of paths on it, shape (k, 8), scaled to N = 1."""
    motion: ComplexArray
    """Consecutive points along it, shape (m, 8), scaled to N = 1; real (zero imaginary parts)
    if `real`."""
    real: bool
    """Whether real points were found, so that the motion is a self-motion of the mechanism."""


@dataclass(frozen=True, eq=False)
class SystemSolutions:
    """The solutions of one system. ``paths = finite + at_infinity + on_curves + lost`` always."""

    points: ComplexArray
    """Distinct finite isolated solutions, shape (n, 8), scaled to N = e.e = 1. The sign is such
    that the largest entry of e has a positive real part. Real solutions have small but in
    general not zero imaginary parts."""
    multiplicity: NDArray[np.int64]
    """How many paths end at each, shape (n,)."""
    singular: NDArray[np.bool_]
    """Whether the Jacobian matrix at each is numerically singular, shape (n,)."""
    condition: FloatArray
    """Condition number of each: the norm of the inverse of the Jacobian matrix with rows
    scaled to 1, in coordinates scaled to norm 1; shape (n,)."""
    residual: FloatArray
    """Largest value of an equation, relative to its coefficients, shape (n,)."""
    paths: int
    """Number of paths, which is the generic count of the structure: 2^products times I."""
    at_infinity: int
    """Paths that end at infinity, N = 0."""
    on_curves: int
    """Paths that end on positive-dimensional solution sets."""
    lost: int
    """Paths whose end is not known."""
    curves: tuple[SolutionCurve, ...]
    """The positive-dimensional solution sets found."""
    seed: int
    """What the random choices were made from."""

    @property
    def finite(self) -> int:
        """Number of paths that end at finite isolated solutions: the sum of multiplicities."""
        return int(self.multiplicity.sum())

    @property
    def verdict(self) -> Literal["complete", "infinite", "incomplete"]:
        """`infinite` if there are curves, else `incomplete` if paths are lost."""
        if self.curves:
            return "infinite"
        return "incomplete" if self.lost else "complete"


def solve_system(
    target: TargetSystem,
    *,
    seed: int = DEFAULT_SEED,
    jobs: int = 1,
    options: TrackerOptions = DEFAULT,
) -> SystemSolutions:
    """Return all isolated solutions of a system, and evidence of any others.

    Parameters
    ----------
    target
        What to solve.
    seed
        Source of the random complex paths. Another seed gives the same set of solutions.
    jobs
        Threads. The result does not depend on them.
    options
        Settings of the tracker.
    """
    return next(solve_systems([target], seed=seed, jobs=jobs, options=options))


def solve_systems(
    targets: Iterable[TargetSystem],
    *,
    seed: int = DEFAULT_SEED,
    jobs: int = 1,
    options: TrackerOptions = DEFAULT,
) -> Iterator[SystemSolutions]:
    """Yield the solutions of many systems, in order, as they become known.

    Each result is the same as `solve_system` gives. Consecutive systems of one structure are
    tracked together, which is what makes this quicker than a loop.
    """
    raise NotImplementedError
