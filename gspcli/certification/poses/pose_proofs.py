"""Certificates of approximate poses of an instance, with increasing precision."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter
from typing import Any

import numpy as np
from flint import acb, ctx
from numpy.typing import ArrayLike, NDArray

from gspcli.certification.equations import study
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.local_frames import (
    FAR,
    LocalFrames,
    least_length,
    length_scale,
)
from gspcli.certification.equations.measures import (
    Measurement,
    measure,
    residual,
    satisfies_constraints,
)
from gspcli.certification.equations.pose_balls import PoseBall, pose_of_floats, pose_of_point
from gspcli.certification.numbers.balls import float_above, largest
from gspcli.certification.poses.certificates import Certificate, Certificates, Outcome
from gspcli.certification.poses.distinct import close_pairs, same
from gspcli.certification.poses.isolation import Isolation, refine_point
from gspcli.defaults import MAX_PRECISION, TOLERANCE
from gspcli.errors import ArgumentError
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance, Side

#: Bits of the first attempt: candidates are floats, and a limb of FLINT has 64 bits.
FIRST_PRECISION = 64


_EPS = float(np.finfo(float).eps)
_SIDES = {1: Side.POSITIVE, -1: Side.NEGATIVE}


class _Candidate:
    """A candidate on its way through the precisions."""

    def __init__(
        self,
        point: NDArray[np.complex128],
        patch: int,
        given: PoseBall,
        said: tuple[int, ...],
        rounding: float,
        length: float,
    ) -> None:
        self.start = self.point = [acb(x) for x in point.tolist()]
        self.patch = patch
        self.given = given
        #: The side of each plane that the candidate is said to be on, as signs, or 0.
        self.said = said
        #: The approximate change of a point by the rounding of its pose to doubles, in Study
        #: coordinates.
        self.rounding = rounding
        #: What translations may deviate is relative to this, in units of the scale: far away, where
        #: they are only known relatively, the scale itself.
        self.length = 1.0 if float_above(largest(given.translation)) > FAR else length
        # Entries of complex rotations may be large; they have relative errors then.
        self.size = max(1.0, float_above(largest(given.entries)))
        self.sides: list[tuple[int, ...]] = []
        self.isolation: Isolation | None = None
        self.pose: PoseBall | None = None
        self.measurements: list[Measurement] = []
        self.deviation = float("inf")
        self.precision = 0
        self.outcome = Outcome.NOT_ISOLATED
        self.is_open = True

    def attempt(self, system: BallSystem, tolerance: float) -> None:
        """Try to decide everything about the candidate at the precision of the system."""
        tolerance *= self.size
        self.precision = system.precision
        if not self.sides:
            self.sides = system.sides_near(self.point, self.given, self.said)
        found = self._nearest(system, tolerance)
        if found is None:
            # With too few digits Newton's method may diverge from a good start.
            self.point = self.start
            if self.isolation is None and self._is_refuted(system, tolerance):
                self.outcome, self.is_open = Outcome.REFUTED, False
            return
        self.isolation, self.pose = result, pose = found
        nearest, farthest = pose.deviation(self.given, self.length)
        self.deviation = float_above(farthest)
        real = result.real
        self.measurements = measure(system, pose) if real else []
        if self.deviation <= tolerance:
            self.point, self.sides = list(result.centre), [result.sides]
            self.outcome, self.is_open = self._judge(system, real)
        elif self._is_refuted(system, tolerance):
            self.outcome, self.is_open = Outcome.REFUTED, False
        else:
            # The error of the solution is part of the bound, and shrinks with the precision; and
            # with more digits Newton's method may find another solution from the same start.
            self.point = list(result.centre) if not nearest > tolerance else self.start
            self.outcome = Outcome.TOO_FAR

    def _is_refuted(self, system: BallSystem, tolerance: float) -> bool:
        """Whether it is proved that no solution is within the tolerance."""
        return system.excludes(self.given.widened(tolerance, self.length))

    def _nearest(self, system: BallSystem, tolerance: float) -> tuple[Isolation, PoseBall] | None:
        """Return the nearest solution that is proved, of those on sides that it may be on.

        Where one is within the tolerance on the sides that it is said to be on, it is meant.
        """
        results = [refine_point(system, self.point, self.patch, sides) for sides in self.sides]
        proved = [
            (result, pose)
            for result in results
            if isinstance(result, Isolation) and (pose := pose_of_point(result.point)) is not None
        ]
        if len(proved) < 2:
            return proved[0] if proved else None
        deviations = [float_above(pose.deviation(self.given, self.length)[1]) for _, pose in proved]
        elsewhere = [
            deviation > tolerance or not self._is_said(system, result)
            for deviation, (result, _) in zip(deviations, proved, strict=True)
        ]
        return min(zip(elsewhere, deviations, proved, strict=True), key=itemgetter(0, 1))[2]

    def _is_said(self, system: BallSystem, isolation: Isolation) -> bool:
        """Whether a solution is on the sides that the candidate is said to be on."""
        each = zip(system.signs(isolation.sides), self.said, strict=True)
        return all(sign * said >= 0 for sign, said in each)

    def _judge(self, system: BallSystem, real: bool | None) -> tuple[Outcome, bool]:
        """Return the outcome of a solution nearby, and whether something is still open."""
        assert self.pose is not None
        if any(not m.value.overlaps(m.target) for m in self.measurements):
            return Outcome.NOT_AS_STATED, False
        if not satisfies_constraints(system, self.pose, real=bool(real)):
            return Outcome.NOT_AS_STATED, True
        side_unknown = any(
            m.height is not None and m.height.contains(0) and not m.target.is_zero()
            for m in self.measurements
        )
        return Outcome.CERTIFIED, real is None or side_unknown

    def certificate(self, system: BallSystem, **relations: Any) -> Certificate:
        """Return the record of what was proved."""
        isolation = self.isolation
        if isolation is None:
            return Certificate(self.outcome, self.precision)
        if self.outcome is not Outcome.CERTIFIED:
            return Certificate(
                self.outcome,
                self.precision,
                deviation=self.deviation,
                length=self.length * system.scale,
            )
        real = isolation.real
        stated = real and bool(self.measurements)
        return Certificate(
            self.outcome,
            self.precision,
            real,
            float_above(isolation.error),
            isolation.uniqueness,
            self.deviation,
            float_above(residual(measure(system, self.given))) if stated else None,
            self._proved_sides(system, isolation),
            isolation=isolation,
            length=self.length * system.scale,
            **relations,
        )

    def _proved_sides(
        self, system: BallSystem, isolation: Isolation
    ) -> tuple[Side | None, ...] | None:
        if self.rounding > isolation.uniqueness and not self._is_said(system, isolation):
            # The one that is said may be so near that it was rounded to this one.
            return None
        if isolation.real:
            return tuple(_side(m) for m in self.measurements) if self.measurements else None
        if isolation.real is None:
            return None
        return tuple(_SIDES.get(sign) for sign in system.signs(isolation.sides))


def _side(measurement: Measurement) -> Side | None:
    height = measurement.height
    if height is None or height.contains(0):
        return None
    return Side.POSITIVE if height > 0 else Side.NEGATIVE


def _array(values: ArrayLike, where: str, shape: tuple[int, ...]) -> NDArray[np.complex128]:
    """Return rotations or translations, one or many, as an array with a leading axis."""
    try:
        array = np.asarray(values, dtype=np.complex128)
    except (TypeError, ValueError) as error:
        message = f"found something that is no array of numbers ({error})"
        raise ArgumentError(message, where) from None
    if array.shape[array.ndim - len(shape) :] != shape or array.ndim > len(shape) + 1:
        expected = ", ".join(map(str, ("n", *shape)))
        message = f"found shape {array.shape}, expected ({expected})"
        raise ArgumentError(message, where)
    return array.reshape(-1, *shape)


def _signs(sides: ArrayLike | None, poses: int) -> list[tuple[int, ...]]:
    """Return the signs of the heights of each pose, 0 where nothing is said."""
    signs = np.zeros((poses, 6), int) if sides is None else np.asarray(sides)
    if signs.shape != (poses, 6) or not np.isin(signs, (-1, 0, 1)).all():
        message = f"found shape {signs.shape}, expected ({poses}, 6) of 1, -1 or 0"
        raise ArgumentError(message, "sides")
    return [tuple(row) for row in signs.astype(int).tolist()]


def certify_equations(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    sides: ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    max_precision: int = MAX_PRECISION,
) -> Certificates:
    """Prove what can be proved about approximate solutions of the equations of an instance.

    Parameters, result and errors are those of `certify`. Where the lines of a DLL are parallel
    its equation has no simple solutions.
    """
    checked(instance)
    rotations, translations = _array(R, "R", (3, 3)), _array(T, "T", (3,))
    if len(rotations) != len(translations):
        message = f"found {len(translations)} translations for {len(rotations)} rotations"
        raise ArgumentError(message, "T")
    local_frames = LocalFrames.of(instance)
    instance = local_frames.applied(instance)
    scale, length = length_scale(instance), least_length(instance)
    with ctx.workprec(FIRST_PRECISION):
        given = [
            _in_frames(pose_of_floats(rotation, translation, 1.0), local_frames, scale)
            for rotation, translation in zip(rotations, translations, strict=True)
        ]
    places = np.array([[complex(x.mid()) for x in pose.translation] for pose in given])
    with np.errstate(all="ignore"):
        points, patches = study.study_points(rotations, places.reshape(-1, 3))
        rounding = _EPS * np.maximum(1, np.abs(translations).max(axis=1, initial=0) / scale)
    candidates = [
        _Candidate(point, int(patch), pose, said, error, length / scale)
        for point, patch, pose, said, error in zip(
            points, patches, given, _signs(sides, len(given)), rounding, strict=True
        )
    ]
    for candidate in candidates:
        if not all(entry.is_finite() for entry in [*candidate.point, *candidate.given.entries]):
            candidate.outcome, candidate.is_open = Outcome.NOT_A_NUMBER, False
    precision = FIRST_PRECISION
    while True:
        with ctx.workprec(precision):
            system = BallSystem(instance, precision)
            _attempt_open(system, candidates, tolerance)
            unknown, equal, rounded = _relations(candidates)
            for index in {k for pair in unknown for k in pair}:
                candidates[index].is_open = True
            if 2 * precision > max_precision or not any(c.is_open for c in candidates):
                return _record(system, candidates, unknown + rounded, equal, length)
        precision *= 2


def _in_frames(pose: PoseBall, local_frames: LocalFrames, scale: float) -> PoseBall:
    translation = local_frames.translation(pose.rotation, pose.translation)
    return PoseBall(pose.rotation, [entry / scale for entry in translation])


def _attempt_open(system: BallSystem, candidates: Sequence[_Candidate], tolerance: float) -> None:
    for candidate in candidates:
        if not candidate.is_open:
            continue
        if system.is_finite:
            candidate.attempt(system, tolerance)
        else:
            candidate.outcome = Outcome.NOT_A_NUMBER
            candidate.precision = system.precision


Pairs = list[tuple[int, int]]


def _relations(candidates: Sequence[_Candidate]) -> tuple[Pairs, Pairs, Pairs]:
    """Return the pairs of certified candidates that are not proved different.

    Returns
    -------
    unknown, equal, rounded
        Pairs that more digits may separate; pairs that approximate the same solution; and pairs
        that do so after rounding: there may be two solutions nearer than the rounding of the
        candidates.
    """
    certified = [k for k, c in enumerate(candidates) if c.outcome is Outcome.CERTIFIED]
    poses = [pose for k in certified if (pose := candidates[k].pose) is not None]
    unknown: Pairs = []
    equal: Pairs = []
    rounded: Pairs = []
    for i, j in close_pairs(poses):
        pair = certified[i], certified[j]
        first, second = (candidates[k].isolation for k in pair)
        assert first is not None
        assert second is not None
        if not same(first, second):
            unknown.append(pair)
        elif max(candidates[k].rounding for k in pair) > max(first.uniqueness, second.uniqueness):
            rounded.append(pair)
        else:
            equal.append(pair)
    return unknown, equal, rounded


def _record(
    system: BallSystem,
    candidates: Sequence[_Candidate],
    unknown: Pairs,
    equal: Pairs,
    length: float,
) -> Certificates:
    same_as: dict[int, int] = {}
    for i, j in sorted(equal):
        same_as[j] = min(i, same_as.get(j, i))
    unresolved: dict[int, list[int]] = {}
    for i, j in unknown:
        unresolved.setdefault(i, []).append(j)
        unresolved.setdefault(j, []).append(i)
    return Certificates(
        tuple(
            candidate.certificate(
                system,
                same_as=same_as.get(k),
                unresolved=tuple(sorted(unresolved.get(k, ()))),
            )
            if candidate.outcome is Outcome.CERTIFIED
            else candidate.certificate(system)
            for k, candidate in enumerate(candidates)
        ),
        system.scale,
        length,
    )
