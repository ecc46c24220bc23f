"""The poses for one choice of sides: the proved ones, and the paths without a pose."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.poses.collection import Collection
from gspcli.certification.poses.far_points import conjugate_sources
from gspcli.certification.poses.isolation import Isolation, same
from gspcli.certification.poses.locator import DOUBLE, AtInfinity, Located
from gspcli.certification.poses.many_values import ProvedPoses
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.systems import FineCoefficients
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.continuation.tracker import PathResults
from gspcli.geometry.quaternions import Field, canonical_sign, pose_from_study
from gspcli.solver.poses import PoseSet
from gspcli.solver.problem import Problem

Bits = NDArray[np.bool_]
Index = NDArray[np.intp]

#: If at most one path in this many is missing, paths have jumped rather than that the platform is
#: special: other paths find what is missing. Else no count says whether more would be found.
FEW = 50
#: Poses that agree to this part of their largest entry are not located again.
_KNOWN = 1e-13
#: Bits of points that are known to many digits, half of those of `far_points`.
_FAR_BITS = 160


class SidePoses:
    """The poses of a platform for one choice of sides.

    Parameters
    ----------
    problem, k
        The platform, and which of its choices of sides.

    Attributes
    ----------
    locator
        The equations in balls.
    sides
        For each constraint the index of its equation (`BallSystem.equations`).
    found
        The proved ones, simple and all different.
    infinite
        The simple solutions at infinity that were met, all different.
    reached
        Which of the ends of the first strategy that came last have led to poses of their own; of
        no ends at all if the kernel could prove nothing.
    unresolved
        The paths that have led to no pose with 32 digits.
    eliminated
        How many eliminations have been done.
    wanted
        How many simple poses there can be.
    all_simple
        Whether all poses are known to be simple ones.
    tried
        How many of the further strategies have ended (`gspcli.solver.further`).
    """

    def __init__(self, problem: Problem, k: int) -> None:
        self.problem, self.k = problem, k
        self.sides = problem.sides[k]
        self.locator = problem.locator
        self.found = Collection(self.locator, self.sides)
        self.infinite: list[Isolation] = []
        self.reached: Bits = np.zeros(0, np.bool_)
        self.unresolved: Index = np.arange(0)
        self.eliminated = 0
        self.wanted = problem.expected // len(problem.choices)
        self.all_simple = False
        self.tried = 0

    @property
    def paths(self) -> TrackedPaths:
        """The paths."""
        return self.problem.tracked[self.k]

    @property
    def is_complete(self) -> bool:
        """Whether as many poses are proved as there can be."""
        return len(self.found) >= min(self.wanted, self.paths.count - len(self.infinite))

    @cached_property
    def target(self) -> FineCoefficients:
        """The equations of paths from the exact numbers, in 32 digits."""
        return self.problem.target(self.k)

    def add_first(self, found: ProvedPoses) -> None:
        """Add what the kernel has proved of the ends of a first strategy, one for each path."""
        place = self.add_proved(found)
        self.reached = np.zeros(len(place), np.bool_)
        self.reached[np.unique(place, return_index=True)[1]] = True
        self.reached &= place >= 0

    def add_proved(self, found: ProvedPoses) -> Index:
        """Add what the kernel has proved of ends, and conjugates; return their places here, or -1.

        It is of one set of values and these sides: shapes (1, n, ...).
        """
        R, T, e, certified, real, rounded, off = (part[0] for part in found[:-1])
        place = np.full(len(R), -1)

        def add(chosen: Bits) -> None:
            pairs = chosen & ~real
            # Zero has one sign.
            parts = [np.concatenate((x[chosen], x[pairs].conj() + 0.0)) for x in (R, T, e)]
            parts += [np.concatenate((x[chosen], x[pairs])) for x in (real, off)]
            place[chosen] = self.found.add_proved(*parts)[: chosen.sum()]

        add(certified & rounded)
        # Mostly pairs of conjugates, which are one after the other.
        for k in np.flatnonzero(certified & ~rounded).tolist():
            place[k] = self.found.place_near(R[k], T[k], off[k])
            if place[k] >= 0:
                continue
            located = self.locator.near_proved(R[k], T[k], off[k], self.sides)
            if self.found.add([located]):
                self.found.add_conjugates()
                place[k] = self.found.place_near(R[k], T[k], off[k])
        return place

    def add(self, ends: PathResults) -> Bits:
        """Add the poses near ends, by the kernel or in balls; return which have led to new ones."""
        before = len(self.found)
        problem, new = self.problem, np.zeros(ends.points.shape[1], np.bool_)
        if not len(new):
            return new
        if problem.proofs is not None:
            choice = problem.choices[self.k : self.k + 1]
            found = problem.proofs.decide(choice, ends.points[None], problem.frames)
            place = self.add_proved(found)
            first = np.unique(place, return_index=True)[1]
            new[first[place[first] >= before]] = True
        # What doubles do not tell from a known pose may be one beside it.
        rest = np.flatnonzero(~new)
        new[rest] = self.locate(ends.take(rest))
        return new

    def locate(self, ends: PathResults) -> Bits:
        """Add the poses near ends in balls, and conjugates; return which have led to new ones."""
        points, low = ends.points[0], ends.more
        if not len(points):
            return np.zeros(0, np.bool_)
        new = ~self._are_known(points, low)
        index = np.flatnonzero(new)
        # One of each pair of conjugates is enough.
        source = index[conjugate_sources(points[index], low[index])]
        sought = index[source == index]
        bits = DOUBLE * (1 + low.shape[1])
        located = self.locator.locate(points[sought], low[sought], self.sides, bits)
        new[sought] = [bool(self.found.add([end])) for end in located]
        new[index] = new[source]
        self.found.add_conjugates()
        for end in located:
            if isinstance(end, AtInfinity) and not any(
                same(end.isolation, other) for other in self.infinite
            ):
                self.infinite.append(end.isolation)
        return new

    def add_far(self, ends: Field, planes: Index | None = None) -> None:
        """Add poses far away, their conjugates and mirror images.

        Parameters
        ----------
        ends
            Study points of any norm with quaternions that are right in double precision, up to a
            factor, one for each path, shape (n, 8).
        planes
            As in `gspcli.solver.poses.Ends`.
        """
        from gspcli.certification.poses.far_points import far_points

        has_images = self.problem.has_mirror_images
        with np.errstate(invalid="ignore"):
            e = ends[:, :4] / np.linalg.norm(ends[:, :4], axis=1, keepdims=True)
        # Poses to which no paths lead come last.
        is_open = ~self.reached[: len(ends)] & np.isfinite(e).all(axis=1)
        of_open = None if planes is None else planes[is_open]
        points = far_points(self.locator, self.sides, e[is_open], of_open)
        if not points:
            return
        for point in points:
            located = self.locator.locate_exactly(point, self.sides, _FAR_BITS)
            if isinstance(located, Located):
                self.found.add([located, located.mirrored] if has_images else [located])
                self.found.add_conjugates()
        self.found.add_close_conjugates()

    def _are_known(self, points: Field, low: Field) -> Bits:
        """Return which points agree with a proved pose in all their digits, shape (k,)."""
        near = self._near_known(points)
        known = np.asarray(near.any(axis=1))
        if low.shape[1]:
            # Another pose may be nearer than doubles tell.
            for i in np.flatnonzero(known).tolist():
                alike = np.flatnonzero(near[i]).tolist()
                known[i] = any(self.found.surrounds(k, points[i], low[i]) for k in alike)
        return known

    def _near_known(self, points: Field) -> Bits:
        """Return which points agree with which proved poses in double precision, shape (k, n)."""
        given = self.problem.arrangement
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            R, T = pose_from_study(points[:, :4], points[:, 4:])
            T = given.restored(R, T)
            here, known = (
                np.concatenate((x.reshape(-1, 9), y / given.length), axis=1)
                for x, y in ((R, T), (self.found.R, self.found.T))
            )
            size = np.abs(here).max(axis=1, initial=1.0)
            near = [
                np.abs(known - pose).max(axis=1) < _KNOWN * unit
                for pose, unit in zip(here, size.tolist(), strict=True)
            ]
        return np.array(near, np.bool_).reshape(len(here), len(known))

    def poses(self, most: int | None = None) -> PoseSet:
        """Return the proved poses, and an account of all paths.

        Parameters
        ----------
        most
            No other solution is possible beside this many, if that is known.
        """
        found, paths = self.found, self.problem.expected // len(self.problem.choices)
        number = len(found)
        at_infinity = paths - number if number == most else len(self.infinite)
        return PoseSet(
            quaternions=canonical_sign(found.quaternions),
            R=found.R,
            T=found.T,
            real=found.real,
            certified=np.ones(number, np.bool_),
            multiplicity=np.ones(number, np.int64),
            motions=(),
            account=PathAccount(
                expected=paths,
                found=number,
                at_infinity=at_infinity,
                lost=paths - number - at_infinity,
                basis=Basis.COUNT if number == most else Basis.PATHS,
            ),
        ).on_sides(self.problem.choices[self.k : self.k + 1])
