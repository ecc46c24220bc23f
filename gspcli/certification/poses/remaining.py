"""What the proofs for many values at a time leave open for one platform: decided pose by pose.

They compute with doubles, and with 32 digits what cancels. A few poses of mutual moments need more;
to prove the others again with them would take longer than all the rest.
"""

from __future__ import annotations

import numpy as np

from gspcli.certification.poses.decisions import decide
from gspcli.certification.poses.distinct import all_different
from gspcli.certification.poses.many_values import ProvedPoses, ValueProofs
from gspcli.geometry.quaternions import quaternion_from_rotation


def with_remaining(proofs: ValueProofs, found: ProvedPoses) -> ProvedPoses:
    """Return what is proved of the ends of paths, with what `decide` proves of those left open.

    Parameters
    ----------
    proofs
        The platform.
    found
        What `ValueProofs.decide_own` returned. Poses that are not finite stay open.
    """
    R, T, quaternions, certified, real, deviation, _ = (part[0].copy() for part in found)
    finite = np.isfinite(R).all(axis=(1, 2)) & np.isfinite(T).all(axis=1)
    rest = np.flatnonzero(~certified & finite)
    certified[rest], real[rest], deviation[rest] = decide(proofs.instance, R[rest], T[rest])
    proved = rest[real[rest]]
    # The real part is no further from a real solution.
    R[proved], T[proved] = R[proved].real, T[proved].real
    quaternions[proved] = quaternion_from_rotation(R[proved])
    entries = np.concatenate((R.reshape(-1, 9), T / proofs.scale), axis=1)
    complete = bool(certified.all()) and all_different(entries, deviation)
    parts = R, T, quaternions, certified, real, deviation, np.array(complete)
    return ProvedPoses(*(part[None] for part in parts))
