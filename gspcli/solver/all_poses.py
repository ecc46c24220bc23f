"""All poses: strategies in the order of their cost, until as many are proved as there are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ALL, DHP, DPH, DPL, DPP, Kind, Primitive
from gspcli.certification.equations.local_frames import StudyFrames
from gspcli.certification.equations.mirror_images import mirrored, with_mirror_images
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.start import StartSystem, path_count
from gspcli.continuation.systems import EQUATIONS, Structure, System
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.three_angles import study_points
from gspcli.solver.kept_geometry import (
    by_careful_steps,
    by_short_steps,
    from_nearest,
    same_geometry,
)
from gspcli.solver.poses import PoseSet
from gspcli.solver.problem import Problem
from gspcli.solver.search import Search
from gspcli.solver.solved_starts import SolvedStarts, Sort
from gspcli.solver.study_systems import complex_system

if TYPE_CHECKING:
    from gspcli.continuation.tracked_paths import TrackedPaths

Strategy = Callable[[Search], None]


def closed_form(search: Search) -> None:
    """Add all poses of a platform with three angles whose surfaces are in general position.

    By Bezout's theorem there are no other poses then.
    """
    problem = search.open
    if not problem.has_closed_form:
        return
    arrangement, values = problem.arrangement, problem.values
    length = arrangement.length_with(values)
    given = arrangement.in_units_of(length)
    found = study_points(given, values[:, given.distances] / length, values)
    if not found.general.any():
        return
    # The two signs of a distance of lines are both of one side.
    signs = np.where(given.sided, found.signs, 1.0)
    each = [found.points[:, (signs == choice).all(axis=1)] for choice in problem.choices]
    if not all(points.shape[1] for points in each):
        return
    points = np.stack(each, axis=1).reshape(len(values), len(each), -1, 8)
    points[~found.general] = np.nan
    centres = arrangement.platform_centre, arrangement.base_centre
    search.add(points, StudyFrames(length=length, platform=centres[0], base=centres[1]))


#: Poses with a larger N, for quaternions of norm 1, need no more digits than paths have.
_FAR = 1e-3


def far_in_planes(search: Search) -> None:
    """Add the ends of paths to poses far away, with points in planes through their lines.

    The equation of a point at a distance from a line is a product, ``G H = d^2 N^2``: G and H are N
    times its heights over two complex planes through the line. Far away N nearly vanishes, and so
    does G or H: there the platform is nearly one with points in planes, whose equations have no
    products. Newton's method with more digits leads from its poses to those of the platform
    (`gspcli.certification.poses.far_points`).
    """
    from gspcli.continuation.reduced_homotopy import ends_from_start
    from gspcli.continuation.start import start_system
    from gspcli.continuation.systems import Structure

    problem = search.problem
    if problem.has_closed_form or not problem.is_reducible_in_planes:
        return
    given, (g, h, _) = problem.equations
    turns = _turns(problem.arrangement.normalized)
    structure = Structure(given.spaces)
    order, start = list(structure.order), start_system(structure.canonical())
    parts, planes = [], []
    for signs in _choices(given.products):
        quadrics = np.where(signs[:, None] < 0, h, g)
        found = [
            ends_from_start(start, each[order], lower_rank=True, keep_lost=True)
            for each in quadrics
        ]
        ends = [points for points in found if points is not None]
        if len(ends) < len(found):
            return
        far = np.array(ends)
        far[~_are_far(far)] = np.nan
        far = far[:, np.isfinite(far).all(axis=2).any(axis=0)]
        parts.append(far)
        planes.append(np.tile(signs * turns, (far.shape[1], 1)))
    points = np.concatenate(parts, axis=1)
    if points.size:
        turned = np.concatenate(planes)
        search.add(points[None], problem.frames, has_directions=True, planes=turned)


def _choices(products: tuple[bool, ...]) -> Iterator[NDArray[np.int64]]:
    """Yield for each product 1 for G and -1 for H, of two choices that are conjugate one."""
    first = products.index(True)
    each = [
        ((1,) if k == first else (1, -1)) if is_product else (0,)
        for k, is_product in enumerate(products)
    ]
    yield from map(np.array, product(*each))


def _turns(given: Arrangement) -> NDArray[np.int64]:
    """Return for each constraint 1 or -1, as a, b and v are right-handed (`study_systems`)."""
    of_base = np.array([kind is DPL for kind in given.kinds])
    axes = np.where(of_base, given.v[:, 0], given.u[:, 0])
    return np.copysign(1, axes).astype(np.int64)


def _are_far(points: ComplexArray) -> NDArray[np.bool_]:
    """Return at which Study points (..., 8) N nearly vanishes."""
    e = points[..., :4]
    size = (np.abs(e) ** 2).sum(axis=-1)
    return np.asarray(np.abs((e * e).sum(axis=-1)) < _FAR * size)


#: Heights of points of a planar body over its plane, in lengths of order one.
_FLAT = 1e-12
#: Seeds of the random platforms, of which from the first fewest paths go wrong.
_SEEDS, _PLANAR_SEEDS = (0, 3, 1), (3, 1)
#: What the equations are linear in: a mean for squares of distances, and zero else, plus i times
#: numbers between these with random signs.
_MEAN, _SPREAD = 0.6, (0.2, 0.4)
#: A kind whose equation is a quadric of a space.
_KINDS = {"a": ALL, "p": DPH, "q": DHP, "s": DPP}


def structure_start(structure: Structure, starts: SolvedStarts) -> StartSystem | None:
    """Return a solved platform of a structure without products, in canonical order.

    None before `OFTEN` platforms of the structure were solved. None for the mutual moment of lines
    that meet, which has no value that could be complex.
    """
    if structure.is_product.any() or not set(structure.spaces) <= _KINDS.keys():
        return None
    if not starts.is_frequent(structure):
        return None
    return starts.kept(Sort.START, structure, partial(_first_solved, structure))


def _first_solved(structure: Structure) -> StartSystem | None:
    kinds = tuple(_KINDS[space] for space in structure.spaces)
    made = (_solved(kinds, (False, False), seed) for seed in _SEEDS)
    return next((start for start in made if start is not None), None)


def planar_starts(arrangement: Arrangement) -> Iterator[StartSystem]:
    """Yield solved platforms that are planar where another is; they are kept for the process.

    None where the planes are not those of two coordinates or joints are shared.

    Parameters
    ----------
    arrangement
        The other one, lengths of order one.
    """
    bodies = arrangement.y, arrangement.x
    flat = (_is_flat(arrangement.y), _is_flat(arrangement.x))
    if set(arrangement.kinds) != {DPP} or not any(flat) or any(map(_shares_joints, bodies)):
        return
    for seed in _PLANAR_SEEDS:
        if (start := _planar(flat, seed)) is not None:
            yield start


@cache
def _planar(flat: tuple[bool, bool], seed: int) -> StartSystem | None:
    """Return a solved platform of which these bodies are planar.

    If both are, the second half of the solutions are the mirror images of the first.
    """
    start = _solved((DPP,) * EQUATIONS, flat, seed)
    if start is None or not all(flat):
        return start
    half = _one_of_each_pair(start.points)
    return None if half is None else StartSystem(start.system, with_mirror_images(half))


def _one_of_each_pair(points: ComplexArray) -> ComplexArray | None:
    """Return half of the points (n, 8) of norm 1: of each pair of mirror images one, or None."""
    alike = np.abs(mirrored(points).conj() @ points.T)
    first = alike.argmax(axis=1) > np.arange(len(points))
    return points[first] if 2 * first.sum() == len(points) else None


def _is_flat(points: NDArray[np.float64]) -> bool:
    return bool(np.ptp(points[:, 2]) <= _FLAT)


def _shares_joints(points: NDArray[np.float64]) -> bool:
    return len(set(map(tuple, points.tolist()))) < len(points)


def _solved(kinds: tuple[Kind, ...], flat: tuple[bool, bool], seed: int) -> StartSystem | None:
    """Return a solved platform of which these bodies are planar; None if some paths are lost."""
    from gspcli.continuation.tracked_paths import track_all

    given = complex_platform(kinds, flat, seed)
    points = next(track_all([given], seed=seed)).distinct_simple()
    if len(points) != path_count(given.structure):
        return None
    return StartSystem(given, points / np.linalg.norm(points, axis=1, keepdims=True))


def complex_platform(kinds: tuple[Kind, ...], flat: tuple[bool, bool], seed: int) -> System:
    """Return a platform with complex values, lengths of order one.

    Parameters
    ----------
    kinds
        Of its constraints, in canonical order.
    flat
        Whether the points of the platform, and of the base, are of one plane.
    seed
        Of its random numbers.
    """
    rng = np.random.default_rng([seed, len(kinds)])
    y, x = rng.uniform(-1, 1, (2, len(kinds), 3))
    y[:, 2] *= not flat[0]
    x[:, 2] *= not flat[1]
    y, x = (z - z.mean(axis=0) for z in (y, x))
    length = np.sqrt(max((z**2).sum(axis=1).max() for z in (y, x)))
    u, v = rng.normal(size=(2, len(kinds), 3))
    u, v = (z / np.linalg.norm(z, axis=1, keepdims=True) for z in (u, v))
    for i, kind in enumerate(kinds):
        u[i] *= kind.platform is not Primitive.POINT
        v[i] *= kind.base is not Primitive.POINT
    square = np.array([kind.is_squared for kind in kinds])
    turns = rng.choice([-1.0, 1.0], len(kinds)) * rng.uniform(*_SPREAD, len(kinds))
    parameters = np.asarray(np.where(square, _MEAN, 0.0) + 1j * turns, np.complex128)
    return complex_system(kinds, y / length, x / length, u, v, parameters)


def reduced_paths(search: Search) -> None:
    """Add the ends of paths with fewer unknowns, of equations without products."""
    from gspcli.continuation.reduced_homotopy import ends_from_start

    problem = search.problem
    if problem.has_closed_form or not problem.is_reducible:
        return
    structure, given = problem.equations
    targets, structure = given.g[:, list(structure.order)], structure.canonical()
    for start in planar_starts(problem.arrangement.normalized):
        if (planar := _planar_ends(problem, start, targets[0])) is not None:
            search.add(planar[None, None], problem.frames, has_directions=True)
            if search.is_complete:
                return
    for start in _start_systems(problem, structure):
        found = [ends_from_start(start, quadrics) for quadrics in targets]
        ends = [points for points in found if points is not None]
        if len(ends) == len(found):
            search.add(np.array(ends)[None], problem.frames, has_directions=True)
            if search.is_complete:
                return


def _planar_ends(problem: Problem, start: StartSystem, target: ComplexArray) -> ComplexArray | None:
    """Return the ends of paths from a planar platform: of one of each pair of mirror images."""
    from gspcli.continuation.reduced_homotopy import ends_from_start
    from gspcli.continuation.tracker import DEFAULT

    if not problem.has_mirror_images:
        return ends_from_start(start, target, DEFAULT)
    half = replace(start, points=start.points[: len(start.points) // 2])
    ends = ends_from_start(half, target, DEFAULT)
    return None if ends is None else with_mirror_images(ends)


def _start_systems(problem: Problem, structure: Structure) -> Iterator[StartSystem]:
    """Yield where reduced paths begin."""
    from gspcli.continuation.start import start_system

    if (start := structure_start(structure, problem.starts)) is not None:
        yield start
    yield start_system(structure)


def quick_paths(search: Search) -> None:
    """Add the ends of paths of products, followed with long steps."""
    from gspcli.continuation.tracked_paths import track_all
    from gspcli.continuation.tracker import QUICK

    problem = search.problem
    if problem.has_closed_form or not problem.equations[0].is_product.any():
        return
    seed, jobs = problem.seed, problem.jobs
    tracked = list(track_all(problem.systems, seed=seed, jobs=jobs, options=QUICK))
    _add_ends(search, tracked)


def careful_paths(search: Search) -> None:
    """Add the ends of all paths, followed with all the care that double precision allows."""
    _add_ends(search, search.problem.tracked)


def _add_ends(search: Search, tracked: Sequence[TrackedPaths]) -> None:
    """Add the ends of paths for each choice of sides."""
    points = np.stack([paths.first().points[0] for paths in tracked])
    search.add(points[None], search.problem.frames)


def all_poses(problem: Problem) -> PoseSet:
    """Return all poses of a platform near the origins of its frames, in any order."""
    search = first_poses(problem)
    if (poses := search.complete) is None:
        from gspcli.solver.by_count import poses_by_count

        poses = poses_by_count(problem, search, lambda other: all_poses(problem.like(other)))
    # What quick paths find at once is found as quickly the next time.
    if not search.is_quick:
        problem.keep(poses, search.points)
    return poses


def first_poses(problem: Problem) -> Search:
    """Return what the first strategies find of a platform, or of it with many sets of values.

    They know neither proofs nor counts, and do nothing for platforms that they do not suit.
    """
    search = Search(problem)
    for strategy in _first_of_many() if problem.rows is not None else _first_of_one():
        strategy(search)
        if search.is_complete:
            search.is_quick = search.is_at_once and _is_quick(strategy, problem)
            break
    return search


def _first_of_many() -> tuple[Strategy, ...]:
    """Return the strategies for many sets of values: from one start, the quickest paths first."""
    return closed_form, from_nearest, by_short_steps, by_careful_steps


def _first_of_one() -> tuple[Strategy, ...]:
    """Return the strategies for one platform, the quickest first.

    Three angles give all rotations, then all translations. Planar and symmetric bodies and shared
    joints begin from the second platform of a geometry on at a kept one. Then come paths of points,
    planes and angles in general position, or of lines; points and lines, with poses far away; and
    all paths with all the care that double precision allows.
    """
    return closed_form, same_geometry, reduced_paths, quick_paths, far_in_planes, careful_paths


def _is_quick(strategy: Strategy, problem: Problem) -> bool:
    """Whether nothing is gained by keeping what a strategy has found."""
    if strategy in (reduced_paths, quick_paths):
        # Planar platforms are kept: from a start of their geometry they take half the time.
        return not problem.has_mirror_images
    return strategy not in (far_in_planes, careful_paths)
