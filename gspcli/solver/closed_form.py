"""All poses of a platform with three distances and three angles (Algorithm 6.6).

First the rotations, then for each the translations, in batches. Nothing is assumed about the
position of the frames or the primitives, but that everything is in general position: by Bezout's
theorem there are no other poses then. What is not in general position is not answered here.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby, islice

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.types import MAX_ANGLES
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.distance_forms import Measures, measures
from gspcli.geometry.quaternions import (
    canonical_sign,
    quaternion_product,
    rotation_from_quaternion,
    unit_quaternion,
)
from gspcli.geometry.surfaces import certainly_not_zero, generic_positions, surfaces
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.rotations import Rotations, angle_forms, rotations

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: How many sets of values are solved together.
_BATCH = 64
#: Squared sine below which a batch is not trusted.
_NEARLY_PARALLEL = 1e-6
_EPS = float(np.finfo(float).eps)
#: Half the product of a translation, as a quaternion, and a quaternion e is linear in both: the
#: part for component j of e, row i of T and column k, shape (4, 12).
_HALVED_PRODUCT = quaternion_product(np.eye(4)[1:], np.eye(4)[:, None]).reshape(4, 12) / 2


def solve_closed_form(arrangement: Arrangement) -> PoseSet | None:
    """Return all poses of a 3D3A platform, None if it is not in general position.

    Raises
    ------
    ValueError
        If the arrangement has not three angles.
    """
    return next(solve_closed_forms(arrangement, arrangement.values[None]))


def solve_closed_forms(arrangement: Arrangement, values: Array) -> Iterator[PoseSet | None]:
    """Yield all poses of one geometry with each of many sets of values, in order.

    Parameters
    ----------
    arrangement
        The geometry and the sides; its own values are not used.
    values
        Shape (b, 6), in the units of the instance.

    Yields
    ------
    None for sets of values with which something is not in general position.

    Raises
    ------
    ValueError
        If the arrangement has not three angles.
    """
    if len(arrangement.angles) != MAX_ANGLES:
        message = f"the closed form needs three angles, not {len(arrangement.angles)}"
        raise ValueError(message)
    distances = arrangement.distances
    # A distance of zero has one sign: it changes the structure.
    for _, group in groupby(values, key=lambda row: tuple(row[distances] == 0)):
        while batch := list(islice(group, _BATCH)):
            yield from _solve_batch(arrangement, np.array(batch))


def general_ends(arrangement: Arrangement) -> Complex | None:
    """Return Study points of all poses, in the frames and the unit of ``arrangement.normalized``.

    Returns
    -------
    Complex or None
        Of any norm, shape (n, 8), as many as a 3D3A platform of these kinds has in general; None
        unless all rotations and the surfaces of all of them are in general position.
    """
    given = arrangement.normalized
    angles, shapes = given.angles, measures(given)
    cosines = arrangement.cosines(arrangement.values)
    turned = rotations(angle_forms(given.u[angles], given.v[angles], cosines)[None])
    e = turned.e
    T, good = _translations(shapes, given.values[given.distances][None], turned)
    if not (len(e) and good.all()):
        return None
    ends = np.empty((*T.shape[:2], 8), complex)
    ends[..., :4] = e[:, None]
    ends[..., 4:] = T @ (e @ _HALVED_PRODUCT).reshape(-1, 3, 4)
    return np.concatenate((ends, ends[~turned.real].conj())).reshape(-1, 8)


def _solve_batch(arrangement: Arrangement, values: Array) -> Iterator[PoseSet | None]:
    """Yield the poses for sets of values in which the same distances are zero."""
    length = arrangement.length_with(values)
    distances = values[:, arrangement.distances] / length
    given = arrangement.with_values(values[0]).in_units_of(length)
    angles = given.angles
    shapes = measures(given)
    turned = rotations(angle_forms(given.u[angles], given.v[angles], given.cosines(values)))
    e, real = turned.e, turned.real
    q, R = unit_quaternion(e), rotation_from_quaternion(e)
    T, good = _translations(shapes, distances, turned)
    end = 0
    for count in turned.counts.tolist():
        begin, end = end, end + count
        here = slice(begin, end)
        if count and good[here].all():
            yield _poses(arrangement, q[here], R[here], T[here], real[here], length)
        else:
            yield None


def _poses(
    arrangement: Arrangement,
    q: Complex,
    R: Complex,
    T: Complex,
    real: NDArray[np.bool_],
    length: float,
) -> PoseSet:
    """Return the poses at rotations, and their conjugates at those that are not real.

    Parameters
    ----------
    arrangement, length
        The platform, and the unit of length of the translations.
    q, R, T, real
        Quaternions with ``e.e = 1``, rotations, the translations at each, and which rotations are
        real: (f, 4), (f, 3, 3), (f, s p, 3), (f,).
    """
    index = np.arange(len(T)).repeat(T.shape[1])
    q, R, T, paired = q[index], R[index], T.reshape(-1, 3), ~real[index]
    real = real[index] & ~T.imag.any(axis=1)
    q, R, T = (np.concatenate((part, part[paired].conj())) for part in (q, R, T))
    number = len(R)
    return PoseSet(
        quaternions=canonical_sign(q),
        R=R,
        T=arrangement.restored(R, T, length),
        real=np.concatenate((real, real[paired])),
        certified=np.zeros(number, bool),
        multiplicity=np.ones(number, int),
        motions=(),
        account=PathAccount(expected=number, found=number, basis=Basis.COUNT),
    )


def _translations(
    shapes: Measures, distances: Array, turned: Rotations
) -> tuple[Complex, NDArray[np.bool_]]:
    """Return the translations at rotations, (f, s p, 3), and which rotations are solved, (f,).

    Parameters
    ----------
    shapes
        What the distances measure.
    distances
        Of each set of values, shape (b, 3).
    turned
        The f rotations.
    """
    given = surfaces(shapes, turned.e, np.repeat(distances, turned.counts, axis=0))
    X, errors, ok = generic_positions(given, turned.errors + _EPS, turned.real)
    finite = certainly_not_zero(X[..., 0], errors)
    good = (ok & finite.all(axis=2)).all(axis=1) & (given.skewness > _NEARLY_PARALLEL)
    t = X[..., 1:] * (1 / np.where(finite, X[..., 0], 1))[..., None]
    T: Complex = t.reshape(len(t), t.shape[1] * t.shape[2], 3) @ np.swapaxes(given.frame, -1, -2)
    return T, good
