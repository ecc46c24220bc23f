"""The search for all poses: what strategies add, what is proved, and what is missing."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.poses.pose_arrays import Bits, PoseProofs, Poses
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.quadrics import ComplexArray
from gspcli.solver.poses import CountKind, PoseSet, Proof, joined, on_sides
from gspcli.solver.problem import Problem

if TYPE_CHECKING:
    from gspcli.certification.equations.local_frames import StudyFrames
    from gspcli.certification.poses.far_poses import FarPoses
    from gspcli.certification.poses.locator import Located, StudyPoints
    from gspcli.solver.side_search import SideSearch


Index = NDArray[np.intp]


class Search:
    """The proved poses of a platform, or of one geometry with each of b sets of values."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        #: The poses for sets of values of which one strategy has found all. Rows of other sets have
        #: no meaning. None if no set of values is complete.
        self.proved: PoseProofs | None = None
        #: The indices of the sets of values that are not complete.
        self.left: Index = np.arange(len(problem.values))
        #: Whether everything was found by quick paths, and proved at once.
        self.is_quick = False
        self._sides: list[SideSearch] = []

    @property
    def sides(self) -> list[SideSearch]:
        """The searches of one platform for each choice of sides, when poses are missing."""
        if not self._sides:
            from gspcli.solver.side_search import SideSearch

            self._sides = [SideSearch(self.problem, k) for k in range(len(self.problem.choices))]
        return self._sides

    @property
    def points(self) -> StudyPoints:
        """Study points of the poses that were located in balls, by the bytes of T."""
        return {T: point for side in self._sides for T, point in side.points.items()}

    @property
    def open(self) -> Problem:
        """The platform with the sets of values that are not complete."""
        return self.problem if self.proved is None else self.problem.part(self.left)

    def add(
        self,
        points: ComplexArray,
        frames: StudyFrames,
        *,
        far: FarPoses | None = None,
        has_directions: bool = False,
        planes: NDArray[np.int64] | None = None,
    ) -> None:
        """Prove poses near points to the incomplete sets of values, by the kernel.

        Parameters
        ----------
        points, frames
            Study points of any norm for each set of values and choice of sides, shape
            (b, k, m, 8), and their frames; not a number where a path is lost.
        far
            Poses far away, to which no paths lead, if there is one choice of sides.
        has_directions
            Whether quaternions are right in all digits, up to a factor, where N nearly vanishes,
            too: where paths with fewer unknowns to one platform have arrived. Then missing poses
            far away are located in balls.
        planes
            For each point and constraint 1 or -1 for the complex plane through the line that the
            point is in, 0 for constraints without points and lines, shape (m, 6); None if there
            are none.
        """
        problem = self.problem
        if problem.proofs is None:
            return
        proofs, choices, jobs = problem.proofs, problem.choices, problem.jobs
        rows = None if problem.rows is None else problem.rows[self.left]
        found, complete = proofs.decide(choices, points, frames, rows=rows, jobs=jobs)
        if far is not None:
            found, complete = far.beside(found, complete, proofs, choices[0], rows, jobs=jobs)
        number = found.real.shape[1]
        if not self._sides and complete.any() and self._counted(number):
            self._keep(found, complete)
        if problem.rows is None and len(self.left):
            for k, side in enumerate(self.sides):
                each = slice(k * number // len(choices), (k + 1) * number // len(choices))
                side.add_first(found[0, each])
        if has_directions and not self.is_complete:
            for k, side in enumerate(self.sides):
                side.add_far(points[0, k], planes)
            if self._answer is None and problem.is_reducible:
                # From now on the search has the count of the geometry.
                _ = problem.geometry_count

    def _keep(self, found: PoseProofs, complete: Bits) -> None:
        """Keep the poses for sets of values that were left and are complete now."""
        self._round(found, complete)
        if self.proved is None:
            self.proved = found
        else:
            self.proved.put(self.left, found)
        self.left = self.left[~complete]

    def _round(self, found: PoseProofs, complete: Bits) -> None:
        """Round poses for complete sets of values in balls, where 32 digits do not do that.

        Of many sets of values the real ones: the numbers of others are as good as their bounds say.
        """
        if found.rounded.all():
            return
        problem, number = self.problem, found.real.shape[1]
        wanted = ~found.rounded & complete[:, None] & (found.real | (problem.rows is None))
        for k in np.flatnonzero(wanted.any(axis=1)).tolist():
            one = problem
            if problem.rows is not None:
                one = problem.with_values(problem.rows[self.left[k]])
            conjugates: list[Located] = []
            for i in np.flatnonzero(wanted[k]).tolist():
                near = found.R[k, i], found.T[k, i], float(found.deviation[k, i])
                sides = one.sides[i * len(one.sides) // number]
                located = next((x for x in conjugates if x.is_within(*near)), None)
                located = located or one.locator.near_proved(*near, sides)
                if located is not None:
                    conjugates.append(located.conjugate)
                    found.R[k, i], found.T[k, i] = located.R, located.T
                    found.quaternions[k, i], found.rounded[k, i] = located.quaternion, True

    @property
    def is_at_once(self) -> bool:
        """Whether a strategy has found everything, and the kernel proved it."""
        return not len(self.left)

    def __len__(self) -> int:
        """Return how many poses of one platform are proved."""
        if self.proved is not None:
            return int(self.proved.real.shape[1])
        return sum(map(len, self._sides))

    def _counted(self, number: int) -> Proof | None:
        """Return the proof that there are exactly this many poses; None if no count says so."""
        problem = self.problem
        if number == problem.expected:
            return Proof(CountKind.TYPE)
        return Proof.by_geometry(problem.known_geometry_count, number)

    @property
    def is_complete(self) -> bool:
        """Whether all poses are proved: as many as the type or the geometry has."""
        return self.is_at_once or (self.problem.rows is None and self._answer is not None)

    @property
    def complete(self) -> PoseSet | None:
        """All poses of one platform, if they are as many as the type or the geometry has."""
        if self.is_at_once:
            return self.poses(0)
        answer = self._answer
        if answer is None:
            return None
        account, proof = answer
        poses = joined([side.answer() for side in self.sides])
        return replace(poses, account=account, proof=proof)

    def poses(self, k: int) -> PoseSet:
        """Return the poses for a complete set of values; its arrays are views of `proved`."""
        assert self.proved is not None
        arrays = {name: getattr(self.proved, name)[k] for name in Poses.OF_POSES}
        return PoseSet(**arrays, **self._shared)

    @cached_property
    def _shared(self) -> dict[str, Any]:
        """The fields of a `PoseSet` that all complete sets of values share."""
        answer = self._answer
        assert answer is not None
        signs = on_sides(self.problem.choices, len(self))
        return {"account": answer[0], "proof": answer[1], "signs": signs}

    @property
    def _answer(self) -> tuple[PathAccount, Proof] | None:
        """The account and the proof of as many poses as are proved, if these are all."""
        number, expected = len(self), self.problem.expected
        proof = self._counted(number) if number else None
        if proof is None:
            return None
        by_paths = number == expected and not self.problem.has_closed_form
        account = PathAccount(
            expected=expected,
            found=number,
            at_infinity=expected - number,
            basis=Basis.PATHS if by_paths else Basis.COUNT,
        )
        return account, proof
