"""Platforms with equal constraints: they have no pose, or infinitely many.

Fewer than six equations on the six-dimensional set of poses have a solution set of positive
dimension through each of their solutions: an equation takes away at most one dimension. So one
certified pose proves what an elimination of a set of four dimensions takes minutes for (``same-
points/*/exact`` of `python -m tools.verify.special solve`: two of three were incomplete after ten
seconds).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.types import CONSTRAINTS
from gspcli.certification import certify
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from gspcli.solver.ledger import Ledger
from gspcli.solver.problem import Problem
from gspcli.solver.results.pose_set import Motion, PoseSet
from gspcli.solver.results.proof import CountKind, Proof
from gspcli.solver.special.infinite_sets import solve_infinite

#: A pose is certified with legs between so many sets of random points beside the constraints.
_TRIES = 4


def poses_of_repeated(problem: Problem, ledger: Ledger) -> PoseSet | None:
    """Return the motions of a platform that has equal constraints; None if it has none.

    Parameters
    ----------
    problem
        The platform.

    Returns
    -------
    PoseSet or None
        None, too, if no real motion is found at a certified pose.
    """
    rows = _different(problem.instance.constraints)
    if len(rows) == CONSTRAINTS:
        return None
    poses = solve_infinite(problem, ledger, None)
    real = [motion for motion in poses.motions if motion.real and motion.dimension]
    if any(_is_pose(problem.instance, rows, motion, problem.seed) for motion in real[:1]):
        return replace(poses, proof=Proof(CountKind.EXACT))
    return None


def _different(constraints: Sequence[Constraint]) -> list[Constraint]:
    """Return the constraints without those that say the same as one before them."""
    known = {
        (row.kind, row.platform, row.base, str(row.value), row.side): row for row in constraints
    }
    return list(known.values())


def _is_pose(instance: Instance, rows: Sequence[Constraint], motion: Motion, seed: int) -> bool:
    """Return whether there is a pose at a sample: one of six constraints that include the rows."""
    R, T = motion.R[0].real, motion.T[0].real
    rng = np.random.default_rng(seed)
    size = max(1.0, float(np.abs(T).max()))
    for _ in range(_TRIES):
        legs = [_leg(R, T, *pair) for pair in size * rng.standard_normal((6 - len(rows), 2, 3))]
        whole = replace(instance, constraints=(*rows, *legs))
        if certify(whole, R[None], T[None])[0].certified:
            return True
    return False


def _leg(R: np.ndarray, T: np.ndarray, on_platform: np.ndarray, on_base: np.ndarray) -> Constraint:
    """Return a distance of two points that has its value at a pose."""
    value = float(np.linalg.norm(R @ on_platform + T - on_base))
    return Constraint(DPP, Point(on_platform), Point(on_base), Number.of(value))
