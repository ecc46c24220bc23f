"""Starts: solved systems of one geometry with complex values.

Short paths lead from the solutions of a start to the poses for all real values: the values alone
change. A special geometry has fewer solutions than its type: for all values the others are at
infinity. The exact count of the geometry decides whether it is special, and proves that no path is
missing. Without that count a special geometry has no start.

A start is about the mean of all sets of values, far enough from real ones that nothing about it is
special. Where there are many sets, it gets members with the values of some of them and smaller
imaginary parts: from the nearest one paths are shorter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from enum import Enum
from functools import cached_property, partial
from math import ceil, log2
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.equations.local_frames import StudyFrames
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.reduced_homotopy import LONG_STEPS, ReducedEnds, ReducedHomotopy
from gspcli.continuation.start import path_count
from gspcli.continuation.systems import EQUATIONS, Coefficients, System
from gspcli.continuation.tracked_paths import TrackedPaths, track_all
from gspcli.continuation.tracker import CAREFUL, DEFAULT, QUICK, PathStatus, TrackerOptions, track
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import apply, study_from_pose
from gspcli.records import dataclass
from gspcli.solver.poses import CountKind, PoseSet, Proof
from gspcli.solver.solved_starts import SolvedStarts, Sort
from gspcli.solver.study_systems import coefficients_of, complex_system, side_choices

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.certification.poses.far_poses import FarPoses


Array = NDArray[np.float64]
Index = NDArray[np.int32]
#: Ends of paths (b, k, m, 8) and their frames (`Search.add`).
StudyEnds = tuple[ComplexArray, StudyFrames]

#: This many paths are followed together, for the memory of their ends.
_BATCH_PATHS = 16_384
#: The spread of the parameters of a start is their standard deviation, but no less than this (in
#: typical lengths, their squares, or cosines).
_LEAST_DEVIATION = 0.125
#: The mean is rounded to multiples of this, and deviations to powers of two, so that the next
#: batch is likely to find its start solved.
_GRID = 0.125
#: The parameters of a start are a mean plus i times a spread times random numbers between these, so
#: that nothing about it is special. Anything from a third to three standard deviations of the
#: parameters asked for makes paths about as short.
_SPREAD = (0.7, 1.3)
#: Sets of values for each member: one costs about as much as ten sets cost less by it, and more
#: than this many do not help.
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
    """Solved systems of a geometry with complex values."""

    #: The geometry, and its unit of length, a power of two.
    given: Arrangement
    length: float
    #: The first of the systems, in canonical order, balanced.
    system: System
    #: Its solutions that were found, shape (n, 8).
    points: ComplexArray
    #: The unit of f in it.
    scale: Array
    #: The equations with fewer unknowns, where nothing but multiples of N moves; None elsewhere.
    homotopy: ReducedHomotopy | None
    #: What these are linear in, of the first system and of members among sets of values, shape (s,
    #: 6).
    parameters: ComplexArray
    #: The solutions in their coordinates, shape (s, n, d).
    reduced: ComplexArray
    #: In which differences of each parameter are measured, shape (6,).
    unit: Array
    #: The poses to which no paths lead, for the only choice of sides; None if there are none.
    far: FarPoses | None = None
    #: What as many certified poses as the start has prove.
    proof: Proof | None = None

    @cached_property
    def inner(self) -> Arrangement:
        """The geometry in its unit of length."""
        return self.given.in_units_of(self.length)

    @cached_property
    def choices(self) -> Array:
        """The sign of each value for each choice of sides, shape (k, 6)."""
        return side_choices(self.given)

    @property
    def found(self) -> int:
        """How many poses there are for values in general position."""
        near = len(self.points) * len(self.choices)
        return near if self.far is None else near + len(self.far)

    @property
    def batch(self) -> int:
        """How many sets of values are solved together."""
        return max(1, _BATCH_PATHS // self.found)

    @property
    def near(self) -> slice:
        """Which systems are near the sets of values: the members, if there are any."""
        return slice(1 if len(self.parameters) > 1 else 0, None)

    def among(self, rows: Array, jobs: int) -> Start:
        """Return the start with members among sets of values (b, 6), solved from the first system.

        It has none if there are too few sets.
        """
        parameters = self._parameters(rows)
        size = min(len(parameters) // _SETS_A_MEMBER, _MOST)
        if self.homotopy is None or size < _LEAST:
            return self
        chosen = np.linspace(0, len(parameters) - 1, size).astype(np.intp)
        members = parameters[chosen] + 1j * _NEARER * self.parameters[0].imag
        ends = self._track(members, np.zeros(size, np.int32), QUICK, jobs)
        good = np.flatnonzero(_all_different(ends.study, ends.status))
        deviation = parameters.std(axis=0)
        return replace(
            self,
            parameters=np.concatenate((self.parameters[:1], members[good])),
            reduced=np.concatenate((self.reduced[:1], ends.points[good])),
            unit=np.where(deviation > 0, deviation, 1.0),
        )

    def quick_ends(self, rows: Array, jobs: int = 1) -> StudyEnds:
        """Return the ends of paths to sets of values (b, 6), from the nearest system."""
        if self.homotopy is None:
            return self._whole_ends(rows, QUICK, jobs)
        parameters = self._parameters(rows)
        return self._reduced_ends(parameters, self._nearest(parameters), LONG_STEPS, jobs)

    def short_ends(self, rows: Array, jobs: int = 1) -> StudyEnds:
        """Return the same, by short steps from the first system, with a homotopy."""
        parameters = self._parameters(rows)
        first = np.zeros(len(parameters), np.int32)
        return self._reduced_ends(parameters, first, DEFAULT, jobs)

    def careful_ends(self, rows: Array, jobs: int = 1) -> StudyEnds:
        """Return the same, by paths of the equations in all unknowns."""
        return self._whole_ends(rows, CAREFUL, jobs)

    def _parameters(self, rows: Array) -> Array:
        values = _inner_values(self.given, rows, self.length, self.choices).reshape(-1, 6)
        return _squared(self.given, values)

    def _nearest(self, parameters: Array) -> Index:
        """Return which system near the sets of values is nearest to each parameters (b, 6)."""
        first = self.near.start
        members, sets = self.parameters[self.near].real / self.unit, parameters / self.unit
        if len(members) == 1:
            return np.full(len(parameters), first, np.int32)
        # Of the squared distances the squares of the sets are the same for all members.
        far = (members**2).sum(axis=1) - 2 * sets @ members.T
        return np.asarray(first + far.argmin(axis=1), np.int32)

    def _track(
        self, parameters: ComplexArray, start: Index, options: TrackerOptions, jobs: int
    ) -> ReducedEnds:
        assert self.homotopy is not None
        given = self.parameters, self.reduced, start, parameters
        return self.homotopy.track(*given, options=options, jobs=jobs)

    def _reduced_ends(
        self, parameters: Array, start: Index, options: TrackerOptions, jobs: int
    ) -> StudyEnds:
        """Return the ends of paths with fewer unknowns, each from one of the systems."""
        ends = self._track(parameters.astype(complex), start, options, jobs)
        return self._ends(ends.study, ends.status, self.length)

    def _whole_ends(self, rows: Array, options: TrackerOptions, jobs: int) -> StudyEnds:
        values = _inner_values(self.given, rows, self.length, self.choices)
        inner = self.inner
        structure, coefficients = coefficients_of(
            inner.kinds, inner.y, inner.x, inner.u, inner.v, values.reshape(-1, 6)
        )
        ordered = Coefficients(*(x[:, list(structure.order)] for x in coefficients))
        targets = ordered.in_units(self.scale).normalized()
        ends = track(self.system, targets, self.points, options=options, jobs=jobs)
        return self._ends(ends.points, ends.status, self.length * float(self.scale))

    def _ends(self, points: ComplexArray, status: NDArray[np.integer], unit: float) -> StudyEnds:
        """Return Study points by choices of sides, with their unit of f."""
        given = self.given
        # What is no end must not pass for one.
        points[status != PathStatus.REGULAR] = np.nan
        points = with_conjugates(points)
        frames = StudyFrames(length=unit, platform=given.platform_centre, base=given.base_centre)
        points = points.reshape(-1, len(self.choices), len(self.points), 8)
        return points, frames


def start_among(
    given: Arrangement,
    rows: Array,
    count: Callable[[], ExactCount | None],
    seed: int,
    jobs: int,
    starts: SolvedStarts,
) -> Start | None:
    """Return a start of a geometry among sets of values; None if that is not safe.

    Parameters
    ----------
    given
        The geometry; the same of its distances are zero as in the sets of values.
    rows
        Sets of values in the units of the instance, shape (b, 6).
    count
        Returns the exact count of the geometry, with values in general position, for the sides
        asked for; None if it is not known. Called only if the geometry seems to have fewer
        solutions than its type.
    seed, jobs, starts
        As for `gspcli.solve`.
    """
    length = 2.0 ** ceil(log2(given.length_with(rows)))
    values = _inner_values(given, rows, length, side_choices(given))
    parameters = _squared(given, values).reshape(-1, 6)
    mean = np.rint(parameters.mean(axis=0) / _GRID) * _GRID
    spread = np.exp2(np.rint(np.log2(np.maximum(parameters.std(axis=0), _LEAST_DEVIATION))))
    zero = (parameters == 0).all(axis=0)
    spread = np.where(zero, 0.0, spread)
    found = start_about(
        given, length, mean, spread, count=count, seed=seed, starts=starts, ways=StartMethod
    )
    return found and found.among(rows, jobs)


def start_about(
    given: Arrangement,
    length: float,
    mean: Array,
    spread: Array,
    *,
    count: Callable[[], ExactCount | None],
    seed: int,
    starts: SolvedStarts,
    ways: Iterable[StartMethod],
    solved: tuple[Array, ComplexArray] | None = None,
    far: FarPoses | None = None,
) -> Start | None:
    """Return a start of a geometry about some parameters; None if that is not safe.

    Parameters
    ----------
    given, length
        The geometry, and its unit of length, a power of two.
    mean, spread
        Of the start's parameters, what the equations are linear in, in that unit, shape (6,). The
        spread may be a matrix, whose products with vectors are differences from the mean, (6, 6).
    count, seed, starts
        As for `start_among`.
    ways
        To the start, which are tried in turn.
    solved
        A platform of the geometry for `StartMethod.SOLVED`, in that unit.
    far
        The poses far away that such a platform has besides.
    """
    inner = given.in_units_of(length)
    geometry = np.array([inner.y, inner.x, inner.u, inner.v]).tobytes()
    key = given.kinds, geometry, tuple(mean.tolist()), spread.tobytes(), seed
    for way in ways:
        made = partial(solved_start, given, length, mean, spread, seed, way=way, solved=solved)
        start = starts.kept(Sort.GEOMETRY, (*key, way, solved is None), made)
        if start is None:
            continue
        # That which is kept may be of other sides, or in another frame.
        start = replace(start, given=given, length=length, far=far)
        if start.found == path_count(start.system.structure) * len(start.choices):
            return replace(start, proof=Proof(CountKind.TYPE))
        counted = count()
        if counted is not None and counted.solutions == start.found:
            return replace(start, proof=Proof.by_geometry(counted, start.found))
    return None


def solved_start(
    given: Arrangement,
    length: float,
    mean: Array,
    spread: Array,
    seed: int,
    *,
    way: StartMethod,
    solved: tuple[Array, ComplexArray] | None = None,
) -> Start | None:
    """Return a start of a geometry with the finite solutions that paths lead to.

    Parameters
    ----------
    given, length
        The geometry, and its unit of length.
    mean, spread
        Of the parameters, shape (6,), or (6, 6) as for `start_about`; a spread of zero leaves the
        parameter alone.
    seed
        Source of random numbers.
    way
        How they are found.
    solved
        From where, if that is from a solved platform.
    """
    kinds, inner = given.kinds, given.in_units_of(length)
    rng = np.random.default_rng([seed, len(kinds)])
    turns = rng.choice([-1.0, 1.0], len(kinds)) * rng.uniform(*_SPREAD, len(kinds))
    if spread.ndim == 1:
        parameters = np.where(spread == 0, 0.0, mean + 1j * turns * spread)
    else:
        parameters = mean + 1j * (spread @ turns)
    geometry = inner.y, inner.x, inner.u, inner.v
    at = partial(complex_system, kinds, *geometry)
    system = at(parameters)
    quadrics = plain_quadrics(inner)
    homotopy = None if quadrics is None else ReducedHomotopy.of(quadrics)
    solutions: ComplexArray | None
    if way is StartMethod.SOLVED:
        solutions = None if solved is None else _ends_from_solved(homotopy, *solved, parameters, at)
    else:
        paths = next(track_all([system], seed=seed))
        solutions = _all_finite(paths) if way is StartMethod.CAREFUL else paths.distinct_simple()
    if solutions is None or not len(solutions):
        return None
    balanced, scale = system.coefficients.balanced()
    points = in_units(solutions, scale)
    return Start(
        given=given,
        length=length,
        system=System(system.structure, balanced),
        points=points,
        scale=scale,
        homotopy=homotopy,
        parameters=parameters[None],
        reduced=solutions[None, :, :0] if homotopy is None else homotopy.points(solutions[None]),
        unit=np.ones(EQUATIONS),
    )


def plain_quadrics(inner: Arrangement) -> Array | None:
    """Return the quadrics without their values, (6, 27); None if values are not multiples of N."""
    kinds = inner.kinds
    if DLL in kinds:
        return None
    zero = np.zeros((1, len(kinds)))
    structure, found = coefficients_of(kinds, inner.y, inner.x, inner.u, inner.v, zero)
    return None if structure.is_product.any() else found.g[0].real


def _ends_from_solved(
    homotopy: ReducedHomotopy | None,
    real: Array,
    points: ComplexArray,
    parameters: ComplexArray,
    at: Callable[[ComplexArray], System],
) -> ComplexArray | None:
    """Return where all poses of a solved platform lead, (n, 8); None if some are lost or meet.

    Parameters
    ----------
    homotopy
        The equations with fewer unknowns, if there are such.
    real, points
        The parameters of the platform, and its poses.
    parameters, at
        Those of the start, and what returns the system with some parameters.
    """
    begin = real.astype(complex)
    if homotopy is not None:
        given = begin[None], homotopy.points(points[None]), np.zeros(1, np.int32)
        ends = homotopy.track(*given, parameters[None], options=DEFAULT, jobs=1)
        study, status = ends.study[0], ends.status
    else:
        target, scale = at(parameters).coefficients.balanced()
        solved = at(begin)
        start = System(solved.structure, solved.coefficients.in_units(scale).normalized())
        system = System(start.structure, target)
        found = track(start, system, in_units(points, scale), options=CAREFUL)
        study, status = in_units(found.points[0], 1 / scale), found.status
    return study if _all_different(study[None], status)[0] else None


def _all_finite(tracked_paths: TrackedPaths) -> ComplexArray | None:
    """Return all finite solutions, None unless they are simple and every path is accounted for."""
    solutions = tracked_paths.solutions()
    simple = (solutions.multiplicity == 1).all() and not solutions.singular.any()
    return solutions.points if solutions.account.verdict == "complete" and simple else None


def with_conjugates(study: ComplexArray) -> ComplexArray:
    """Return ends of paths to real systems (b, n, 8), lost ones replaced by conjugates of others.

    An end whose conjugate is no end has the conjugate among the lost ones.
    """
    lost = np.asarray(~np.isfinite(study).all(axis=2))
    for k in np.flatnonzero(lost.any(axis=1) & ~lost.all(axis=1)).tolist():
        points = study[k, ~lost[k]]
        points = points / np.linalg.norm(points, axis=1, keepdims=True)
        has_conjugate = (np.abs(points @ points.T) > 1 - _SAME).any(axis=1)
        places = np.flatnonzero(lost[k])
        missing = points[~has_conjugate].conj()[: len(places)]
        study[k, places[: len(missing)]] = missing
    return study


def in_units(points: ComplexArray, scale: Array) -> ComplexArray:
    """Return Study points (n, 8) with f in a unit."""
    return np.concatenate((points[:, :4], points[:, 4:] / scale), axis=1)


def _all_different(study: ComplexArray, status: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Return to which targets (b,) all paths lead, to different solutions."""
    # Paths that fail may leave no numbers: these are different from none.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        points = study / np.linalg.norm(study, axis=-1, keepdims=True)
        overlaps = np.abs(points.conj() @ points.swapaxes(1, 2))
    overlaps[:, np.eye(points.shape[1], dtype=bool)] = 0
    regular = (status == PathStatus.REGULAR).all(axis=1)
    return np.asarray(regular & (overlaps < 1 - _SAME).all(axis=(1, 2)))


def solved_system(given: Arrangement, length: float, poses: PoseSet) -> tuple[Array, ComplexArray]:
    """Return a solved platform in a unit of length, of several choices of sides the first."""
    choices = side_choices(given)
    chosen = slice(None) if poses.signs is None else (poses.signs == choices[0]).all(axis=1)
    R = poses.R[chosen]
    T = (poses.T[chosen] - given.base_centre + apply(R, given.platform_centre)) / length
    return parameters_in(given, length), np.concatenate(study_from_pose(R, T), axis=-1)


def parameters_in(given: Arrangement, length: float) -> Array:
    """Return what the equations are linear in, in a unit of length, for the first sides."""
    values = _inner_values(given, given.values[None], length, side_choices(given))
    found: Array = _squared(given, values)[0, 0]
    return found


def _inner_values(given: Arrangement, rows: Array, length: float, choices: Array) -> Array:
    """Return values as `coefficients_of` takes them, for each choice of sides: (b, k, 6)."""
    values = rows.copy()
    values[:, given.distances] /= length
    values[:, given.angles] = given.cosines(rows)
    return values[:, None, :] * choices


def _squared(given: Arrangement, values: Array) -> Array:
    """Return what the equations are linear in: distances without sides squared, (..., 6)."""
    square = [kind.is_squared for kind in given.kinds]
    return np.where(square, values**2, values)
