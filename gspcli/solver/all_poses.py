"""All poses of one platform: strategies in the order of their cost, until a count is reached."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from gspcli.solver.ledger import Ends, Ledger
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.problem import Problem

Strategy = Callable[[Problem], Iterator[Ends]]


def all_poses(problem: Problem) -> PoseSet:
    """Return all poses of a platform near the origins of its frames, in any order."""
    ledger = Ledger(problem)
    for strategy, is_quick in first_strategies(problem):
        for ends in strategy(problem):
            ledger.add(ends)
            if (poses := ledger.complete) is not None:
                # What quick paths find at once is found as quickly the next time.
                if not (is_quick and ledger.is_at_once):
                    problem.keep(poses)
                return poses
    from gspcli.solver.by_count import poses_by_count

    poses = poses_by_count(problem, ledger, all_poses)
    problem.keep(poses)
    return poses


def first_strategies(problem: Problem) -> Iterator[tuple[Strategy, bool]]:
    """Yield the strategies that suit a platform, the quickest first, and which are quick.

    Each is imported when it is needed: most platforms need one.
    """
    if problem.has_closed_form:
        # Three angles: all rotations, then all translations.
        from gspcli.solver.strategies.closed_form import closed_form

        yield closed_form, True
    elif problem.has_kept_geometry:
        # Planar or symmetric bodies, shared joints: from the second platform of a geometry on.
        from gspcli.solver.strategies.same_geometry import same_geometry

        yield same_geometry, True
    from gspcli.solver.strategies.stored_start import careful_paths, reduced_paths, short_series

    if not problem.has_closed_form:
        # Points, planes and angles in general position, or lines.
        yield (reduced_paths if problem.is_reducible else short_series), True
    # Everything else, with all the care that double precision allows.
    yield careful_paths, False
