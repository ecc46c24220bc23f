"""Proofs for many platforms of one geometry at a time: what differs is the values.

The theorem is that of `isolation`, the equations those of `ball_system`, the bounds of rounding
errors those of `floating`; the native kernel computes them for as many points as it has lanes. A
value enters few coefficients, linearly as its square, itself or its cosine, so that the balls of
all others are rounded to doubles once. Values are doubles here, meant exactly.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from flint import arb, ctx
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import AHH, AHL, ALH, ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.certification import study
from gspcli.certification.ball_system import (
    Form,
    base_height,
    mutual_moment,
    platform_height,
    rotation_form,
    scaled,
    square_distance,
)
from gspcli.certification.balls import OUTWARD, dot, norm
from gspcli.certification.centring import Centring
from gspcli.certification.deciding import nearly_parallel
from gspcli.certification.distinct import all_different
from gspcli.certification.floating import (
    COMPLEX,
    CONVERSION,
    ISOLATED,
    REAL,
    converted,
    form_hessians,
)
from gspcli.certification.sines import SINE_ERROR, cosines, sines
from gspcli.certification.statement import Statement, statements
from gspcli.defaults import TOLERANCE
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.geometry.numbers import Number

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: Bits of coefficients, of which the kernel takes twice those of a double where it needs them.
_PRECISION = 128
#: A cosine errs by at most `SINE_ERROR`, which is this part of the unit of `converted`.
_COSINE_ERROR = SINE_ERROR / CONVERSION


class ProvedPoses(NamedTuple):
    """What is proved about n ends of paths for each of b sets of values.

    Attributes
    ----------
    R, T
        The poses, shapes (b, n, 3, 3) and (b, n, 3), complex; proved real ones are exactly real.
    quaternions
        Of the rotations, ``e.e = 1``, with the sign of `quaternion_from_rotation`; (b, n, 4).
    certified
        Near which of them there is exactly one solution, a simple one, proved real or proved not
        to be; shape (b, n).
    real
        Which of those are real, shape (b, n).
    complete
        For which sets all are certified and proved to be different solutions, shape (b,).
    """

    R: Complex
    T: Complex
    quaternions: Complex
    certified: NDArray[np.bool_]
    real: NDArray[np.bool_]
    complete: NDArray[np.bool_]


class Frames(NamedTuple):
    """The unit of length and the origins, in the frames of the instance, of Study points."""

    unit: float
    base: Array
    platform: Array


class _ValueEquation(NamedTuple):
    """``A + w t N = 0``, or that times N minus the squares; t is a function of the value."""

    main: int
    squares: tuple[int, ...]
    weight: arb
    turned: bool = False
    """Whether the last square is to be multiplied by the value (DLL)."""


class ValueProofs:
    """The equations of a geometry with its values left open.

    Parameters
    ----------
    instance
        The geometry, its numbers taken exactly.
    rows
        All sets of values that will be asked for, shape (b, 6), in the units of the instance:
        their largest distances set the unit of length. None for those of the instance.
    """

    def __init__(self, instance: Instance, rows: Array | None) -> None:
        self.instance = instance
        if rows is not None:
            largest = np.abs(rows).max(axis=0)
            self.instance = instance.with_values(
                {
                    i: Number.of(float(size))
                    for i, (size, row) in enumerate(zip(largest, instance.constraints, strict=True))
                    if row.kind.is_distance
                }
            )
        with ctx.workprec(_PRECISION):
            self.statements = statements(self.instance)
            self._forms: list[Form] = [{study.NORM: arb(1)}, {study.STUDY: arb(1)}]
            self._equations = [self._equation(given) for given in self.statements]
            weights = np.array([converted(equation.weight) for equation in self._equations])
            nearest, bounds = np.zeros((2, len(self._forms), study.COUNT))
            for row, form in enumerate(self._forms):
                for k, coefficient in form.items():
                    nearest[row, k], bounds[row, k] = converted(coefficient)
        distances = [given for given in self.statements if given.kind.is_distance]
        self.scale = float(distances[0].unit)
        # For the kernel, see native/ends.hpp; what bounds N comes with the values.
        mains = [equation.main for equation in self._equations]
        lows = [float(e.weight - float(e.weight)) for e in self._equations]
        self._weights = np.array((*weights.T, bounds[mains, study.NORM], lows))
        bounds[mains, study.NORM] = 0
        self._hessians = np.tensordot(nearest, form_hessians(), 1)
        self._moduli = np.tensordot(bounds, np.abs(form_hessians()), 1)
        self._table = np.full((len(mains), 3), -1, np.int32)
        self._turned = np.full(len(mains), -1, np.int32)
        for i, equation in enumerate(self._equations):
            self._table[i, : 1 + len(equation.squares)] = equation.main, *equation.squares
            if equation.turned:
                self._turned[i] = equation.squares[-1]

    @cached_property
    def _lows(self) -> Array:
        """What double precision leaves of the Hessian matrices, shape (k, 8, 8)."""
        lows = np.zeros_like(self._hessians)
        hessians = form_hessians()
        with ctx.workprec(_PRECISION):
            for row, form in enumerate(self._forms):
                entries: dict[tuple[int, int], arb] = {}
                for k, coefficient in form.items():
                    for place in zip(*np.nonzero(hessians[k]), strict=True):
                        term = coefficient * int(hessians[k][place])
                        entries[place] = entries.get(place, 0) + term
                for place, entry in entries.items():
                    lows[row][place] = float(entry - float(self._hessians[row][place]))
        return lows

    @classmethod
    def of(cls, instance: Instance, rows: Array | None) -> ValueProofs | None:
        """Return the equations; None if the frames are too far from the platform for doubles."""
        return cls(instance, rows) if Centring.of(instance).is_none else None

    def _add(self, form: Form) -> int:
        self._forms.append(form)
        return len(self._forms) - 1

    def _equation(self, given: Statement) -> _ValueEquation:
        """Return the equation of `BallSystem`, with a distance or an angle's cosine of zero."""
        kind, a, b, u, v = given.kind, given.a, given.b, given.u, given.v
        if not kind.is_distance:
            return _ValueEquation(self._add(rotation_form(v, u)), (), -norm(u) * norm(v))
        if kind is DPP:
            return _ValueEquation(self._add(square_distance(a, b, arb(0))), (), arb(-1))
        if kind is DLL:
            moment, cosine = mutual_moment(a, b, u, v), rotation_form(v, u)
            squares = (self._add(moment), self._add(cosine))
            weight = dot(u, u) * dot(v, v)
            return _ValueEquation(self._add({study.NORM: arb(0)}), squares, weight, turned=True)
        height = base_height(a, b, v) if v else platform_height(a, b, u)
        if kind in (DPL, DLP):
            axis = dot(u or v, u or v)
            main = self._add(scaled(square_distance(a, b, arb(0)), axis))
            return _ValueEquation(main, (self._add(height),), -axis)
        if kind is DHP:
            height = scaled(height, arb(-1))
        elif kind is not DPH:
            raise ValueError(kind)
        return _ValueEquation(self._add(height), (), -norm(u or v))

    def _cosines(self, kind: Kind, angles: Array) -> Array:
        """Return the values of ``R u . v`` that angles ask for (`Statement.cosine`)."""
        degrees = self.instance.units.angle is AngleUnit.DEGREE
        if kind in (ALH, AHL):
            return sines(angles, degrees=degrees)
        if kind not in (ALL, AHH):
            raise ValueError(kind)
        return cosines(angles, degrees=degrees) * (-1 if kind is AHH else 1)

    def _is_fine(self, values: Array) -> bool:
        """Whether distances that quadrics are multiplied by are doubles (native/residuals.hpp)."""
        turned = self._turned >= 0
        # The square of such a double needs no third one.
        square, low = _square(values[:, 2, turned])
        return bool((values[:, 0, turned] == square).all() and (values[:, 3, turned] == low).all())

    def _values(self, rows: Array, choices: Array) -> Array:
        """Return what the kernel wants of each value (native/ends.hpp), shape (b, k, 5, 6)."""
        values = np.repeat(rows[:, None, :], len(choices), axis=1)
        bounds, lows, gaps = np.empty_like(values), np.zeros_like(values), np.zeros_like(values)
        for i, given in enumerate(self.statements):
            if given.kind.is_distance:
                # Exact: a power of two.
                values[..., i] /= self.scale
                if given.kind in (DPH, DHP):
                    values[..., i] *= choices[:, i]
                else:
                    values[..., i], lows[..., i] = _square(values[..., i])
                bounds[..., i] = np.abs(values[..., i])
            else:
                values[..., i] = self._cosines(given.kind, rows[:, i])[:, None]
                bounds[..., i] = np.abs(values[..., i]) + _COSINE_ERROR
                gaps[..., i] = SINE_ERROR
        distances = np.broadcast_to(np.abs(rows)[:, None] / self.scale, values.shape)
        return np.stack((values, bounds, distances, lows, gaps), axis=2)

    def decide(
        self, rows: Array, choices: Array, points: Complex, frames: Frames, *, jobs: int = 1
    ) -> ProvedPoses:
        """Prove what double precision can about the ends of paths.

        Parameters
        ----------
        rows
            Sets of values, shape (b, 6); none is zero where the geometry has lines at a distance.
        choices
            For each choice of sides the sign of each constraint, shape (k, 6).
        points
            Study points of any norm for each set and choice, shape (b, k, m, 8), n = k m.
        frames
            In which they are.
        jobs
            Threads.
        """
        return self._decide(self._values(rows, choices), points, frames, jobs)

    def decide_own(self, choices: Array, points: Complex, frames: Frames) -> ProvedPoses:
        """Prove what double precision can of the values of the instance, exactly as written.

        Parameters
        ----------
        choices, frames
            As for `decide`.
        points
            Shape (k, m, 8).
        """
        return self._decide(self._own_values(choices)[None], points[None], frames, jobs=1)

    def _own_values(self, choices: Array) -> Array:
        """Return what the kernel wants of the values of the instance, shape (k, 5, 6)."""
        columns = np.zeros((len(choices), 5, len(self.statements)))
        with ctx.workprec(_PRECISION):
            for i, given in enumerate(self.statements):
                kind = given.kind
                for k, sign in enumerate(choices[:, i].tolist()):
                    if not kind.is_distance:
                        value = given.cosine
                    else:
                        value = given.value * sign if kind in (DPH, DHP) else given.value**2
                    nearest, bound = converted(value)
                    low = float(value - nearest)
                    gap = float((value - nearest - low).abs_upper()) * OUTWARD
                    columns[k, :, i] = nearest, bound, abs(float(given.value)), low, gap
        return columns

    def _decide(self, values: Array, points: Complex, frames: Frames, jobs: int) -> ProvedPoses:
        """Return what the kernel proves about points (b, k, m, 8) for values (b, k, 5, 6)."""
        count = len(values)
        values = values.reshape(-1, *values.shape[2:])
        points = np.ascontiguousarray(points.reshape(-1, *points.shape[2:]))

        def decide(values: Array, points: Complex, lows: Array) -> tuple[NDArray[Any], ...]:
            return _kernel.decide(
                self._hessians,
                lows,
                self._moduli,
                self._table,
                self._weights,
                self._turned,
                values,
                points,
                unit=frames.unit / self.scale,
                origins=np.array((frames.base, frames.platform)) / self.scale,
                scale=self.scale,
                tolerance=TOLERANCE,
                jobs=jobs,
            )

        # Who has once needed 32 digits, needs them again: poses are far away for any values.
        known = "_lows" in vars(self)
        found = decide(values, points, self._lows if known else np.zeros((0, 8, 8)))
        again = np.flatnonzero(found[-1] == 0)
        if len(again) and not known and self._is_fine(values):
            for part, better in zip(
                found, decide(values[again], points[again], self._lows), strict=True
            ):
                part[again] = better
        R, T, quaternions, deviation, bits, complete = found
        certified = ((bits & ISOLATED) > 0) & ((bits & (REAL | COMPLEX)) > 0)
        different = complete > 0
        for k in np.flatnonzero(certified.all(axis=1) & ~different):
            # One linear form does not tell them apart.
            entries = np.concatenate((R[k].reshape(-1, 9), T[k] / self.scale), axis=1)
            different[k] = all_different(entries, deviation[k])
        if any(given.kind is DLL for given in self.statements):
            parallel = nearly_parallel(self.instance, R.reshape(-1, 3, 3))
            certified &= ~parallel.reshape(certified.shape)
        real = certified & ((bits & REAL) > 0)
        # Solutions of the equations of different sides are different ones: no distance is zero.
        different &= certified.all(axis=1)

        def together(part: NDArray[Any]) -> NDArray[Any]:
            return part.reshape(count, -1, *part.shape[2:])

        return ProvedPoses(
            R=together(R),
            T=together(T),
            quaternions=together(quaternions),
            certified=together(certified),
            real=together(real),
            complete=np.asarray(different.reshape(count, -1).all(axis=1)),
        )


def _square(x: Array) -> tuple[Array, Array]:
    """Return squares of moderate numbers, and what rounding leaves of them (T. J. Dekker)."""
    split = x * (2.0**27 + 1)
    high = split - (split - x)
    low = x - high
    square = x * x
    return square, ((high * high - square) + 2 * high * low) + low * low
