"""Generic solution counts from nothing: monodromy loops and trace tests.

All pairs (system in six given spaces, solution) form an irreducible variety, because the systems
through a given point form a linear space. So loops in the space of systems permute the solutions of
a generic system transitively, and one solution leads to all. The first one is a chosen point,
through which the system is chosen. Trace tests confirm that no solution is missing.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import (
    BASES,
    ComplexArray,
    evaluate,
    monomials,
    random_complex,
    random_quadrics,
)
from gspcli.continuation.systems import EQUATIONS, Coefficients, Structure, System
from gspcli.continuation.tracker import CAREFUL, PathStatus, TrackerOptions, track
from gspcli.records import dataclass

_QUIET_LOOPS = 8
_MAX_LOOPS = 500


class MonodromyError(Exception):
    """The loops went on to find solutions, or the trace test failed."""


@dataclass(frozen=True, eq=False)
class GenericSolutions:
    """A generic system of six quadrics with all its solutions."""

    quadrics: ComplexArray
    """Shape (6, 27)."""
    points: ComplexArray
    """Shape (count, 8), norm 1."""
    loops: int
    """How many loops were run."""
    trace: float
    """The largest relative defect of the trace tests; see `trace_defects`."""


def random_phases(rng: np.random.Generator, *shape: int) -> ComplexArray:
    """Return random complex numbers of absolute value 1."""
    return np.asarray(np.exp(2j * np.pi * rng.random(shape)))


def random_point(rng: np.random.Generator) -> ComplexArray:
    """Return a random complex point of the Study quadric, norm 1, shape (8,)."""
    e, f = random_complex(rng, 2, 4)
    point = np.concatenate([e, f - e * (e @ f) / (e @ e)])
    return np.asarray(point / np.linalg.norm(point))


def _through(point: ComplexArray, spaces: str, quadrics: ComplexArray) -> ComplexArray:
    """Return the nearest quadrics of the same spaces that vanish at a point."""
    rows = []
    for letter, quadric in zip(spaces, quadrics, strict=True):
        basis = np.linalg.qr(BASES[letter].T)[0].T
        values = basis @ monomials(point)
        rows.append(
            quadric
            - (quadric @ monomials(point)) * (values.conj() @ basis) / np.vdot(values, values)
        )
    return np.array(rows)


def _system(spaces: str, quadrics: ComplexArray) -> System:
    zero = np.zeros(EQUATIONS, dtype=np.complex128)
    return System(Structure(spaces), Coefficients(quadrics, np.zeros_like(quadrics), zero))


def move(
    spaces: str,
    start: ComplexArray,
    target: ComplexArray,
    points: ComplexArray,
    options: TrackerOptions = CAREFUL,
) -> ComplexArray:
    """Track solutions from one generic system of six quadrics to another; keep the regular ends.

    Returns
    -------
    ndarray
        Shape (at most P, 8).
    """
    results = track(_system(spaces, start), _system(spaces, target), points, options=options)
    return np.asarray(results.points[0][results.status[0] == PathStatus.REGULAR])


def _merge(points: ComplexArray, others: ComplexArray) -> ComplexArray:
    """Return the points, and the others that are not among them."""
    for other in others:
        if np.abs(points.conj() @ other).max() < 1 - 1e-10:
            points = np.vstack([points, other])
    return points


def solve_generic(spaces: str, rng: np.random.Generator) -> GenericSolutions:
    """Solve a random generic system of six quadrics by monodromy.

    Parameters
    ----------
    spaces
        Six letters.
    rng
        Source of every random choice.

    Raises
    ------
    MonodromyError
        If the loops go on to find solutions, or a trace test fails.
    """
    point = random_point(rng)
    base = _through(point, spaces, random_quadrics(spaces, rng))
    points, quiet, loops = point[None], 0, 0
    while quiet < _QUIET_LOOPS:
        if loops == _MAX_LOOPS:
            message = f"{spaces}: still new solutions after {loops} loops ({len(points)})"
            raise MonodromyError(message)
        corners = [base, *(random_quadrics(spaces, rng) for _ in range(2)), base]
        ends = points
        for start, target in pairwise(corners):
            ends = move(spaces, start * random_phases(rng, EQUATIONS, 1), target, ends)
        merged = _merge(points, ends)
        quiet = quiet + 1 if len(merged) == len(points) else 0
        points, loops = merged, loops + 1
    trace = trace_defects(spaces, base, points, rng).max()
    if not trace < 1e-8:
        message = f"{spaces}: the trace test fails ({len(points)} solutions, defect {trace:.1e})"
        raise MonodromyError(message)
    return GenericSolutions(base, points, loops, float(trace))


def trace_defects(
    spaces: str, quadrics: ComplexArray, points: ComplexArray, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the relative defect of one trace test for each space present.

    Five equations define a curve. Take the chart in which a quadric k of the sixth equation's space
    is 1. There the solutions of ``g + s k = 0`` are the sections of the curve with parallel
    hyperplanes. So the sum of another coordinate m / k over *all* of them is an affine function of
    s. If the curve is irreducible, the sum over a part of them in general is not. The curve of each
    space is tried.

    Returns
    -------
    ndarray
        Second differences of the sums, relative to the sum of absolute values.
    """
    defects = []
    for letter in sorted(set(spaces)):
        i = spaces.index(letter)
        chart, coordinate = random_quadrics(letter * 2, rng)
        step = random_phases(rng, 1)[0]
        sums, size = [], 0.0
        for s in (-step, 0.0, step):
            shifted = quadrics.copy()
            shifted[i] += s * chart
            ends = points if s == 0 else move(spaces, quadrics, shifted, points)
            top, bottom = evaluate(np.array([coordinate, chart]), ends).T
            sums.append((top / bottom).sum())
            size += float(np.abs(top / bottom).sum())
        defects.append(abs(sums[0] - 2 * sums[1] + sums[2]) / size)
    return np.array(defects)
