"""All poses: strategies in the order of their cost, until as many are proved as there are."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from gspcli.solver.ends import Ends
from gspcli.solver.ledger import Ledger
from gspcli.solver.problem import Problem
from gspcli.solver.results.pose_set import PoseSet

Strategy = Callable[[Problem], Iterator[Ends]]


def all_poses(problem: Problem) -> PoseSet:
    """Return all poses of a platform near the origins of its frames, in any order."""
    ledger = first_poses(problem)
    if (poses := ledger.complete) is None:
        from gspcli.solver.special.by_count import poses_by_count

        poses = poses_by_count(problem, ledger, lambda other: all_poses(problem.like(other)))
    # What quick paths find at once is found as quickly the next time.
    if not ledger.is_quick:
        problem.keep(poses, ledger.points)
    return poses


def first_poses(problem: Problem) -> Ledger:
    """Return what the first strategies find of a platform, or of it with many sets of values."""
    ledger = Ledger(problem)
    for strategy, is_quick in first_strategies(problem):
        for ends in strategy(ledger.open):
            ledger.add(ends)
            if ends.has_directions and not ledger.is_complete:
                ledger.add_far(ends)
            if ledger.is_complete:
                ledger.is_quick = is_quick and ledger.is_at_once
                return ledger
    return ledger


def first_strategies(problem: Problem) -> Iterator[tuple[Strategy, bool]]:
    """Yield the strategies that suit a platform, the quickest first, and which are quick.

    Each is imported when it is needed: most platforms need one.
    """
    if problem.has_closed_form:
        # Three angles: all rotations, then all translations.
        from gspcli.solver.strategies.closed_form import closed_form

        yield closed_form, True
    if problem.rows is not None:
        # Many sets of values: from one start, the quickest paths first.
        from gspcli.solver.strategies.kept_geometry import (
            by_careful_steps,
            by_short_steps,
            from_nearest,
        )

        yield from ((way, True) for way in (from_nearest, by_short_steps, by_careful_steps))
        return
    if problem.has_kept_geometry and not problem.has_closed_form:
        # Planar or symmetric bodies, shared joints: from the second platform of a geometry on.
        from gspcli.solver.strategies.kept_geometry import same_geometry

        yield same_geometry, True
    from gspcli.solver.strategies.stored_start import careful_paths, reduced_paths, short_series

    if not problem.has_closed_form:
        # Points, planes and angles in general position, or lines.
        # Planar platforms are kept: from a start of their geometry they take half the time.
        is_quick = not problem.has_mirror_images
        yield (reduced_paths if problem.is_reducible else short_series), is_quick
    if problem.is_reducible_in_planes and not problem.has_closed_form:
        # Points and lines: poses far away.
        from gspcli.solver.strategies.complex_planes import far_in_planes

        yield far_in_planes, False
    # Everything else, with all the care that double precision allows.
    yield careful_paths, False
