"""All solutions of a target system, with an account of every path."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from itertools import groupby, islice

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.accounts import (
    Settled,
    all_regular,
    random_start,
    regular_ends,
    settle,
)
from gspcli.continuation.paths import PathAccount
from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.start import StartSystem, start_system
from gspcli.continuation.systems import Coefficients, System
from gspcli.continuation.tracker import DEFAULT, PathResults, TrackerOptions, track
from gspcli.defaults import SEED

_BATCH = 256
_BATCH_PATHS = 65_536


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
    """The solutions of one system, with an account of every path."""

    points: ComplexArray
    """Distinct finite isolated solutions, shape (n, 8), scaled to N = e.e = 1. The sign is such
    that the largest entry of e has a positive real part. Real solutions have small but in
    general not zero imaginary parts."""
    multiplicity: NDArray[np.int64]
    """How many paths end at each, shape (n,)."""
    singular: NDArray[np.bool_]
    """Whether the Jacobian matrix at each is numerically singular, shape (n,)."""
    condition: FloatArray
    """Condition number of each, shape (n,): Frobenius norm of the inverse of the Jacobian matrix,
    in coordinates scaled to norm 1, the equations divided by the size of the terms that cancel
    in them. A relative change of the coefficients moves the solution by about as much times
    this. Infinite where singular."""
    residual: FloatArray
    """Largest value of an equation, divided by the size of the terms that cancel in it, for
    coordinates and factors of norm 1; shape (n,)."""
    account: PathAccount
    """Where all paths end; as many are expected as the generic count of the structure says,
    2^products times I."""
    curves: tuple[SolutionCurve, ...]
    """The positive-dimensional solution sets found."""
    seed: int
    """What the random choices were made from."""


def solve_system(
    target: System,
    *,
    seed: int = SEED,
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
        Settings of the first attempt; what it loses is tracked again with `CAREFUL` and
        `PARANOID`.

    Raises
    ------
    ValueError
        If more than three equations are of family a.
    """
    return next(solve_systems([target], seed=seed, jobs=jobs, options=options))


def solve_systems(
    targets: Iterable[System],
    *,
    seed: int = SEED,
    jobs: int = 1,
    options: TrackerOptions = DEFAULT,
) -> Iterator[SystemSolutions]:
    """Yield the solutions of many systems, in order, as they become known.

    Each result is the same as `solve_system` gives. Consecutive systems of one structure are
    tracked together, which is what makes this quicker than a loop.
    """
    for structure, group in groupby(targets, key=lambda target: target.structure):
        start = start_system(structure.canonical())
        size = max(1, min(_BATCH, _BATCH_PATHS // len(start.points)))
        while batch := list(islice(group, size)):
            yield from _solve_batch(start, batch, seed, jobs, options)


def _solve_batch(
    start: StartSystem,
    targets: list[System],
    seed: int,
    jobs: int,
    options: TrackerOptions,
) -> Iterator[SystemSolutions]:
    given = Coefficients.stacked([target.canonical() for target in targets])
    balanced, scale = given.balanced()
    results = track(
        random_start(start, seed, 0),
        balanced,
        start.points,
        options=options,
        jobs=jobs,
    )
    clean = all_regular(results)
    for i in range(len(targets)):
        if clean[i]:
            ends = regular_ends(results, i)
        else:
            row = PathResults(*(getattr(results, f.name)[i : i + 1] for f in fields(results)))
            target = System(start.system.structure, balanced.take(i))
            ends = settle(start, target, row, seed, jobs)
        yield _solutions(ends, float(scale[i]), seed)


def _solutions(ends: Settled, scale: float, seed: int) -> SystemSolutions:
    return SystemSolutions(
        points=_scaled_to_one(ends.points, scale),
        multiplicity=ends.multiplicity,
        singular=~np.isfinite(ends.condition),
        condition=ends.condition,
        residual=ends.residual,
        account=ends.account,
        curves=tuple(
            SolutionCurve(
                curve.dimension,
                _scaled_to_one(curve.points, scale),
                _scaled_to_one(curve.motion, scale),
                curve.real,
            )
            for curve in ends.curves
        ),
        seed=seed,
    )


def _scaled_to_one(points: ComplexArray, scale: float) -> ComplexArray:
    """Undo the balance of e and f, and scale to N = 1 with a definite sign."""
    points = points / np.sqrt((points[:, :4] ** 2).sum(axis=1, keepdims=True))
    points[:, 4:] *= scale
    largest = points[np.arange(len(points)), np.abs(points[:, :4]).argmax(axis=1)]
    return points * np.where(largest.real < 0, -1.0, 1.0)[:, None]
