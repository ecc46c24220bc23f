"""The ten intersections: every common point satisfies the set, and there are 1, 2, 4 or 8."""

import random
from collections.abc import Sequence
from itertools import combinations
from typing import Any

import pytest
from sympy import QQ, ZZ, Matrix, Poly, Rational, ring, symbols

from gspcli.symbolic.closed_forms import CASES, INTERSECTIONS, derive, determinant
from gspcli.symbolic.triangular import (
    TriangularSet,
    coefficient,
    coefficients,
    evaluate,
    parametrize,
    symbols_of,
)

#: Proposition 6.7.
SOLUTIONS = {
    "PPP": 1, "PPC": 2, "PPS": 2, "SSS": 2, "PSS": 2,
    "PCC": 4, "SSC": 4, "PSC": 4, "CCC": 8, "SCC": 8,
}  # fmt: skip


def _number(rng: random.Random) -> Rational:
    return Rational(rng.randint(-9, 9), rng.randint(1, 5))


def _vector(rng: random.Random) -> list[Rational]:
    while not any(vector := [_number(rng) for _ in range(3)]):
        pass
    return vector


def plane_coefficients(point: Sequence[Any], normal: Sequence[Any]) -> list[Any]:
    """Return d1..d4 of equation (15) for the plane through a point."""
    return [*normal, -_dot(normal, point)]


def sphere_coefficients(centre: Sequence[Any], square: Any) -> list[Any]:
    """Return d5..d8 of equation (15) for a sphere, given the square of its radius."""
    return [*(-2 * c for c in centre), _dot(centre, centre) - square]


def cylinder_coefficients(point: Sequence[Any], direction: Sequence[Any], square: Any) -> list[Any]:
    """Return d9..d18 of equation (15) for a cylinder of revolution.

    Parameters
    ----------
    point
        A point of the axis.
    direction
        A vector along the axis, of any length.
    square
        The square of the radius.

    Notes
    -----
    The cylinder is ``|u|² |p − a|² − (u·(p − a))² = |u|² r²``.
    """
    u, a = direction, point
    length, along = _dot(u, u), _dot(u, a)
    linear = [2 * (along * ui - length * ai) for ui, ai in zip(u, a, strict=True)]
    return [
        *(length - ui * ui for ui in u),
        -2 * u[1] * u[2],
        -2 * u[0] * u[2],
        linear[2],
        -2 * u[0] * u[1],
        linear[1],
        linear[0],
        length * (_dot(a, a) - square) - along**2,
    ]


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return sum(p * q for p, q in zip(a, b, strict=True))


def _surface_through(letter: str, point: list[Rational], rng: random.Random) -> list[Rational]:
    """Return the coefficients of a random plane, sphere or cylinder through a point."""
    if letter == "P":
        return plane_coefficients(point, _vector(rng))
    centre = _vector(rng)
    apart = Matrix(point) - Matrix(centre)
    if letter == "S":
        return sphere_coefficients(centre, apart.dot(apart))
    axis = Matrix(_vector(rng))
    across = apart.cross(axis)
    return cylinder_coefficients(centre, list(axis), across.dot(across) / axis.dot(axis))


def _instance(case: str, point: list[Rational], rng: random.Random) -> dict[str, Rational]:
    numbers = [d for letter in case for d in _surface_through(letter, point, rng)]
    return {f"d{i}": number for i, number in enumerate(numbers, start=1)}


def test_proposition_6_7():
    assert {case: derive(case).solutions for case in INTERSECTIONS} == SOLUTIONS


@pytest.mark.parametrize("case", INTERSECTIONS)
def test_a_common_point_of_random_surfaces_satisfies_the_set(case):
    rng = random.Random(f"point {case}")
    for _ in range(4):
        point = _vector(rng)
        elements = derive(case).at(_instance(case, point, rng))
        at = dict(zip("xyz", point, strict=True))
        assert [evaluate(element, at, Rational(1)) for element in elements] == [0, 0, 0]


@pytest.mark.parametrize("case", INTERSECTIONS)
def test_the_set_has_as_many_solutions_and_all_solve_the_surfaces(case):
    """In QQ[x]/(h1): h1 is squarefree, the initials are units, the surfaces vanish."""
    rng = random.Random(f"count {case}")
    given = _instance(case, _vector(rng), rng)
    triangular = derive(case)
    first, unknowns = parametrize(triangular.at(given))
    assert first.degree() == SOLUTIONS[case]
    assert first.gcd(first.diff()).degree() == 0
    one = Poly(1, first.gen, domain=QQ)
    for surface in triangular.system_at(given):
        assert evaluate(surface, unknowns, one).rem(first).is_zero


@pytest.mark.parametrize("case", INTERSECTIONS)
def test_no_spurious_factor(case):
    """At surfaces with random coefficients h1 is irreducible, hence so it is in general."""
    rng = random.Random(f"irreducible {case}")
    triangular = derive(case)
    given = {name: rng.randint(-9, 9) for name in triangular.parameters}
    first, _ = parametrize(triangular.at(given))
    assert first.degree() == SOLUTIONS[case]
    assert first.is_irreducible


@pytest.mark.parametrize("case", ["CCC", "SCC"])
def test_h1_of_three_quadrics_is_their_resultant(case):
    """Sylvester's determinant for three ternary quadrics is 512 times the resultant."""
    rng = random.Random(f"resultant {case}")
    triangular = derive(case)
    y, z, w = symbols("y z w")
    for _ in range(3):
        given = {name: rng.randint(-5, 5) for name in triangular.parameters}
        at = Rational(rng.randint(-5, 5))
        value = triangular.at(given)[0].as_expr().subs("x", at)
        forms = [
            Poly(surface.as_expr().subs("x", at), y, z).homogenize(w).as_expr()
            for surface in triangular.system_at(given)
        ]
        jacobian = Matrix(forms).jacobian([y, z, w]).det()
        rows = [*forms, *(jacobian.diff(variable) for variable in (y, z, w))]
        monomials = [y**2, y * z, z**2, y * w, z * w, w**2]
        sylvester = Matrix(
            [[Poly(row, y, z, w).coeff_monomial(m) for m in monomials] for row in rows]
        ).det()
        divisor = triangular.values(given, QQ.one)["k1"]
        assert abs(512 * value) == abs(divisor**3 * sylvester)


def test_the_resultant_of_three_quadrics_has_21894_terms():
    """Why CCC is not expanded: Sylvester's determinant by its 3 × 3 minors."""
    letters = [f"{c}{i}" for c in "abc" for i in range(6)]
    domain, *gens = ring(["y", "z", "w", *letters], ZZ)
    y, z, w = gens[:3]
    monomials = [y * y, y * z, y * w, z * z, z * w, w * w]
    forms = [
        sum(c * m for c, m in zip(gens[k : k + 6], monomials, strict=True)) for k in (3, 9, 15)
    ]
    jacobian = determinant([[form.diff(v) for v in (y, z, w)] for form in forms])
    keys = [m.leading_expv()[:3] for m in monomials]
    parts = [coefficients(row, ("y", "z", "w")) for row in (*forms, *map(jacobian.diff, (y, z, w)))]
    rows = [[part.get(key, domain.zero) for key in keys] for part in parts]
    total = domain.zero
    for left in combinations(range(6), 3):
        right = [column for column in range(6) if column not in left]
        top = determinant([[row[column] for column in left] for row in rows[:3]])
        bottom = determinant([[row[column] for column in right] for row in rows[3:]])
        total += (-1) ** (sum(left) - 3) * top * bottom
    assert len(total) == 21894


@pytest.mark.parametrize("case", CASES)
def test_shape(case):
    triangular = derive(case)
    assert [element.leading for element in triangular.elements] == list(triangular.variables)
    order = list(triangular.variables)
    known = set(triangular.parameters)
    for definition in triangular.definitions:
        assert symbols_of(definition.numerator) | symbols_of(definition.divisor) <= known
        known.add(definition.symbol)
    for position, element in enumerate(triangular.elements):
        unknowns = symbols_of(element.polynomial) & set(order)
        assert order[position] in unknowns <= set(order[: position + 1])
        assert symbols_of(element.polynomial) <= known | set(order)
    guarded = {name for condition in triangular.conditions for name in condition.elements}
    for element in triangular.elements:
        assert element.initial.is_ground or element.name in guarded


@pytest.mark.parametrize("case", [case for case in CASES if case not in ("CCC", "SCC", "AAA")])
def test_expanded_means_the_same(case):
    rng = random.Random(f"expanded {case}")
    triangular = derive(case)
    expanded = triangular.expanded()
    given = {name: rng.randint(-9, 9) for name in triangular.parameters}
    assert triangular.at(given) == expanded.at(given)
    for definition in expanded.definitions:
        assert symbols_of(definition.numerator) <= set(expanded.parameters)
        assert definition.divisor == 1


def test_expanded_coefficients_of_equation_16_have_no_common_factor():
    triangular: TriangularSet = derive("PSC").expanded()
    values = {item.symbol: item.numerator for item in triangular.definitions}
    assert list(values) == [f"z{i}" for i in range(1, 11)]
    for symbols_ in (("z1", "z2", "z3", "z4", "z5"), ("z6", "z7", "z8", "z9", "z10")):
        common = values[symbols_[0]]
        for symbol in symbols_[1:]:
            common = common.gcd(values[symbol])
        assert common == 1


def test_cylinder_coefficients_are_the_definition():
    a, u, p = (symbols(f"{name}1:4") for name in "aup")
    (r,) = symbols("r,")
    across = (Matrix(p) - Matrix(a)).cross(Matrix(u))
    expected = across.dot(across) - Matrix(u).dot(Matrix(u)) * r**2
    x, y, z = p
    monomials = [x * x, y * y, z * z, y * z, x * z, z, x * y, y, x, 1]
    numbers = cylinder_coefficients(a, u, r**2)
    actual = sum(c * m for c, m in zip(numbers, monomials, strict=True))
    assert (expected - actual).expand() == 0


def test_when_initials_vanish_at_cylinders_of_revolution():
    u, v, a, b = (symbols(f"{name}1:4") for name in "uvab")
    (r,) = symbols("r,")
    cross = Matrix(u).cross(Matrix(v))
    first, second = cylinder_coefficients(a, u, r**2), cylinder_coefficients(b, v, r**2)

    def value(case, symbol, given):
        found = {item.symbol: item.numerator for item in derive(case).definitions}
        if symbol.startswith("z"):
            found = {item.symbol: item.numerator for item in derive(case).expanded().definitions}
        numbers = {f"d{i}": number for i, number in given.items()}
        return found[symbol].as_expr().subs(numbers)

    plane = Matrix(symbols("d1:4"))
    across = plane.cross(Matrix(u))
    leading = value("PSC", "z6", dict(enumerate(first, start=9)))
    assert (leading - across.dot(across) ** 2).expand() == 0
    both = dict(enumerate([*first, *second], start=5))
    divisor = value("SCC", "k1", both)
    assert (divisor - 2 * (u[1] * v[1] + u[2] * v[2]) * cross[0]).expand() == 0
    leading = Poly(value("PCC", "z6", both).expand(), *u, *v)
    assert leading.rem(Poly(cross.dot(cross), *u, *v)).is_zero


def test_coefficients_are_ordered_by_the_last_variable():
    ring = derive("PSC").ring
    x, y, z = ring.gens[:3]
    parts = coefficients(3 * x**2 + x * y - y + 5 * z, ("x", "y"))
    assert list(parts) == [(1, 1), (0, 1), (2, 0), (0, 0)]
    assert parts[0, 0] == 5 * z
    assert coefficient(x * y - y, "y", 1) == x - 1
    assert evaluate(x * y - y, {"x": QQ(3), "y": QQ(1, 2)}, QQ.one) == 1
