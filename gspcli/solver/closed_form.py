"""All poses of a platform with three distances and three angles (Algorithm 6.6).

First the rotations, then for each the translations. Nothing is assumed about the position of
the frames or the primitives. Systems in general position are solved in batches; those whose
answer is not certain are solved again one by one with everything that can happen in mind.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby, islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import MAX_ANGLES
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.distance_forms import Measures, measures
from gspcli.geometry.quaternions import (
    Field,
    apply,
    canonical_sign,
    cross,
    dot,
    quaternion_product,
    rotation_from_quaternion,
    unit_quaternion,
)
from gspcli.geometry.surfaces import (
    certainly_not_zero,
    generic_positions,
    intersection,
    surfaces,
)
from gspcli.solver.infinity import finite_pose
from gspcli.solver.pose_set import Motion, PoseSet
from gspcli.solver.rotations import Rotations, angle_forms, rotations
from gspcli.solver.self_motion import local_motion

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
#: Half the product of a translation, as a quaternion, and a quaternion e is linear in both: the
#: part for component j of e, row i of T and column k, shape (4, 12).
_HALVED_PRODUCT = quaternion_product(np.eye(4)[1:], np.eye(4)[:, None]).reshape(4, 12) / 2


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
    (turned,) = rotations(angle_forms(given.u[angles], given.v[angles], cosines)[None])
    if not turned.are_general:
        return None
    places = _places(shapes, given.values[given.distances][None], [turned])
    if not places.good.all():
        return None
    e, T = places.quaternions, places.T
    paired = ~turned.real
    e, T = np.concatenate((e, e[paired].conj())), np.concatenate((T, T[paired].conj()))
    ends = np.empty((*T.shape[:2], 8), complex)
    ends[..., :4] = e[:, None]
    ends[..., 4:] = T @ (e @ _HALVED_PRODUCT).reshape(-1, 3, 4)
    return ends.reshape(-1, 8)


def _solve_batch(arrangement: Arrangement, values: Array) -> Iterator[PoseSet]:
    """Yield the poses for sets of values in which the same distances are zero."""
    length = arrangement.length_with(values)
    distances = values[:, arrangement.distances] / length
    given = arrangement.with_values(values[0]).in_units_of(length)
    angles = given.angles
    forms = angle_forms(given.u[angles], given.v[angles], given.cosines(values))
    shapes = measures(given)
    turned = rotations(forms)
    ends = np.cumsum([len(rotation.e) for rotation in turned])
    places = _places(shapes, distances, turned)
    for k, rotation in enumerate(turned):
        ledger = _Ledger(given, shapes, forms[k], distances[k])
        ledger.add_rotations(rotation, places.of(slice(ends[k] - len(rotation.e), ends[k])))
        yield ledger.poses(arrangement, values[k], length)


class _Places(NamedTuple):
    """Where the platform is at some rotations, as far as their surfaces are in general position.

    Quaternions with ``e.e = 1``, rotations, translations, and which rotations have been solved:
    (f, 4), (f, 3, 3), (f, s p, 3), (f,).
    """

    quaternions: Complex
    R: Complex
    T: Complex
    good: NDArray[np.bool_]

    def of(self, k: slice) -> _Places:
        return _Places(self.quaternions[k], self.R[k], self.T[k], self.good[k])


def _places(shapes: Measures, distances: Array, turned: list[Rotations]) -> _Places:
    """Return the quick solutions for the rotations of each set of values, one after the other."""
    e = np.concatenate([rotation.e for rotation in turned])
    real = np.concatenate([rotation.real for rotation in turned])
    accuracy = np.concatenate([rotation.errors for rotation in turned])
    distances = np.repeat(distances, [len(rotation.e) for rotation in turned], axis=0)
    given = surfaces(shapes, e, distances)
    X, errors, ok = generic_positions(given, accuracy + _EPS, real)
    finite = certainly_not_zero(X[..., 0], errors)
    good = (ok & finite.all(axis=2)).all(axis=1) & (given.skewness > _NEARLY_PARALLEL)
    t = X[..., 1:] * (1 / np.where(finite, X[..., 0], 1))[..., None]
    T: Complex = t.reshape(len(e), t.shape[1] * t.shape[2], 3) @ np.swapaxes(given.frame, -1, -2)
    return _Places(unit_quaternion(e), rotation_from_quaternion(e), T, good)


class _Isolated(NamedTuple):
    """Isolated poses, arrays over them; quaternions of either sign."""

    quaternions: Complex
    R: Complex
    T: Complex
    real: NDArray[np.bool_]
    multiplicity: Index

    @classmethod
    def joined(cls, parts: list[_Isolated]) -> _Isolated:
        return cls(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


_NO_POSES = _Isolated(
    np.zeros((0, 4), complex),
    np.zeros((0, 3, 3), complex),
    np.zeros((0, 3), complex),
    np.zeros(0, bool),
    np.zeros(0, int),
)


class _Translations(NamedTuple):
    """What became of the points at one rotation.

    Translations and their multiplicities, samples of infinite sets, and the account.
    """

    T: Complex
    multiplicity: Index
    samples: Complex
    account: PathAccount


class _Ledger:
    """Collects poses in the unit of length of a batch, with the account of all expected ones."""

    def __init__(
        self, geometry: Arrangement, shapes: Measures, forms: Array, distances: Array
    ) -> None:
        self.geometry = geometry
        self.shapes = shapes
        self.forms = forms
        self.distances = distances
        self.each = shapes.positions  # poses of each rotation (Theorem 6.9)
        self.isolated = [_NO_POSES]
        self.samples: list[tuple[Complex, Complex]] = []
        self.account = PathAccount(expected=0, basis=Basis.COUNT)

    def _account(self, **parts: int) -> PathAccount:
        """Return the account of one rotation; what is not counted is at infinity."""
        rest = self.each - sum(parts.values())
        return PathAccount(expected=self.each, at_infinity=rest, basis=Basis.COUNT, **parts)

    def add_rotations(self, rotations: Rotations, places: _Places) -> None:
        """Add everything at some rotations; at complex ones the conjugate poses as well."""
        good = places.good
        index = good.nonzero()[0].repeat(places.T.shape[1])
        T = places.T[good].reshape(-1, 3)
        real = rotations.real[index] & ~T.imag.any(axis=1)
        self._add(
            _Isolated(
                places.quaternions[index],
                places.R[index],
                T,
                real,
                rotations.multiplicity[index],
            ),
            ~rotations.real[index],
        )
        paths = int(rotations.multiplicity[good] @ np.where(rotations.real[good], 1, 2))
        self.account += self._account(found=self.each) * paths
        for f in (~good).nonzero()[0]:
            self._add_carefully(rotations, places, int(f))
        for e in rotations.samples:
            self._add_sample(e)
        if rotations.account.at_infinity:
            self.account += self._account() * rotations.account.at_infinity
        if rotations.account.lost:
            self.account += self._account(lost=self.each) * rotations.account.lost

    def _add(self, poses: _Isolated, paired: NDArray[np.bool_]) -> None:
        """Add poses, and the conjugates of those whose rotation is not real."""
        self.isolated.append(poses)
        if paired.any():
            self.isolated.append(
                _Isolated(
                    poses.quaternions[paired].conj(),
                    poses.R[paired].conj(),
                    poses.T[paired].conj(),
                    poses.real[paired],
                    poses.multiplicity[paired],
                )
            )

    def _add_carefully(self, rotations: Rotations, places: _Places, f: int) -> None:
        """Add the poses of one isolated rotation, whatever the position of its surfaces."""
        e, turned_really = rotations.e[f], bool(rotations.real[f])
        multiplicity = int(rotations.multiplicity[f])
        weight = multiplicity * (1 if turned_really else 2)
        T, counts, samples, account = self._translations(
            e,
            float(rotations.errors[f]),
            isolated=multiplicity == 1,
            # Nothing but simple points can be told from the effects of a small N.
            only_simple=bool(abs(dot(e, e)) < _NEARLY_NULL),
        )
        real = np.zeros(len(T), bool)
        if turned_really and len(T):
            distances = np.abs(T.conj()[:, None] - T).sum(axis=-1)
            real = distances.argmin(axis=1) == np.arange(len(T))
            T = np.where(real[:, None], T.real, T)
        index = np.full(len(T), f)
        self._add(
            _Isolated(places.quaternions[index], places.R[index], T, real, counts * multiplicity),
            ~rotations.real[index],
        )
        self.samples += [(places.R[f], point) for point in samples]
        self.account += account * weight

    def _add_sample(self, e: Field) -> None:
        """Add the poses of one rotation on a positive-dimensional set of rotations.

        If there are none, there may still be poses at special rotations of the set. They are
        not looked for.
        """
        T, _, samples, account = self._translations(
            e, _SAMPLE_ACCURACY, isolated=False, only_simple=False
        )
        points = [*T, *samples]
        R = rotation_from_quaternion(e)
        self.samples += [(R, point) for point in points]
        if points:
            on_curves = account.found + account.on_curves
            self.account += replace(account, found=0, on_curves=on_curves)
        else:
            self.account += self._account(lost=self.each)

    def _translations(
        self, e: Field, accuracy: float, *, isolated: bool, only_simple: bool
    ) -> _Translations:
        """Return the translations at a rotation whose error is known.

        Simple points that seem to be infinitely far are examined if the rotation is isolated
        and simple too; else they are at infinity as well as can be told. Everything but simple
        points is lost if that is asked for.
        """
        given, accuracy = self.geometry, max(accuracy, _EPS)
        R = rotation_from_quaternion(e)
        pairs = np.array([i for i in given.distances if given.kinds[i] is DLL], int)
        sines = np.linalg.norm(cross(apply(R, given.u[pairs]), given.v[pairs]), axis=-1)
        parallel = pairs[sines <= _PARALLEL + 10 * accuracy].tolist()
        least = sines.min(initial=1, where=sines > _PARALLEL + 10 * accuracy)
        if least < _SKEW + 1e4 * accuracy:
            nowhere = np.zeros((0, 3), complex)
            return _Translations(nowhere, np.zeros(0, int), nowhere, self._account(lost=self.each))
        # Normals of planes are as accurate as the sines.
        accuracy /= least
        shapes = measures(given, parallel) if parallel else self.shapes
        there = surfaces(shapes, e[None], self.distances[None])
        frame = there.frame[0]
        points: list[Complex] = []
        counts: list[int] = []
        samples: list[Complex] = []
        examined = lost = 0
        for signs, planes in zip(shapes.signs, there.planes[0, :, : len(shapes.flat)], strict=True):
            meet = intersection(planes, there.quadrics[0], accuracy)
            points += list(meet.points @ frame.T)
            counts += meet.multiplicity.tolist()
            samples += list(meet.samples @ frame.T)
            # Spheres meet in fewer points than quadrics.
            lost += min(meet.lost, self.each // len(shapes.signs))
            for X in meet.distant if isolated else ():
                X = np.concatenate((X[:1], there.basis[0] @ X[1:]))
                pose = finite_pose(self.forms, shapes, signs, self.distances, e, X)
                if pose:
                    points.append(pose[1])
                    counts.append(1)
                examined += pose is False
                lost += pose is None
        if only_simple:
            points = [X for X, count in zip(points, counts, strict=True) if count == 1]
            counts, samples = [1] * len(points), []
            lost = self.each - len(points) - examined
        return _Translations(
            np.array(points, complex).reshape(-1, 3),
            np.array(counts, int),
            np.array(samples, complex).reshape(-1, 3),
            self._account(found=sum(counts), on_curves=len(samples), lost=lost),
        )

    def poses(self, arrangement: Arrangement, values: Array, length: float) -> PoseSet:
        """Return everything in the frames and units of the arrangement with some values."""
        q, R, T, real, multiplicity = _Isolated.joined(self.isolated)
        motions, account = self._motions(arrangement, values, length), self.account
        if not motions:
            # Samples of a set are no evidence if no motion is found through any of them.
            lost = account.lost + account.on_curves
            account = replace(account, on_curves=0, lost=lost)
        return PoseSet(
            quaternions=canonical_sign(q),
            R=R,
            T=arrangement.restored(R, T, length),
            real=real,
            certified=np.zeros(len(R), bool),
            multiplicity=multiplicity,
            motions=motions,
            account=account,
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
