"""Poses from the eigenvectors of multiplication matrices, without any path.

The algebra of solutions is computed with any number of digits; the elimination follows the one
modulo a prime. The eigenvectors of the multiplication by a linear form are the values of the normal
monomials at the solutions. Poses far away are found like near ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import log2
from random import Random
from typing import Any

from flint import acb, acb_mat, acb_poly, arb, arb_mat, arb_poly, ctx, fmpq

from gspcli.certification.counting.elements import FieldElement, NoElementError, Sum
from gspcli.certification.counting.exact_counts import work_limit
from gspcli.certification.counting.modular_platform import (
    ModularPlatform,
    NotCountedError,
    on_sides,
)
from gspcli.certification.counting.motion_equations import (
    Function,
    MotionEquations,
    equations,
    evaluated,
    exact_constraints,
    with_moments,
)
from gspcli.certification.counting.residue_counts import EliminationTrace, Ending, Step, count
from gspcli.certification.numbers.balls import power_of_two, rotated
from gspcli.defaults import COUNT_LIMIT, SEED
from gspcli.geometry import study
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.geometry.numbers import Number
from gspcli.records import dataclass

#: A polynomial, by packed exponents; and a vector over normal monomials, by their positions.
Polynomial = dict[int, arb]
Vector = dict[int, arb]

ONE = arb(1)
#: The relations of the coordinates have fractions with denominators and numerators below these.
_MAX_DENOMINATOR, _MAX_NUMERATOR = 64, 2**20


class NotFollowedError(ValueError):
    """An elimination that cannot be followed; says why."""


def add(vector: dict[int, arb], at: int, value: arb) -> None:
    """Add a value at one place."""
    present = vector.get(at)
    vector[at] = value if present is None else present + value


def add_multiple(polynomial: Polynomial, other: Polynomial, factor: arb) -> None:
    """Add a multiple of another polynomial."""
    for monomial, value in other.items():
        add(polynomial, monomial, value * factor)


def add_product(polynomial: Polynomial, first: Polynomial, second: Polynomial, factor: arb) -> None:
    """Add a multiple of the product of two polynomials."""
    for a, x in first.items():
        scaled = x * factor
        for b, y in second.items():
            add(polynomial, a + b, scaled * y)


def small_fraction(residue: int, prime: int) -> arb:
    """Return the fraction of small integers with a residue."""
    for denominator in range(1, _MAX_DENOMINATOR):
        numerator = residue * denominator % prime
        numerator -= prime if numerator > prime // 2 else 0
        if abs(numerator) < _MAX_NUMERATOR:
            return arb(fmpq(numerator, denominator))
    raise NotFollowedError(
        f"the relation {residue} of the coordinates modulo {prime} is no small fraction"
    )


def products_of_coordinates(position: int, has_translation: bool) -> list[tuple[int, int, int]]:
    """Return products of coordinates, and signs: a function without a coordinate is their sum."""
    rotation = study.ROTATION
    if position == study.RHO:
        vector = study.TRANSLATION if has_translation else study.BODY
        return [(k, k, 1) for k in vector]
    if position in study.BODY:
        j = study.BODY.index(position)
        return [(rotation[i][j], study.TRANSLATION[i], 1) for i in range(3)]
    if position in study.TRANSLATION:
        i = study.TRANSLATION.index(position)
        return [(rotation[i][j], study.BODY[j], 1) for j in range(3)]
    i, j = divmod(position - study.MOMENT[0][0], 3)
    turned = i if has_translation else j
    after, last = (turned + 1) % 3, (turned + 2) % 3
    if has_translation:  # (T x R)_ij
        first, second = study.TRANSLATION[after], study.TRANSLATION[last]
        return [(rotation[last][j], first, 1), (rotation[after][j], second, -1)]
    first, second = study.BODY[last], study.BODY[after]  # (R x U)_ij
    return [(rotation[i][after], first, 1), (rotation[i][last], second, -1)]


def solved_rows(
    rows: Sequence[Vector], pivots: Sequence[int], others: Sequence[int]
) -> list[list[arb]]:
    """Return the other columns of the rows, reduced: each pivot is 1 and alone in its column."""
    if not rows:
        return []
    zero = arb(0)
    matrix = arb_mat([[row.get(c, zero) for c in pivots] for row in rows])
    right = arb_mat([[row.get(c, zero) for c in others] for row in rows])
    entries = matrix.solve(right, algorithm="approx").entries() if others else []
    width = len(others)
    return [entries[k * width : (k + 1) * width] for k in range(len(pivots))]


def affine_forms(
    equations: MotionEquations, trace: EliminationTrace, units: Sequence[int]
) -> dict[int, Polynomial]:
    """Return the coordinates in use as affine forms, by the linear equations."""
    forms: dict[int, Polynomial] = {study.NORM: {0: ONE}}
    forms |= {k: {unit: ONE} for k, unit in zip(trace.variables, units, strict=True)}
    pivots = [k for k in trace.coordinates if k not in forms]
    if pivots:
        others = [study.NORM, *trace.variables]
        rows = [
            {k: arb(value) for k, value in equation.linear.items()}
            for number, equation in enumerate(equations.equations)
            if number not in trace.quadrics
        ]
        for pivot, row in zip(pivots, solved_rows(rows, pivots, others), strict=True):
            forms[pivot] = {
                monomial: -value for monomial, value in zip([0, *units], row, strict=True)
            }
    return forms


_BITS = 5
_MASK = 2**_BITS - 1


def _degree(monomial: int) -> int:
    total = 0
    while monomial:
        total += monomial & _MASK
        monomial >>= _BITS
    return total


class FollowedElimination:
    """The algebra of solutions: normal monomials and their products with the variables.

    Parameters
    ----------
    equations
        The equations with balls as coefficients.
    trace
        The record of the elimination modulo a prime.
    """

    def __init__(self, equations: MotionEquations, trace: EliminationTrace) -> None:
        self.variables = len(trace.variables)
        self._units = [1 << (_BITS * i) for i in range(self.variables)]
        #: For each function of the motion that is a coordinate, an affine form in the variables.
        self.forms = affine_forms(equations, trace, self._units)
        self.normal: list[int] = [0]
        self._start = [0]
        self._position = {0: 0}
        self._known: dict[int, Vector] = {}
        #: Of the step that is followed: its degree, its columns, and their number with those of the
        #: normal monomials, the least of which are last.
        self._degree, self._width = 0, 0
        self._column_of: dict[int, int] = {}
        #: The reduced rows of each step.
        self._reduced: list[Callable[[int], Polynomial]] = []
        self._generators = self._first_generators(equations, trace)
        for step in trace.steps:
            self._follow(step)

    @property
    def dimension(self) -> int:
        """The number of solutions."""
        return len(self.normal)

    def multiplication(self, form: Sequence[int]) -> arb_mat:
        """Return the matrix of the multiplication of the normal monomials by a linear form.

        Its right eigenvectors are the values of the normal monomials at the solutions; its
        eigenvalues are those of the form.
        """
        size = self.dimension
        rows = [[arb(0)] * size for _ in range(size)]
        for row, monomial in zip(rows, self.normal, strict=True):
            for factor, unit in zip(form, self._units, strict=True):
                for position, value in self._vector(monomial + unit).items():
                    row[position] += factor * value
        return arb_mat(rows)

    def coordinates(self) -> list[Vector]:
        """Return each variable as a vector over the normal monomials."""
        return [self._vector(unit) for unit in self._units]

    def functions(self, variables: Sequence[acb]) -> dict[int, acb]:
        """Return the values of all coordinates in use, from those of the variables."""
        at = dict(zip(self._units, variables, strict=True)) | {0: acb(1)}
        return {
            function: sum((at[monomial] * x for monomial, x in form.items()), acb(0))
            for function, form in self.forms.items()
        }

    # --- generators

    def _first_generators(
        self, equations: MotionEquations, trace: EliminationTrace
    ) -> list[Polynomial]:
        forms = [self.forms[k] for k in trace.coordinates]
        result = []
        for relation in trace.relations:
            polynomial: Polynomial = {}
            entries = iter(relation)
            for i, first in enumerate(forms):
                for second in forms[: i + 1]:
                    residue = next(entries)
                    if residue:
                        value = small_fraction(residue, trace.prime)
                        add_product(polynomial, first, second, value)
            result.append(polynomial)
        for number in trace.quadrics:
            equation = equations.equations[number]
            polynomial = self._quadric(equation.linear)
            for weight, function in equation.squares:
                form = self._combined(function)
                add_product(polynomial, form, form, arb(weight))
            result.append(polynomial)
        return result

    def _combined(self, function: Function) -> Polynomial:
        result: Polynomial = {}
        for position, coefficient in function.items():
            add_multiple(result, self.forms[position], arb(coefficient))
        return result

    def _quadric(self, function: Function) -> Polynomial:
        """Return a function of the motion, as a product of coordinates if it is not one."""
        result: Polynomial = {}
        for position, coefficient in function.items():
            value = arb(coefficient)
            if position in self.forms:
                add_multiple(result, self.forms[position], value)
                continue
            for first, second, sign in products_of_coordinates(
                position, study.TRANSLATION[0] in self.forms
            ):
                add_product(result, self.forms[first], self.forms[second], value * sign)
        return result

    # --- one step

    def _follow(self, step: Step) -> None:
        self._forget_from(step.degree)
        below = self.dimension
        columns = sorted(
            {m + unit for m in self.normal[self._start[step.degree - 1] :] for unit in self._units}
        )
        top = len(columns)
        self._degree, self._width = step.degree, top + below
        self._column_of = {monomial: c for c, monomial in enumerate(columns)}
        rows = [self._row(source) for source in step.sources]
        others = sorted(set(range(self._width)) - set(step.pivots))
        solved = solved_rows(rows, step.pivots, others)
        self._reduced.append(
            _reduced_rows([*columns, *reversed(self.normal)], step, others, solved)
        )
        falls = [row for row, pivot in enumerate(step.pivots) if pivot >= top]
        if falls:
            self._generators += map(self._reduced[-1], falls)
            return
        self._start.append(below)
        for column in reversed(others):
            if column < top:
                self._position[columns[column]] = self.dimension
                self.normal.append(columns[column])
        positions = [self._position[columns[c]] if c < top else self._width - 1 - c for c in others]
        for row, pivot in enumerate(step.pivots):
            self._known[columns[pivot]] = {
                position: -value
                for position, value in zip(positions, solved[row], strict=True)
                if not value.is_zero()
            }

    def _forget_from(self, degree: int) -> None:
        if len(self._start) <= degree:
            return
        del self.normal[self._start[degree] :]
        del self._start[degree:]
        self._position = {monomial: k for k, monomial in enumerate(self.normal)}
        self._known = {m: v for m, v in self._known.items() if _degree(m) < degree}

    def _row(self, source: Sequence[int]) -> Vector:
        row: Vector = {}
        if len(source) == 1 or source[0] < 0:
            number, *rest = source
            polynomial = self._reduced[rest[0]](rest[1]) if rest else self._generators[number]
            for monomial, value in polynomial.items():
                self._add_term(row, monomial, value)
            return row
        i, j, *exponents = source
        monomial = sum(e << (_BITS * k) for k, e in enumerate(exponents))
        for first, second, sign in ((i, j, ONE), (j, i, -ONE)):
            vector = self._vector(monomial + self._units[first])
            self._add_multiplied(row, vector, second, sign)
        return row

    def _add_term(self, row: Vector, monomial: int, value: arb) -> None:
        """Add a multiple of a monomial to a row."""
        if monomial == 0:
            add(row, self._width - 1, value)
        elif monomial in self._column_of:
            add(row, self._column_of[monomial], value)
        elif _degree(monomial) <= self._degree:  # otherwise it is exactly zero
            i = self._divisor(monomial)
            rest = self._normal_form(monomial - self._units[i])
            self._add_multiplied(row, rest, i, value)

    def _add_multiplied(self, row: Vector, vector: Vector, i: int, factor: arb) -> None:
        """Add a multiple of a variable times a vector to a row."""
        last = self._start[self._degree - 1]
        unit = self._units[i]
        for position, value in vector.items():
            monomial, product = self.normal[position] + unit, value * factor
            if position >= last:
                add(row, self._column_of[monomial], product)
            elif monomial in self._position:
                add(row, self._width - 1 - self._position[monomial], product)
            else:
                for at, x in self._known[monomial].items():
                    add(row, self._width - 1 - at, product * x)

    def _vector(self, monomial: int) -> Vector:
        position = self._position.get(monomial)
        return self._known[monomial] if position is None else {position: ONE}

    def _divisor(self, monomial: int) -> int:
        """Return the first variable that divides and whose quotient is known, as in the kernel."""
        dividing = [i for i in range(self.variables) if monomial >> (_BITS * i) & _MASK]
        for i in dividing:
            rest = monomial - self._units[i]
            if rest in self._position or rest in self._known:
                return i
        return dividing[-1]

    def _normal_form(self, monomial: int) -> Vector:
        if monomial in self._position or monomial in self._known:
            return self._vector(monomial)
        i = self._divisor(monomial)
        result: Vector = {}
        for position, value in self._normal_form(monomial - self._units[i]).items():
            for at, x in self._vector(self.normal[position] + self._units[i]).items():
                add(result, at, value * x)
        return result


def _reduced_rows(
    monomials: Sequence[int], step: Step, others: Sequence[int], solved: Sequence[Sequence[arb]]
) -> Callable[[int], Polynomial]:
    """Return a function that gives a row of a step as a polynomial."""

    def polynomial(row: int) -> Polynomial:
        pivot = step.pivots[row]
        terms = zip(others, solved[row], strict=True)
        return {monomials[pivot]: ONE} | {monomials[c]: x for c, x in terms if c > pivot}

    return polynomial


_ISOLATED_BITS = 30
#: The binary logarithm of the ratio from which roots are of different sizes: each part of a
#: polynomial gives them to so many bits, about.
_APART_BITS = 20
#: The most times that all of them are improved together.
_SWEEPS = 40
#: The power of the matrix in which the largest eigenvalues dominate.
_POWERS = 6


class SpectrumError(ValueError):
    """The precision does not suffice to separate the eigenvalues."""


def eigenvectors(matrix: arb_mat, entries: Sequence[int]) -> list[tuple[acb, ...]]:
    """Return some entries of each right eigenvector of a matrix with distinct eigenvalues.

    Parameters
    ----------
    matrix
        A square matrix; only its midpoints are used.
    entries
        The entries to return.

    Raises
    ------
    SpectrumError
        If the eigenvalues cannot be separated.
    """
    size = matrix.nrows()
    flat = [entry.mid() for entry in matrix.entries()]
    rows = [flat[size * i : size * (i + 1)] for i in range(size)]
    steps = _to_hessenberg(rows)
    restoring = arb_mat([_restoring_row(k, size, steps) for k in entries])
    result: list[tuple[acb, ...]] = []
    for value in _eigenvalues(rows):
        column = (restoring * acb_mat(size, 1, _vector(rows, value))).entries()
        result.append(tuple(x.mid() for x in column))
        if isinstance(value, acb):
            result.append(tuple(x.conjugate().mid() for x in column))
    return result


def largest_eigenvectors(
    matrix: arb_mat, entries: Sequence[int], number: int
) -> list[tuple[acb, ...]]:
    """Return some entries of each right eigenvector of the largest eigenvalues.

    This saves a third of the time of a first solution if poses are far away because of rounding
    (`tools.verify.realistic`, hexapods in floating point).

    Parameters
    ----------
    matrix, entries
        As for `eigenvectors`; the errors are the same.
    number
        The number of eigenvalues that are much larger than the others. If they are not, the result
        is meaningless.
    """
    size, random = matrix.nrows(), Random(0)
    # The sizes of the entries of these eigenvectors are proportional to those of the rows.
    sums = (matrix * arb_mat(size, 1, [1] * size)).entries()
    scales = [power_of_two(float(abs(x).mid())) for x in sums]
    image, forms = (
        arb_mat([[sign * x for sign in random.choices((-1, 1), k=number)] for x in each])
        for each in (scales, [1 / x for x in scales])
    )
    for _ in range(_POWERS):
        basis, image = image, (matrix * image).mid()
    forms = forms.transpose()
    small = (forms * basis).solve(forms * image, algorithm="approx")
    flat = basis.entries()
    rows = arb_mat([flat[number * k : number * (k + 1)] for k in entries])
    found = eigenvectors(small, range(number))
    columns = ((rows * acb_mat(number, 1, vector)).entries() for vector in found)
    return [tuple(x.mid() for x in column) for column in columns]


def _to_hessenberg(rows: list[list[arb]]) -> list[tuple[int, int, list[arb]]]:
    """Make a matrix Hessenberg in place, by eliminations with pivots; return the steps."""
    size = len(rows)
    steps = []
    for m in range(1, size - 1):
        pivot = max(range(m, size), key=lambda i: abs(rows[i][m - 1]))
        if rows[pivot][m - 1].is_zero():
            raise SpectrumError("the matrix is reducible")
        rows[m], rows[pivot] = rows[pivot], rows[m]
        for row in rows:
            row[m], row[pivot] = row[pivot], row[m]
        leading, upper = rows[m][m - 1], rows[m]
        factors = []
        for i in range(m + 1, size):
            row = rows[i]
            factor = (row[m - 1] / leading).mid()
            factors.append(factor)
            if factor.is_zero():
                continue
            row[m - 1] = arb(0)
            row[m:] = [(x - factor * y).mid() for x, y in zip(row[m:], upper[m:], strict=True)]
        for row in rows:
            total = row[m]
            for factor, x in zip(factors, row[m + 1 :], strict=True):
                total += factor * x
            row[m] = total.mid()
        steps.append((m, pivot, factors))
    return steps


def _eigenvalues(rows: Sequence[Sequence[arb]]) -> list[arb | acb]:
    """Return the real eigenvalues of a Hessenberg matrix, and one of each pair of conjugates."""
    polynomials = [arb_poly([1])]
    for k in range(len(rows)):
        current = arb_poly([-rows[k][k], 1]) * polynomials[k]
        product = arb(1)
        for i in range(k - 1, -1, -1):
            product = (product * rows[i + 1][i]).mid()
            current -= polynomials[i] * (rows[i][k] * product)
        polynomials.append(arb_poly([x.mid() for x in current.coeffs()]))
    last = polynomials[-1]
    parts = _parts(last)
    try:
        roots = [[unit * root for root in part.complex_roots()] for part, unit in parts]
    except ValueError as error:
        raise SpectrumError(str(error)) from None
    if len(parts) > 1:
        return _together(acb_poly(last), [root.mid() for each in roots for root in each])
    # Balls about the roots are disjoint: one that contains a real number has a real root.
    real = [root.real.mid() for root in roots[0] if root.imag.contains(0)]
    upper = [root.mid() for root in roots[0] if root.imag > 0]
    return [
        *(_polished(last, root) for root in real),
        *(_polished(acb_poly(last), root) for root in upper),
    ]


def _parts(polynomial: arb_poly) -> list[tuple[arb_poly, arb]]:
    """Return polynomials with the roots of one of about equal sizes, in units of these.

    Poses that are 1e24 lengths away have eigenvalues of this size. FLINT does not find the roots of
    a polynomial whose sizes differ so much. The slopes of its Newton polygon are their logarithms,
    and the coefficients between two corners give the roots of one size, up to the ratio of sizes.
    """
    coefficients = polynomial.coeffs()
    # Corners of the polygon, and the logarithms of the sizes between them.
    corners: list[tuple[int, float]] = []
    for k, x in enumerate(coefficients):
        if x.is_zero():
            continue
        here = (k, _logarithm(x))
        while len(corners) > 1 and _slope(corners[-2], here) >= _slope(corners[-2], corners[-1]):
            corners.pop()
        corners.append(here)
    kept = corners[:1]
    for k in range(1, len(corners) - 1):
        sizes = [-_slope(corners[k + i - 1], corners[k + i]) for i in (0, 1)]
        if sizes[1] - sizes[0] > _APART_BITS:
            kept.append(corners[k])
    kept.append(corners[-1])
    result = []
    for first, last in pairwise(kept):
        unit = arb(2) ** round(-_slope(first, last))
        part = coefficients[first[0] : last[0] + 1]
        scaled = [(x * unit**k).mid() for k, x in enumerate(part)]
        result.append((arb_poly(scaled), unit))
    return result


def _together(polynomial: acb_poly, roots: list[acb]) -> list[arb | acb]:
    """Return all real roots and one of each pair of conjugates, from bad approximations of all.

    Each step keeps away from the other roots (O. Aberth, Iteration methods for finding all zeros of
    a polynomial simultaneously, Mathematics of Computation 27, 1973).
    """
    derivative = polynomial.derivative()
    for _ in range(_SWEEPS):
        largest = arb(0)
        for k, root in enumerate(roots):
            step = polynomial(root).mid() / derivative(root).mid()
            others = sum((1 / (root - x) for i, x in enumerate(roots) if i != k), acb(0)).mid()
            step = (step / (1 - step * others)).mid()
            roots[k] = (root - step).mid()
            largest = max(largest, abs(step / root).mid())
        if largest < arb(2) ** (-ctx.prec // 4):
            break
    least = arb(2) ** (-ctx.prec // 8)
    real = [x for x in roots if abs(x.imag) <= least * abs(x)]
    return [*(x.real for x in real), *(x for x in roots if x.imag > least * abs(x))]


def _logarithm(x: arb) -> float:
    """Return the logarithm of the size of a number for the base 2."""
    mantissa, exponent = x.mid().man_exp()
    return float(int(exponent)) + log2(abs(int(mantissa)))


def _slope(first: tuple[int, float], last: tuple[int, float]) -> float:
    return (last[1] - first[1]) / (last[0] - first[0])


def _polished(polynomial: Any, root: Any) -> Any:
    """Return a root of a polynomial in the working precision, by Newton's method."""
    derivative = polynomial.derivative()
    # FLINT's roots have some thirty correct bits at least, and each step doubles them.
    for _ in range(max(ctx.prec // _ISOLATED_BITS, 1).bit_length() + 1):
        root = (root - (polynomial(root) / derivative(root)).mid()).mid()
    return root


def _vector(rows: Sequence[Sequence[arb]], value: Any) -> list[Any]:
    """Return an eigenvector of a Hessenberg matrix from its last entry upwards."""
    size = len(rows)
    vector: list[Any] = [arb(0)] * size
    vector[-1] = arb(1)
    for i in range(size - 1, 0, -1):
        row = rows[i]
        total = value * vector[i]
        for x, y in zip(row[i:], vector[i:], strict=True):
            total -= x * y
        vector[i - 1] = (total / row[i - 1]).mid()
    return vector


def _restoring_row(k: int, size: int, steps: Sequence[tuple[int, int, Sequence[arb]]]) -> list[arb]:
    """Return the row that gives an entry of an eigenvector from that of the Hessenberg form."""
    row = [arb(0)] * size
    row[k] = arb(1)
    for m, pivot, factors in steps:
        row[m], row[pivot] = row[pivot], row[m]
        total = row[m]
        for factor, x in zip(factors, row[m + 1 :], strict=True):
            if not x.is_zero():
                total += factor * x
        row[m] = total.mid()
    return row


#: The coefficients of the linear form are below this number.
_COEFFICIENTS = 64
#: In degrees, an angle whose cosine has an image, and no special value.
_OTHER_ANGLE = Number.of(37)


@dataclass(frozen=True)
class ApproximatePose:
    """A complex pose in high precision, without a bound of its error."""

    #: The rotation, by rows.
    R: tuple[tuple[acb, acb, acb], ...]
    #: The translation.
    T: tuple[acb, acb, acb]


def poses_by_elimination(
    instance: Instance, bits: int, *, near: int = 0, seed: int = SEED
) -> Iterator[ApproximatePose]:
    """Yield approximations of all poses of an instance, by eigenvectors.

    Parameters
    ----------
    instance
        The platform.
    bits
        The working precision. A pose at a distance L needs a multiple of log2(L) bits.
    near
        The number of poses on a choice of sides, at least half of all, that are much nearer than
        the others. The others are then yielded first, in a fraction of the time.
    seed
        As in `exact_count`.

    Yields
    ------
    As many poses as there are solutions with multiplicity; multiple ones are inaccurate. None if
    there are infinitely many, or if the elimination cannot be followed.
    """
    try:
        exact = exact_constraints(instance)
        platform = _modular_platform(instance, seed)
    except (NoElementError, NotCountedError):
        return
    with ctx.workprec(bits):
        rows = [evaluated(row, _real) for row in exact]
    for signs in platform.choices:
        result = count(
            with_moments(platform.equations(signs)),
            platform.blocks,
            platform.prime,
            seed=platform.randomness.below(2**63),
            max_work=work_limit(COUNT_LIMIT),
            find_distinct=False,
            moment_relations=False,
            trace=True,
        )
        assert result.followed is not None
        if result.outcome is not Ending.FINITE:
            return
        if result.solutions == 0:
            continue
        try:
            with ctx.workprec(bits):
                algebra = FollowedElimination(
                    with_moments(equations(on_sides(rows, signs))), result.followed
                )
                form = [
                    platform.randomness.below(_COEFFICIENTS) + 1 for _ in range(algebra.variables)
                ]
                matrix = algebra.multiplication(form)
        except (NotFollowedError, ZeroDivisionError):
            continue
        far = algebra.dimension - near
        for number in (far, 0) if 0 < far <= near else (0,):
            # The caller may use another precision.
            with ctx.workprec(bits):
                poses = _poses(algebra, matrix, number)
            yield from poses


def _modular_platform(instance: Instance, seed: int) -> ModularPlatform:
    """Return an instance modulo a prime, with other angles if its own have no image.

    The cosine of an angle of ten decimals has too large a degree. Almost all values have the same
    pivots. If those of the instance are not among them, no poses are found.
    """
    try:
        return ModularPlatform(instance, seed)
    except NotCountedError:
        angles = {
            k: _OTHER_ANGLE
            for k, row in enumerate(instance.constraints)
            if not row.kind.is_distance and row.value.fraction
        }
        if not angles or instance.units.angle is not AngleUnit.DEGREE:
            raise
        return ModularPlatform(instance.with_values(angles), seed)


def _real(element: FieldElement) -> arb:
    """Return a ball with a real element."""
    quotient: acb = _sum(element.numerator) / _sum(element.denominator)
    return quotient.real


def _sum(terms: Sum) -> acb:
    total = acb(0)
    for term, factor in terms.items():
        value = acb(fmpq(factor.numerator, factor.denominator))
        if term.radicand != 1:
            value *= arb(term.radicand).sqrt()
        if term.turn or term.radians:
            turn, radians = (fmpq(x.numerator, x.denominator) for x in (term.turn, term.radians))
            value *= acb(0, 2 * arb.pi() * turn + radians).exp()
        if term.pi:
            value *= arb.pi() ** term.pi
        total += value
    return total


def _poses(algebra: FollowedElimination, matrix: arb_mat, far: int) -> list[ApproximatePose]:
    """Return a number of poses far away, or all poses; none if there are too few digits."""
    coordinates = algebra.coordinates()
    entries = sorted({0}.union(*coordinates))
    try:
        if far:
            vectors = largest_eigenvectors(matrix, entries, far)
        else:
            vectors = eigenvectors(matrix, entries)
        return [_pose(algebra, dict(zip(entries, vector, strict=True))) for vector in vectors]
    except (SpectrumError, ZeroDivisionError):
        return []


def _pose(algebra: FollowedElimination, vector: dict[int, acb]) -> ApproximatePose:
    """Return the pose at which normal monomials have values in some proportion."""
    values = [
        sum((vector[k] * x for k, x in coordinate.items()), acb(0)) / vector[0]
        for coordinate in algebra.coordinates()
    ]
    functions = algebra.functions(values)
    x, y, z = (
        (functions[i].mid(), functions[j].mid(), functions[k].mid()) for i, j, k in study.ROTATION
    )
    if study.TRANSLATION[0] in functions:
        a, b, c = (functions[k] for k in study.TRANSLATION)
    else:
        a, b, c = rotated((x, y, z), [functions[k] for k in study.BODY])
    return ApproximatePose((x, y, z), (a.mid(), b.mid(), c.mid()))
