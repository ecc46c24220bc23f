"""What every method of solution returns: poses, motions, and an account of every path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.paths import PathAccount
from gspcli.geometry.local_motions import Motion
from gspcli.geometry.quaternions import quaternion_from_rotation, stable_order
from gspcli.records import EqualByContent, dataclass
from gspcli.solver.results.proof import Proof

if TYPE_CHECKING:
    from gspcli.certification.equations.local_frames import LocalFrames

Complex = NDArray[np.complex128]


#: Poses with larger entries, lengths in typical ones, are far away: 32 digits in the frames of the
#: platform do not round them correctly.
_FAR = 64
#: What there is one of for each pose.
_OF_POSES = ("quaternions", "R", "T", "real", "certified", "multiplicity")
#: Ends of paths that are no isolated poses.
_NO_POSES = ("at_infinity", "on_curves", "spurious", "lost")


@dataclass(frozen=True, eq=False)
class PoseSet(EqualByContent):
    """Poses, in the frames of the arrangement.

    Attributes
    ----------
    quaternions
        Of the rotations, ``e.e = 1``, with the sign of `quaternion_from_rotation`, shape (n, 4),
        complex.
    R, T
        Distinct isolated poses, shapes (n, 3, 3) and (n, 3), complex.
    real
        Which of them are real; their imaginary parts are exactly zero. Shape (n,). Proved for
        certified poses. For others it is decided by pairing conjugates, a numerical argument
        without a threshold: real systems have conjugate solutions, and a pose whose conjugate
        is nearest to itself is its own.
    certified
        Which of them are proved to exist, to be simple, and to be real or not, shape (n,).
    multiplicity
        How many paths end at each, shape (n,).
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

    quaternions: Complex
    R: Complex
    T: Complex
    real: NDArray[np.bool_]
    certified: NDArray[np.bool_]
    multiplicity: NDArray[np.int64]
    motions: tuple[Motion, ...]
    account: PathAccount
    proof: Proof | None = None
    exact_count: int | None = None
    signs: NDArray[np.float64] | None = None
    problem: str | None = None

    @property
    def account_text(self) -> str:
        """How many poses there are of which sort, and the verdict, on one line."""
        parts = [f"{int(self.real.sum())} real of {len(self.R)} poses"]
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
        return cls(
            quaternions=np.zeros((0, 4), complex),
            R=np.zeros((0, 3, 3), complex),
            T=np.zeros((0, 3), complex),
            real=np.zeros(0, bool),
            certified=np.zeros(0, bool),
            multiplicity=np.zeros(0, int),
            motions=(),
            account=PathAccount(expected=expected, lost=expected),
            problem=problem,
        )

    @property
    def lone(self) -> PoseSet:
        """The real poses from which no real motion begins, as poses that are found."""
        motions = [motion for motion in self.motions if not motion.dimension]
        count = len(motions)
        R = np.concatenate([np.zeros((0, 3, 3)), *(motion.R for motion in motions)])
        T = np.concatenate([np.zeros((0, 3)), *(motion.T for motion in motions)])
        return PoseSet(
            quaternions=quaternion_from_rotation(R).astype(complex),
            R=R.astype(complex),
            T=T.astype(complex),
            real=np.ones(count, bool),
            certified=np.zeros(count, bool),
            multiplicity=np.ones(count, int),
            motions=(),
            account=PathAccount(expected=count, found=count),
        )

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
        return self.reordered(stable_order(self.real, self.quaternions, self.T, length))

    def reordered(self, order: NDArray[np.integer] | NDArray[np.bool_]) -> PoseSet:
        """Return the poses in another order, or some of them."""
        parts = {name: getattr(self, name)[order] for name in _OF_POSES}
        return replace(self, signs=None if self.signs is None else self.signs[order], **parts)


def are_far(R: Complex, T: Complex, length: float, limit: float = _FAR) -> NDArray[np.bool_]:
    """Return which poses, (n, 3, 3) and (n, 3), are far away, by the typical length."""
    turns, places = np.abs(R).max(axis=(1, 2)), np.abs(T).max(axis=1)
    return np.asarray(np.maximum(turns, places / length) > limit)


def on_sides(choices: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return the choice of sides (of k, shape (k, 6)) of each of n poses in equal parts, (n, 6)."""
    return np.repeat(choices, count // len(choices), axis=0)


def joined(parts: Sequence[PoseSet]) -> PoseSet:
    """Return the poses of several systems together, without a proof."""
    signs = [part.signs for part in parts if part.signs is not None]
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in _OF_POSES
    }
    return PoseSet(
        **arrays,
        motions=tuple(motion for part in parts for motion in part.motions),
        signs=np.concatenate(signs) if len(signs) == len(parts) else None,
        account=sum((part.account for part in parts), PathAccount(expected=0)),
    )
