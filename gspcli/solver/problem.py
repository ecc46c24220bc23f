"""A platform with everything that its solution needs, each part computed once at its first use."""

from __future__ import annotations

from copy import copy
from fractions import Fraction
from functools import cached_property
from math import ceil, log2
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ANGLE_KINDS, DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.catalogue.types import MAX_ANGLES
from gspcli.certification.equations.local_frames import LocalFrames, StudyFrames
from gspcli.certification.equations.mirror_images import has_mirror_images
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.continuation.systems import Coefficients, FineCoefficients, Structure, System
from gspcli.defaults import PATIENCE, SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.solver.solved_starts import STARTS, SolvedPlatform, SolvedStarts
from gspcli.solver.study_systems import coefficients_at, coefficients_of, side_choices, systems_of

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.certification.poses.locator import Locator, StudyPoints
    from gspcli.continuation.tracked_paths import TrackedPaths
    from gspcli.solver.poses import PoseSet
    from gspcli.solver.start import Start

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: Kinds with an equation of one quadric in e, e ^ f and f.f alone, and of a product of two.
_REDUCIBLE = frozenset({DPP, DPH, DHP, *ANGLE_KINDS})
_PRODUCTS = frozenset({DPL, DLP})


class Problem:
    """A platform.

    Parameters
    ----------
    instance, arrangement
        The platform, exactly and in floating point.
    rows
        Sets of values in place of those of the instance, doubles that are meant exactly, shape
        (b, 6); the same distances are zero in all of them, and in the arrangement. None for the
        values of the instance, exactly as written.
    seed, jobs, prove, starts
        As for `gspcli.solve`.
    """

    def __init__(
        self,
        instance: Instance,
        arrangement: Arrangement | None = None,
        *,
        rows: Array | None = None,
        seed: int = SEED,
        jobs: int = 1,
        prove: bool | None = None,
        starts: SolvedStarts = STARTS,
    ) -> None:
        self.instance = instance
        self.arrangement = Arrangement.of(instance) if arrangement is None else arrangement
        self.rows = rows
        self.seed, self.jobs, self.starts = seed, jobs, starts
        #: Work that a count may take, None for no limit; if it is zero, nothing is counted.
        self.limit = {True: None, False: 0.0, None: PATIENCE}[prove]
        #: The count of the geometry, once it is computed.
        self.known_geometry_count: ExactCount | None = None
        self._has_counted = False
        #: From where paths lead to the sets of values, if they have a start together.
        self.start: Start | None = None

    def like(
        self, instance: Instance, arrangement: Arrangement | None = None, rows: Array | None = None
    ) -> Problem:
        """Return another platform, to be solved likewise."""
        seed, jobs, starts = self.seed, self.jobs, self.starts
        other = Problem(instance, arrangement, rows=rows, seed=seed, jobs=jobs, starts=starts)
        other.limit = self.limit
        return other

    def with_values(self, values: NDArray[np.float64]) -> Problem:
        """Return the same geometry with other values (6,), doubles that are meant exactly."""
        # Of a float itself a number would be the shortest decimal.
        numbers = {i: Number.of(Fraction(x)) for i, x in enumerate(values.tolist())}
        return self.like(self.instance.with_values(numbers), self.arrangement.with_values(values))

    def with_rows(self, rows: Array) -> Problem:
        """Return the same geometry with sets of values (b, 6), to be solved together."""
        return self.like(self.instance, self.arrangement.with_values(rows[0]), rows)

    def part(self, chosen: Index) -> Problem:
        """Return the same with some of its sets of values."""
        other = copy(self)
        other.rows = self.values[chosen]
        return other

    @property
    def values(self) -> Array:
        """The sets of values, in doubles, shape (b, 6)."""
        return self.arrangement.values[None] if self.rows is None else self.rows

    @cached_property
    def local_frames(self) -> LocalFrames:
        """Frames near the bodies, if those of the instance are far away from them."""
        return LocalFrames.of(self.instance)

    @cached_property
    def choices(self) -> NDArray[np.float64]:
        """The sign of each value for each combination of sides asked for, shape (k, 6)."""
        return side_choices(self.arrangement)

    @cached_property
    def sides(self) -> list[tuple[int, ...]]:
        """For each choice which equation of each constraint it means (`BallSystem.equations`)."""
        kinds, given = self.arrangement.kinds, self.arrangement.sides.tolist()
        both = [kind.has_sides and side == 0 for kind, side in zip(kinds, given, strict=True)]
        return [
            tuple(int(free and sign < 0) for free, sign in zip(both, choice, strict=True))
            for choice in self.choices.tolist()
        ]

    @cached_property
    def expected(self) -> int:
        """How many poses the type has, for the sides asked for."""
        if self.has_closed_form and self.arrangement.values.all():
            return self.instance.expected
        from gspcli.continuation.start import path_count

        return path_count(self.equations[0]) * len(self.choices)

    @property
    def has_closed_form(self) -> bool:
        """Whether three angles give the rotations."""
        return len(self.arrangement.angles) == MAX_ANGLES

    @cached_property
    def is_reducible(self) -> bool:
        """Whether the equations can be solved for some unknowns first (`ReducedHomotopy`)."""
        return _REDUCIBLE.issuperset(self.arrangement.kinds)

    @cached_property
    def is_reducible_in_planes(self) -> bool:
        """Whether that holds with points in planes in place of points at a distance from lines."""
        kinds = self.arrangement.kinds
        return not _PRODUCTS.isdisjoint(kinds) and _REDUCIBLE.union(_PRODUCTS).issuperset(kinds)

    @cached_property
    def is_kept(self) -> bool:
        """Whether the count and a start of its geometry are kept for other values."""
        return DLL not in self.arrangement.kinds and self._has_distances

    @property
    def _has_distances(self) -> bool:
        """Whether no distance is zero."""
        return bool(self.arrangement.values[self.arrangement.distances].all())

    @property
    def has_kept_geometry(self) -> bool:
        """Whether a solved platform of its geometry is kept, and may be used."""
        return (
            self.is_kept and self.limit != 0 and self.starts.platform(self.arrangement) is not None
        )

    @cached_property
    def unit(self) -> float:
        """A power of two about the typical length."""
        return 2.0 ** ceil(log2(self.arrangement.length_with(self.arrangement.values[None])))

    @cached_property
    def frames(self) -> StudyFrames:
        """The coordinates of the equations of paths."""
        return StudyFrames.of(self.arrangement)

    @cached_property
    def equations(self) -> tuple[Structure, Coefficients]:
        """The equations of paths, for each choice of sides."""
        return coefficients_at(self.arrangement.normalized)

    @property
    def systems(self) -> list[System]:
        """The equations of paths as systems, one for each choice of sides."""
        return list(systems_of(*self.equations))

    @cached_property
    def tracked(self) -> list[TrackedPaths]:
        """The paths to all poses, followed in doubles with care, for each choice of sides."""
        from gspcli.continuation.tracked_paths import track_all

        return list(track_all(self.systems, seed=self.seed, jobs=self.jobs))

    @cached_property
    def has_mirror_images(self) -> bool:
        """Whether each pose has a mirror image (`gspcli.certification.equations.mirror_images`)."""
        return has_mirror_images(self.instance)

    def keep(self, poses: PoseSet, points: StudyPoints) -> None:
        """Keep poses for platforms of the same geometry, if they are all it has.

        The points are those of `SolvedPlatform`.
        """
        # Without a start, poses far away help with other values.
        if not (self.is_kept or (points and self._has_distances)):
            return
        number, count = int(poses.certified.sum()), self.known_geometry_count
        known = (self.expected, count.solutions if count else None)
        if number == len(poses.R) and number in known:
            solved = SolvedPlatform(self.instance, self.arrangement, poses, count, points)
            self.starts.keep_platform(solved)

    @cached_property
    def proofs(self) -> ValueProofs | None:
        """The equations of proofs for the kernel; None if the frames are too far away for it."""
        return ValueProofs(self.instance, self.rows) if self.local_frames.is_none else None

    @cached_property
    def locator(self) -> Locator:
        """The equations in balls."""
        from gspcli.certification.poses.locator import Locator

        return Locator(self.instance, self.frames)

    def target(self, k: int) -> FineCoefficients:
        """Return the equations of paths for a choice of sides, from the exact numbers."""
        from gspcli.certification.equations.statement import many_digits, normalized

        given = self.arrangement
        asked = np.where(given.sides == 0, 1 - 2 * np.array(self.sides[k]), given.signs)
        with many_digits():
            numbers = normalized(self.instance, self.frames)
            values = numbers.values * np.where(asked < 0, -1, 1)
            structure, found = coefficients_of(given.kinds, *numbers[:4], values[None])
            order = list(structure.order)
            exact = Coefficients(*(x[0, order] for x in found))
            return FineCoefficients.of(self.tracked[k].balanced(exact))

    @property
    def geometry_count(self) -> ExactCount | None:
        """The count of a geometry that is kept; None if it is not known, or would take too long."""
        if not self._has_counted:
            self.known_geometry_count, self._has_counted = self._geometry_count(), True
        return self.known_geometry_count

    def _geometry_count(self) -> ExactCount | None:
        if not self.is_kept or self.limit == 0:
            return None
        known = self.starts.platform(self.arrangement)
        if known is not None and known.geometry_count and known.has_geometry_of(self.instance):
            return known.geometry_count
        return self.count_geometry()

    def count_geometry(self) -> ExactCount | None:
        """Return the count of the geometry with values in general position."""
        given = self.instance, self.arrangement.values, self.seed, self.limit
        self.known_geometry_count = self.starts.count(*given)
        return self.known_geometry_count
