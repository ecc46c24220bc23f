"""Certificates: the proved properties of approximate poses, of each and of all together."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from enum import Enum
from functools import partial
from itertools import chain
from operator import itemgetter
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from flint import acb, arb, ctx
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.counting import by_points, with_points_for_lines
from gspcli.certification.equations.ball_system import (
    BallSystem,
    Measurement,
    PoseBall,
    measure,
    pose_of_floats,
    pose_of_point,
    residual,
    satisfies_constraints,
)
from gspcli.certification.equations.local_frames import FAR, LocalFrames, least_length, length_scale
from gspcli.certification.numbers.balls import float_above, largest
from gspcli.certification.poses.isolation import Isolation, close_pairs, refine_point, same
from gspcli.certification.poses.multiple import Complex, nearly_parallel, where_parallel
from gspcli.defaults import MAX_PRECISION, TOLERANCE
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry import study
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.measurement import sides_of
from gspcli.records import dataclass

if TYPE_CHECKING:
    import pandas as pd


Rows = tuple[tuple[str, str, str], tuple[str, str, str], tuple[str, str, str]]
Triple = tuple[str, str, str]


class Outcome(Enum):
    """The reason why a candidate is certified or not."""

    CERTIFIED = "certified"
    REFUTED = "refuted"
    TOO_FAR = "too far"
    NOT_AS_STATED = "not as stated"
    NOT_ISOLATED = "not isolated"
    NOT_A_NUMBER = "not a number"

    @property
    def meaning(self) -> str:
        """The outcome in a sentence."""
        return _MEANINGS[self]


_MEANINGS = {
    Outcome.CERTIFIED: "one simple solution is proved to be near, and alone there",
    Outcome.REFUTED: "it is proved that no solution is within the tolerance",
    Outcome.TOO_FAR: "no solution is proved to be within the tolerance, nor that there is none",
    Outcome.NOT_AS_STATED: "the solution nearby is not proved to meet the constraints as stated",
    Outcome.NOT_ISOLATED: "no simple, isolated solution could be proved nearby",
    Outcome.NOT_A_NUMBER: "a number of the pose or of the instance is not finite",
}


@dataclass(frozen=True)
class Certificate:
    """The proved properties of one candidate."""

    #: `Outcome.CERTIFIED`, or the reason why nothing is proved.
    outcome: Outcome
    #: Bits of the last attempt.
    precision: int
    #: True if the solution is proved to be real, False if it is proved not to be, else None.
    real: bool | None = None
    #: Proved bound of the distance between the solution and `isolation.centre`, in Study
    #: coordinates (lengths by the scale of the instance).
    error: float | None = None
    #: Radius of the ball about that centre in which there is no other solution with the same sides.
    uniqueness: float | None = None
    #: Proved bound of the difference between the candidate and the solution in any entry of R and
    #: of T, the latter divided by `length`.
    deviation: float | None = None
    #: For real solutions: proved bound of the difference between the values measured on the
    #: candidate (its given numbers are exact) and the stated values, in the units of the instance.
    residual_bound: float | None = None
    #: For each constraint the side on which the point of a real solution is proved to lie, and that
    #: of its equation for another; None where a constraint has no sides, the distance is zero or
    #: nothing is proved, and for a solution that may be either.
    sides: tuple[Side | None, ...] | None = None
    #: Index of the first candidate that is proved to approximate the same solution.
    same_as: int | None = None
    #: Indices of the candidates whose solutions are proved to be neither the same nor different,
    #: and of those that approximate the same solution, but have another solution as near in
    #: doubles.
    unresolved: tuple[int, ...] = ()
    #: The proof, from which the solution can be refined.
    isolation: Isolation | None = field(default=None, repr=False)
    #: The instance whose equations the proof uses, if it is not the given one: it has the same
    #: poses, and points for lines that are parallel at every pose.
    equivalent: Instance | None = field(default=None, repr=False)
    #: The unit of deviations of T: `Certificates.least_length`. If T is larger than eight scales,
    #: so that it has a relative error, the unit is the scale.
    length: float | None = None

    @property
    def certified(self) -> bool:
        """Whether exactly one simple solution is proved near the candidate."""
        return self.outcome is Outcome.CERTIFIED

    def to_json(self) -> dict[str, Any]:
        """Return the certificate as plain data; candidates and constraints are counted from 1."""
        sides = [side and side.value for side in self.sides or ()]
        return {
            "certified": self.certified,
            "outcome": self.outcome.value,
            "real": self.real,
            "same_as": None if self.same_as is None else self.same_as + 1,
            "unresolved": [index + 1 for index in self.unresolved],
            "residual_bound": self.residual_bound,
            "deviation": self.deviation,
            "sides": {str(k): side for k, side in enumerate(sides, 1) if side},
            "precision": self.precision,
            "error": self.error,
            "uniqueness": self.uniqueness,
        }


@dataclass(frozen=True)
class Certificates(Sequence[Certificate]):
    """The certificates of all candidates, in their order.

    Attributes
    ----------
    items
        One for each candidate.
    scale
        The length, a power of two, by which translations are divided in errors.
    least_length
        The length, a power of two, by which translations that are not far are divided in
        deviations. It is the largest one below the size of the smaller body that is no point, and
        at least 2^-20 of the scale.
    """

    items: tuple[Certificate, ...]
    scale: float
    least_length: float

    @property
    def deviations(self) -> tuple[float, float]:
        """Proved bounds for all that are certified: of R, and of T in the unit of the instance."""
        bounds = [
            (item.deviation, item.deviation * item.length)
            for item in self.items
            if item.certified and item.deviation is not None and item.length is not None
        ]
        turned, moved = zip(*bounds, strict=True) if bounds else ((0.0,), (0.0,))
        return max(turned), max(moved)

    @overload
    def __getitem__(self, index: int) -> Certificate: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Certificate, ...]: ...

    def __getitem__(self, index: int | slice) -> Certificate | tuple[Certificate, ...]:
        """Return one certificate, or several by a slice."""
        return self.items[index]

    def __repr__(self) -> str:
        return (
            f"<Certificates: {self.certified} of {len(self)} certified, {self.distinct} of them "
            f"proved different, {self.real} of these real>"
        )

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each candidate (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.to_json()["solutions"])

    def to_json(self) -> dict[str, Any]:
        """Return the certificates as plain data, as `gsp certify` prints them."""
        entries = enumerate((item.to_json() for item in self.items), 1)
        return {
            "scale": self.scale,
            "least_length": self.least_length,
            "counts": {
                "poses": len(self),
                "certified": self.certified,
                "distinct": self.distinct,
                "real": self.real,
            },
            "solutions": [{"number": number, **entry} for number, entry in entries],
        }

    def __len__(self) -> int:
        """Return the number of candidates."""
        return len(self.items)

    @property
    def certified(self) -> int:
        """The number of certified candidates, duplicates included."""
        return sum(item.certified for item in self.items)

    @property
    def distinct(self) -> int:
        """The number of pairwise different solutions that are proved to exist."""
        return len(self._representatives())

    @property
    def real(self) -> int:
        """The number of pairwise different solutions that are proved to exist and to be real."""
        return sum(self.items[k].real is True for k in self._representatives())

    def _representatives(self) -> set[int]:
        chosen: set[int] = set()
        for index, item in enumerate(self.items):
            if item.certified and item.same_as is None and chosen.isdisjoint(item.unresolved):
                chosen.add(index)
        return chosen


#: The outcomes of solutions that are not isolated.
_SINGULAR = (Outcome.NOT_ISOLATED, Outcome.NOT_AS_STATED)
#: The most bits for each digit.
_BITS_A_DIGIT = 64


@dataclass(frozen=True)
class RefinedPose:
    """A solution in decimals.

    Every printed number differs from the exact one by less than 0.51 units of its last place.
    """

    #: The rotation by rows and the translation in length units; real parts, if the solution is not
    #: proved real.
    R: Rows
    T: Triple
    #: The imaginary parts, or None if the solution is proved real.
    R_imag: Rows | None
    T_imag: Triple | None
    #: Bits that were needed.
    precision: int


def refine(instance: Instance, certificate: Certificate, digits: int) -> RefinedPose:
    """Return a certified solution to a number of proved digits.

    Parameters
    ----------
    instance
        The instance that was certified.
    certificate
        What `certify` returned for the solution.
    digits
        Decimals of the rotation, and significant digits of the largest number of T; all
        of T has the same number of decimals.

    Returns
    -------
    RefinedPose
        The numbers as decimal strings.

    Raises
    ------
    ValueError
        If the certificate proves nothing.
    IncompleteError
        If the digits need an unreasonable precision, or the solution is none of this instance.
    """
    isolation = certificate.isolation
    if not certificate.certified or isolation is None:
        raise ValueError(f"there is nothing to refine: {certificate.outcome.meaning}")
    instance = certificate.equivalent or instance
    local_frames = LocalFrames.of(instance)
    centre = list(isolation.centre)
    precision = isolation.precision
    while precision <= _BITS_A_DIGIT * (digits + 16) + 2 * isolation.precision:
        with ctx.workprec(precision):
            system = BallSystem(local_frames.applied(instance), precision)
            result = refine_point(system, centre, isolation.patch, isolation.sides)
            if isinstance(result, Isolation):
                centre = list(result.centre)
                refined = _printed(certificate, result, system.scale, local_frames, digits)
                if refined is not None:
                    return refined
        precision *= 2
    raise IncompleteError(f"{digits} digits could not be proved with {precision // 2} bits")


def _printed(
    certificate: Certificate,
    result: Isolation,
    scale: float,
    local_frames: LocalFrames,
    digits: int,
) -> RefinedPose | None:
    """Return the decimals, or None if the precision does not suffice."""
    pose = pose_of_point(result.point)
    proved = certificate.isolation
    if pose is None or proved is None or not proved.contains(result):
        return None
    turn = list(chain(*pose.rotation))
    shift = local_frames.back(pose.rotation, [entry * scale for entry in pose.translation])
    size = max(*(float_above(entry) for entry in shift), scale * 10.0**-digits)
    places = max(0, digits - math.floor(math.log10(size)) - 1)
    real = bool(certificate.real or result.real)
    parts = [
        _decimals([x.real for x in turn], digits),
        _decimals([x.real for x in shift], places),
        _decimals([x.imag for x in turn], digits),
        _decimals([x.imag for x in shift], places),
    ]
    R, T, R_imag, T_imag = parts
    if R is None or T is None or (not real and (R_imag is None or T_imag is None)):
        return None
    return RefinedPose(
        _rows(R),
        (T[0], T[1], T[2]),
        None if real or R_imag is None else _rows(R_imag),
        None if real or T_imag is None else (T_imag[0], T_imag[1], T_imag[2]),
        result.precision,
    )


def _rows(entries: Sequence[str]) -> Rows:
    a, b, c, d, e, f, g, h, i = entries
    return ((a, b, c), (d, e, f), (g, h, i))


def _decimals(values: Sequence[arb], places: int) -> list[str] | None:
    """Return numbers with this many places, or None if one of them is not accurate enough."""
    texts = []
    for value in values:
        shifted = value * arb(10) ** places
        nearest = (shifted.mid() + arb(0.5)).floor().unique_fmpz()
        if nearest is None or not abs(shifted - nearest) < 0.51:
            return None
        # Python refuses to write an integer of more than 4300 digits; FLINT does not.
        digits = str(abs(nearest)).rjust(places + 1, "0")
        whole, fraction = digits[: len(digits) - places], digits[len(digits) - places :]
        sign = "-" if nearest < 0 else ""
        texts.append(f"{sign}{whole}.{fraction}" if places else f"{sign}{whole}")
    return texts


#: Bits for each decimal of a pose, and for rounding.
_BITS_OF_A_DIGIT, _GUARD = 4, 64


def excluded(instance: Instance, pose: RefinedPose) -> bool:
    """Return whether it is proved that a pose violates a constraint of an instance.

    Parameters
    ----------
    instance
        The constraints, of any number.
    pose
        A real pose; the proof is about all poses that its decimals may stand for.
    """
    digits = max(_places(x) for x in chain(*pose.R, pose.T))
    precision = _BITS_OF_A_DIGIT * digits + _GUARD
    with ctx.workprec(precision):
        system = BallSystem(instance, precision)
        rotation = [[_ball(x) for x in row] for row in pose.R]
        return system.excludes(PoseBall(rotation, [_ball(x) / system.scale for x in pose.T]))


def _places(text: str) -> int:
    return len(text.partition(".")[2])


def _ball(text: str) -> acb:
    """Return the numbers for which a decimal of `RefinedPose` may stand."""
    return acb(arb(text) + arb(0, 0.51) / arb(10) ** _places(text))


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
        raise ArgumentError(
            f"found something that is no array of numbers ({error})", where
        ) from None
    if array.shape[array.ndim - len(shape) :] != shape or array.ndim > len(shape) + 1:
        expected = ", ".join(map(str, ("n", *shape)))
        raise ArgumentError(f"found shape {array.shape}, expected ({expected})", where)
    return array.reshape(-1, *shape)


def _signs(sides: ArrayLike | None, poses: int) -> list[tuple[int, ...]]:
    """Return the signs of the heights of each pose, 0 where nothing is said."""
    signs = np.zeros((poses, 6), int) if sides is None else np.asarray(sides)
    if signs.shape != (poses, 6) or not np.isin(signs, (-1, 0, 1)).all():
        raise ArgumentError(
            f"found shape {signs.shape}, expected ({poses}, 6) of 1, -1 or 0", "sides"
        )
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
        raise ArgumentError(
            f"found {len(translations)} translations for {len(rotations)} rotations", "T"
        )
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
                system, same_as=same_as.get(k), unresolved=tuple(sorted(unresolved.get(k, ())))
            )
            if candidate.outcome is Outcome.CERTIFIED
            else candidate.certificate(system)
            for k, candidate in enumerate(candidates)
        ),
        system.scale,
        length,
    )


#: The sides of planes, and which lines are parallel.
Part = tuple[tuple[int, ...], tuple[int, ...]]


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
