"""Which of many poses of an instance are proved, and which are proved to be real."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.equations import study
from gspcli.certification.equations.frames import OWN
from gspcli.certification.poses.collection import Collection
from gspcli.certification.poses.locator import Locator
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.defaults import TOLERANCE
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Line
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.residuals import sides_of

Complex = NDArray[np.complex128]
#: Squared sine (of complex lines the bilinear one) below which lines are too nearly parallel for
#: double precision.
_PARALLEL = 1e-4


class Decisions(NamedTuple):
    """Answers for n poses.

    Attributes
    ----------
    certified
        Whether exactly one simple solution is proved to be within the tolerance, different from
        those near the other certified poses, and proved to be real or not to be; shape (n,).
    real
        Whether it is proved to be real, shape (n,).
    R, T, quaternions
        The poses, the certified ones rounded correctly; (n, 3, 3), (n, 3), (n, 4).
    """

    certified: NDArray[np.bool_]
    real: NDArray[np.bool_]
    R: Complex
    T: Complex
    quaternions: Complex


# What is no rotation has no quaternion: it is not certified.
@np.errstate(all="ignore")
def decide(instance: Instance, R: ArrayLike, T: ArrayLike) -> Decisions:
    """Certify the poses of an instance, and decide which are real.

    Most are proved by the kernel, many at a time; the others in balls. Poses that are not proved
    to be different count once.

    Parameters
    ----------
    instance, R, T
        As for `certify`.
    """
    rotations = np.array(R, dtype=np.complex128).reshape(-1, 3, 3)
    translations = np.array(T, dtype=np.complex128).reshape(-1, 3)
    count = len(rotations)
    found = Decisions(
        np.zeros(count, np.bool_),
        np.zeros(count, np.bool_),
        rotations,
        translations,
        quaternion_from_rotation(rotations).astype(complex),
    )
    if count:
        locator, proofs = Locator(instance, OWN), ValueProofs.of(instance, None)
        arrangement = Arrangement.of(instance)
        signs = sides_of(arrangement, rotations, translations)
        for choice in np.unique(signs, axis=0):
            chosen = np.flatnonzero((signs == choice).all(axis=1))
            _decide_side(locator, proofs, choice, chosen, found, arrangement.length)
    return found


def _decide_side(
    locator: Locator,
    proofs: ValueProofs | None,
    choice: NDArray[np.int64],
    chosen: NDArray[np.intp],
    found: Decisions,
    length: float,
) -> None:
    """Decide about those of the poses that are on some sides."""
    points, _ = study.study_points(found.R[chosen], found.T[chosen])
    sides = locator.sides(choice.tolist())
    collection = Collection(locator, sides)
    places = np.full(len(chosen), -1)
    if proofs is not None:
        signs = np.where(choice == 0, 1.0, choice)
        proved = proofs.decide_own(signs[None], points[None], OWN)
        known = (proved.certified & proved.rounded)[0]
        R, T, quaternions, real, off = (
            part[0][known]
            for part in (
                proved.R,
                proved.T,
                proved.quaternions,
                proved.real,
                proved.deviation,
            )
        )
        places[known] = collection.add_proved(R, T, quaternions, real, off)
    for k in np.flatnonzero(places < 0).tolist():
        if collection.add(locator.locate(points[k : k + 1], None, sides)):
            places[k] = len(collection) - 1
    first = np.unique(places, return_index=True)[1]
    kept = first[places[first] >= 0]
    index, place = chosen[kept], places[kept]
    # What Newton's method has moved farther was no approximation of it.
    turned = np.abs(collection.R[place] - found.R[index]).max(axis=(1, 2), initial=0)
    moved = np.abs(collection.T[place] - found.T[index]).max(axis=1, initial=0)
    size = np.maximum(1, np.abs(found.R[index]).max(axis=(1, 2), initial=0))
    near = np.maximum(turned, moved / length) <= TOLERANCE * size
    index, place = index[near], place[near]
    found.certified[index] = True
    found.real[index] = collection.real[place]
    found.R[index], found.T[index] = collection.R[place], collection.T[place]
    found.quaternions[index] = collection.quaternions[place]


def nearly_parallel(instance: Instance, R: Complex) -> NDArray[np.bool_]:
    """Return at which poses the lines of which DLL are nearly parallel, shape (n, 6).

    There its equation holds whatever their distance, so that the constraint is to be measured.
    """
    nearly = np.zeros((len(R), len(instance.constraints)), bool)
    for k, constraint in enumerate(instance.constraints):
        line, other = constraint.platform, constraint.base
        if constraint.kind is DLL and isinstance(line, Line) and isinstance(other, Line):
            normal = np.cross(R @ line.unit, other.unit)
            sizes = 1 + np.abs(R).max(axis=(1, 2)) ** 2
            nearly[:, k] = np.abs((normal**2).sum(axis=1)) <= _PARALLEL * sizes
    return nearly
