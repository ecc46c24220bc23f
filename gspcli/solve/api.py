"""The one function that solves any instance."""

from __future__ import annotations

import numpy as np

from gspcli.geometry.instance import Instance
from gspcli.geometry.residuals import Arrangement
from gspcli.solve.closed_form import PoseSet, solve_closed_form
from gspcli.solve.motion import Motion, local_motion
from gspcli.solve.result import SolveResult, stable_order

#: The default seed of everything random.
DEFAULT_SEED = 20031
#: How many samples of positive-dimensional sets are examined.
_SAMPLES = 4


def solve(instance: Instance, *, seed: int = DEFAULT_SEED, certify: bool = True) -> SolveResult:
    """Return all poses of an instance, with an account of every path.

    Platforms with three angles are solved in closed form (Algorithm 6.6), all others by
    tracking paths.

    Parameters
    ----------
    instance
        The platform; the sides of its DPH and DHP distances say which solutions are asked for.
    seed
        Source of random choices. Another seed gives the same poses in the same order.
    certify
        Whether to prove each pose in ball arithmetic.
    """
    arrangement = Arrangement.of(instance)
    poses = solve_closed_form(arrangement)
    order = stable_order(arrangement, poses.R, poses.T, poses.real)
    return SolveResult(
        instance=instance,
        arrangement=arrangement,
        R=poses.R[order],
        T=poses.T[order],
        real=poses.real[order],
        certified=np.zeros(len(order), bool),
        multiplicity=poses.multiplicity[order],
        expected=poses.paths,
        at_infinity=poses.at_infinity,
        on_curves=poses.on_curves,
        lost=poses.lost,
        motions=_motions(arrangement, poses),
        seed=seed,
    )


def _motions(arrangement: Arrangement, poses: PoseSet) -> tuple[Motion, ...]:
    """Return a motion for each dimension of the sets that the samples lie on."""
    found: dict[tuple[bool, int], Motion] = {}
    for R, T in zip(*poses.samples, strict=True):
        motion = local_motion(arrangement, R, T)
        if motion is not None:
            found.setdefault((not motion.real, -motion.dimension), motion)
            if len(found) == _SAMPLES or motion.real:
                break
    return tuple(found[key] for key in sorted(found))
