"""What every method of solution returns: poses, motions, and an account of every path."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.poses.pose_arrays import Poses
from gspcli.continuation.paths import PathAccount
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.local_motions import Motion
from gspcli.geometry.measurement import condition_numbers, proved_residuals, residuals
from gspcli.geometry.quaternions import stable_order
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.certification.equations.local_frames import LocalFrames


class CountKind(StrEnum):
    """A count that certified poses can reach (docs/certificates.md)."""

    TYPE = "type count"
    """As many distinct simple poses as the type has: there can be no other solution at all."""
    GEOMETRY = "geometry count"
    """As many as this geometry has with values in general position."""
    EXACT = "exact count"
    """As many as the numbers as written have, with multiplicities."""


class Grade(StrEnum):
    """How certain a proof is."""

    CERTAIN = "certain"
    """No random choice can make it wrong."""
    PRIME = "up to a random prime"
    """It is wrong if the random prime of a count is a bad one, with a probability that is known."""


@dataclass(frozen=True)
class Proof:
    """Why there are no other poses, or why there are infinitely many."""

    #: The count that decides.
    by: CountKind
    #: Bound of the probability that the random prime of the count is a bad one; 0 if the count
    #: holds for every prime.
    error: float = 0.0

    @classmethod
    def modulo(cls, by: CountKind, error: float) -> Proof | None:
        """Return a proof by a count modulo a random prime; None if the bound of its error is 1."""
        return cls(by, error) if error < 1 else None

    @classmethod
    def by_geometry(cls, count: ExactCount | None, number: int) -> Proof | None:
        """Return the proof that this many poses, at least one, are all that the geometry has."""
        # Two pairs of lines parallel at once spoil the argument (docs/counts.md).
        if count is None or not number or count.solutions != number or not count.has_lone_lines:
            return None
        return cls.modulo(CountKind.GEOMETRY, count.error)

    @property
    def grade(self) -> Grade:
        """Whether the proof is certain."""
        return Grade.PRIME if self.error else Grade.CERTAIN

    @property
    def words(self) -> str:
        """The grade in a sentence: proved, or proved with the bound of its error."""
        return f"proved ({self._bound})" if self.error else "proved"

    @property
    def reservation(self) -> str:
        """What the proof rests on unless it is certain; then empty."""
        if not self.error:
            return ""
        certain = ": treat as certain" if self.error <= 1e-9 else ""
        return f"{self._bound}, if the random prime of the {self.by} misleads{certain}"

    @property
    def _bound(self) -> str:
        return f"wrong at most once in 10^{math.floor(-math.log10(self.error))}"

    def to_json(self) -> dict[str, Any]:
        """Return the proof as plain data: `modulo_random_prime` is false or the error bound."""
        return {
            "by": self.by.value,
            "grade": self.grade.value,
            "modulo_random_prime": self.error or False,
        }


Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


#: Poses that are measured together: enough that their number does not matter.
_BLOCK = 4096


@dataclass(frozen=True, eq=False, kw_only=True)
class PoseBatch(Poses):
    """All poses for each of b sets of values; rows are filled up to the longest with NaN.

    The arrays of `Poses` have the shape (b, n, ...), in the frames and units of the instance.
    """

    #: The geometry, and the sets of values with the offsets of the instance added, shape (b, 6).
    arrangement: Arrangement
    values: Array
    #: How many distinct poses each set has, shape (b,).
    number: NDArray[np.int64]
    #: For which sets the poses are all that there are: the account of paths adds up to the verdict
    #: ``complete``; shape (b,).
    complete: NDArray[np.bool_]
    #: For which of them that is proved, for certain or up to a random prime, shape (b,).
    proved: NDArray[np.bool_]
    #: The `PoseSet` of each set with special or wrong values, with account, motions and proof.
    others: Mapping[int, PoseSet]

    def __len__(self) -> int:
        return len(self.number)

    def __repr__(self) -> str:
        parts = f"{len(self)} sets of values, {int(self.real.sum())} real poses"
        missing = f"{int((~self.complete).sum())} incomplete"
        return f"<PoseBatch: {parts}, {int(self.proved.sum())} proved complete, {missing}>"

    @cached_property
    def residuals(self) -> Array:
        """The largest residual of a constraint at each pose, NaN where there is none, (b, n)."""
        result = np.full(self.real.shape, np.nan)
        for measure, chosen in ((proved_residuals, True), (residuals, False)):
            there = np.nonzero((self.multiplicity > 0) & (self.certified == chosen))
            # In blocks: what lies between takes some hundred numbers a pose.
            for begin in range(0, len(there[0]), _BLOCK):
                at = tuple(index[begin : begin + _BLOCK] for index in there)
                given = self.arrangement.with_values(self.values[at[0]])
                result[at] = measure(given, self.R[at], self.T[at]).max(axis=1)
        return result

    @cached_property
    def conditions(self) -> Array:
        """The condition number of each pose, NaN where there is none, shape (b, n)."""
        there = np.nonzero(self.multiplicity)
        lengths = np.array([self.arrangement.length_with(row) for row in self.values])
        given = self.R[there], self.T[there], lengths[there[0]]
        result = np.full(self.real.shape, np.nan)
        result[there] = condition_numbers(self.arrangement, *given)
        return result


#: Poses with larger entries, lengths in typical ones, are far away: 32 digits in the frames of the
#: platform do not round them correctly.
_FAR = 64
#: Ends of paths that are no isolated poses.
_NO_POSES = ("at_infinity", "on_curves", "spurious", "lost")


@dataclass(frozen=True, eq=False, kw_only=True)
class PoseSet(Poses):
    """Distinct isolated poses of a platform, shape (n, ...), and what is known of all others.

    Which are real is proved for certified poses. For others it is decided by pairing conjugates, a
    numerical argument without a threshold: real systems have conjugate solutions, and a pose whose
    conjugate is nearest to itself is its own.

    Attributes
    ----------
    signs
        The choice of sides (`side_choices`) in whose equations each pose was found, shape (n, 6);
        None if only the pose tells.
    motions
        Sets of poses that are not isolated, as far as they were found.
    account
        The account of all paths, for all chosen sides.
    proof
        What proves that there are no other poses, or that there are infinitely many; None if
        nothing does.
    exact_count
        The number of poses of exactly this platform, with multiplicity, where it was needed:
        None if it was not, or if there are infinitely many.
    problem
        What is wrong with the numbers, if they were not solved for that.
    """

    account: PathAccount
    motions: tuple[Motion, ...] = ()
    proof: Proof | None = None
    exact_count: int | None = None
    signs: NDArray[np.float64] | None = None
    problem: str | None = None

    OF_POSES: ClassVar[tuple[str, ...]] = (*Poses.OF_POSES, "signs")

    @classmethod
    def of(cls, poses: Poses, **rest: Any) -> PoseSet:
        """Return poses with further fields, or others in their place."""
        return cls(**({name: getattr(poses, name) for name in Poses.OF_POSES} | rest))

    @property
    def account_text(self) -> str:
        """How many poses there are of which sort, and the verdict, on one line."""
        parts = [f"{int(self.real.sum())} real of {len(self.R)} solutions"]
        if self.certified.any():
            parts.append(f"{int(self.certified.sum())} certified")
        ends = ((name, getattr(self.account, name)) for name in _NO_POSES)
        parts += [f"{number} {name.replace('_', ' ')}" for name, number in ends if number]
        proved = f", {self.proof.words}" if self.proof and not self.problem else ""
        return ", ".join([*parts, (self.problem or self.account.verdict) + proved])

    def __repr__(self) -> str:
        return f"<PoseSet: {self.account_text}>"

    @classmethod
    def unsolved(cls, expected: int, problem: str | None = None) -> PoseSet:
        """Return the set of a platform that is not solved, for some reason: all paths are lost."""
        account = PathAccount(expected=expected, lost=expected)
        return cls(**Poses.none(0), account=account, problem=problem)

    def on_sides(self, choices: NDArray[np.float64]) -> PoseSet:
        """Return the poses, found in equal parts for some choices of sides, shape (k, 6)."""
        return replace(self, signs=on_sides(choices, len(self.R)))

    def taken_back(self, local_frames: LocalFrames) -> PoseSet:
        """Return poses that were found near the bodies in the frames of the instance."""

        def moved(motion: Motion) -> Motion:
            return replace(motion, T=local_frames.doubles_back(motion.R, motion.T))

        T = local_frames.doubles_back(self.R, self.T)
        return replace(self, T=T, motions=tuple(map(moved, self.motions)))

    def in_order(self, length: float) -> PoseSet:
        """Return the poses in the order of `stable_order`, with this typical length."""
        return self[stable_order(self.real, self.quaternions, self.T, length)]


def are_far(R: Complex, T: Complex, length: float, limit: float = _FAR) -> NDArray[np.bool_]:
    """Return which poses, (n, 3, 3) and (n, 3), are far away, by the typical length."""
    turns, places = np.abs(R).max(axis=(1, 2)), np.abs(T).max(axis=1)
    return np.asarray(np.maximum(turns, places / length) > limit)


def on_sides(choices: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return the choice of sides (of k, shape (k, 6)) of each of n poses in equal parts, (n, 6)."""
    return np.repeat(choices, count // len(choices), axis=0)


def joined(parts: Sequence[PoseSet]) -> PoseSet:
    """Return the poses of several systems together, without a proof."""
    return replace(
        PoseSet.together(parts),
        motions=tuple(motion for part in parts for motion in part.motions),
        account=sum((part.account for part in parts), PathAccount(expected=0)),
        proof=None,
        exact_count=None,
        problem=None,
    )
