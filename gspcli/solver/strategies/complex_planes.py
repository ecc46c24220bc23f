"""Poses far away of platforms with points at a distance from lines, where the points are in planes.

The equation of such a point is a product, ``G H = d^2 N^2``: G and H are N times its heights over
two complex planes through the line. Far away N nearly vanishes, and so does G or H. So there the
platform is nearly one with points in planes, whose equations have no products. Paths with fewer
unknowns lead to its poses. Newton's method with more digits leads from these to poses of the
platform (`gspcli.certification.poses.far_points`). Without them the first solution of machines with
two guide rods took 0.05 to 3 s instead of 0.03 (`tools.verify.realistic`).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPL
from gspcli.continuation.quadrics import ComplexArray
from gspcli.geometry.arrangement import Arrangement
from gspcli.solver.ends import Ends
from gspcli.solver.problem import Problem

#: Poses with a larger N, for quaternions of norm 1, need no more digits than paths have.
_FAR = 1e-3


def far_in_planes(problem: Problem) -> Iterator[Ends]:
    """Yield the ends of paths to poses far away, with points in planes through their lines."""
    from gspcli.continuation.reduced_homotopy import ends_from_start
    from gspcli.continuation.start import start_system
    from gspcli.continuation.systems import Structure

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
        yield Ends(points[None], problem.frames, has_directions=True, planes=np.concatenate(planes))


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
