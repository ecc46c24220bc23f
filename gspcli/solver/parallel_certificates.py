"""Certificates of poses at which lines happen to be parallel: by all poses of the platform.

Balls never prove that lines are exactly parallel. Counting does
(`gspcli.solver.special.poses_in_parts`). The platform is solved. A candidate is a pose with
parallel lines if it is proved, with points for these lines, to approximate the same solution as one
of the poses found.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.certification import Certificates
from gspcli.certification import certify as certify_alone
from gspcli.certification.counting import by_points
from gspcli.certification.poses.parallel_poses import nearly_parallel, where_parallel
from gspcli.certification.poses.platform_certificates import SINGULAR
from gspcli.certification.poses.pose_proofs import certify_equations
from gspcli.defaults import MAX_PRECISION, TOLERANCE
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.residuals import sides_of
from gspcli.solver.api import solve

Complex = NDArray[np.complex128]
#: The sides of planes, and which lines are parallel.
Part = tuple[tuple[int, ...], tuple[int, ...]]


def certify(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    sides: ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    max_precision: int = MAX_PRECISION,
) -> Certificates:
    """Prove what can be proved about approximate solutions of an instance.

    Parameters, result and errors are those of `gspcli.certification.certify`. Only for candidates
    that it leaves open, and at which the lines of a DLL may be parallel, the platform is solved.
    That such a candidate is certified rests on the proof of that solution, which may be modulo a
    random prime (`SolveResult.proof`).
    """
    found = certify_alone(
        instance, R, T, sides=sides, tolerance=tolerance, max_precision=max_precision
    )
    left = np.flatnonzero([item.outcome in SINGULAR for item in found])
    rotations = np.asarray(R, complex).reshape(-1, 3, 3)
    translations = np.asarray(T, complex).reshape(-1, 3)
    parts = _parts(instance, rotations, translations, left)
    if not parts:
        return found
    result = solve(instance)
    if result.verdict != "complete" or result.proof is None:
        return found
    known = _parts(instance, result.R, result.T, np.flatnonzero(result.certified))
    items = list(found)
    for (signs, lines), places in parts.items():
        poses = np.array(known.get((signs, lines), []), np.intp)
        chosen = instance.on_sides(signs)
        poses = poses[where_parallel(chosen, lines, result.R[poses], result.T[poses])]
        same = by_points(chosen, lines)
        proved = certify_equations(
            same,
            np.concatenate((result.R[poses], rotations[places])),
            np.concatenate((result.T[poses], translations[places])),
            tolerance=tolerance,
            max_precision=max_precision,
        )
        first: dict[int, int] = {}
        for place, item in zip(places, proved[len(poses) :], strict=True):
            pose = item.same_as
            if pose is not None and pose < len(poses):
                items[place] = replace(
                    item, same_as=first.get(pose), unresolved=(), equivalent=same
                )
                first.setdefault(pose, place)
    return Certificates(tuple(items), found.scale, found.least_length)


def _parts(
    instance: Instance, R: Complex, T: Complex, chosen: NDArray[np.intp]
) -> dict[Part, list[int]]:
    """Return those of the poses chosen at which lines may be parallel, by sides and lines."""
    parts: dict[Part, list[int]] = defaultdict(list)
    parallel = nearly_parallel(instance, R[chosen])
    if parallel.any():
        sides = sides_of(Arrangement.of(instance), R[chosen], T[chosen])
        for place, signs, lines in zip(chosen.tolist(), sides.tolist(), parallel, strict=True):
            if lines.any():
                parts[tuple(signs), tuple(np.flatnonzero(lines).tolist())].append(place)
    return parts
