"""Platforms that differ in their values only: followed from one of the same geometry.

A system of the geometry with complex values in general position is solved once (`geometry_start`).
From its solutions lead short paths to those of all real values, on which nothing moves but the
values. That none is missing rests on the exact count of the geometry where it is special, without
which nothing is done here then.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from math import ceil, log2
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.equations.frames import StudyFrames
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.start import path_count
from gspcli.continuation.systems import Coefficients
from gspcli.continuation.tracker import PathStatus, track
from gspcli.continuation.tracker_options import (
    CAREFUL,
    SHORT,
    SHORT_STEPS,
    VALUE_STEPS,
    TrackerOptions,
)
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import apply, study_from_pose
from gspcli.records import dataclass
from gspcli.solver.ends import Ends
from gspcli.solver.results.pose_set import PoseSet
from gspcli.solver.results.proof import CountKind, Proof
from gspcli.solver.starts.solved_starts import SolvedStarts, Sort
from gspcli.solver.starts.start import Start, StartMethod, geometry_start
from gspcli.solver.study_systems import coefficients_of, side_choices

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.certification.poses.far_poses import FarPoses

Array = NDArray[np.float64]

#: So many paths are followed together, for the memory of their ends.
_BATCH_PATHS = 16_384
#: The spread of the parameters of a start is their standard deviation, but no less than this (in
#: typical lengths, their squares, or cosines).
_LEAST_DEVIATION = 0.125
#: The mean is rounded to multiples of this, and deviations to powers of two, so that the next
#: batch is likely to find its start solved.
_GRID = 0.125


def geometry_among(
    given: Arrangement,
    rows: Array,
    count: Callable[[], ExactCount | None],
    seed: int,
    jobs: int,
    starts: SolvedStarts,
) -> SolvedGeometry | None:
    """Return a geometry with a start among sets of values; None if that is not safe.

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
    found = geometry_about(
        given, length, mean, spread, count=count, seed=seed, starts=starts, ways=StartMethod
    )
    return found and found.among(rows, jobs)


def geometry_about(
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
) -> SolvedGeometry | None:
    """Return a geometry with a start about some parameters; None if that is not safe.

    Parameters
    ----------
    given, length
        The geometry, and its unit of length, a power of two.
    mean, spread
        Of the start's parameters, what the equations are linear in, in that unit, shape (6,).
    count, seed, starts
        As for `geometry_among`.
    ways
        To the start, which are tried in turn.
    solved
        A platform of the geometry for `StartMethod.SOLVED`, in that unit.
    far
        The poses far away that such a platform has besides.
    """
    inner, choices = given.in_units_of(length), side_choices(given)
    geometry = np.array([inner.y, inner.x, inner.u, inner.v]).tobytes()
    about = (given.kinds, geometry, tuple(mean.tolist()), tuple(spread.tolist()), seed)
    for way in ways:
        made = partial(geometry_start, *about, way=way, solved=solved)
        start = starts.kept(Sort.GEOMETRY, (*about, way, solved is None), made)
        if start is None:
            continue
        expected = path_count(start.system.structure) * len(choices)
        found = len(start.points) * len(choices) + (0 if far is None else len(far))
        proof: Proof | None = Proof(CountKind.TYPE)
        if found < expected:
            counted = count()
            if counted is None or counted.solutions != found:
                continue
            # Two pairs of lines parallel at once spoil the argument (docs/count-proofs.md).
            proof = (
                Proof.modulo(CountKind.GEOMETRY, counted.error) if counted.has_lone_lines else None
            )
        return SolvedGeometry(given, inner, length, choices, start, start, far, expected, proof)
    return None


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
    square = [kind.is_distance and not kind.has_sides for kind in given.kinds]
    return np.where(square, values**2, values)


@dataclass(frozen=True, eq=False)
class SolvedGeometry:
    """A geometry with the solutions of its start.

    Attributes
    ----------
    given, inner, length
        As given, and in the typical length, a power of two.
    choices
        The sign of each value for each choice of sides, shape (k, 6).
    start
        The start for each of them.
    near
        The same with members among the sets of values, where there are many.
    far
        The poses to which no paths lead, for the only choice of sides; None if there are none.
    expected
        The generic count of the type.
    proof
        What as many certified poses as the start has prove.
    """

    given: Arrangement
    inner: Arrangement
    length: float
    choices: Array
    start: Start
    near: Start
    far: FarPoses | None
    expected: int
    proof: Proof | None

    @property
    def found(self) -> int:
        """How many poses there are for values in general position."""
        near = len(self.start.points) * len(self.choices)
        return near if self.far is None else near + len(self.far)

    @property
    def batch(self) -> int:
        """How many sets of values are solved together."""
        return max(1, _BATCH_PATHS // self.found)

    def among(self, rows: Array, jobs: int) -> SolvedGeometry:
        """Return the geometry with starts among sets of values (b, 6)."""
        if self.start.homotopy is None:
            return self
        return replace(self, near=self.start.about(self._parameters(rows), jobs))

    def quick_ends(self, rows: Array, jobs: int = 1) -> Ends:
        """Return the ends of paths to sets of values (b, 6), from the nearest start."""
        if self.near.homotopy is None:
            return self._whole_ends(rows, SHORT, jobs)
        return self._ends(self.near.follow(self._parameters(rows), VALUE_STEPS, jobs), self.length)

    def short_ends(self, rows: Array, jobs: int = 1) -> Ends | None:
        """Return the same, by short steps from the geometry's own start; None without a pool."""
        if self.start.homotopy is None:
            return None
        ends = self.start.follow(self._parameters(rows), SHORT_STEPS, jobs)
        return self._ends(ends, self.length)

    def careful_ends(self, rows: Array, jobs: int = 1) -> Ends:
        """Return the same, by paths of the equations in all unknowns."""
        return self._whole_ends(rows, CAREFUL, jobs)

    def _ends(self, points: ComplexArray, unit: float) -> Ends:
        """Return ends by choices of sides, and the poses far away.

        Parameters
        ----------
        points, unit
            Study points for each set of values and choice of sides, and their unit of f.
        """
        choices, given = len(self.choices), self.given
        frames = StudyFrames(length=unit, platform=given.platform_centre, base=given.base_centre)
        points = points.reshape(-1, choices, len(self.start.points), 8)
        return Ends(points, frames, self.far, all_poses=True)

    def _parameters(self, rows: Array) -> Array:
        values = _inner_values(self.given, rows, self.length, self.choices).reshape(-1, 6)
        return _squared(self.given, values)

    def _whole_ends(self, rows: Array, options: TrackerOptions, jobs: int) -> Ends:
        values = _inner_values(self.given, rows, self.length, self.choices)
        inner, start = self.inner, self.start
        structure, coefficients = coefficients_of(
            inner.kinds, inner.y, inner.x, inner.u, inner.v, values.reshape(-1, 6)
        )
        ordered = Coefficients(*(x[:, list(structure.order)] for x in coefficients))
        targets = ordered.in_units(start.scale).normalized()
        ends = track(start.system, targets, start.points, options=options, jobs=jobs)
        ends.points[ends.status != PathStatus.REGULAR] = np.nan
        return self._ends(ends.points, self.length * float(start.scale))
