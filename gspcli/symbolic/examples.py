"""Examples 6.2 and 6.8 solved in exact radicals from their triangular sets."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import TypeAlias

from sympy import Expr, Matrix, Rational, Symbol, radsimp, sqrt, sqrtdenest, sympify, together

from gspcli.errors import GspError
from gspcli.symbolic.closed_forms import derive
from gspcli.symbolic.triangular import TriangularPolynomial

Number: TypeAlias = int | Expr
Point: TypeAlias = tuple[Expr, Expr, Expr]

_HALF = Rational(1, 2)
#: The order of Table 1: the root of h1 as an equation for r32² (-1 the smaller), the sign of r32
#: and the sign of r31.
_TABLE_1_ORDER = (
    (-1, 1, -1), (-1, 1, 1), (1, -1, 1), (1, -1, -1),
    (1, 1, -1), (1, 1, 1), (-1, -1, -1), (-1, -1, 1),
)  # fmt: skip


def example_6_2_rotations(
    d1: Number = _HALF, d2: Number = _HALF, d3: Number = _HALF
) -> list[Matrix]:
    """Return the eight rotations of Example 6.2 in the order of Table 1.

    Parameters
    ----------
    d1, d2, d3
        The cosines of the three angles; exact numbers.

    Returns
    -------
    list of Matrix
        Exact 3 × 3 matrices, complex where no real rotation exists.

    Raises
    ------
    GspError
        If a condition of the triangular set fails: d1 = ±1, d3 = d1·d2 or d2 = d1·d3.
    """
    triangular = derive("6.2")
    given = _symbols(d1=d1, d2=d2, d3=d3)
    for condition in triangular.conditions:
        if condition.polynomial.as_expr().subs(given) == 0:
            raise GspError(_degenerate(d1, d2, d3, condition.meaning))
    h1, h2, *linear = triangular.elements
    rotations = []
    for which, sign_r32, sign_r31 in _TABLE_1_ORDER:
        known = dict(given)
        constant, middle = (_coefficient(h1, degree, known) for degree in (0, 2))
        square = (-middle + which * sqrt(middle**2 - 4 * constant)) / 2
        known[Symbol("r32")] = _tidy(sign_r32 * sqrt(square))
        known[Symbol("r31")] = _tidy(sign_r31 * sqrt(-_coefficient(h2, 0, known)))
        for element in linear:
            slope, rest = (_coefficient(element, degree, known) for degree in (1, 0))
            if slope == 0:
                meaning = f"the initial of {element.name} is 0"
                raise GspError(_degenerate(d1, d2, d3, meaning))
            known[Symbol(element.leading)] = _tidy(-rest / slope)
        known |= dict(zip(map(Symbol, ("r33", "r22", "r11")), given.values(), strict=True))
        rotations.append(
            Matrix(3, 3, lambda i, j, k=known: together(k[Symbol(f"r{i + 1}{j + 1}")]))
        )
    return rotations


def example_6_8_points(r1: Number, r2: Number, r3: Number) -> list[Point]:
    """Return the eight points of Example 6.8 in the order of Table 2.

    Parameters
    ----------
    r1, r2, r3
        The radii of the cylinders about the z, y and x axis (equation (17)); exact numbers.
    """
    given = _symbols(r1=r1, r2=r2, r3=r3)
    roots = [
        _tidy(sqrt(-_coefficient(element, 0, given) / _coefficient(element, 2, given)))
        for element in derive("6.8").elements
    ]
    x, y, z = roots
    return [(a * x, b * y, c * z) for a, b, c in product((1, -1), repeat=3)]


def equal_numbers(first: str, second: str) -> bool:
    """Say whether two radicals, as ``1/(1-sqrt(5))``, are the same number, exactly."""
    return bool(radsimp(sympify(first) - sympify(second)).expand() == 0)


def _symbols(**numbers: Number) -> dict[Symbol, Expr]:
    return {Symbol(name): sympify(number) for name, number in numbers.items()}


def _degenerate(d1: Number, d2: Number, d3: Number, why: str) -> str:
    return f"Example 6.2 with cosines {d1}, {d2}, {d3} is not in general position: {why}"


def _coefficient(element: TriangularPolynomial, degree: int, known: Mapping[Symbol, Expr]) -> Expr:
    expression = element.polynomial.as_expr().expand()
    return expression.coeff(Symbol(element.leading), degree).subs(known).expand()


def _tidy(number: Expr) -> Expr:
    return sqrtdenest(radsimp(number)).expand()
