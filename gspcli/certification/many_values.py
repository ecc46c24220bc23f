"""Proofs for many platforms of one geometry at a time: what differs is the values.

The theorem is that of `isolation`, the equations those of `ball_system`, the bounds of rounding
errors those of `floating`; the native kernel computes them for as many points as it has lanes. A
value enters few coefficients, linearly as its square, itself or its cosine, so that the balls of
all others are rounded to doubles once. Values are doubles here, meant exactly.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from flint import arb, ctx
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
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
from gspcli.certification.balls import dot, norm
from gspcli.certification.centring import Centring
from gspcli.certification.deciding import nearly_parallel
from gspcli.certification.distinct import all_different, surely_different
from gspcli.certification.floating import (
    COMPLEX,
    ISOLATED,
    REAL,
    converted,
    deviations,
    form_hessians,
)
from gspcli.certification.proving import FIRST_PRECISION
from gspcli.certification.statement import Statement, statements
from gspcli.defaults import TOLERANCE
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import quaternion_product

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: A coefficient plus a weight times a value errs by this many of the errors of its parts, as
#: `converted` bounds them: those of coefficient, weight, value, their product and the sum.
_PARTS = 4
#: Absolute error of a cosine computed with `FIRST_PRECISION` bits, as a part of the unit of
#: `converted`: far more than there is.
_COSINE_ERROR = 2.0**-8


class Decided(NamedTuple):
    """What is proved about n poses for each of b sets of values.

    Attributes
    ----------
    certified
        Near which of them there is exactly one solution, a simple one, proved real or proved not
        to be; shape (b, n).
    real
        Which of those are real, shape (b, n).
    different
        For which sets all certified solutions are proved to be different ones, shape (b,).
    """

    certified: NDArray[np.bool_]
    real: NDArray[np.bool_]
    different: NDArray[np.bool_]


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
        their largest distances set the unit of length.
    """

    def __init__(self, instance: Instance, rows: Array) -> None:
        largest = np.abs(rows).max(axis=0)
        self.instance = instance.with_values(
            {
                i: Number.of(float(size))
                for i, (size, row) in enumerate(zip(largest, instance.constraints, strict=True))
                if row.kind.is_distance
            }
        )
        with ctx.workprec(FIRST_PRECISION):
            self.statements = statements(self.instance)
            self._forms: list[Form] = [{study.NORM: arb(1)}, {study.STUDY: arb(1)}]
            self._equations = [self._equation(given) for given in self.statements]
            weights = [converted(equation.weight) for equation in self._equations]
            self._weights, self._weight_bounds = np.array(weights).T
            self._nearest, self._bounds = np.zeros((2, len(self._forms), study.COUNT))
            for row, form in enumerate(self._forms):
                for k, coefficient in form.items():
                    self._nearest[row, k], self._bounds[row, k] = converted(coefficient)
        distances = [given for given in self.statements if given.kind.is_distance]
        self.scale = float(distances[0].unit)

    @classmethod
    def of(cls, instance: Instance, rows: Array) -> ValueProofs | None:
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

    def _parameters(self, rows: Array, choices: Array) -> tuple[Array, Array]:
        """Return the functions of the values (b, k, 6) and bounds for `converted`."""
        values = np.repeat(rows[:, None, :], len(choices), axis=1)
        bounds = np.empty_like(values)
        for i, given in enumerate(self.statements):
            if given.kind.is_distance:
                # Exact: a power of two.
                values[..., i] /= self.scale
                if given.kind in (DPH, DHP):
                    values[..., i] *= choices[:, i]
                else:
                    values[..., i] **= 2
                bounds[..., i] = np.abs(values[..., i])
            else:
                with ctx.workprec(FIRST_PRECISION):
                    cosines = [
                        float(replace(given, value=arb(value) / given.unit).cosine)
                        for value in rows[:, i].tolist()
                    ]
                values[..., i] = np.array(cosines)[:, None]
                bounds[..., i] = np.abs(values[..., i]) + _COSINE_ERROR
        return values, bounds

    def _systems(self, rows: Array, choices: Array) -> tuple[Array, Array, NDArray[np.int32]]:
        """Return Hessian matrices (b k, quadrics, 8, 8), bounds for them, and the equations."""
        parameters, parameter_bounds = (
            part.reshape(-1, len(self.statements)) for part in self._parameters(rows, choices)
        )
        count = len(parameters)
        nearest = np.repeat(self._nearest[None], count, axis=0)
        bounds = np.repeat(self._bounds[None], count, axis=0)
        equations = np.full((len(self.statements), 3), -1, dtype=np.int32)
        for i, equation in enumerate(self._equations):
            value, bound = parameters[:, i], parameter_bounds[:, i]
            squares = equation.squares
            main = nearest[:, equation.main], bounds[:, equation.main]
            if equation.turned:
                distance = np.repeat(np.abs(rows[:, i]) / self.scale, len(choices))
                turned = squares[-1]
                nearest[:, turned] *= distance[:, None]
                bounds[:, turned] *= _PARTS * distance[:, None]
            main[0][:, study.NORM] += self._weights[i] * value
            main[1][:, study.NORM] += self._weight_bounds[i] * bound
            main[1][:, study.NORM] *= _PARTS
            equations[i, 0] = equation.main
            equations[i, 1 : 1 + len(squares)] = squares
        shape = (count, len(self._forms), 8, 8)
        flat = form_hessians().reshape(study.COUNT, 64)
        return (nearest @ flat).reshape(shape), (bounds @ np.abs(flat)).reshape(shape), equations

    # Whatever is not a number proves nothing.
    @np.errstate(all="ignore")
    def decide(
        self,
        rows: Array,
        choices: Array,
        quaternions: Complex,
        R: Complex,
        T: Complex,
        *,
        jobs: int = 1,
    ) -> Decided:
        """Prove what double precision can about approximate poses.

        Parameters
        ----------
        rows
            Sets of values, shape (b, 6); none is zero where the geometry has lines at a distance.
        choices
            For each choice of sides the sign of each constraint, shape (k, 6).
        quaternions, R, T
            The poses: those of each choice of sides one after the other, shapes (b, k m, 4),
            (b, k m, 3, 3) and (b, k m, 3); quaternions with ``e.e = 1``.
        jobs
            Threads.
        """
        shape = R.shape[:2]
        hessians, moduli, equations = self._systems(rows, choices)
        points, patches = _points(quaternions, T / self.scale)
        systems = (len(hessians), -1)
        points, errors, proved = _kernel.prove(
            np.ascontiguousarray(hessians),
            np.ascontiguousarray(moduli),
            equations,
            points.reshape(*systems, 8),
            patches.reshape(systems),
            jobs=jobs,
        )
        places = (T / self.scale).reshape(-1, 3)
        turns = R.reshape(-1, 3, 3)
        deviation = deviations(points.reshape(-1, 8), errors.reshape(-1), turns, places)
        entries = np.concatenate((turns.reshape(-1, 9), places), axis=1)
        tolerance = TOLERANCE * np.maximum(1, np.abs(entries).max(axis=1, initial=0))
        bits = proved.reshape(-1)
        certified = ((bits & ISOLATED) > 0) & ((bits & (REAL | COMPLEX)) > 0)
        certified &= deviation <= tolerance
        if any(given.kind is DLL for given in self.statements):
            certified &= ~nearly_parallel(self.instance, turns)
        real = certified & ((bits & REAL) > 0)
        entries, deviation = entries.reshape(*shape, 12), deviation.reshape(shape)
        certified = certified.reshape(shape)
        different = surely_different(entries, np.where(certified, deviation, np.inf))
        for k in np.flatnonzero(~different):
            known = certified[k]
            different[k] = all_different(entries[k, known], deviation[k, known])
        return Decided(certified, real.reshape(shape), different)


def _points(quaternions: Complex, places: Complex) -> tuple[Complex, NDArray[np.int32]]:
    """Return Study points of poses in their patches (..., 8), and the patches (...)."""
    pure = np.concatenate((np.zeros_like(places[..., :1]), places), axis=-1)
    points = np.concatenate((quaternions, quaternion_product(pure, quaternions) / 2), axis=-1)
    patches = np.abs(points[..., :4]).argmax(axis=-1)[..., None]
    points = points / np.take_along_axis(points, patches, axis=-1)
    np.put_along_axis(points, patches, 1, axis=-1)
    return np.ascontiguousarray(points), patches[..., 0].astype(np.int32)
