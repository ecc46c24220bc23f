"""Platforms whose solutions are infinitely many over the complex numbers and few over the reals.

A platform with a ball in a seat may have curves of complex solutions, and real poses on them that
cannot move. Here such constraints are stated by planes and right angles instead
(`gspcli.geometry.local_motions`), six of these are solved, and the others are checked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations, islice

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.types import CONSTRAINTS, MAX_ANGLES, GspType
from gspcli.certification import certify, refine
from gspcli.certification.counting import exact_count
from gspcli.certification.poses.exclusion import excluded
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.local_motions import Motion, real_statement
from gspcli.geometry.residuals import relative_residuals
from gspcli.solver.results.pose_set import PoseSet

#: This many choices of six constraints are counted, of types with at most this many poses.
_CHOICES, _MOST_POSES = 40, 640
#: Decimals to which a pose is compared with the constraints that it was not made from.
_DIGITS = 50
#: Residuals, lengths by that of the platform, of what holds and what does not. Of multiple poses,
#: and of the distance of parallel lines, where its equation always holds, nothing else is known.
_HOLDS, _FAILS = 1e-9, 1e-4


def isolated_real_poses(
    instance: Instance, solve: Callable[[Instance], PoseSet]
) -> tuple[Motion, ...] | None:
    """Return the real poses of a platform, each a motion of dimension zero.

    It is proved that there are no others, and so that none can move. That all constraints hold at
    each of them is known to fifty decimals, or nine where poses meet and for the distance of
    parallel lines.

    Parameters
    ----------
    instance
        A platform with infinitely many solutions.
    solve
        How to solve the platforms that take its place.

    Returns
    -------
    tuple of Motion or None
        None if no constraint is several real ones, or if no six of these have finitely many
        solutions that can all be found.
    """
    unit = instance.units.angle
    rows = tuple(row for given in instance.constraints for row in real_statement(given, unit))
    if len(rows) == CONSTRAINTS:
        return None
    # The sense of a direction is said by the angle itself.
    whole = replace(instance, constraints=(*rows, *instance.constraints))
    for chosen in islice(_choices(replace(instance, constraints=rows)), _CHOICES):
        count = exact_count(chosen)
        if count is not None and count.finite:
            poses = solve(chosen)
            return _common(whole, chosen, poses) if poses.proof is not None else None
    return None


def _choices(instance: Instance) -> Iterator[Instance]:
    """Yield six of the constraints at a time, those of types with few poses first."""
    choices: list[tuple[int, int, tuple[Constraint, ...]]] = []
    for rows in combinations(instance.constraints, CONSTRAINTS):
        if sum(not row.kind.is_distance for row in rows) <= MAX_ANGLES:
            counts = generic_counts(GspType.of(row.kind for row in rows))
            if counts.one_sided <= _MOST_POSES:
                choices.append((counts.one_sided, len(choices), rows))
    for _, _, rows in sorted(choices, key=lambda choice: choice[:2]):
        yield replace(instance, constraints=rows)


def _common(whole: Instance, chosen: Instance, poses: PoseSet) -> tuple[Motion, ...] | None:
    """Return the real poses at which all constraints hold, None if some are undecided."""
    real = poses.reordered(poses.real)
    arrangement = Arrangement.of(whole)
    sizes = relative_residuals(arrangement, real.R, real.T).max(axis=1, initial=0.0)
    kept = []
    certificates = certify(chosen, real.R, real.T)
    for k, certificate in enumerate(certificates):
        if _HOLDS < sizes[k] < _FAILS:
            return None
        if sizes[k] > _HOLDS:
            continue
        exact = refine(chosen, certificate, _DIGITS) if certificate.certified else None
        if exact is None or not excluded(whole, exact):
            kept.append(Motion(0, True, real.R[k : k + 1].real, real.T[k : k + 1].real))
    return tuple(kept)
