"""All poses of a platform with three distances and three angles (Algorithm 6.6).

First the rotations, then for each the translations. Nothing is assumed about the position of
the frames or the primitives. Systems in general position are solved in batches; those whose
answer is not certain are solved again one by one with everything that can happen in mind.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
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
from gspcli.solve.rotations import ROTATIONS, rotations

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.int64]

#: Sine of the angle of two lines below which they are parallel.
_PARALLEL = 1e-9
#: Squared sine below which a batch is not trusted.
_NEARLY_PARALLEL = 1e-6
#: Forms X of norm 1 with a smaller first coordinate are at infinity.
_INFINITY = 1e-12
#: Translations nearer than this are one, found for two signs of a distance that do not differ.
_SAME = 1e-10


def generic_count(arrangement: Arrangement) -> int:
    """Return the generic number of complex poses for the sides asked for (Theorem 6.9).

    Each line-line distance has two signs, and so has each distance to a plane without a side.
    """
    count = ROTATIONS * intersection_number(*surface_counts(arrangement.kinds))
    for i in arrangement.distances:
        kind, value, side = arrangement.kinds[i], arrangement.values[i], arrangement.sides[i]
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
    given = arrangement.normalised
    angles = given.angles
    if len(angles) != 3:
        message = f"the closed form needs three angles, not {len(angles)}"
        raise ValueError(message)
    turned = rotations(given.u[angles], given.v[angles], given.cosines)
    each = generic_count(given) // ROTATIONS
    ledger = _Ledger(each)
    ledger.add_rotations(given, turned.real, turned.real_multiplicity)
    ledger.add_rotations(given, turned.upper, turned.upper_multiplicity)
    for R in turned.samples:
        ledger.add_sample(given, R)
    ledger.at_infinity += each * turned.at_infinity
    ledger.lost += each * turned.lost
    return ledger.poses(arrangement)


class _Ledger:
    """Collects poses of a normalised arrangement and counts what became of every path."""

    def __init__(self, each: int) -> None:
        self.each = each
        self.isolated: list[tuple[Field, Field, NDArray[np.bool_], Index]] = []
        self.samples: list[tuple[Field, Field]] = []
        self.at_infinity = self.on_curves = self.lost = 0

    def add_rotations(self, given: Arrangement, R: Field, multiplicity: Index) -> None:
        """Add the poses of isolated rotations; of complex ones the conjugate poses as well."""
        if not len(R):
            return
        both = 2 if np.iscomplexobj(R) else 1
        shapes = surfaces(given, R)
        X, errors, ok = generic_positions(shapes)
        good = ok.all(axis=1) & (shapes.skewness > _NEARLY_PARALLEL)
        finite = np.abs(X[..., 0]) > np.maximum(_INFINITY, 100 * errors)
        finite[~good] = False
        which = finite.nonzero()[0]
        points = X[finite]
        real = ~(points.imag != 0).any(axis=-1) if both == 1 else np.zeros(len(points), bool)
        self._add(R[which], points[:, 1:] / points[:, :1], real, multiplicity[which])
        paths = both * multiplicity
        self.at_infinity += int(self.each * paths[good].sum() - both * multiplicity[which].sum())
        for f in (~good).nonzero()[0]:
            self._add_carefully(given, R[f], int(multiplicity[f]), both)

    def _add(self, R: Field, T: Field, real: NDArray[np.bool_], multiplicity: Index) -> None:
        self.isolated.append((R, T, real, multiplicity))
        if np.iscomplexobj(R):
            self.isolated.append((R.conj(), T.conj(), real, multiplicity))

    def _add_carefully(self, given: Arrangement, R: Field, multiplicity: int, both: int) -> None:
        """Add the poses of one isolated rotation, whatever the position of its surfaces."""
        T, counts, samples, lost = _translations(given, R)
        real = np.zeros(len(T), bool)
        if both == 1:
            distances = np.abs(T.conj()[:, None] - T).sum(axis=-1)
            real = distances.argmin(axis=1) == np.arange(len(T)) if len(T) else real
            T = np.where(real[:, None], T.real, T)
        count = len(T)
        self._add(np.repeat(R[None], count, 0), T, real, counts * multiplicity)
        self.samples += [(R, point) for point in samples]
        on_curves = len(samples)
        rest = max(0, self.each - int(counts.sum()) - on_curves - lost)
        self.at_infinity += both * multiplicity * rest
        self.on_curves += both * multiplicity * on_curves
        self.lost += both * multiplicity * lost

    def add_sample(self, given: Arrangement, R: Field) -> None:
        """Add the poses of one rotation on a positive-dimensional set of rotations.

        If there are none, there may still be poses at special rotations of the set. They are
        not looked for.
        """
        T, _, samples, lost = _translations(given, R)
        found = [*T, *samples]
        self.samples += [(R, point) for point in found]
        on_curves = min(len(found), self.each)
        self.on_curves += on_curves
        if found:
            self.lost += lost
            self.at_infinity += self.each - on_curves - lost
        else:
            self.lost += self.each

    def poses(self, arrangement: Arrangement) -> PoseSet:
        """Return everything in the frames of the arrangement."""
        R = np.concatenate([np.zeros((0, 3, 3), complex), *(part[0] for part in self.isolated)])
        T = np.concatenate([np.zeros((0, 3), complex), *(part[1] for part in self.isolated)])
        return PoseSet(
            R=R,
            T=arrangement.restored(R, T),
            real=np.concatenate([np.zeros(0, bool), *(part[2] for part in self.isolated)]),
            multiplicity=np.concatenate([np.zeros(0, int), *(part[3] for part in self.isolated)]),
            motions=self._motions(arrangement),
            paths=ROTATIONS * self.each,
            at_infinity=self.at_infinity,
            on_curves=self.on_curves,
            lost=self.lost,
        )

    def _motions(self, arrangement: Arrangement) -> tuple[Motion, ...]:
        """Return the largest motion through a sample, a real one if there is any."""
        found = []
        for R, T in self.samples:
            motion = local_motion(arrangement, R, arrangement.restored(R, T))
            if motion is not None:
                found.append(motion)
                if motion.real:
                    break
        found.sort(key=lambda motion: (not motion.real, -motion.dimension))
        return tuple(found[:1])


def _translations(given: Arrangement, R: Field) -> tuple[Complex, Index, Complex, int]:
    """Return the points T, their multiplicities, samples of components, and how many are lost."""
    pairs = [i for i in given.distances if given.kinds[i] is DLL]
    normals = cross(apply(R, given.u[pairs]), given.v[pairs])
    sines = np.linalg.norm(normals, axis=-1)
    parallel = [i for i, sine in zip(pairs, sines, strict=True) if sine < _PARALLEL]
    shapes = surfaces(given, R[None], parallel=parallel)
    points: list[Complex] = []
    counts: list[int] = []
    samples: list[Complex] = []
    lost = 0
    for signs in shapes.signs:
        planes = shapes.planes[0].copy()
        planes[:, 0] -= signs * shapes.distances
        meet = intersection(planes, shapes.quadrics[0])
        samples += list(meet.samples)
        lost += meet.lost
        for T, multiplicity in zip(meet.points, meet.multiplicity, strict=True):
            same = [k for k, other in enumerate(points) if np.abs(T - other).max() < _SAME]
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
