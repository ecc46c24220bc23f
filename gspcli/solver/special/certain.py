"""Proofs up to a random prime that become certain by a bound of the number of poses."""

from __future__ import annotations

from dataclasses import replace

from gspcli.certification.counting.certain_bounds import certain_bound
from gspcli.solver.problem import Problem
from gspcli.solver.results.pose_set import PoseSet
from gspcli.solver.results.proof import CountKind, Grade, Proof


def made_certain(problem: Problem, poses: PoseSet) -> PoseSet:
    """Return poses with a certain proof, if a platform cannot have more than are certified.

    Parameters
    ----------
    problem, poses
        The platform, and all its poses.
    """
    proof = poses.proof
    if proof is None or proof.grade is Grade.CERTAIN or poses.account.verdict != "complete":
        return poses
    if not poses.certified.all() or (poses.multiplicity > 1).any():
        return poses
    # More sides than one share the poses: the bound of each is as low as it gets.
    enough = len(poses.R) if len(problem.choices) == 1 else 0
    if certain_bound(problem.instance, enough) != len(poses.R):
        return poses
    return replace(poses, proof=Proof(CountKind.EXACT))
