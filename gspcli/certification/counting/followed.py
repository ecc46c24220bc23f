"""The elimination in real numbers of any precision, with the pivots found modulo a prime.

The computation modulo the prime shows which rows are independent, their pivots and which entries
are exactly zero. So only linear systems with invertible matrices have to be solved. The results are
approximate and their errors are not bounded: the poses that follow from them are certified later.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flint import acb, arb, arb_mat

from gspcli.certification.counting.coordinate_forms import (
    ONE,
    Polynomial,
    Vector,
    add,
    add_multiple,
    add_product,
    affine_forms,
    products_of_coordinates,
    small_fraction,
    solved_rows,
)
from gspcli.certification.counting.motion_equations import Function, MotionEquations
from gspcli.certification.counting.residue_counts import EliminationTrace, Step
from gspcli.certification.equations import study

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
        column_of = {monomial: c for c, monomial in enumerate(columns)}
        width = top + below
        rows = [self._row(source, step.degree, column_of, width) for source in step.sources]
        others = sorted(set(range(width)) - set(step.pivots))
        solved = solved_rows(rows, step.pivots, others)
        self._reduced.append(
            _reduced_rows([*columns, *reversed(self.normal)], step, others, solved)
        )
        if any(pivot >= top for pivot in step.pivots):
            for row, pivot in enumerate(step.pivots):
                if pivot >= top:
                    self._add_fall(pivot, others, solved[row], width, top)
            return
        self._start.append(below)
        for column in reversed(others):
            if column < top:
                self._position[columns[column]] = self.dimension
                self.normal.append(columns[column])
        positions = [self._position[columns[c]] if c < top else width - 1 - c for c in others]
        for row, pivot in enumerate(step.pivots):
            self._known[columns[pivot]] = {
                position: -value
                for position, value in zip(positions, solved[row], strict=True)
                if not value.is_zero()
            }

    def _add_fall(
        self, pivot: int, others: Sequence[int], row: Sequence[arb], width: int, top: int
    ) -> None:
        leading = self.normal[width - 1 - pivot]
        polynomial = {leading: ONE}
        for column, value in zip(others, row, strict=True):
            # Entries before the pivot are exactly zero.
            if column > pivot and column >= top:
                polynomial[self.normal[width - 1 - column]] = value
        self._generators.append(polynomial)

    def _forget_from(self, degree: int) -> None:
        if len(self._start) <= degree:
            return
        del self.normal[self._start[degree] :]
        del self._start[degree:]
        self._position = {monomial: k for k, monomial in enumerate(self.normal)}
        self._known = {m: v for m, v in self._known.items() if _degree(m) < degree}

    def _row(
        self, source: Sequence[int], degree: int, column_of: dict[int, int], width: int
    ) -> Vector:
        row: Vector = {}
        if len(source) == 1 or source[0] < 0:
            number, *rest = source
            polynomial = self._reduced[rest[0]](rest[1]) if rest else self._generators[number]
            for monomial, value in polynomial.items():
                self._add_term(row, monomial, value, degree, column_of, width)
            return row
        i, j, *exponents = source
        monomial = sum(e << (_BITS * k) for k, e in enumerate(exponents))
        for first, second, sign in ((i, j, ONE), (j, i, -ONE)):
            vector = self._vector(monomial + self._units[first])
            self._add_multiplied(row, vector, second, sign, degree, column_of, width)
        return row

    def _add_term(
        self,
        row: Vector,
        monomial: int,
        value: arb,
        degree: int,
        column_of: dict[int, int],
        width: int,
    ) -> None:
        """Add a multiple of a monomial to a row."""
        if monomial == 0:
            add(row, width - 1, value)
        elif monomial in column_of:
            add(row, column_of[monomial], value)
        elif _degree(monomial) <= degree:  # otherwise it is exactly zero
            i = self._divisor(monomial)
            rest = self._normal_form(monomial - self._units[i])
            self._add_multiplied(row, rest, i, value, degree, column_of, width)

    def _add_multiplied(
        self,
        row: Vector,
        vector: Vector,
        i: int,
        factor: arb,
        degree: int,
        column_of: dict[int, int],
        width: int,
    ) -> None:
        """Add a multiple of a variable times a vector to a row."""
        last = self._start[degree - 1]
        unit = self._units[i]
        for position, value in vector.items():
            monomial, product = self.normal[position] + unit, value * factor
            if position >= last:
                add(row, column_of[monomial], product)
            elif monomial in self._position:
                add(row, width - 1 - self._position[monomial], product)
            else:
                for at, x in self._known[monomial].items():
                    add(row, width - 1 - at, product * x)

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
