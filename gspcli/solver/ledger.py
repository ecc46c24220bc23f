"""The poses of a platform that are proved, whoever found them, and what is missing."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gspcli.certification.equations.frames import Frames
from gspcli.certification.poses.many_values import ProvedPoses
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.quadrics import ComplexArray
from gspcli.solver.pose_set import PoseSet, joined, on_sides
from gspcli.solver.problem import Problem
from gspcli.solver.proof import CountKind, Proof

if TYPE_CHECKING:
    from gspcli.certification.poses.far_poses import FarPoses
    from gspcli.solver.side import Side


#: What `ProvedPoses` has of each pose.
_OF_POSES = tuple(name for name in ProvedPoses._fields if name != "complete")


class Ends(NamedTuple):
    """Study points of any norm that may be poses, shape (k, m, 8) for k choices of sides.

    With poses far away, known for other values, and approximations of them (`FarPoses`), if there
    is one choice of sides.
    """

    points: ComplexArray
    frames: Frames
    far: FarPoses | None = None
    local: ComplexArray | None = None


class Ledger:
    """The proved poses of a platform.

    Parameters
    ----------
    problem
        The platform.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        #: What a strategy has found that found everything at once.
        self._whole: ProvedPoses | None = None
        self._sides: list[Side] = []

    @property
    def sides(self) -> list[Side]:
        """The poses for each choice of sides, from the first time on that some are missing."""
        if not self._sides:
            from gspcli.solver.side import Side

            self._sides = [Side(self.problem, k) for k in range(len(self.problem.choices))]
        return self._sides

    def add(self, ends: Ends) -> None:
        """Prove poses near ends of all choices of sides by the kernel: many at a time."""
        problem = self.problem
        if problem.proofs is None:
            return
        proofs, choices = problem.proofs, problem.choices
        found = proofs.decide_own(choices, ends.points, ends.frames)
        if ends.far is not None:
            values = proofs.own_values(choices), np.ones(1), proofs.scale
            found = ends.far.beside(found, *values, ends.local)
        number = found.certified.size
        if found.complete[0] and not self._sides and self._counted(number):
            self._whole = found
            return
        for k, side in enumerate(self.sides):
            each = slice(k * number // len(choices), (k + 1) * number // len(choices))
            side.add_first(
                found._replace(**{name: getattr(found, name)[:, each] for name in _OF_POSES})
            )

    @property
    def is_at_once(self) -> bool:
        """Whether a strategy has found everything, and the kernel proved it."""
        return self._whole is not None

    def __len__(self) -> int:
        """Return how many poses are proved."""
        if self._whole is not None:
            return self._whole.certified.size
        return sum(len(side.found) for side in self.sides)

    def _counted(self, number: int) -> Proof | None:
        """Return what says that there are so many poses."""
        problem = self.problem
        if number == problem.expected:
            return Proof(CountKind.TYPE)
        count = problem.known_geometry_count
        # Two pairs of lines that are parallel at once spoil the argument (docs/counts.md).
        if count is None or count.solutions != number or not count.has_lone_lines:
            return None
        return Proof.modulo(CountKind.GEOMETRY, count.error)

    @property
    def complete(self) -> PoseSet | None:
        """All poses, if they are as many as the type or the geometry has."""
        number, expected = len(self), self.problem.expected
        proof = self._counted(number) if number else None
        if proof is None:
            return None
        account = PathAccount(
            expected=expected,
            found=number,
            at_infinity=expected - number,
            basis=Basis.PATHS
            if number == expected and not self.problem.has_closed_form
            else Basis.COUNT,
        )
        if self._whole is None:
            poses = joined([side.poses() for side in self.sides])
            return replace(poses, account=account, proof=proof)
        found = self._whole
        return PoseSet(
            quaternions=found.quaternions[0],
            R=found.R[0],
            T=found.T[0],
            real=found.real[0],
            certified=found.certified[0],
            multiplicity=np.ones(number, np.int64),
            motions=(),
            account=account,
            proof=proof,
            signs=on_sides(self.problem.choices, number),
        )
