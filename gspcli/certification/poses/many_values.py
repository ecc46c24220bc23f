"""Proofs for many sets of values of one geometry at a time.

The theorem is that of `isolation`, the equations are those of `ball_system`, the bounds of rounding
errors those of `rounding`. The native kernel sets up the equations from numbers with 32 digits and
evaluates them for as many points as it has lanes. A value enters few coefficients, linearly as its
square, itself or its cosine. Values are doubles, taken as exact, or those of the instance.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import ANGLE_KINDS, DHP, DLL, DLP, DPH, DPL, DPP, Kind, Primitive
from gspcli.certification.equations.local_frames import (
    LocalFrames,
    StudyFrames,
    length_scale,
    length_scales,
)
from gspcli.certification.equations.skew_lines import are_skew
from gspcli.certification.numbers.doubled import (
    ERROR,
    Doubled,
    doubled,
    quotients,
    sines,
    two_product,
)
from gspcli.certification.numbers.rounding import COMPLEX, CONVERSION, ISOLATED, REAL, ROUNDED, TINY
from gspcli.certification.poses.pose_arrays import Bits, PoseProofs
from gspcli.defaults import TOLERANCE
from gspcli.geometry.enclosures import above
from gspcli.geometry.instance import AngleUnit, Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from gspcli.geometry.study import form_hessians

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.intp]

#: The numbers of the kinds in the kernel (native/open_equations.hpp), and that of lines that meet.
_RELATIONS = {DPP: 0, DPH: 1, DHP: 2, DPL: 3, DLP: 4, DLL: 5, **dict.fromkeys(ANGLE_KINDS, 6)}
_MEETING_LINES = 7
#: A cosine errs by at most `ERROR`, which is this part of the unit of `converted`.
COSINE_ERROR = ERROR / CONVERSION
#: The bits of the kernel.
_BITS = np.arange(2 * max(ISOLATED, REAL, COMPLEX, ROUNDED))
_CERTIFIED = ((_BITS & ISOLATED) > 0) & ((_BITS & (REAL | COMPLEX)) > 0)
_REAL = (_BITS & REAL) > 0
_ROUNDED = (_BITS & ROUNDED) > 0


class ValueProofs:
    """The equations of a geometry with its values left open.

    Parameters
    ----------
    instance
        The geometry, its numbers taken exactly.
    rows
        All sets of values that will be used, shape (b, 6), in the units of the instance: their
        largest distances set the unit of length. None for the values of the instance.
    """

    def __init__(self, instance: Instance, rows: Array | None) -> None:
        self.instance = instance
        given = instance.constraints
        self.kinds = tuple([row.kind for row in given])
        self._distances = [i for i, kind in enumerate(self.kinds) if kind.is_distance]
        self._angles = [i for i, kind in enumerate(self.kinds) if not kind.is_distance]
        largest = None if rows is None else np.abs(rows[:, self._distances]).max(axis=0).tolist()
        self.scale = length_scale(instance, largest)
        zero = [
            row.value.fraction == 0 if rows is None else not rows[:, i].any()
            for i, row in enumerate(given)
        ]
        self._meeting = meeting = tuple(
            is_zero and kind is DLL for is_zero, kind in zip(zero, self.kinds, strict=True)
        )
        numbers = _numbers(instance, self.kinds)
        # Exact: a power of two.
        numbers[:, :, :2] /= self.scale
        #: Relations, primitives (3, 6, 4, 3), Hessian matrices of forms, what is added to bounds.
        self.opened = _relations(self.kinds, meeting), numbers, form_hessians(), TINY / CONVERSION
        #: Hessian matrices with their low parts and moduli, equations, weights, turning parts.
        self.numbers = _kernel.open(*self.opened[:3], tiny=self.opened[3])

    @classmethod
    def of(cls, instance: Instance, rows: Array | None) -> ValueProofs | None:
        """Return the equations; None if the frames are too far from the platform for doubles."""
        return cls(instance, rows) if LocalFrames.of(instance).is_none else None

    def _cosines(self, rows: Array) -> tuple[Array, Array]:
        """Return the values of ``R u . v`` that angles ask for (`Statement.cosine`), (2, b, k)."""
        laws = [self.kinds[i].law for i in self._angles]
        signs, complements = np.array([x.sign for x in laws]), np.array([x.is_cosine for x in laws])
        degrees = self.instance.units.angle is AngleUnit.DEGREE
        high, low = sines(rows[:, self._angles], complements, degrees=degrees)
        return high * signs, low * signs

    def values(self, choices: Array, rows: Array | None = None) -> Array:
        """Return the numbers of each value for the kernel (native/ends.hpp), shape (b, k, 6, 6).

        Parameters are those of `decide`.
        """
        if rows is None:
            return self._own_values(choices)[None]
        values = np.repeat(rows[:, None, :], len(choices), axis=1)
        bounds, lows, gaps = np.empty_like(values), np.zeros_like(values), np.zeros_like(values)
        for i in self._distances:
            # Exact: a power of two.
            values[..., i] /= self.scale
            if self.kinds[i] in (DPH, DHP):
                values[..., i] *= choices[:, i]
            else:
                values[..., i], lows[..., i] = two_product(values[..., i], values[..., i])
            bounds[..., i] = np.abs(values[..., i])
        if self._angles:
            k = self._angles
            values[..., k], lows[..., k] = (x[:, None] for x in self._cosines(rows))
            bounds[..., k] = np.abs(values[..., k]) + COSINE_ERROR
            gaps[..., k] = ERROR
        distances = np.broadcast_to(np.abs(rows)[:, None] / self.scale, values.shape)
        return np.stack((values, bounds, distances, lows, gaps, np.zeros_like(gaps)), axis=2)

    def decide(
        self,
        choices: Array,
        points: Complex,
        frames: StudyFrames,
        *,
        rows: Array | None = None,
        jobs: int = 1,
    ) -> tuple[PoseProofs, Bits]:
        """Prove poses near the ends of paths in double precision.

        Parameters
        ----------
        choices
            For each choice of sides the sign of each constraint, shape (k, 6).
        points
            Study points of any norm for each set of values and choice, shape (b, k, m, 8),
            n = k m.
        frames
            The frames of the points.
        rows
            Sets of values, shape (b, 6); a distance of lines is zero in all of them or in none.
            None for the values of the instance, exactly as written; b = 1.
        jobs
            Threads.

        Returns
        -------
        What is proved about the ends, shape (b, n), and for which sets of values all ends are
        certified and proved to be different, shape (b,).
        """
        return self._decide(self.values(choices, rows), self.units(rows), points, frames, jobs)

    def units(self, rows: Array | None) -> Array:
        """Return the units of the last digits of translations, in lengths of the equations."""
        if rows is None:
            return np.ones(1)
        return length_scales(self.instance, rows[:, self._distances]) / self.scale

    def _own_values(self, choices: Array) -> Array:
        """Return the numbers of the instance's values for the kernel, shape (k, 6, 6)."""
        rows = self.instance.constraints
        exact = [row.value.fraction if row.kind.is_distance else None for row in rows]
        signed = [row.kind.has_sides for row in rows]
        unit = 1 / self.scale
        ratios = [
            (0, 1)
            if x is None
            else (x.numerator, x.denominator)
            if heights
            else (x.numerator**2, x.denominator**2)
            for x, heights in zip(exact, signed, strict=True)
        ]
        # Exact: powers of two.
        factors = [unit if heights else unit**2 for heights in signed]
        found = quotients(ratios) * factors
        turning = np.zeros((2, len(rows)))
        for i, row in enumerate(rows):
            if exact[i] is None:
                found[:, i] = self._irrational(row)
            if row.kind is DLL:
                turning[:, i] = self._turning(row)
        high, low, size = found
        bounds, gaps = size + TINY / CONVERSION, above(size * ERROR)
        columns = np.array([(high, bounds, turning[0], low, gaps, turning[1])] * len(choices))
        if any(signed):
            columns[:, [0, 3]] *= np.where(signed, choices, 1.0)[:, None]
        return columns

    def _turning(self, row: Constraint) -> tuple[float, float]:
        """Return the distance by which the quadric of the cosine of two lines is multiplied."""
        high, low, size = Doubled.of(row.value).scaled(1 / self.scale)
        # The kernel assumes this accuracy.
        return abs(high), (low if high > 0 else -low) if abs(high) == size else math.nan

    def _irrational(self, row: Constraint) -> Doubled:
        """Return the number in the equation of a constraint whose value is no fraction."""
        if not row.kind.is_distance:
            from gspcli.certification.equations.statement import cosine

            return Doubled.near(lambda: cosine(row, self.instance.units.angle))
        if row.kind in (DPH, DHP):
            return Doubled.of(row.value).scaled(1 / self.scale)
        return Doubled.square(row.value).scaled(1 / self.scale**2)

    def _decide(
        self, values: Array, units: Array, points: Complex, frames: StudyFrames, jobs: int
    ) -> tuple[PoseProofs, Bits]:
        """Return the proofs of the kernel about points (b, k, m, 8) for values (b, k, 6, 6).

        The units (b,) of the last digits of translations are in lengths of the equations.
        """
        count = len(values)
        units = np.repeat(units, values.shape[1])
        values = values.reshape(-1, *values.shape[2:])
        points = np.ascontiguousarray(points.reshape(-1, *points.shape[2:]))
        R, T, quaternions, deviation, bits, complete = _kernel.decide(
            *self.numbers,
            values,
            units,
            points,
            unit=frames.length / self.scale,
            origins=np.array((frames.base, frames.platform)) / self.scale,
            scale=self.scale,
            tolerance=TOLERANCE,
            jobs=jobs,
        )
        certified, real, rounded = proved_bits(bits)
        different = complete > 0
        undecided = () if different.all() else np.flatnonzero(certified.all(axis=1) & ~different)
        for k in undecided:
            from gspcli.certification.poses.isolation import all_different

            # One linear form does not separate them.
            with np.errstate(all="ignore"):
                entries = np.concatenate((R[k].reshape(-1, 9), T[k] / self.scale), axis=1)
            different[k] = all_different(entries, deviation[k])
        if DLL in self.kinds:
            skew = are_skew(self.instance, R.reshape(-1, 3, 3), deviation.ravel())
            skew = skew.reshape(certified.shape)
            certified, real, rounded = certified & skew, real & skew, rounded & skew
        # Solutions for different sides are different: no distance is zero.
        different &= certified.all(axis=1)

        def together(part: NDArray[Any]) -> NDArray[Any]:
            return part if len(part) == count else part.reshape(count, -1, *part.shape[2:])

        certified = together(certified)
        found = PoseProofs(
            R=together(R),
            T=together(T),
            quaternions=together(quaternions),
            certified=certified,
            real=together(real),
            multiplicity=certified.astype(np.int64),
            rounded=together(rounded),
            deviation=together(deviation),
        )
        return found, np.asarray(different.reshape(count, -1).all(axis=1))


def proved_bits(bits: NDArray[np.uint8]) -> tuple[NDArray[np.bool_], ...]:
    """Return which poses are certified, real and rounded correctly, by the bits of the kernel."""
    certified = _CERTIFIED[bits]
    return certified, certified & _REAL[bits], certified & _ROUNDED[bits]


def _numbers(instance: Instance, kinds: tuple[Kind, ...]) -> Array:
    """Return the points and the directions of both primitives as `doubled`, (3, 6, 4, 3)."""
    numbers: list[Number] = []
    factors: list[float] = []
    for body in instance.primitives:
        numbers += body.position
        factors.append(1.0)
        if not isinstance(body, Point):
            numbers += body.vector
            # The length becomes nearly one by an exact operation.
            largest = max([abs(number.value) for number in body.vector])
            factors.append(2.0 ** (1 - math.frexp(largest)[1]))
    found = np.zeros((3, len(kinds), 4, 3))
    constraints, vectors = _places(kinds)
    found[:, constraints, vectors] = doubled(numbers).reshape(3, -1, 3) * np.array(factors)[:, None]
    return found


@cache
def _places(kinds: tuple[Kind, ...]) -> tuple[Index, Index]:
    """Return the places of the vectors of `Instance.primitives`: constraint, and which of four."""
    places = [
        (i, j)
        for k, bodies in enumerate(([x.platform for x in kinds], [x.base for x in kinds]))
        for i, body in enumerate(bodies)
        for j in ((k,) if body is Primitive.POINT else (k, 2 + k))
    ]
    constraints, vectors = np.array(places).T
    return constraints, vectors


@cache
def _relations(kinds: tuple[Kind, ...], meeting: tuple[bool, ...]) -> NDArray[np.int32]:
    """Return the numbers of constraints in the kernel, shape (6,); some are lines that meet."""
    return np.where(meeting, _MEETING_LINES, [_RELATIONS[kind] for kind in kinds]).astype(np.int32)
