"""Paths from the solutions of one system to those of another system of its structure."""

from __future__ import annotations

import numpy as np

from gspcli.continuation.endpoints import all_regular
from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.systems import EQUATIONS, System
from gspcli.continuation.tracker import track
from gspcli.continuation.tracker_options import DEFAULT, TrackerOptions
from gspcli.records import dataclass

#: Angles of the random phases. With zero a path between real systems can meet a fold; with larger
#: angles a path is longer and has more steps.
_PHASES = (0.3, 1.0)


@dataclass(frozen=True, eq=False)
class Followed:
    """Solutions of a system, in the order of those of the system from which they were followed."""

    points: ComplexArray
    """Shape (n, 8), scaled to N = e.e = 1."""
    condition: FloatArray
    """Condition number of each (`SystemSolutions.condition`), shape (n,)."""


def follow(
    known: System,
    points: ComplexArray,
    target: System,
    *,
    rng: np.random.Generator,
    options: TrackerOptions = DEFAULT,
    jobs: int = 1,
) -> Followed | None:
    """Follow solutions of one system to another of the same structure, along a complex path.

    The random path decides which solution leads to which. If the points are all solutions of a
    system with the generic number of solutions, they lead to all solutions of the target. Paths
    that end at infinity or at each other are not analysed, unlike in `solve_systems`.

    Parameters
    ----------
    known
        A system; lengths of order one (`Coefficients.balanced`), as those of the target.
    points
        Solutions of it, shape (n, 8), of any norm.
    target
        Another system with its equations in the same order.
    rng
        Source of the path.
    options, jobs
        As for `track`.

    Returns
    -------
    Followed or None
        None unless all paths end at finite regular solutions that are distinct.
    """
    g, h = np.exp(1j * rng.uniform(*_PHASES, size=(2, EQUATIONS)))
    square = np.einsum("ni,ni->n", points.conj(), points).real
    starts = points * (1 / np.sqrt(square))[:, None]
    results = track(
        known.normalized().scaled(g, h), target.normalized(), starts, options=options, jobs=jobs
    )
    if not all_regular(results)[0]:
        return None
    return Followed(_finite(results.points[0]), results.condition[0])


# Ends at infinity give meaningless numbers.
@np.errstate(divide="ignore", invalid="ignore")
def _finite(points: ComplexArray) -> ComplexArray:
    return np.asarray(points / np.sqrt((points[..., :4] ** 2).sum(axis=-1, keepdims=True)))
