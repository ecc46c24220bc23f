"""Many platforms that differ in their values only: followed from one of the same geometry.

A system of the geometry with complex values in general position is solved once, with every care.
From its solutions lead short paths to those of all real values, on which nothing moves but the
values. Where the geometry is special there are fewer of them than the type has solutions: the
others are at infinity whatever the values. That none is missing rests then on the exact count of
the geometry, without which nothing is done here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby
from math import ceil, log2
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, Kind
from gspcli.certification.frames import Frames
from gspcli.certification.many_values import ProvedPoses, ValueProofs
from gspcli.continuation.parameter_homotopy import SHORT
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.shifts import Shifts
from gspcli.continuation.solve import solve_system
from gspcli.continuation.start import path_count
from gspcli.continuation.systems import Coefficients, System
from gspcli.continuation.tracker import CAREFUL, PathStatus, TrackerOptions, track
from gspcli.geometry.arrangement import Arrangement
from gspcli.solver.proof import Ground, Proof
from gspcli.solver.study_systems import coefficients_of, side_choices

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount

Array = NDArray[np.float64]

#: Fewer sets of values are solved one by one: solving the geometry costs as much as a few of them.
_LEAST = 4
#: So many paths are followed together, for the memory of their ends.
_BATCH_PATHS = 16_384
#: The parameters of the start are about the mean of those asked for plus i times their standard
#: deviation, but for that no less than this (in typical lengths, their squares, or cosines), ...
_LEAST_DEVIATION = 0.125
#: ... times random numbers between these, so that nothing about it is special. Anything from a
#: third to three standard deviations makes paths about as short.
_SPREAD = (0.7, 1.3)
#: The mean is rounded to multiples of this, and deviations to powers of two, so that the next
#: batch is likely to find its start solved.
_GRID = 0.125
#: So many starts are kept for the process, those used last.
_KEPT = 64


class Solved(NamedTuple):
    """The poses for sets of values, of which those that are complete have all there are.

    Attributes
    ----------
    poses
        What was found and proved.
    account, proof
        Of each set that is complete.
    """

    poses: ProvedPoses
    account: PathAccount
    proof: Proof | None


@dataclass(frozen=True, eq=False)
class _Start:
    """A solved system of a geometry with complex values.

    Attributes
    ----------
    system
        In canonical order, balanced.
    points
        All its solutions, shape (n, 8).
    scale
        The unit of f in it.
    parameters
        What its equations are linear in, shape (1, 6).
    shifts
        The same equations with fewer unknowns, where nothing but multiples of N moves.
    shifted
        The solutions in its coordinates, shape (1, n, d).
    """

    system: System
    points: ComplexArray
    scale: Array
    parameters: ComplexArray
    shifts: Shifts | None
    shifted: ComplexArray


def solve_rows(
    arrangement: Arrangement,
    rows: Array,
    *,
    count: Callable[[], ExactCount | None],
    proofs: ValueProofs | None,
    seed: int,
    jobs: int = 1,
) -> Iterator[tuple[int, Solved | None]]:
    """Yield all poses of one geometry with each of many sets of values, in order.

    Parameters
    ----------
    arrangement
        The geometry and the sides; its own values are not used.
    rows
        Sets of values in the units of the instance, shape (b, 6).
    count
        Returns the exact count of the geometry, with values in general position, for the sides
        asked for; None if it is not known. Called only if the geometry seems to have fewer
        solutions than its type.
    proofs
        The equations of the geometry with its values left open; None if the poses cannot be
        certified, and nothing be solved here.
    seed
        Source of the random paths. Another seed gives the same sets of poses.
    jobs
        Threads. The result does not depend on them.

    Yields
    ------
    How many sets of values come next, and their poses; None if each needs a solution of its
    own, because the geometry is not worth it (too few sets) or not known well enough.
    """
    # A distance of zero has one sign, and may have another equation.
    zero = [(row == 0).tobytes() for row in rows] if (rows == 0).any() else [b""] * len(rows)
    geometries = {
        pattern: _geometry(arrangement, rows[[z == pattern for z in zero]], count, seed)
        for pattern in dict.fromkeys(zero)
        if proofs is not None
    }
    begin = 0
    for pattern, group in groupby(zero):
        end = begin + len(list(group))
        geometry = geometries.get(pattern)
        size = geometry.batch if geometry else end - begin
        for first in range(begin, end, size):
            batch = rows[first : min(first + size, end)]
            found = geometry.solve(batch, proofs, jobs) if geometry and proofs else None
            yield len(batch), found
        begin = end


def _geometry(
    arrangement: Arrangement,
    rows: Array,
    count: Callable[[], ExactCount | None],
    seed: int,
) -> _Geometry | None:
    """Return the geometry with its start, or None if that does not pay or is not safe."""
    if len(rows) < _LEAST:
        return None
    given = arrangement.with_values(rows[0])
    length = 2.0 ** ceil(log2(given.length_with(rows)))
    inner, choices = given.in_units_of(length), side_choices(given)
    parameters = _squared(given, _inner_values(given, rows, length, choices)).reshape(-1, 6)
    mean = np.rint(parameters.mean(axis=0) / _GRID) * _GRID
    spread = np.exp2(np.rint(np.log2(np.maximum(parameters.std(axis=0), _LEAST_DEVIATION))))
    zero = (parameters == 0).all(axis=0)
    start = _solved(
        given.kinds,
        np.array([inner.y, inner.x, inner.u, inner.v]).tobytes(),
        tuple(mean.tolist()),
        tuple(np.where(zero, 0.0, spread).tolist()),
        seed,
    )
    if start is None:
        return None
    expected = path_count(start.system.structure) * len(choices)
    found = len(start.points) * len(choices)
    proof: Proof | None = Proof(Ground.TYPE)
    if found < expected:
        counted = count()
        if counted is None or counted.solutions != found:
            return None
        # Two pairs of lines that are parallel at once spoil the argument (docs/counts.md).
        proof = Proof(Ground.GEOMETRY, counted.error) if counted.has_lone_lines else None
    return _Geometry(given, inner, length, choices, start, expected, proof)


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


@lru_cache(maxsize=_KEPT)
def _solved(
    kinds: tuple[Kind, ...],
    geometry: bytes,
    mean: tuple[float, ...],
    spread: tuple[float, ...],
    seed: int,
) -> _Start | None:
    """Return the start of a geometry, None unless all its finite solutions are simple.

    Parameters
    ----------
    kinds, geometry
        The kinds of the constraints, and y, x, u, v of their primitives, (4, 6, 3).
    mean, spread
        Of the parameters; a spread of zero leaves the parameter alone.
    seed
        Source of random numbers.
    """
    rng = np.random.default_rng([seed, len(kinds)])
    turns = rng.choice([-1.0, 1.0], len(kinds)) * rng.uniform(*_SPREAD, len(kinds))
    parameters = np.where(np.array(spread) == 0, 0.0, np.array(mean) + 1j * turns * spread)
    square = [kind.is_distance and not kind.has_sides for kind in kinds]
    values = np.where(square, np.sqrt(parameters), parameters)
    y, x, u, v = np.frombuffer(geometry).reshape(4, len(kinds), 3)
    structure, coefficients = coefficients_of(kinds, y, x, u, v, values[None])
    system = System(structure, coefficients.take(0)).canonical()
    solutions = solve_system(system, seed=seed)
    simple = (solutions.multiplicity == 1).all() and not solutions.singular.any()
    if solutions.account.verdict != "complete" or not simple or not len(solutions.points):
        return None
    balanced, scale = system.coefficients.balanced()
    points = solutions.points.copy()
    points[:, 4:] /= scale
    shifts = None
    if not structure.is_product.any() and DLL not in kinds:
        _, plain = coefficients_of(kinds, y, x, u, v, np.zeros((1, len(kinds))))
        shifts = Shifts.of(plain.g[0].real)
    shifted = shifts.points(solutions.points[None]) if shifts else solutions.points[None]
    start = System(system.structure, balanced)
    return _Start(start, points, scale, parameters[None], shifts, shifted)


@dataclass(frozen=True, eq=False)
class _Geometry:
    """A geometry with the solutions of its start.

    Attributes
    ----------
    given, inner, length
        As given, and in the typical length, a power of two.
    choices
        The sign of each value for each choice of sides, shape (k, 6).
    start
        The start for each of them.
    expected
        The generic count of the type.
    proof
        What as many certified poses as the start has prove.
    """

    given: Arrangement
    inner: Arrangement
    length: float
    choices: Array
    start: _Start
    expected: int
    proof: Proof | None

    @property
    def found(self) -> int:
        """How many poses there are for values in general position."""
        return len(self.start.points) * len(self.choices)

    @property
    def batch(self) -> int:
        """How many sets of values are solved together."""
        return max(1, _BATCH_PATHS // self.found)

    def solve(self, rows: Array, proofs: ValueProofs, jobs: int) -> Solved:
        """Return the poses for sets of values (b, 6)."""

        def proved(rows: Array, points: ComplexArray, unit: float) -> ProvedPoses:
            points = points.reshape(len(rows), len(self.choices), -1, 8)
            frames = Frames(
                length=unit, platform=self.given.platform_centre, base=self.given.base_centre
            )
            return proofs.decide(rows, self.choices, points, frames, jobs=jobs)

        poses = proved(rows, *self._quick_ends(rows, jobs))
        again = np.flatnonzero(~poses.complete)
        if len(again):
            careful = proved(rows[again], *self._careful_ends(rows[again], CAREFUL, jobs))
            for part, better in zip(poses, careful, strict=True):
                part[again] = better
        account = PathAccount(
            expected=self.expected,
            found=self.found,
            at_infinity=self.expected - self.found,
            basis=Basis.PATHS if self.found == self.expected else Basis.COUNT,
        )
        return Solved(poses, account, self.proof)

    def _quick_ends(self, rows: Array, jobs: int) -> tuple[ComplexArray, float]:
        """Return Study points of the ends of paths to sets of values, and their unit of f."""
        start = self.start
        if start.shifts is None:
            return self._careful_ends(rows, SHORT, jobs)
        values = _inner_values(self.given, rows, self.length, self.choices).reshape(-1, 6)
        ends = start.shifts.track(
            start.parameters,
            start.shifted,
            np.zeros(len(values), np.int32),
            _squared(self.given, values).astype(np.complex128),
            jobs=jobs,
        )
        # What is no end must not pass for one.
        ends.study[ends.status != PathStatus.REGULAR] = np.nan
        return ends.study, self.length

    def _careful_ends(
        self, rows: Array, options: TrackerOptions, jobs: int
    ) -> tuple[ComplexArray, float]:
        """Return the same, by paths of the system as it is."""
        values = _inner_values(self.given, rows, self.length, self.choices)
        inner, start = self.inner, self.start
        structure, coefficients = coefficients_of(
            inner.kinds, inner.y, inner.x, inner.u, inner.v, values.reshape(-1, 6)
        )
        ordered = Coefficients(*(x[:, list(structure.order)] for x in coefficients))
        targets = ordered.in_units(start.scale).normalized()
        ends = track(start.system, targets, start.points, options=options, jobs=jobs)
        ends.points[ends.status != PathStatus.REGULAR] = np.nan
        return ends.points, self.length * float(start.scale)
