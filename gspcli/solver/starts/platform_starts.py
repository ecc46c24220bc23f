"""Solved platforms with complex values, without lines: paths from them to others are short.

A platform is a start for others of its structure, as the stored quadrics are, with steps three
times as long: a stream of new platforms takes three quarters to four fifths of the time. The
equations of a planar body are not solved for the same quantities as those of others
(`ReducedHomotopy`). From a platform that is planar, too, another is solved in a third of the time
that all paths of the equations as they are take (`make bench`, row "planar 6-6").
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ALL, DHP, DPH, DPP, Kind, Primitive
from gspcli.certification.equations.mirror_images import mirrored, with_mirror_images
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.start import StartSystem, path_count
from gspcli.continuation.systems import EQUATIONS, Structure, System
from gspcli.geometry.arrangement import Arrangement
from gspcli.solver.starts.solved_starts import SolvedStarts, Sort
from gspcli.solver.study_systems import complex_system

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
