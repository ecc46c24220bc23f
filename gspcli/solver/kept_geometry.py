"""Paths from a solved platform of the same geometry, along which only the values change.

Planar bodies, symmetric ones and shared joints are what most platforms have, and leave fewer poses
than the type. Paths from the stored start system would end at infinity; those from a start of the
geometry do not. Where that is so but for rounding, the others are far away: they need no paths, as
they hardly depend on the values (`gspcli.certification.poses.far_poses`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.reduced_homotopy import Balance
from gspcli.geometry.arrangement import Arrangement
from gspcli.solver.poses import PoseSet, are_far
from gspcli.solver.problem import Problem
from gspcli.solver.search import Search
from gspcli.solver.solved_starts import SolvedPlatform, Sort, geometry_key
from gspcli.solver.start import (
    Start,
    StartMethod,
    parameters_in,
    plain_quadrics,
    solved_system,
    start_about,
)

if TYPE_CHECKING:
    from gspcli.certification.poses.far_poses import FarPoses
    from gspcli.certification.poses.many_values import ValueProofs


Array = NDArray[np.float64]

#: Squares of distances, in typical lengths, are about this; what has a sign is about zero.
_SQUARE = 0.5
#: How far the start's values are from real ones.
_SPREAD = 0.5
#: Bodies with a smaller part of their largest extent across a plane are nearly planar.
_FLAT = 1e-3
#: To poses not farther away than this many lengths paths lead.
_REACHED = 200
#: This many random starts are tried near far poses: from some, paths are lost or jump.
_ATTEMPTS = 6


def same_geometry(search: Search) -> None:
    """Add the ends of paths from a start of the geometry, and its far poses, where it is kept."""
    problem = search.problem
    if problem.has_closed_form or not problem.has_kept_geometry:
        return
    start = kept_start(problem)
    # Where it has fewer poses than its type, its count is what says that these are all.
    if start is not None and (
        start.found == problem.expected or problem.geometry_count is not None
    ):
        ends, has_directions = start.quick_ends(problem.values), start.homotopy is not None
        search.add(*ends, far=start.far, has_directions=has_directions)


def from_nearest(search: Search) -> None:
    """Add the ends of paths to sets of values, each from the nearest system."""
    problem, start = search.open, search.problem.start
    if start is not None:
        search.add(*start.quick_ends(problem.values, problem.jobs), far=start.far)


def by_short_steps(search: Search) -> None:
    """Add the ends of paths from the start's first system, with short steps."""
    problem, start = search.open, search.problem.start
    if start is not None and start.homotopy is not None:
        search.add(*start.short_ends(problem.values, problem.jobs), far=start.far)


def by_careful_steps(search: Search) -> None:
    """Add the ends of paths of the equations in all unknowns, from the start's first system.

    Where there are equations with fewer unknowns, the other sets of values are solved one by one:
    that takes less time than these paths.
    """
    problem, start = search.open, search.problem.start
    if start is not None and start.homotopy is None:
        search.add(*start.careful_ends(problem.values, problem.jobs), far=start.far)


def kept_start(problem: Problem) -> Start | None:
    """Return a start from a kept platform of the geometry; None if there is no safe one."""
    known = problem.starts.platform(problem.arrangement)
    if known is None:
        return None
    far = _are_far(known)
    if not far.any():
        return _about(problem, known.arrangement, known.poses, problem.seed)
    if not known.has_geometry_of(problem.instance):
        return None
    key = geometry_key(problem.arrangement), problem.unit, problem.seed, problem.limit
    kept = cast("tuple[SolvedPlatform, Start | None] | None", problem.starts.fetch(Sort.SAME, key))
    # Platforms that are the same in doubles may not be the same.
    if kept is None or kept[0] is not known:
        kept = problem.starts.keep(Sort.SAME, key, (known, _checked(problem, known, far)))
    return kept[1]


def kept_among(
    problem: Problem, solve: Callable[[Problem], PoseSet], *, begin: bool
) -> Start | None:
    """Return a start with poses far away among sets of values; None if there are no such poses.

    Parameters
    ----------
    problem, solve
        The platform with its sets of values, and what returns all poses of one.
    begin
        Whether to solve one of them if no platform of the geometry is kept.
    """
    rows = problem.values
    one = problem.with_values(rows[len(rows) // 2])
    if not one.is_kept or one.limit == 0:
        return None
    known = problem.starts.platform(one.arrangement)
    if known is None and begin:
        poses = solve(one)
        known = problem.starts.platform(one.arrangement)
        if known is None and are_far(poses.R, poses.T, one.arrangement.length, _REACHED).any():
            # Quick paths have found all poses, from the stored start.
            one.keep(poses, {})
            known = problem.starts.platform(one.arrangement)
    if known is None or not _are_far(known).any():
        return None
    found = kept_start(one)
    return found and found.among(rows, problem.jobs)


def _are_far(known: SolvedPlatform) -> NDArray[np.bool_]:
    """Return which poses of a platform need no paths."""
    return are_far(known.poses.R, known.poses.T, known.arrangement.length, _REACHED)


def _checked(problem: Problem, known: SolvedPlatform, is_far: NDArray[np.bool_]) -> Start | None:
    """Return a start from a platform with far poses, if paths from it lead back to all poses."""
    solved = problem.like(known.instance)
    if len(solved.choices) > 1 or solved.proofs is None:
        return None
    starts = _starts(problem, solved, solved.proofs, known, is_far)
    return next((x for x in starts if _leads_back(x, problem, solved, known)), None)


def _starts(
    problem: Problem,
    solved: Problem,
    proofs: ValueProofs,
    known: SolvedPlatform,
    is_far: NDArray[np.bool_],
) -> Iterator[Start]:
    """Yield starts of the near poses, with the far ones beside them, then one of all poses."""
    from gspcli.certification.poses.far_poses import FarPoses

    near, apart = known.poses[~is_far], known.poses[is_far]
    sides, length = (solved.choices[0], solved.sides[0]), known.arrangement.length
    given = solved.locator, proofs, *sides, apart.R, apart.T, known.points, length
    spread = _spread(problem, known.arrangement)
    far = None if is_far.all() else FarPoses.of(*given, spread, problem.unit)
    for attempt in range(0 if far is None else _ATTEMPTS):
        found = _about(problem, _flattened(known.arrangement), near, problem.seed + attempt, far)
        if found is None or far is None:
            continue
        # Near and far poses are followed from the same values on the same way: where values change,
        # one may take the place of the other.
        moved = far.about(
            found.parameters[0], parameters_in(known.arrangement, problem.unit), problem.unit
        )
        if moved is not None:
            yield replace(found, far=moved)
    # Poses a hundred lengths away may have equations that are too nearly dependent for local
    # coordinates; they are proved at the ends of paths.
    found = _about(problem, known.arrangement, known.poses, problem.seed)
    if found is not None:
        yield found


def _leads_back(found: Start, problem: Problem, solved: Problem, known: SolvedPlatform) -> bool:
    """Whether all poses of the platform that a start was made from are found and proved."""
    rows = known.arrangement.values[None]
    search = Search(solved.with_rows(rows))
    if found.found < solved.expected:
        search.problem.known_geometry_count = problem.geometry_count
    search.add(*found.quick_ends(rows), far=found.far)
    return search.is_at_once


def _about(
    problem: Problem, known: Arrangement, poses: PoseSet, seed: int, far: FarPoses | None = None
) -> Start | None:
    """Return a start from a solved platform; None if that is not safe."""
    length, spread = problem.unit, _spread(problem, known)
    if spread is None:
        square = [kind.is_squared for kind in known.kinds]
        among = np.where(square, _SQUARE, 0.0), np.full(len(square), _SPREAD)
    else:
        among = parameters_in(known, length), spread
    start = start_about(
        problem.arrangement if far is None else known,
        length,
        *among,
        count=lambda: problem.geometry_count,
        seed=seed,
        starts=problem.starts,
        ways=(StartMethod.SOLVED, StartMethod.QUICK) if far is None else (StartMethod.SOLVED,),
        solved=solved_system(known, length, poses),
        far=far,
    )
    return None if start is None or start.proof is None else start


def _spread(problem: Problem, known: Arrangement) -> Array | None:
    """Return by how much values differ from those of a solved platform (`Balance.spread`).

    None unless its equations are nearly dependent.
    """
    length = problem.unit

    def made() -> Array | None:
        quadrics = plain_quadrics(known.in_units_of(length))
        balance = None if quadrics is None else Balance.of(quadrics)
        return balance and balance.spread(parameters_in(known, length))

    return problem.starts.kept(Sort.SPREAD, (geometry_key(known), length), made)


def _flattened(arrangement: Arrangement) -> Arrangement:
    """Return the arrangement with the points of nearly planar bodies in their planes.

    In the equations of paths with fewer unknowns, a nearly planar body makes a nearly singular
    matrix. Proofs use the platform with its own points.
    """
    return replace(arrangement, y=_in_plane(arrangement.y), x=_in_plane(arrangement.x))


def _in_plane(points: Array) -> Array:
    """Return points (n, 3) in a plane that they are nearly in."""
    middle = points.mean(axis=0)
    _, sizes, axes = np.linalg.svd(points - middle)
    if not sizes[2] < _FLAT * sizes[0]:
        return points
    flat: Array = points - np.outer((points - middle) @ axes[2], axes[2])
    return flat
