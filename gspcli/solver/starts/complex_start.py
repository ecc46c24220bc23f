"""Systems of one geometry with complex values, solved: from there the values alone are moved.

Where the geometry is special there are fewer solutions than its type has: the others are at
infinity whatever the values. Which of the two is true the geometry's exact count says.
"""

from __future__ import annotations

from enum import Enum

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, Kind
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.reduced_homotopy import ReducedHomotopy
from gspcli.continuation.systems import EQUATIONS, System
from gspcli.continuation.tracked_paths import TrackedPaths, track_all
from gspcli.records import dataclass
from gspcli.solver.starts.start_pool import StartPool
from gspcli.solver.study_systems import coefficients_of, complex_system

Array = NDArray[np.float64]

#: The parameters of a start are a mean plus i times a spread times random numbers between these, so
#: that nothing about it is special. Anything from a third to three standard deviations of the
#: parameters asked for makes paths about as short.
_SPREAD = (0.7, 1.3)


class StartMethod(Enum):
    """How the solutions of a start are found."""

    SOLVED = "by short paths from a solved platform of the geometry; there may be others"
    QUICK = "by paths from the stored start, simple ends only; there may be others"
    CAREFUL = "by all of these, followed to their ends; None unless all finite ones are simple"


@dataclass(frozen=True, eq=False)
class GeometryStart:
    """A solved system of a geometry with complex values.

    Attributes
    ----------
    system
        In canonical order, balanced.
    points
        Its solutions that were found, shape (n, 8).
    scale
        The unit of f in it.
    pool
        The same with fewer unknowns, where nothing but multiples of N moves; None elsewhere.
    """

    system: System
    points: ComplexArray
    scale: Array
    pool: StartPool | None


@dataclass(frozen=True, eq=False)
class SolvedSystem:
    """A solved platform of the geometry.

    Attributes
    ----------
    parameters
        What the equations are linear in, shape (6,).
    points
        Its Study points, shape (n, 8).
    """

    parameters: Array
    points: ComplexArray


def geometry_start(
    kinds: tuple[Kind, ...],
    geometry: bytes,
    mean: tuple[float, ...],
    spread: tuple[float, ...],
    seed: int,
    *,
    way: StartMethod,
    solved: SolvedSystem | None = None,
) -> GeometryStart | None:
    """Return the start of a geometry with the finite solutions that paths lead to.

    Parameters
    ----------
    kinds, geometry
        The kinds of the constraints, and y, x, u, v of their primitives, (4, 6, 3).
    mean, spread
        Of the parameters; a spread of zero leaves the parameter alone.
    seed
        Source of random numbers.
    way
        How they are found.
    solved
        From where, if that is from a solved platform.
    """
    rng = np.random.default_rng([seed, len(kinds)])
    turns = rng.choice([-1.0, 1.0], len(kinds)) * rng.uniform(*_SPREAD, len(kinds))
    parameters = np.where(np.array(spread) == 0, 0.0, np.array(mean) + 1j * turns * spread)
    y, x, u, v = np.frombuffer(geometry).reshape(4, len(kinds), 3)
    system = complex_system(kinds, y, x, u, v, parameters)
    structure = system.structure
    solutions: ComplexArray | None = None
    homotopy = None
    if not structure.is_product.any() and DLL not in kinds:
        _, plain = coefficients_of(kinds, y, x, u, v, np.zeros((1, len(kinds))))
        homotopy = ReducedHomotopy.of(plain.g[0].real)
    if way is StartMethod.SOLVED:
        solutions = _ends_from_solved(homotopy, solved, parameters)
    else:
        tracked_paths = next(track_all([system], seed=seed))
        solutions = (
            _all_finite(tracked_paths)
            if way is StartMethod.CAREFUL
            else tracked_paths.distinct_simple()
        )
    if solutions is None or not len(solutions):
        return None
    balanced, scale = system.coefficients.balanced()
    points = solutions.copy()
    points[:, 4:] /= scale
    pool = None if homotopy is None else _pool(homotopy, parameters, solutions)
    return GeometryStart(System(system.structure, balanced), points, scale, pool)


def _pool(homotopy: ReducedHomotopy, parameters: ComplexArray, points: ComplexArray) -> StartPool:
    return StartPool(homotopy, parameters[None], homotopy.points(points[None]), np.ones(EQUATIONS))


def _ends_from_solved(
    homotopy: ReducedHomotopy | None, solved: SolvedSystem | None, parameters: ComplexArray
) -> ComplexArray | None:
    """Return where all poses of a solved platform lead; None if some are lost or meet."""
    if homotopy is None or solved is None:
        return None
    real = _pool(homotopy, solved.parameters.astype(complex), solved.points)
    return real.solutions_at(parameters)


def _all_finite(tracked_paths: TrackedPaths) -> ComplexArray | None:
    """Return all finite solutions, None unless they are simple and every path is accounted for."""
    solutions = tracked_paths.solutions()
    simple = (solutions.multiplicity == 1).all() and not solutions.singular.any()
    return solutions.points if solutions.account.verdict == "complete" and simple else None
