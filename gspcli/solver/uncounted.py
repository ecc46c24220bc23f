"""What can be said of a system in special position whose solutions nobody has counted.

If as many poses are proved as the geometry has with values in general position, there are no
others at all (docs/counts.md). Otherwise only proved poses count as found, and only proved simple
solutions with N = 0 as being at infinity. Everything else is lost.
"""

from __future__ import annotations

import numpy as np

from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.quaternions import canonical_sign
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.search import Effort, Search

#: If at most one path in so many is missing, paths jumped rather than that the platform is special:
#: other paths find what is missing. Otherwise no count says whether more means would find more.
FEW = 50


def without_count(search: Search, most: int | None, most_effort: Effort = Effort.MUCH) -> PoseSet:
    """Return the proved poses, and an account of all paths.

    Parameters
    ----------
    search
        For the poses of the system.
    most
        The number of poses with values in general position if no other solution is possible
        beside so many, else None.
    most_effort
        What is worth it.
    """
    found, paths = search.found, search.pursuit.paths
    for effort in search.steps:
        missing = min(paths - len(found) - len(search.infinite), (most or paths) - len(found))
        if missing <= 0 or effort > most_effort:
            break
        if effort is Effort.MUCH and missing * FEW > paths:
            break
    is_all = len(found) == most
    at_infinity = paths - len(found) if is_all else len(search.infinite)
    return PoseSet(
        quaternions=canonical_sign(found.quaternions),
        R=found.R,
        T=found.T,
        real=found.real,
        certified=np.ones(len(found), np.bool_),
        multiplicity=np.ones(len(found), np.int64),
        motions=(),
        account=PathAccount(
            expected=paths,
            found=len(found),
            at_infinity=at_infinity,
            lost=paths - len(found) - at_infinity,
            basis=Basis.COUNT if is_all else Basis.PATHS,
        ),
    )
