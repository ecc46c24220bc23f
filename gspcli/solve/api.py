"""The one function that solves any instance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Instance
from gspcli.geometry.poses import Field
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
        Whether to prove each pose, and whether it is real, in ball arithmetic.
    """
    arrangement = Arrangement.of(instance)
    poses = solve_closed_form(arrangement)
    R, T = poses.R, poses.T
    real, certified = poses.real, np.zeros(len(R), bool)
    if certify and len(R):
        real, certified = _proved(instance, R, T, real)
    order = stable_order(arrangement, R, T, real)
    return SolveResult(
        instance=instance,
        arrangement=arrangement,
        R=R[order],
        T=T[order],
        real=real[order],
        certified=certified[order],
        multiplicity=poses.multiplicity[order],
        expected=poses.paths,
        at_infinity=poses.at_infinity,
        on_curves=poses.on_curves,
        lost=poses.lost,
        motions=_motions(arrangement, poses),
        seed=seed,
    )


def _proved(
    instance: Instance, R: Field, T: Field, real: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which poses are real, by proof where there is one, and which are certified.

    A pose is certified if exactly one simple solution is proved near it, different from those
    of the other poses, and proved to be real or not to be.
    """
    from gspcli.certification import certify

    certificates = certify(instance, R, T)
    certified = np.array(
        [
            c.certified and c.real is not None and c.same_as is None and not c.unresolved
            for c in certificates
        ]
    )
    proved = np.array([bool(c.real) for c in certificates])
    return np.where(certified, proved, real), certified


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
