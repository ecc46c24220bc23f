"""Proofs, at exact motions, of the slips in Sections 4 to 6.1.

Every function returns its evidence in a sentence and raises `CheckFailed` if there is none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from random import Random
from typing import Any

import numpy as np
from sympy import Expr, Matrix, Poly, Rational, Symbol, radsimp, symbols, sympify

from gspcli.catalogue.kinds import DHP, DLL, DLP, Kind
from gspcli.errors import CheckFailed
from gspcli.geometry import study
from gspcli.symbolic.closed_forms import derive
from gspcli.symbolic.exact_motions import PLACES, Exact, random_motion, random_vector
from gspcli.symbolic.triangular import parametrize

_X, _Y, _Z = np.eye(3, dtype=int).astype(object)


def equation_5() -> str:
    """Prove that the second line of equation (5) does not equal its first, and what does."""
    random = Random(5)
    printed_holds = 0
    for _ in range(10):
        motion, y, x = random_motion(random), random_vector(random), random_vector(random)
        R, T = motion.rotation, motion.translation
        first = _square(R @ y + T - x)
        common = y @ y + T @ T + x @ x - 2 * (x @ T) - 2 * ((R @ y) @ x)
        _require(first == common + 2 * (T @ (R @ y)), "2[T, RY] is wrong, too")
        _require(first == common + 2 * (y @ (R.T @ T)), "the third line is wrong")
        printed_holds += first == common + 2 * (T @ (R.T @ y))
    _require(printed_holds == 0, "the printed line holds")
    return (
        "at ten exact random motions the first line equals the third and the second with "
        "2[T, RY], and differs from the second as printed"
    )


def directions_of_lines() -> str:
    """Prove that the vector of a line must be along it, not normal to it."""
    distances = [_square(np.cross(3 * _X, v)) for v in (_Z, _X)]
    _require(distances == [9, 0], f"{distances}")
    angles = [u @ _Z for u in (_Z, _X)]
    _require(angles == [1, 0], f"{angles}")
    return (
        "the point (3, 0, 0) is 3 from the z axis: |(3, 0, 0) × v| is 3 for v along the axis and 0 "
        "for the normal v = (1, 0, 0); a line normal to a plane makes 90° with it: u1·u2 is "
        "cos(90° − 90°) = 1 for u1 along the line and 0 for u1 normal to it"
    )


def distance_of_lines() -> str:
    """Prove that the equation of DLL holds with the vectors u along the lines as its v."""
    along = np.cross(_X, _Y)
    offset = 2 * _X - 5 * _Y + 3 * _Z
    squared = _square(along) * 9
    _require(squared == (offset @ along) ** 2, "the equation does not hold")
    return "for lines along x and y, 3 apart, the equation with v1 = u1 and v2 = u2 gives d = 3"


def first_distance() -> str:
    """Prove that the equation of the first DPP, with its points at the origins, has d1 squared."""
    motion, zero = random_motion(Random(3)), 0 * _X
    R, T = motion.rotation, motion.translation
    _require(_square(R @ zero + T - zero) == T @ T, "[T, T] is not the square of the distance")
    return "with Y1 = X1 = 0 the distance d1 of (9) is the length of T, as (10) uses it"


def turned_directions() -> str:
    """Prove that R belongs to the lines of the platform, L4 to L6, in Section 6.1."""
    R = random_motion(Random(6)).rotation
    of_base, of_platform = (R @ _Z) @ _X, _Z @ (R @ _X)
    _require(of_base != of_platform, "both are the same")
    return (
        "(11) has s1·Rs4, which is cos∠(L1, RL4); at an exact random rotation, with s1 = (0, 0, 1) "
        "and s4 = (1, 0, 0), Rs1·s4 is another number"
    )


def quadratic_equation(kind: Kind) -> str:
    """Return the coordinates in which a DHP, DLP or DLL has an equation of degree two.

    Squares of functions that are linear in them add up to what the paper's Section 4 has: the
    square of the distance times a constant or, for lines, times the square of a sine, whose cosine
    is linear in R. This is checked at an exact random motion.
    """
    random = Random(4)
    motion, (a, b, u, v) = random_motion(random), (random_vector(random) for _ in range(4))
    R, T = motion.rotation, motion.translation
    r, w = R @ a + T - b, R @ u
    heights = (study.platform_height(a, b, np.cross(u, axis)) for axis in (_X, _Y, _Z))
    functions, square = {
        DHP: ([study.platform_height(a, b, u)], (r @ w) ** 2),
        DLP: ([*heights], _square(np.cross(r, w))),
        DLL: ([study.mutual_moment(a, b, u, v)], (r @ np.cross(w, v)) ** 2),
    }[kind]
    forms = study.forms_of_pose(R, T)
    values = [sum(x * forms[k] for k, x in function.items()) for function in functions]
    _require(sum(value**2 for value in values) == square, f"{kind} has another equation")
    return ",".join(
        name for name, places in PLACES.items() if any(k in f for f in functions for k in places)
    )


def _square(vector: Exact) -> Any:
    return vector @ vector


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise CheckFailed(message)


#: An instance of equation (12) in the paper's frame, s2, s3, s5 and s6 of unit length.
_ANGLES = {
    "d1": Rational(1, 3), "d2": Rational(1, 5), "d3": Rational(-1, 7),
    "l1": Rational(1, 3), "m1": Rational(2, 3), "n1": Rational(2, 3),
    "l3": Rational(2, 7), "m3": Rational(3, 7), "n3": Rational(6, 7),
    "m0": Rational(3, 5), "n0": Rational(4, 5), "m2": Rational(5, 13), "n2": Rational(12, 13),
}  # fmt: skip


def equation_12() -> str:
    """Prove that no h2 of (12) has degree 3 in r32 in both of its coefficients."""
    first, unknowns = parametrize(derive("AAA").at(_ANGLES))
    _require(first.degree() == 8 and first.is_irreducible, "h1 is reducible")
    r32 = Poly(first.gen, domain=first.domain)
    products = [r32**k * factor for factor in (unknowns["r31"], r32**0) for k in range(4)]
    columns = [
        [product.rem(first).coeff_monomial(first.gen**k) for k in range(8)] for product in products
    ]
    rank = Matrix(columns).rank()
    _require(rank == 8, f"the rank is {rank}")
    return (
        "at a rational instance with irreducible h1 the eight products of 1, r31 with 1, r32, "
        "r32², r32³ are linearly independent modulo h1, so no polynomial of the printed shape "
        "vanishes at the eight rotations"
    )


def equation_14() -> str:
    """Prove that (14) translates the surfaces the wrong way, and the third by a wrong vector."""
    p1, p2, p3, q = (Matrix(symbols(f"{name}_x:z")) for name in ("p", "s", "t", "q"))
    printed = q + p1 - p2  # in both lines
    # With R fixed the platform moves by q − p1 when p1 moves to q.
    second, third = p2 + q - p1, p3 + q - p1
    _require(second - printed == 2 * (p2 - p1), "the second line is right")
    _require(third != printed and not printed.has(*p3), "the third line is right")
    return (
        "if p1 moves to q with R fixed, p2 moves to q + p2 − p1. The printed argument is "
        "q + p1 − p2, wrong by 2(p2 − p1). The third line has it, too, instead of one with p3"
    )


def equation_15() -> str:
    """Prove that the quadric of (15) is not every cylinder: it has no term in xy."""
    x, y, z = symbols("x y z")
    # |u|² |p|² − (u·p)² = |u|² r² with u = (1, 1, 0), r = 1.
    cylinder = Poly(2 * (x**2 + y**2 + z**2) - (x + y) ** 2 - 2, x, y, z)
    mixed = cylinder.coeff_monomial(x * y)
    _require(mixed != 0, "the cylinder has no term in xy")
    return (
        f"the cylinder about the line x = y, z = 0 has the term {mixed}·xy, and the printed "
        "quadric two in yz, d12 and d15, but none in xy"
    )


def equation_16() -> str:
    """Prove that the third polynomial of (16) needs d1 x where d1 z is printed."""
    x, y, z, d1, d2, d3, d4 = symbols("x y z d1:5")
    plane = derive("PSC").system[0].polynomial.as_expr()
    printed = d3 * z + d2 * y + d1 * z + d4
    _require((plane - printed - d1 * (x - z)).expand() == 0, "the difference is another")
    return "it must be the plane of (15), which exceeds the print by d1(x − z)"


def equation_18() -> str:
    """Prove that (18) is the solution of (17) with r2 and r3 exchanged."""
    exchange = {Symbol("r2"): Symbol("r3"), Symbol("r3"): Symbol("r2")}
    x, y, z, r1, r2, r3 = symbols("x y z r1:4")
    printed = (
        2 * x**2 + r2**2 - r3**2 - r1**2,
        2 * y**2 + r3**2 - r1**2 - r2**2,
        2 * z**2 + r1**2 - r3**2 - r2**2,
    )
    derived = [element.polynomial.as_expr() for element in derive("6.8").elements]
    _require(
        all(
            _same(ours.subs(exchange, simultaneous=True), theirs)
            for ours, theirs in zip(derived, printed, strict=True)
        ),
        "exchanging r2 and r3 does not give the print",
    )
    differ = [not _same(ours, theirs) for ours, theirs in zip(derived, printed, strict=True)]
    _require(differ == [True, True, False], "the print is right")
    return (
        "from (17), C1 + C2 − C3 is 2x² − r1² − r2² + r3²; the printed set is the one derived "
        "with r2 and r3 exchanged, and differs from it in x and y"
    )


def table_1(printed: Mapping[str, str], computed: Mapping[str, str]) -> str:
    """Prove that a row of Table 1 is no rotation as printed, and is one as computed."""
    wrong, right = _gram_defects(printed), _gram_defects(computed)
    _require(bool(wrong) and not right, f"{wrong} as printed, {right} as computed")
    place, value = next(iter(wrong.items()))
    return (
        f"as printed columns {place[0]} and {place[1]} have the product {value} instead of "
        f"{int(place[0] == place[1])}; the computed matrix is orthogonal"
    )


def _gram_defects(rotation: Mapping[str, str]) -> dict[tuple[int, int], Expr]:
    """Return by columns where the scalar products of the columns are not those of a rotation."""
    matrix = Matrix(3, 3, lambda i, j: sympify(rotation[f"r{i + 1}{j + 1}"]))
    gram = (matrix.T * matrix).applyfunc(lambda entry: radsimp(entry).expand())
    return {
        (i + 1, j + 1): gram[i, j] for i in range(3) for j in range(i, 3) if gram[i, j] != (i == j)
    }


def table_2(printed: Sequence[Mapping[str, str]], computed: Sequence[Mapping[str, str]]) -> str:
    """Prove that the points of Table 2 are not on the cylinders (17), and the computed ones are."""
    wanted = (36, 16, 25)
    theirs, ours = ({_squares(point) for point in points} for points in (printed, computed))
    _require(ours == {wanted} and len(theirs) == 1 and theirs != ours, f"{theirs}, {ours}")
    (found,) = theirs
    return (
        f"x² + y², x² + z², y² + z² are {', '.join(map(str, found))} at every printed point; "
        f"they are 6², 4², 5² at every computed one, as (17) asks"
    )


def _squares(point: Mapping[str, str]) -> tuple[Expr, ...]:
    x, y, z = (sympify(point[name]) for name in "xyz")
    return tuple(radsimp(v).expand() for v in (x**2 + y**2, x**2 + z**2, y**2 + z**2))


def _same(first: Expr, second: Expr) -> bool:
    return bool((first - second).expand() == 0)
