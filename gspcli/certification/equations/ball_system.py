"""The polynomial equations of an instance in Study coordinates, with balls as coefficients.

Each constraint is ``A = 0`` or ``N A - B^2 - C^2 = 0`` with quadratic forms A, B, C, equivalent to
the constraint as stated wherever ``N != 0``:

* angles, PP and PH or HP on one side: one quadric, linear in the forms of `study`;
* PL: ``|w|^2 |u|^2 - (w . u)^2 = d^2 |u|^2`` with w from a point of the line to the point and u
  along the line, and LP likewise; ``N |w|^2`` is the quadric of PP and ``N w . u`` one more;
* LL: ``d^2 (|u|^2 |v|^2 - (u . v)^2) = M^2`` with the mutual moment M. For d = 0 this is the
  square of ``M = 0``, which is taken instead.

No direction is normalized, so only square roots of lengths, cosines of angles and irrational
numbers of the input are irrational. The polynomials are those of `study.forms_of`, which are
solved, too. `measure` finds the distances and angles themselves on a real pose, without them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, cached_property
from itertools import chain, product
from math import prod
from typing import Any, NamedTuple

import numpy as np
from flint import acb, acb_mat, arb, arb_mat, fmpz_mat
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, Law
from gspcli.certification.equations.local_frames import length_scale
from gspcli.certification.equations.statement import Statement, statements
from gspcli.certification.numbers.balls import cross, dot, floats_above, largest, norm, rotated
from gspcli.geometry import study
from gspcli.geometry.enclosures import above
from gspcli.geometry.instance import Instance, Side
from gspcli.records import dataclass


@dataclass(frozen=True)
class PoseBall:
    """Balls that contain a rotation, by rows, and a translation in units of the scale."""

    rotation: list[list[acb]]
    translation: list[acb]

    @property
    def entries(self) -> list[acb]:
        """The twelve numbers."""
        return [*chain(*self.rotation), *self.translation]

    def widened(self, radius: float, length: float) -> PoseBall:
        """Return balls of all poses that deviate by at most a radius from this one."""
        turned, moved = (acb(arb(0, x), arb(0, x)) for x in (radius, arb(radius) * length))
        return PoseBall(
            [[entry + turned for entry in row] for row in self.rotation],
            [entry + moved for entry in self.translation],
        )

    def deviation(self, other: PoseBall, length: float) -> tuple[arb, arb]:
        """Bound the largest difference of any of the numbers of two poses, below and above.

        Differences of translations are divided by a length, a power of two in units of the scale.
        """
        gaps = [x - y for x, y in zip(self.entries, other.entries, strict=True)]
        gaps[9:] = [gap / length for gap in gaps[9:]]
        return max(gap.abs_lower() for gap in gaps), largest(gaps)


def pose_of_point(point: Sequence[acb]) -> PoseBall | None:
    """Return the pose of a Study point, or None if N is not proved to differ from zero."""
    n, rotation, translation = study.motion(point)
    if n.contains(0):
        return None
    unit = 1 / n
    return PoseBall(
        [[entry * unit for entry in row] for row in rotation],
        [entry * unit for entry in translation],
    )


def pose_of_floats(R: NDArray[np.complex128], T: NDArray[np.complex128], scale: float) -> PoseBall:
    """Return a pose whose numbers are given, exactly: shapes (3, 3) and (3,), length units."""
    return PoseBall(
        [[acb(x) for x in row] for row in R.tolist()], [acb(x) / scale for x in T.tolist()]
    )


@cache
def _hessians() -> fmpz_mat:
    """Return the Hessian matrices of all forms, one flattened matrix a row."""
    entries = study.form_hessians().ravel().tolist()
    return fmpz_mat(study.COUNT, 64, [int(entry) for entry in entries])


#: The nearer side is taken if the two distances differ by this part of their sum.
_CLEAR = 0.9
_SIGNS = {Side.POSITIVE: (1,), Side.NEGATIVE: (-1,), Side.BOTH: (1, -1)}


@dataclass(frozen=True)
class BallEquation:
    """The equation ``A = 0`` (no squares) or ``N A = B^2 + ...``, by indices of quadrics."""

    main: int
    squares: tuple[int, ...] = ()


class OpenEquation(NamedTuple):
    """The equation F = 0 of one quadric, or ``G H = c N^2`` of the distance of a point and a line.

    G and H are the heights of the point over two complex planes through the line.
    """

    factors: tuple[acb_mat, ...]
    """The Hessian matrices of F, or of G and H."""
    constant: arb = arb(0)
    """The square of the distance c."""


def heights(a: list[arb], b: list[arb], u: list[arb], v: list[arb]) -> list[study.Form]:
    """Return N times two coordinates across a line, whose squares add up to that of the distance.

    Their axes and the direction of the line are right-handed.

    Parameters
    ----------
    a, b
        The point, and a point of the line: that of the platform first.
    u, v
        The direction of the line if it is the platform's or the base's; empty for the other.
    """
    axis = u or v
    least = min(range(3), key=lambda k: abs(float(axis[k].mid())))
    across = cross(axis, [arb(int(k == least)) for k in range(3)])
    units = [[x / norm(w) for x in w] for w in (across, cross(axis, across))]
    return [study.platform_height(a, b, w) if u else study.base_height(a, b, w) for w in units]


class BallSystem:
    """The equations of an instance at the working precision.

    Lengths are in units of `length_scale`, a power of two, so that all coordinates are of a
    similar size.

    Parameters
    ----------
    instance
        The exact instance.
    precision
        The number of bits; the caller uses the same precision (``flint.ctx``).
    given
        Constraints in place of those of the instance, in the same unit of length. Their points
        and directions may be complex.
    """

    def __init__(
        self, instance: Instance, precision: int, given: tuple[Statement, ...] | None = None
    ) -> None:
        self.precision = precision
        self.scale = length_scale(instance)
        self.statements = statements(instance) if given is None else given
        #: The quadrics: N, e . f, and those of the constraints.
        self.forms: list[study.Form] = [{study.NORM: arb(1)}, {study.STUDY: arb(1)}]
        #: For each constraint its equation, or those of its positive and its negative side.
        self.equations = tuple(self._equations(statement) for statement in self.statements)
        self._single: dict[tuple[int, ...], acb_mat | None] = {}

    @cached_property
    def rows(self) -> Any:
        """The coefficients of the quadrics in all forms, a quadric a row.

        An `acb_mat` if points or directions are complex, else an `arb_mat`.
        """
        rows = [[form.get(k, arb(0)) for k in range(study.COUNT)] for form in self.forms]
        is_real = not any(isinstance(entry, acb) for entry in chain(*rows))
        return arb_mat(rows) if is_real else acb_mat(rows)

    @cached_property
    def monomial_rows(self) -> arb_mat:
        """The coefficients of the quadrics in `monomials`, a quadric a row."""
        product: arb_mat = self.rows * arb_mat(monomials())
        return product

    @cached_property
    def _coefficients(self) -> acb_mat:
        return acb_mat(self.rows)

    @cached_property
    def _entries(self) -> list[list[Any]]:
        """The entries of the Hessian matrix of each quadric."""
        entries = (self.rows * type(self.rows)(arb_mat(_hessians()))).entries()
        return [entries[64 * k : 64 * (k + 1)] for k in range(len(self.forms))]

    @cached_property
    def _hessians(self) -> acb_mat:
        """The Hessian matrices below each other."""
        return acb_mat(8 * len(self.forms), 8, list(chain(*self._entries)))

    @cached_property
    def _moduli(self) -> NDArray[np.float64]:
        """Bounds of the moduli of the entries of the Hessian matrices, shape (k, 8, 8)."""
        return floats_above(chain(*self._entries)).reshape(-1, 8, 8)

    @property
    def is_finite(self) -> bool:
        """Whether every coefficient exists (``acos(2)`` does not)."""
        return bool(np.isfinite(self._moduli).all())

    def _equations(self, given: Statement) -> tuple[BallEquation, ...]:
        law, u, v, d = given.kind.law, given.u, given.v, given.value
        form, *others = study.forms_of(given.kind, given.a, given.b, u, v)
        if not given.kind.is_distance:
            form[study.NORM] = -given.cosine * norm(u) * norm(v)
            return (BallEquation(self._add(form)),)
        if law is Law.MOMENT:
            if given.is_zero:
                return (BallEquation(self._add(form)),)
            main: study.Form = {study.NORM: d * d * dot(u, u) * dot(v, v)}
            cosine = study.scaled(others[0], d)
            return (BallEquation(self._add(main), (self._add(form), self._add(cosine))),)
        axis = u or v
        if law is Law.SQUARE:
            form[study.NORM] = form[study.NORM] - d * d
            form = study.scaled(form, dot(axis, axis)) if axis else form
            return (BallEquation(self._add(form), tuple(map(self._add, others))),)
        value = d * norm(axis)
        return tuple(
            BallEquation(self._add({**form, study.NORM: form[study.NORM] - sign * value}))
            for sign in (_SIGNS[given.side] if not given.is_zero else (1,))
        )

    def _add(self, form: study.Form) -> int:
        self.forms.append(form)
        return len(self.forms) - 1

    def sides_near(
        self, point: Sequence[acb], pose: PoseBall, said: Sequence[int]
    ) -> list[tuple[int, ...]]:
        """Return for each constraint the index of the side whose equation is nearer to zero.

        If this is not clear all combinations are returned, the likeliest first.

        Parameters
        ----------
        point, pose
            A Study point and its pose. Far away either may have lost the digits that distinguish
            the sides: the one with the larger quotient of the two distances has more of them.
        said
            For each constraint 1 or -1 for the likelier side if it is not clear, or 0.
        """
        if all(len(sides) == 1 for sides in self.equations):
            return [(0,) * len(self.equations)]
        column = acb_mat(8, 1, list(point))
        places = (self._values(column, self._gradients(column)), self._quadrics(pose))
        each = zip(self.equations, said, strict=True)
        return list(product(*(_nearer(sides, places, sign) for sides, sign in each)))

    def signs(self, sides: Sequence[int]) -> tuple[int, ...]:
        """Return the signs of the heights in equations, 0 for constraints without sides."""
        return tuple(
            _SIGNS[given.side][side] if given.kind.has_sides and not given.is_zero else 0
            for given, side in zip(self.statements, sides, strict=True)
        )

    def excludes(self, pose: PoseBall) -> bool:
        """Whether it is proved that no pose in these balls meets all constraints."""
        quadrics = self._quadrics(pose)
        return any(
            not any(_value(equation, quadrics).contains(0) for equation in equations)
            for equations in self.equations
        )

    def _quadrics(self, pose: PoseBall) -> list[acb]:
        forms = study.forms_of_pose(pose.rotation, pose.translation)
        entries: list[acb] = (self._coefficients * acb_mat(study.COUNT, 1, forms)).entries()
        return entries

    def _gradients(self, column: acb_mat) -> acb_mat:
        return acb_mat(len(self.forms), 8, (self._hessians * column).entries())

    def _values(self, column: acb_mat, gradients: acb_mat) -> list[acb]:
        return [value / 2 for value in (gradients * column).entries()]

    def at(self, point: Sequence[acb], sides: Sequence[int]) -> tuple[acb_mat, acb_mat]:
        """Return the seven equations, six constraints and ``e . f``, and their Jacobian.

        Parameters
        ----------
        point
            A Study point, 8 coordinates.
        sides
            For each constraint the index of its equation.

        Returns
        -------
        values, jacobian
            Shapes (7, 1) and (7, 8).
        """
        column = acb_mat(8, 1, list(point))
        single = self._single_quadrics(tuple(sides))
        if single is not None:
            jacobian = acb_mat(7, 8, (single * column).entries())
            return acb_mat(7, 1, self._values(column, jacobian)), jacobian
        gradients = self._gradients(column)
        quadrics = self._values(column, gradients)
        # The chain rule: derivatives of the equations by the values of the quadrics.
        outer = [[acb(0)] * len(quadrics) for _ in range(7)]
        values = [quadrics[1]]
        outer[0][1] = acb(1)
        for row, (equations, side) in enumerate(zip(self.equations, sides, strict=True), 1):
            equation = equations[side]
            values.append(_value(equation, quadrics))
            if equation.squares:
                outer[row][study.NORM] += quadrics[equation.main]
                outer[row][equation.main] += quadrics[study.NORM]
            else:
                outer[row][equation.main] += 1
            for index in equation.squares:
                outer[row][index] -= 2 * quadrics[index]
        return acb_mat(7, 1, values), acb_mat(outer) * gradients

    def open_equations(self, sides: tuple[int, ...]) -> list[OpenEquation] | None:
        """Return e.f and the six equations, None if one has a distance of lines.

        Quadrics are scaled so that the value (the square of a distance, a height, a cosine) has the
        coefficient -N in its equation.
        """
        found = [OpenEquation((self._hessian(self._entries[1]),))]
        for given, equations, side in zip(self.statements, self.equations, sides, strict=True):
            equation = equations[side]
            if not equation.squares:
                directions = [norm(vector) for vector in (given.u, given.v) if vector]
                factor = acb(1 / prod(directions, start=arb(1)))
                quadric = self._hessian(self._entries[equation.main]) * factor
                found.append(OpenEquation((quadric,)))
                continue
            if given.kind.law is not Law.SQUARE:
                return None
            rows = arb_mat(
                [
                    [f.get(k, arb(0)) for k in range(study.COUNT)]
                    for f in heights(given.a, given.b, given.u, given.v)
                ]
            )
            entries = (rows * arb_mat(_hessians())).entries()
            a, b = (self._hessian(entries[64 * k : 64 * (k + 1)]) for k in range(2))
            factors = a + b * acb(0, 1), a - b * acb(0, 1)
            found.append(OpenEquation(factors, given.value * given.value))
        return found

    @staticmethod
    def _hessian(entries: list[Any]) -> acb_mat:
        return acb_mat(8, 8, entries)

    def _single_quadrics(self, sides: tuple[int, ...]) -> acb_mat | None:
        """Return the Hessian matrices, (56, 8), if each equation is a quadric alone, else None."""
        if sides not in self._single:
            chosen = [each[side] for each, side in zip(self.equations, sides, strict=True)]
            entries = chain.from_iterable(
                self._entries[k] for k in (1, *(equation.main for equation in chosen))
            )
            self._single[sides] = (
                None
                if any(equation.squares for equation in chosen)
                else acb_mat(56, 8, list(entries))
            )
        return self._single[sides]

    @cached_property
    def _second(self) -> NDArray[np.float64]:
        """Bounds of the sum of the moduli of the second derivatives of each quadric."""
        return np.asarray(self._moduli.sum(axis=(1, 2)))

    def curvatures(self, moduli: NDArray[np.float64]) -> NDArray[np.float64]:
        """Bound the sum of the moduli of all second derivatives of each equation, on any side.

        Parameters
        ----------
        moduli
            Upper bounds of the moduli of the coordinates in the region, shape (..., 8).

        Returns
        -------
        NDArray[np.float64]
            Upper bounds, shape (..., 7), rounded outward.
        """
        second = self._second
        if not any(equation.squares for equations in self.equations for equation in equations):
            shape = moduli.shape[:-1]
            bounds = [np.full(shape, second[1])]
            mains = ([equation.main for equation in equations] for equations in self.equations)
            bounds += [np.full(shape, second[main].max()) for main in mains]
            return np.asarray(above(np.stack(bounds, axis=-1)))
        first = moduli @ self._moduli.sum(axis=1).T
        gradients = (moduli @ self._moduli.reshape(-1, 8).T).reshape(*first.shape, 8)
        value = (gradients * moduli[..., None, :]).sum(axis=-1) / 2
        bounds = [np.full(first.shape[:-1], second[1])]
        for equations in self.equations:
            a = [equation.main for equation in equations]
            if not equations[0].squares:
                bounds.append(np.full(first.shape[:-1], second[a].max()))
                continue
            [k] = a
            bound = second[0] * value[..., k] + value[..., 0] * second[k]
            bound += 2 * first[..., 0] * first[..., k]
            for b in equations[0].squares:
                bound += 2 * (first[..., b] ** 2 + value[..., b] * second[b])
            bounds.append(bound)
        return np.asarray(above(np.stack(bounds, axis=-1)))


@cache
def monomials() -> fmpz_mat:
    """Return the coefficients of e_i e_j, e_i f_j and f.f in each form (native/fine_points.hpp)."""
    hessians = study.form_hessians().astype(int)
    columns = [[int(h[i, j]) // (2 if i == j else 1) for i, j in places()] for h in hessians]
    return fmpz_mat(columns)


def places() -> list[tuple[int, int]]:
    """Return the entries of Hessian matrices that have the coefficients of `monomials`."""
    turning = [(i, j) for i in range(4) for j in range(i, 4)]
    return [*turning, *((i, j) for i in range(4) for j in range(4, 8)), (4, 4)]


def _nearer(
    sides: Sequence[BallEquation], places: Sequence[Sequence[acb]], said: int
) -> tuple[int, ...]:
    """Return which equations are near zero, by the values that separate them best."""
    if len(sides) == 1:
        return (0,)
    first, second = sides
    pairs = [
        (float(values[first.main].abs_upper()), float(values[second.main].abs_upper()))
        for values in places
    ]
    return _likelier(pairs, said)


def _value(equation: BallEquation, quadrics: Sequence[acb]) -> acb:
    if not equation.squares:
        return quadrics[equation.main]
    value = quadrics[study.NORM] * quadrics[equation.main]
    for index in equation.squares:
        value -= quadrics[index] * quadrics[index]
    return value


def _likelier(pairs: Sequence[tuple[float, float]], said: int) -> tuple[int, ...]:
    """Return the side whose equation is nearer; both, the likelier first, if it is not clear.

    Parameters
    ----------
    pairs
        The distances from both equations, measured in several ways; the way that separates the
        sides best is used.
    said
        1 or -1 for the likelier side if it is not clear, or 0.
    """
    a, b = max(pairs, key=_contrast)
    order = (0, 1) if a <= b else (1, 0)
    if _contrast((a, b)) > _CLEAR:
        return order[:1]
    return {1: (0, 1), -1: (1, 0)}.get(said, order)


def _contrast(pair: tuple[float, float]) -> float:
    return abs(pair[0] - pair[1]) / (sum(pair) or 1.0)


@dataclass(frozen=True)
class Measurement:
    """A constraint measured on a real pose, in the units of the instance."""

    #: A ball of the distance or angle.
    value: arb
    #: A ball of the value that the constraint states.
    target: arb
    #: For PH and HP a ball of the signed distance, positive where the normal points.
    height: arb | None = None


def measure(system: BallSystem, pose: PoseBall) -> list[Measurement]:
    """Measure all constraints on a real pose."""
    R = [[entry.real for entry in row] for row in pose.rotation]
    T = [entry.real for entry in pose.translation]
    return [_measure(statement, R, T) for statement in system.statements]


def _measure(given: Statement, R: list[list[arb]], T: list[arb]) -> Measurement:
    kind, target = given.kind, given.value * given.unit
    u = rotated(R, given.u) if given.u else []
    if not kind.is_distance:
        angle = _angle(u, given.v)
        if kind.law is not Law.COSINE:
            angle = (arb.pi() if kind.law.is_cosine else arb.pi() / 2) - angle
        return Measurement(angle * given.unit, target)
    w = [x + t - y for x, t, y in zip(rotated(R, given.a), T, given.b, strict=True)]
    if kind.law is Law.MOMENT:
        common = cross(u, given.v)
        return Measurement(abs(dot(w, common)) / norm(common) * given.unit, target)
    axis = u or given.v
    if kind.law is Law.SQUARE:
        distance = norm(cross(w, axis)) / norm(axis) if axis else norm(w)
        return Measurement(distance * given.unit, target)
    height = dot(w, axis) / norm(axis) * given.unit
    height = -height if u else height
    return Measurement(abs(height), target, height)


def _angle(u: list[arb], v: list[arb]) -> arb:
    """Return the angle of two vectors, in [0, pi]; it is accurate near 0 and pi, too."""
    return arb.atan2(norm(cross(u, v)), dot(u, v))


def residual(measurements: Sequence[Measurement]) -> arb:
    """Bound the largest difference of a measured and a stated value."""
    return largest([m.value - m.target for m in measurements])


def satisfies_constraints(system: BallSystem, pose: PoseBall, *, real: bool) -> bool:
    """Whether the stated constraints are proved to hold.

    Only the equation of a distance of two lines has other solutions: parallel lines at any
    distance.
    """
    if real and any(not m.value.overlaps(m.target) for m in measure(system, pose)):
        return False
    for given in system.statements:
        if given.kind is DLL:
            normal = cross(
                rotated(pose.rotation, [acb(x) for x in given.u]), list(map(acb, given.v))
            )
            if dot(normal, normal).contains(0):
                return False
    return True
