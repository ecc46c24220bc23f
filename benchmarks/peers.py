"""What a peer answers, and how that is compared with our solutions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.homotopy import UNKNOWNS, poses
from gspcli.geometry.quaternions import Field
from gspcli.solver import SolveResult

#: A pose of a peer this near to one of ours, relative to its size, is the same. Ours are mostly
#: exact to 1e-12, those of peers may be bad to 1e-8, and distinct ones are farther apart.
SAME = 1e-5
#: A numerical peer's solution counts as real below this part of imaginary numbers.
REAL = 1e-8


@dataclass(frozen=True, eq=False)
class Answer:
    """What a peer found.

    Attributes
    ----------
    seconds
        Processor time that counts.
    points
        Solutions with e0 = 1, shape (n, 7); of exact peers the real ones only.
    complex_count
        Number of complex solutions, if the peer counts what it does not list.
    trouble
        Why there is no answer, or empty.
    """

    seconds: float
    points: NDArray[np.complex128]
    complex_count: int | None = None
    trouble: str = ""


def no_answer(trouble: str) -> Answer:
    """Return the answer of a peer that gave none."""
    return Answer(math.nan, np.zeros((0, UNKNOWNS), complex), trouble=trouble)


@dataclass(frozen=True)
class Comparison:
    """A peer's answer beside ours.

    Attributes
    ----------
    complex_count, real
        Distinct solutions of the peer, and how many of them are real.
    lost
        Solutions of ours that the peer has not.
    duplicated
        Solutions that the peer lists again.
    extra
        Listed points that are none of our solutions.
    """

    complex_count: int
    real: int
    lost: int
    duplicated: int
    extra: int

    @property
    def clean(self) -> bool:
        """Whether the peer found what we found, once each."""
        return not (self.lost or self.duplicated or self.extra)


def compare(answer: Answer, ours: SolveResult) -> Comparison:
    """Match the poses of a peer with ours."""
    exact = answer.complex_count is not None
    chosen = ours.real if exact else np.ones(len(ours.R), bool)
    mine = _flat(ours.R[chosen], ours.T[chosen])
    theirs = _flat(*poses(answer.points)) if len(answer.points) else np.zeros((0, 12))
    nearest, near = _nearest(theirs, mine)
    hits = np.bincount(nearest[near], minlength=len(mine))
    size = 1 + np.abs(answer.points).max(axis=1, initial=0.0)
    real = (np.abs(answer.points.imag).max(axis=1, initial=0.0) < REAL * size)[near]
    found, lost = int((hits > 0).sum()), int((hits == 0).sum())
    if exact:
        # The non-real ones are counted, not listed.
        lost += max(0, len(ours.R) - answer.complex_count - lost)
    return Comparison(
        complex_count=answer.complex_count if exact else found,
        real=len(np.unique(nearest[near][real])),
        lost=lost,
        duplicated=int((hits - 1).clip(0).sum()),
        extra=int((~near).sum()),
    )


def _flat(R: Field, T: Field) -> Field:
    return np.concatenate((R.reshape(-1, 9), T.reshape(-1, 3)), axis=1)


def _nearest(theirs: Field, mine: Field) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return for each pose of a peer our nearest one, and whether it is the same."""
    if not len(theirs) or not len(mine):
        return np.zeros(len(theirs), np.intp), np.zeros(len(theirs), bool)
    nearest = np.zeros(len(theirs), np.intp)
    distance = np.zeros(len(theirs))
    for i, row in enumerate(theirs):
        distances = np.abs(mine - row).max(axis=1)
        nearest[i] = distances.argmin()
        distance[i] = distances[nearest[i]] / max(1.0, np.abs(row).max())
    return nearest, distance < SAME
