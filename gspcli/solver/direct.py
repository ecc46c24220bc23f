"""All poses, proved, by the quickest paths there are: what most platforms need."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ANGLE_KINDS, DHP, DLL, DPH, DPP
from gspcli.certification.equations.frames import Frames
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.shifts import FROM_START, LONG_STEPS, ends_from_start, followed_again
from gspcli.continuation.start import StartSystem, start_system
from gspcli.continuation.tracker import TrackerOptions
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.solver.pose_set import PoseSet, on_sides
from gspcli.solver.proof import Ground, Proof
from gspcli.solver.reference_start import reference_start
from gspcli.solver.study_systems import coefficients_at, side_choices

Complex = NDArray[np.complex128]

#: At most this part of the poses is a few.
_FEW = 0.02
#: Whose equations are each one quadric that depends on e, e ^ f and f.f alone.
_REDUCIBLE = frozenset({DPP, DPH, DHP, *ANGLE_KINDS})


def proofs_of(instance: Instance, arrangement: Arrangement) -> ValueProofs | None:
    """Return what proves the ends of paths; None if they need other equations, or more digits."""
    if any(
        kind is DLL and not value
        for kind, value in zip(arrangement.kinds, arrangement.values.tolist(), strict=True)
    ):
        # Such lines meet, which is another equation.
        return None
    return ValueProofs.of(instance, None)


def is_reducible(arrangement: Arrangement) -> bool:
    """Return whether the equations can be solved for some unknowns first (`Shifts`)."""
    return _REDUCIBLE.issuperset(arrangement.kinds)


def proved_directly(proofs: ValueProofs, arrangement: Arrangement) -> PoseSet | None:
    """Return all poses, proved, by the quickest paths there are.

    None unless they are as many as the type has; and if an equation is a product or a mutual
    moment, or the geometry is special.
    """
    if not is_reducible(arrangement):
        return None
    structure, coefficients = coefficients_at(arrangement.normalized)
    given = coefficients.g[:, list(structure.order)]
    structure = structure.canonical()
    reference = reference_start(structure)
    if reference is not None:
        poses = _proved_from(reference.start, LONG_STEPS, given, proofs, arrangement)
        if poses is not None:
            return poses
    return _proved_from(start_system(structure), FROM_START, given, proofs, arrangement)


def _proved_from(
    start: StartSystem,
    options: TrackerOptions,
    given: Complex,
    proofs: ValueProofs,
    arrangement: Arrangement,
) -> PoseSet | None:
    """Return the poses at the ends of the paths from a start, if all are proved.

    Parameters
    ----------
    start, options
        See `ends_from_start`.
    given
        The quadrics for each combination of sides, shape (k, 6, 27).
    proofs, arrangement
        As for `proved_directly`.
    """
    ends = []
    for quadrics in given:
        points = ends_from_start(start, quadrics, options)
        if points is None:
            return None
        ends.append(points)
    frames = Frames.of(arrangement)
    poses = all_proved(proofs, arrangement, np.array(ends), frames)
    if poses is not None or options is not LONG_STEPS:
        return poses
    again = [followed_again(start, *each) for each in zip(given, ends, strict=True)]
    mended = [old if new is None else new for new, old in zip(again, ends, strict=True)]
    if all(new is None for new in again):
        return None
    return all_proved(proofs, arrangement, np.array(mended), frames)


def all_proved(
    proofs: ValueProofs,
    arrangement: Arrangement,
    points: Complex,
    frames: Frames,
    *,
    one_by_one: bool = False,
    basis: Basis = Basis.PATHS,
) -> PoseSet | None:
    """Return the poses at ends of paths (sides, paths, 8) in some frames if all are proved.

    A few that are not proved with all others are proved one by one, if that is asked for. The
    account rests on the paths unless something else is said.
    """
    choices = side_choices(arrangement)
    found = proofs.decide_own(choices, points, frames)
    count = found.certified.size
    if one_by_one and 0 < count - found.certified.sum() <= max(2, _FEW * count):
        from gspcli.certification.poses.remaining import with_remaining

        found = with_remaining(proofs, found)
    if not found.complete[0]:
        return None
    return PoseSet(
        quaternions=found.quaternions[0],
        R=found.R[0],
        T=found.T[0],
        real=found.real[0],
        certified=found.certified[0],
        multiplicity=np.ones(count, np.int64),
        motions=(),
        account=PathAccount(expected=count, found=count, basis=basis),
        proof=Proof(Ground.TYPE),
        signs=on_sides(choices, count),
    )
