"""Certificates of poses, also where the lines of a DLL are parallel at every pose."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.counting import with_points_for_lines
from gspcli.certification.poses.certificates import Certificate, Certificates, Outcome
from gspcli.certification.poses.parallel_poses import Complex, nearly_parallel
from gspcli.certification.poses.pose_proofs import certify_equations
from gspcli.defaults import MAX_PRECISION, TOLERANCE
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.residuals import sides_of

#: The outcomes of solutions that are not isolated.
SINGULAR = (Outcome.NOT_ISOLATED, Outcome.NOT_AS_STATED)


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
    singular = np.array([item.outcome in SINGULAR for item in found], bool)
    if DLL not in (row.kind for row in instance.constraints) or not singular.any():
        return found
    rotations = np.asarray(R, complex).reshape(-1, 3, 3)
    translations = np.asarray(T, complex).reshape(-1, 3)
    chosen = np.flatnonzero(singular & nearly_parallel(instance, rotations).any(axis=1))
    items = list(found)
    for signs, places in _by_sides(instance, rotations, translations, chosen).items():
        same = with_points_for_lines(instance.on_sides(signs))
        if same is not None:
            proved = proof(same, rotations[places], translations[places])
            for place, item in zip(places, proved, strict=True):
                items[place] = _numbered(item, places, same)
    return Certificates(tuple(items), found.scale, found.least_length)


def _by_sides(
    instance: Instance, R: Complex, T: Complex, chosen: NDArray[np.intp]
) -> dict[tuple[int, ...], list[int]]:
    """Return the poses chosen by the sides on which they are."""
    if not len(chosen):
        return {}
    found = defaultdict(list)
    sides = sides_of(Arrangement.of(instance), R[chosen], T[chosen])
    for place, signs in zip(chosen.tolist(), sides.tolist(), strict=True):
        found[tuple(signs)].append(place)
    return found


def _numbered(item: Certificate, places: list[int], same: Instance) -> Certificate:
    """Return a certificate of some of the candidates, by an equivalent instance."""
    return replace(
        item,
        same_as=None if item.same_as is None else places[item.same_as],
        unresolved=tuple(places[k] for k in item.unresolved),
        equivalent=same,
    )
