"""Systems of one geometry with complex values, solved: from there the values alone are moved.

A special geometry has fewer solutions than its type: for all values the others are at infinity. The
exact count of the geometry decides whether it is special.

A start is about the mean of all sets of values, far enough from real ones that nothing about it is
special. Where there are many sets, it gets members with the values of some of them and smaller
imaginary parts: from the nearest one paths are shorter.
"""

from __future__ import annotations

from dataclasses import replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, Kind
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.reduced_homotopy import ReducedEnds, ReducedHomotopy
from gspcli.continuation.systems import EQUATIONS, System
from gspcli.continuation.tracked_paths import TrackedPaths, track_all
from gspcli.continuation.tracker import PathStatus
from gspcli.continuation.tracker_options import FROM_START, SHORT_STEPS, TrackerOptions
from gspcli.records import dataclass
from gspcli.solver.study_systems import coefficients_of, complex_system

Array = NDArray[np.float64]

#: The parameters of a start are a mean plus i times a spread times random numbers between these, so
#: that nothing about it is special. Anything from a third to three standard deviations of the
#: parameters asked for makes paths about as short.
_SPREAD = (0.7, 1.3)
#: Sets of values for each member: one costs about as much as ten sets cost less by it, and no
#: more than so many are of use.
_SETS_A_MEMBER = 32
_LEAST, _MOST = 4, 128
#: The imaginary parts of a member as parts of those of the start.
_NEARER = 0.3
#: Solutions whose Study points have a cosine nearer to one count as the same.
_SAME = 1e-10


class StartMethod(Enum):
    """How the solutions of a start are found."""

    SOLVED = "by short paths from a solved platform of the geometry; there may be others"
    QUICK = "by paths from the stored start, simple ends only; there may be others"
    CAREFUL = "by all of these, followed to their ends; None unless all finite ones are simple"


@dataclass(frozen=True, eq=False)
class Start:
    """Solved systems of a geometry with complex values.

    Attributes
    ----------
    system
        The first of them, in canonical order, balanced.
    points
        Its solutions that were found, shape (n, 8).
    scale
        The unit of f in it.
    homotopy
        The equations with fewer unknowns, where nothing but multiples of N moves; None elsewhere.
    parameters
        What these are linear in, of each of s members, shape (s, 6).
    reduced
        The solutions in their coordinates, shape (s, n, d).
    unit
        In which differences of each parameter are measured, shape (6,).
    """

    system: System
    points: ComplexArray
    scale: Array
    homotopy: ReducedHomotopy | None
    parameters: ComplexArray
    reduced: ComplexArray
    unit: Array

    def about(self, parameters: Array, jobs: int) -> Start:
        """Return a start with members among sets of real parameters (b, 6).

        They are solved from the first member. This start if there are too few sets.
        """
        size = min(len(parameters) // _SETS_A_MEMBER, _MOST)
        if size < _LEAST:
            return self
        chosen = np.linspace(0, len(parameters) - 1, size).astype(np.intp)
        members = parameters[chosen] + 1j * _NEARER * self.parameters[0].imag
        ends = self._follow(members, np.zeros(size, np.int32), FROM_START, jobs)
        good = np.flatnonzero(_all_different(ends))
        deviation = parameters.std(axis=0)
        unit = np.where(deviation > 0, deviation, 1.0)
        if not len(good):
            return self
        return replace(self, parameters=members[good], reduced=ends.points[good], unit=unit)

    def follow(self, parameters: Array, options: TrackerOptions, jobs: int) -> ComplexArray:
        """Return the ends of paths from the nearest member to each set of parameters (b, 6).

        Study points of any norm, shape (b, n, 8), not a number where a path is lost.
        """
        ends = self._follow(parameters.astype(complex), self._nearest(parameters), options, jobs)
        # What is no end must not pass for one.
        ends.study[ends.status != PathStatus.REGULAR] = np.nan
        return ends.study

    def _follow(
        self, parameters: ComplexArray, start: NDArray[np.int32], options: TrackerOptions, jobs: int
    ) -> ReducedEnds:
        assert self.homotopy is not None
        given = self.parameters, self.reduced, start, parameters
        return self.homotopy.track(*given, options=options, jobs=jobs)

    def _nearest(self, parameters: Array) -> NDArray[np.int32]:
        """Return which member is nearest to each set of parameters (b, 6)."""
        if len(self.parameters) == 1:
            return np.zeros(len(parameters), np.int32)
        members, sets = self.parameters.real / self.unit, parameters / self.unit
        # Of the squared distances the squares of the sets are the same for all members.
        far = (members**2).sum(axis=1) - 2 * sets @ members.T
        nearest: NDArray[np.int32] = far.argmin(axis=1).astype(np.int32)
        return nearest


def geometry_start(
    kinds: tuple[Kind, ...],
    geometry: bytes,
    mean: tuple[float, ...],
    spread: tuple[float, ...],
    seed: int,
    *,
    way: StartMethod,
    solved: tuple[Array, ComplexArray] | None = None,
) -> Start | None:
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
    reduced = solutions[None, :, :0] if homotopy is None else homotopy.points(solutions[None])
    return Start(
        system=System(system.structure, balanced),
        points=points,
        scale=scale,
        homotopy=homotopy,
        parameters=parameters[None],
        reduced=reduced,
        unit=np.ones(EQUATIONS),
    )


def _ends_from_solved(
    homotopy: ReducedHomotopy | None,
    solved: tuple[Array, ComplexArray] | None,
    parameters: ComplexArray,
) -> ComplexArray | None:
    """Return where all poses of a solved platform lead, (n, 8); None if some are lost or meet."""
    if homotopy is None or solved is None:
        return None
    real, points = solved
    given = real[None].astype(complex), homotopy.points(points[None]), np.zeros(1, np.int32)
    ends = homotopy.track(*given, parameters[None], options=SHORT_STEPS, jobs=1)
    return ends.study[0] if _all_different(ends)[0] else None


def _all_finite(tracked_paths: TrackedPaths) -> ComplexArray | None:
    """Return all finite solutions, None unless they are simple and every path is accounted for."""
    solutions = tracked_paths.solutions()
    simple = (solutions.multiplicity == 1).all() and not solutions.singular.any()
    return solutions.points if solutions.account.verdict == "complete" and simple else None


def _all_different(ends: ReducedEnds) -> NDArray[np.bool_]:
    """Return to which targets (b,) all paths lead, to different solutions."""
    # Paths that fail may leave no numbers: these are different from none.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        points = ends.study / np.linalg.norm(ends.study, axis=-1, keepdims=True)
        overlaps = np.abs(points.conj() @ points.swapaxes(1, 2))
    overlaps[:, np.eye(points.shape[1], dtype=bool)] = 0
    regular = (ends.status == PathStatus.REGULAR).all(axis=1)
    return np.asarray(regular & (overlaps < 1 - _SAME).all(axis=(1, 2)))
