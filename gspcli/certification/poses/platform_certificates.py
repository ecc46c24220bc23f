"""Certificates of poses, also where the lines of a DLL are parallel, at every pose or at some.

Three proofs are tried: of the equations; of the equations with points for lines that are parallel
at every pose; and, for lines that happen to be parallel, by all poses of the platform.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.counting import by_points, with_points_for_lines
from gspcli.certification.poses.certificates import Certificate, Certificates, Outcome
from gspcli.certification.poses.parallel_poses import Complex, nearly_parallel, where_parallel
from gspcli.certification.poses.pose_proofs import certify_equations
from gspcli.defaults import MAX_PRECISION, TOLERANCE
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.residuals import sides_of

#: The sides of planes, and which lines are parallel.
Part = tuple[tuple[int, ...], tuple[int, ...]]
#: The outcomes of solutions that are not isolated.
_SINGULAR = (Outcome.NOT_ISOLATED, Outcome.NOT_AS_STATED)


def certify(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    sides: ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    max_precision: int = MAX_PRECISION,
    solve: Callable[[Instance], tuple[Complex, Complex] | None] | None = None,
) -> Certificates:
    """Prove what can be proved about approximate solutions of an instance.

    A candidate is certified if it is proved that a solution differs from it by at most the
    tolerance, is simple, and is the only one in a ball about it. The numbers of the instance
    are taken exactly. The precision is doubled until everything is decided or the limit
    is reached. Multiple solutions, and points of solution curves, can never be certified.

    Parameters
    ----------
    instance
        The instance.
    R
        Rotations, real or complex, shape (n, 3, 3).
    T
        Translations in length units, real or complex, shape (n, 3).
    sides
        For each pose and constraint 1 or -1 for the side of its plane that is meant, 0 where
        nothing is said, shape (n, 6). Two poses whose doubles are the same may be on both sides of
        a plane; where the pose itself tells the side this is not believed.
    tolerance
        Largest difference of a candidate from its solution in any entry of R, and of T divided by
        `Certificate.length`; relative to the largest of them if that exceeds one. If the
        coordinates of a body are far from its origin, T is that of frames near the bodies
        (`LocalFrames`): the tolerance does not grow with the offset.
    max_precision
        Largest number of bits to work with.
    solve
        Returns all poses of an instance, R and T, if they are proved to be all. Called only if
        candidates stay open at which the lines of a DLL may be parallel; without it they stay open.

    Returns
    -------
    Certificates
        One certificate for each candidate, and how many different solutions they prove.

    Raises
    ------
    ArgumentError
        If an argument is of another sort or shape. Candidates that are not finite are only not
        certified.
    """
    proof = partial(certify_equations, tolerance=tolerance, max_precision=max_precision)
    found = proof(instance, R, T, sides=sides)
    if DLL not in (row.kind for row in instance.constraints):
        return found
    rotations = np.asarray(R, complex).reshape(-1, 3, 3)
    translations = np.asarray(T, complex).reshape(-1, 3)
    items = list(found)
    by_sides: dict[tuple[int, ...], list[int]] = defaultdict(list)
    for (signs, _), places in _parts(instance, rotations, translations, _open(items)).items():
        by_sides[signs] = sorted(by_sides[signs] + places)
    for signs, places in by_sides.items():
        same = with_points_for_lines(instance.on_sides(signs))
        if same is not None:
            proved = proof(same, rotations[places], translations[places])
            for place, item in zip(places, proved, strict=True):
                items[place] = _numbered(item, places, same)
    parts = _parts(instance, rotations, translations, _open(items))
    if solve is not None and parts and (known := solve(instance)) is not None:
        _compare(items, instance, parts, (rotations, translations), known, proof)
    return Certificates(tuple(items), found.scale, found.least_length)


def _open(items: Sequence[Certificate]) -> NDArray[np.intp]:
    """Return the candidates that seem not to be isolated."""
    return np.flatnonzero([item.outcome in _SINGULAR for item in items])


def _compare(
    items: list[Certificate],
    instance: Instance,
    parts: Mapping[Part, list[int]],
    candidates: tuple[Complex, Complex],
    known: tuple[Complex, Complex],
    proof: Callable[..., Certificates],
) -> None:
    """Certify candidates that approximate the same solutions as known poses with parallel lines.

    Balls never prove that lines are exactly parallel; the count of the known poses does.
    """
    among = _parts(instance, *known, np.arange(len(known[1])))
    for (signs, lines), places in parts.items():
        poses = np.array(among.get((signs, lines), []), np.intp)
        chosen = instance.on_sides(signs)
        poses = poses[where_parallel(chosen, lines, *(part[poses] for part in known))]
        same = by_points(chosen, lines)
        both = (
            np.concatenate((a[poses], b[places])) for a, b in zip(known, candidates, strict=True)
        )
        proved = proof(same, *both)
        first: dict[int, int] = {}
        for place, item in zip(places, proved[len(poses) :], strict=True):
            pose = item.same_as
            if pose is not None and pose < len(poses):
                items[place] = replace(
                    item, same_as=first.get(pose), unresolved=(), equivalent=same
                )
                first.setdefault(pose, place)


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


def _numbered(item: Certificate, places: list[int], same: Instance) -> Certificate:
    """Return a certificate of some of the candidates, by an equivalent instance."""
    return replace(
        item,
        same_as=None if item.same_as is None else places[item.same_as],
        unresolved=tuple(places[k] for k in item.unresolved),
        equivalent=same,
    )
