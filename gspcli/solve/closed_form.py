"""All poses of a platform with three distances and three angles (Algorithm 6.6).

First the rotations, then for each the translations. Nothing is assumed about the position of
the frames or the primitives. Systems in general position are solved in batches; those whose
answer is not certain are solved again one by one with everything that can happen in mind.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import groupby, islice

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import MAX_ANGLES
from gspcli.geometry.poses import Field, apply, cross
from gspcli.geometry.residuals import Arrangement
from gspcli.geometry.surfaces import (
    generic_positions,
    intersection,
    intersection_number,
    surface_counts,
    surfaces,
)
from gspcli.solve.motion import Motion, local_motion
from gspcli.solve.poses import PoseSet
from gspcli.solve.rotations import ROTATIONS, RotationGroup, rotations

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.int64]

#: How many sets of values are solved together.
_BATCH = 64
#: Sine of the angle of two lines below which they are parallel.
_PARALLEL = 1e-9
#: Squared sine below which a batch is not trusted.
_NEARLY_PARALLEL = 1e-6
#: Forms X of norm 1 with a smaller first coordinate are at infinity.
_INFINITY = 1e-12
#: About how many samples of infinite sets are examined for motions.
_SAMPLES = 8
#: Error of rotations on components.
_SAMPLE_ACCURACY = 1e-12
_EPS = float(np.finfo(float).eps)
#: Translations nearer than this are one, found for two signs of a distance that do not differ.
_SAME = 1e-10


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
    inner = values.copy()
    inner[:, arrangement.distances] /= length
    given = arrangement.with_values(values[0]).in_units_of(length)
    angles = given.angles
    turned = rotations(given.u[angles], given.v[angles], given.cosines(values))
    real = _translated(given, inner, [rotation.real.R for rotation in turned])
    upper = _translated(given, inner, [rotation.upper.R for rotation in turned])
    each = generic_count(given) // ROTATIONS
    for k, rotation in enumerate(turned):
        ledger = _Ledger(given, inner[k], each)
        ledger.add_rotations(rotation.real, real[k])
        ledger.add_rotations(rotation.upper, upper[k])
        for R in rotation.samples:
            ledger.add_sample(R)
        ledger.at_infinity += each * rotation.at_infinity
        ledger.lost += each * rotation.lost
        yield ledger.poses(arrangement, values[k], length)


#: Forms X, which of them are finite, and which rotations are solved: (f, s, p, 4), (f, s, p), (f,).
_Points = tuple[Field, NDArray[np.bool_], NDArray[np.bool_]]


def _translated(given: Arrangement, values: Array, rotations: list[Field]) -> list[_Points]:
    """Return the quick solutions for the rotations of each set of values."""
    counts = [len(R) for R in rotations]
    R = np.concatenate(rotations)
    shapes = surfaces(given, R, np.repeat(values[:, given.distances], counts, axis=0))
    X, errors, ok = generic_positions(shapes)
    good = ok.all(axis=1) & (shapes.skewness > _NEARLY_PARALLEL)
    finite = np.abs(X[..., 0]) > np.maximum(_INFINITY, 100 * errors)
    finite[~good] = False
    ends = np.cumsum(counts)
    return [
        (X[end - count : end], finite[end - count : end], good[end - count : end])
        for count, end in zip(counts, ends, strict=True)
    ]


class _Ledger:
    """Collects poses in the unit of length of a batch, and counts what became of every path."""

    def __init__(self, geometry: Arrangement, values: Array, each: int) -> None:
        self.geometry = geometry
        self.values = values
        self.each = each
        self.isolated: list[tuple[Field, Field, NDArray[np.bool_], Index]] = []
        self.samples: list[tuple[Field, Field]] = []
        self.at_infinity = self.on_curves = self.lost = 0

    @cached_property
    def given(self) -> Arrangement:
        """The arrangement with its own values; only special positions ask for it."""
        return self.geometry.with_values(self.values)

    def add_rotations(self, group: RotationGroup, points: _Points) -> None:
        """Add the poses of isolated rotations; of complex ones the conjugate poses as well."""
        R, multiplicity = group.R, group.multiplicity
        X, finite, good = points
        which = finite.nonzero()[0]
        X = X[finite]
        is_complex = np.iscomplexobj(R)
        real = np.zeros(len(X), bool) if is_complex else ~(X.imag != 0).any(axis=-1)
        self._add(R[which], X[:, 1:] / X[:, :1], real, multiplicity[which])
        missing = self.each * multiplicity[good].sum() - multiplicity[which].sum()
        self.at_infinity += (1 + is_complex) * int(missing)
        for f in (~good).nonzero()[0]:
            self._add_carefully(R[f], int(multiplicity[f]), float(group.errors[f]))

    def _add(self, R: Field, T: Field, real: NDArray[np.bool_], multiplicity: Index) -> None:
        self.isolated.append((R, T, real, multiplicity))
        if np.iscomplexobj(R):
            self.isolated.append((R.conj(), T.conj(), real, multiplicity))

    def _add_carefully(self, R: Field, multiplicity: int, accuracy: float) -> None:
        """Add the poses of one isolated rotation, whatever the position of its surfaces."""
        T, counts, samples, lost = _translations(self.given, R, accuracy)
        real = np.zeros(len(T), bool)
        weight = multiplicity * (2 if np.iscomplexobj(R) else 1)
        if not np.iscomplexobj(R):
            distances = np.abs(T.conj()[:, None] - T).sum(axis=-1)
            real = distances.argmin(axis=1) == np.arange(len(T)) if len(T) else real
            T = np.where(real[:, None], T.real, T)
        count = len(T)
        self._add(np.repeat(R[None], count, 0), T, real, counts * multiplicity)
        self.samples += [(R, point) for point in samples]
        rest = max(0, self.each - int(counts.sum()) - lost)
        on_curves = min(len(samples), rest)
        self.at_infinity += weight * (rest - on_curves)
        self.on_curves += weight * on_curves
        self.lost += weight * lost

    def add_sample(self, R: Field) -> None:
        """Add the poses of one rotation on a positive-dimensional set of rotations.

        If there are none, there may still be poses at special rotations of the set. They are
        not looked for.
        """
        T, _, samples, lost = _translations(self.given, R, _SAMPLE_ACCURACY)
        found = [*T, *samples]
        self.samples += [(R, point) for point in found]
        on_curves = min(len(found), self.each)
        self.on_curves += on_curves
        if found:
            self.lost += lost
            self.at_infinity += self.each - on_curves - lost
        else:
            self.lost += self.each

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


def _translations(
    given: Arrangement, R: Field, accuracy: float
) -> tuple[Complex, Index, Complex, int]:
    """Return the points T, their multiplicities, samples of components, and how many are lost.

    The accuracy is the error of the rotation.
    """
    pairs = [i for i in given.distances if given.kinds[i] is DLL]
    normals = cross(apply(R, given.u[pairs]), given.v[pairs])
    sines = np.linalg.norm(normals, axis=-1)
    parallel = [i for i, sine in zip(pairs, sines, strict=True) if sine < _PARALLEL]
    shapes = surfaces(given, R[None], parallel=parallel)
    points: list[Complex] = []
    counts: list[int] = []
    samples: list[Complex] = []
    lost = 0
    near = max(_SAME, 10 * accuracy)
    for signs in shapes.signs:
        planes = shapes.planes[0].copy()
        planes[:, 0] -= signs * shapes.distances
        meet = intersection(planes, shapes.quadrics[0], max(accuracy, _EPS))
        samples += list(meet.samples)
        lost += meet.lost
        for T, multiplicity in zip(meet.points, meet.multiplicity, strict=True):
            same = [k for k, other in enumerate(points) if np.abs(T - other).max() < near]
            if same:
                counts[same[0]] += int(multiplicity)
            else:
                points.append(T)
                counts.append(int(multiplicity))
    return (
        np.array(points, complex).reshape(-1, 3),
        np.array(counts, int),
        np.array(samples, complex).reshape(-1, 3),
        lost,
    )
