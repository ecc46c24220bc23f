"""All poses of one platform: strategies in the order of their cost, until a count is reached."""

from __future__ import annotations

from gspcli.solver.ledger import Ledger
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.problem import Problem
from gspcli.solver.strategies import first_strategies


def all_poses(problem: Problem) -> PoseSet:
    """Return all poses of a platform near the origins of its frames, in any order."""
    ledger = Ledger(problem)
    for strategy in first_strategies(problem):
        for ends in strategy(problem):
            ledger.add(ends)
            if (poses := ledger.complete) is not None:
                problem.keep(poses, at_once=ledger.is_at_once)
                return poses
    from gspcli.solver.by_count import poses_by_count

    poses = poses_by_count(problem, ledger, all_poses)
    problem.keep(poses, at_once=False)
    return poses
