"""All poses of one platform: strategies in the order of their cost, until a count is reached."""

from __future__ import annotations

from gspcli.solver.ledger import Ledger
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.problem import Problem
from gspcli.solver.strategies import short_strategies


def solved(problem: Problem) -> PoseSet:
    """Return all poses of a platform, in any order."""
    ledger = Ledger(problem)
    if not problem.certify and problem.has_closed_form:
        from gspcli.solver.closed_form import solve_closed_form

        if (poses := solve_closed_form(problem.arrangement)) is not None:
            return poses
    for strategy in short_strategies(problem):
        for ends in strategy(problem):
            ledger.add(ends)
            if (poses := ledger.complete) is not None:
                return poses
    if not problem.certify and all(pursuit.is_regular for pursuit in problem.pursuits):
        from gspcli.solver.tracking import poses_by_paths

        return poses_by_paths(problem.arrangement, problem.pursuits)
    from gspcli.solver.special import finish

    return finish(problem, ledger, solved)
