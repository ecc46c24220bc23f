"""All poses of a platform with three distances and three angles (Algorithm 6.6).

First the rotations, then for each the translations. Nothing is assumed about the position of
the frames or the primitives. Systems in general position are solved in batches; those whose
answer is not certain are solved again one by one with everything that can happen in mind.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby, islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import MAX_ANGLES
from gspcli.geometry.measures import Measures, measures
from gspcli.geometry.poses import Field, apply, cross, dot, rotation_from_quaternion
from gspcli.geometry.residuals import Arrangement
from gspcli.geometry.surfaces import (
    certainly_not_zero,
    generic_positions,
    intersection,
    intersection_number,
    surface_counts,
    surfaces,
)
from gspcli.solve.infinity import finite_pose
from gspcli.solve.motion import Motion, local_motion
from gspcli.solve.poses import PoseSet
from gspcli.solve.rotations import ROTATIONS, RotationGroup, angle_forms, rotations

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.int64]

#: How many sets of values are solved together.
_BATCH = 64
#: Lines are parallel if the sine of their angle is as good as zero: at most the first number.
#: They are not if it is at least the second, and in between nothing is said.
_PARALLEL, _SKEW = 1e-12, 1e-9
#: Squared sine below which a batch is not trusted.
_NEARLY_PARALLEL = 1e-6
#: Rotations with a smaller N (of a quaternion of norm one) are nearly infinite.
_NEARLY_NULL = 1e-3
#: About how many samples of infinite sets are examined for motions.
_SAMPLES = 8
#: Error of rotations on components.
_SAMPLE_ACCURACY = 1e-12
_EPS = float(np.finfo(float).eps)


def generic_count(arrangement: Arrangement) -> int:
    """Return the generic number of complex poses for the sides asked for (Theorem 6.9).

    Each line-line distance has two signs, and so has each distance to a plane without a side.
    """
    count = ROTATIONS * intersection_number(*surface_counts(arrangement.kinds))
    for i in arrangement.distances:
        kind, value, side = arrangement.kinds[i], arrangement.values[i], arrangement.signs[i]
        if (kind is DLL or (kind.has_sides and side == 0)) and value != 0:
            count *= 2
    return count


def solve_closed_form(arrangement: Arrangement) -> PoseSet:
    """Return all poses of a 3D3A platform.

    Raises
    ------
    ValueError
        If the arrangement has not three angles.
    """
    return next(solve_closed_forms(arrangement, arrangement.values[None]))


def solve_closed_forms(arrangement: Arrangement, values: Array) -> Iterator[PoseSet]:
    """Yield all poses of one geometry with each of many sets of values, in order.

    Parameters
    ----------
    arrangement
        The geometry and the sides; its own values are not used.
    values
        Shape (b, 6), in the units of the instance.

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


def _solve_batch(arrangement: Arrangement, values: Array) -> Iterator[PoseSet]:
    """Yield the poses for sets of values in which the same distances are zero."""
    length = arrangement.length_with(values)
    distances = values[:, arrangement.distances] / length
    given = arrangement.with_values(values[0]).in_units_of(length)
    angles = given.angles
    forms = angle_forms(given.u[angles], given.v[angles], given.cosines(values))
    turned = rotations(forms)
    shapes = measures(given)
    real = _translated(shapes, distances, [rotation.real for rotation in turned])
    upper = _translated(shapes, distances, [rotation.upper for rotation in turned])
    each = generic_count(given) // ROTATIONS
    for k, rotation in enumerate(turned):
        ledger = _Ledger(given, shapes, forms[k], distances[k], each)
        ledger.add_rotations(rotation.real, real[k])
        ledger.add_rotations(rotation.upper, upper[k])
        for e in rotation.samples:
            ledger.add_sample(e)
        ledger.at_infinity += each * rotation.at_infinity
        ledger.lost += each * rotation.lost
        yield ledger.poses(arrangement, values[k], length)


#: Rotations, translations, which of those there are, and which rotations are solved:
#: (f, 3, 3), (f, s p, 3), (f,).
_Points = tuple[Field, Field, NDArray[np.bool_]]


def _translated(shapes: Measures, distances: Array, groups: list[RotationGroup]) -> list[_Points]:
    """Return the quick solutions for the rotations of each set of values."""
    counts = [len(group.e) for group in groups]
    e = np.concatenate([group.e for group in groups])
    if not len(e):
        nothing = np.zeros((0, 3, 3), e.dtype)
        return [(nothing, nothing, np.zeros(0, bool)) for _ in groups]
    accuracy = np.concatenate([group.errors for group in groups])
    given = surfaces(shapes, e, np.repeat(distances, counts, axis=0))
    X, errors, ok = generic_positions(given, accuracy + _EPS)
    finite = certainly_not_zero(X[..., 0], errors)
    good = (ok & finite.all(axis=2)).all(axis=1) & (given.skewness > _NEARLY_PARALLEL)
    R = rotation_from_quaternion(e)
    t = X[..., 1:] / np.where(finite, X[..., 0], 1)[..., None]
    T = t.reshape(len(e), t.shape[1] * t.shape[2], 3) @ np.swapaxes(given.frame, -1, -2)
    ends = np.cumsum(counts)
    return [
        (R[end - count : end], T[end - count : end], good[end - count : end])
        for count, end in zip(counts, ends, strict=True)
    ]


class _Translations(NamedTuple):
    """What became of the points at one rotation.

    Translations and their multiplicities, samples of infinite sets, simple points that were
    examined and found to be at infinity, and how many are lost.
    """

    T: Complex
    multiplicity: Index
    samples: Complex
    at_infinity: int
    lost: int


class _Ledger:
    """Collects poses in the unit of length of a batch, and counts what became of every path."""

    def __init__(
        self, geometry: Arrangement, shapes: Measures, forms: Array, distances: Array, each: int
    ) -> None:
        self.geometry = geometry
        self.shapes = shapes
        self.forms = forms
        self.distances = distances
        self.each = each
        self.isolated: list[tuple[Field, Field, NDArray[np.bool_], Index]] = []
        self.samples: list[tuple[Field, Field]] = []
        self.at_infinity = self.on_curves = self.lost = 0

    def add_rotations(self, group: RotationGroup, points: _Points) -> None:
        """Add the poses of isolated rotations; of complex ones the conjugate poses as well."""
        R, T, good = points
        count = T.shape[1]
        multiplicity = np.repeat(group.multiplicity[good], count)
        T = T[good].reshape(-1, 3)
        is_complex = np.iscomplexobj(R)
        real = np.zeros(len(T), bool) if is_complex else ~(T.imag != 0).any(axis=-1)
        self._add(np.repeat(R[good], count, axis=0), T, real, multiplicity)
        if not good.all():
            for f in (~good).nonzero()[0]:
                self._add_carefully(
                    R[f], group.e[f], int(group.multiplicity[f]), float(group.errors[f])
                )

    def _add(self, R: Field, T: Field, real: NDArray[np.bool_], multiplicity: Index) -> None:
        self.isolated.append((R, T, real, multiplicity))
        if np.iscomplexobj(R):
            self.isolated.append((R.conj(), T.conj(), real, multiplicity))

    def _add_carefully(self, R: Field, e: Field, multiplicity: int, accuracy: float) -> None:
        """Add the poses of one isolated rotation, whatever the position of its surfaces."""
        weight = multiplicity * (2 if np.iscomplexobj(R) else 1)
        found = self._translations(e, accuracy, multiplicity == 1)
        T, counts = found.T, found.multiplicity
        lost, samples = found.lost, found.samples
        if abs(dot(e, e)) < _NEARLY_NULL:
            # Nothing but simple points can be told from the effects of a small N.
            simple = counts == 1
            T, counts, samples = T[simple], counts[simple], samples[:0]
            lost = self.each - len(T) - found.at_infinity
        real = np.zeros(len(T), bool)
        if not np.iscomplexobj(R):
            distances = np.abs(T.conj()[:, None] - T).sum(axis=-1)
            real = distances.argmin(axis=1) == np.arange(len(T)) if len(T) else real
            T = np.where(real[:, None], T.real, T)
        self._add(np.repeat(R[None], len(T), 0), T, real, counts * multiplicity)
        self.samples += [(R, point) for point in samples]
        rest = max(0, self.each - int(counts.sum()) - lost)
        on_curves = min(len(samples), rest)
        self.at_infinity += weight * (rest - on_curves)
        self.on_curves += weight * on_curves
        self.lost += weight * lost

    def add_sample(self, e: Field) -> None:
        """Add the poses of one rotation on a positive-dimensional set of rotations.

        If there are none, there may still be poses at special rotations of the set. They are
        not looked for.
        """
        found = self._translations(e, _SAMPLE_ACCURACY, False)
        points = [*found.T, *found.samples]
        R = rotation_from_quaternion(e)
        self.samples += [(R, point) for point in points]
        on_curves = min(len(points), self.each)
        self.on_curves += on_curves
        if points:
            self.lost += found.lost
            self.at_infinity += self.each - on_curves - found.lost
        else:
            self.lost += self.each

    def _translations(self, e: Field, accuracy: float, isolated: bool) -> _Translations:
        """Return the translations at a rotation whose error is known.

        Simple points that seem to be infinitely far are examined if the rotation is simple
        too; else they are at infinity as well as can be told.
        """
        given, accuracy = self.geometry, max(accuracy, _EPS)
        R = rotation_from_quaternion(e)
        pairs = np.array([i for i in given.distances if given.kinds[i] is DLL], int)
        sines = np.linalg.norm(cross(apply(R, given.u[pairs]), given.v[pairs]), axis=-1)
        parallel = pairs[sines <= _PARALLEL + 10 * accuracy].tolist()
        least = sines.min(initial=1, where=sines > _PARALLEL + 10 * accuracy)
        if least < _SKEW + 1e4 * accuracy:
            nowhere = np.zeros((0, 3), complex)
            return _Translations(nowhere, np.zeros(0, int), nowhere, 0, self.each)
        # Normals of planes are as accurate as the sines.
        accuracy /= least
        shapes = measures(given, parallel) if parallel else self.shapes
        there = surfaces(shapes, e[None], self.distances[None])
        frame = there.frame[0]
        points: list[Complex] = []
        counts: list[int] = []
        samples: list[Complex] = []
        at_infinity = lost = 0
        for signs in shapes.signs:
            planes = there.planes[0].copy()
            planes[:, 0] -= signs * there.offsets[0]
            meet = intersection(planes, there.quadrics[0], accuracy)
            points += list(meet.points @ frame.T)
            counts += meet.multiplicity.tolist()
            samples += list(meet.samples @ frame.T)
            lost += meet.lost
            for X in meet.distant if isolated else ():
                X = np.concatenate((X[:1], there.basis[0] @ X[1:]))
                pose = finite_pose(self.forms, shapes, signs, self.distances, e, X)
                if pose:
                    points.append(pose[1])
                    counts.append(1)
                at_infinity += pose is False
                lost += pose is None
        return _Translations(
            np.array(points, complex).reshape(-1, 3),
            np.array(counts, int),
            np.array(samples, complex).reshape(-1, 3),
            at_infinity,
            lost,
        )

    def poses(self, arrangement: Arrangement, values: Array, length: float) -> PoseSet:
        """Return everything in the frames and units of the arrangement with some values."""
        R = np.concatenate([np.zeros((0, 3, 3), complex), *(part[0] for part in self.isolated)])
        T = np.concatenate([np.zeros((0, 3), complex), *(part[1] for part in self.isolated)])
        return PoseSet(
            R=R,
            T=arrangement.restored(R, T, length),
            real=np.concatenate([np.zeros(0, bool), *(part[2] for part in self.isolated)]),
            multiplicity=np.concatenate([np.zeros(0, int), *(part[3] for part in self.isolated)]),
            motions=self._motions(arrangement, values, length),
            paths=ROTATIONS * self.each,
            at_infinity=self.at_infinity,
            on_curves=self.on_curves,
            lost=self.lost,
        )

    def _motions(
        self, arrangement: Arrangement, values: Array, length: float
    ) -> tuple[Motion, ...]:
        """Return the largest motion through a sample, a real one if there is any."""
        found = []
        moving = arrangement.with_values(values) if self.samples else arrangement
        spread = max(1, len(self.samples) // _SAMPLES)
        for R, T in self.samples[::spread]:
            motion = local_motion(moving, R, arrangement.restored(R, T, length))
            if motion is not None:
                found.append(motion)
                if motion.real:
                    break
        found.sort(key=lambda motion: (not motion.real, -motion.dimension))
        return tuple(found[:1])
