"""Three angles: every rotation satisfies the sets, there are eight, and what the paper prints."""

import random

import pytest
from sympy import QQ, ZZ, Matrix, Poly, Rational, eye, groebner, ring, symbols

from gspcli.symbolic.closed_forms import ORDER, derive
from gspcli.symbolic.triangular import coefficients, evaluate, parametrize

R_NAMES = [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]


def _number(rng: random.Random) -> Rational:
    return Rational(rng.randint(-9, 9), rng.randint(1, 5))


def _cayley(rng: random.Random) -> Matrix:
    """A random rotation matrix with rational entries."""
    a, b, c = (_number(rng) for _ in range(3))
    skew = Matrix([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    return (eye(3) - skew) * (eye(3) + skew).inv()


def _unit(rng: random.Random, flat: bool) -> Matrix:
    """A random rational unit vector (by stereographic projection), with x = 0 if flat."""
    s, t = (Rational(0) if flat else _number(rng)), _number(rng)
    return Matrix([2 * s, 2 * t, 1 - s**2 - t**2]) / (1 + s**2 + t**2)


def _instance(rng: random.Random) -> tuple[Matrix, dict[str, Rational]]:
    """A rotation and the parameters of equation (12) that it satisfies."""
    rotation = _cayley(rng)
    s2, s5 = _unit(rng, True), _unit(rng, True)
    s3, s6 = _unit(rng, False), _unit(rng, False)
    values = (rotation[2, 2], s2.dot(rotation * s5), s3.dot(rotation * s6))
    names = ("d1", "d2", "d3", "l1", "m1", "n1", "l3", "m3", "n3", "m0", "n0", "m2", "n2")
    numbers = (*values, *s3, *s6, *s2[1:], *s5[1:])
    return rotation, dict(zip(names, numbers, strict=True))


def _entries(rotation: Matrix) -> dict[str, Rational]:
    return dict(zip(R_NAMES, rotation, strict=True))


def test_every_rotation_satisfies_equation_12():
    rng = random.Random(12)
    for _ in range(5):
        rotation, given = _instance(rng)
        entries = _entries(rotation)
        for element in derive("AAA").at(given):
            assert evaluate(element, entries, Rational(1)) == 0


def test_equation_12_has_eight_solutions_and_all_are_rotations():
    """Proposition 6.1, in QQ[r32]/(h1): h1 squarefree, initials units, (11) holds."""
    _, given = _instance(random.Random(8))
    triangular = derive("AAA")
    assert triangular.degrees == (8, 1, 1, 1, 1, 1, 1, 1, 1)
    first, unknowns = parametrize(triangular.at(given))
    assert first.degree() == 8
    assert first.gcd(first.diff()).degree() == 0
    one = Poly(1, first.gen, domain=QQ)
    assert len(triangular.system) == 10
    for equation in triangular.system_at(given):
        assert evaluate(equation, unknowns, one).rem(first).is_zero


def _random_angles() -> dict[str, Rational]:
    """Parameters of equation (12) for which no solution is planted."""
    _, given = _instance(random.Random(5))
    return given | {"d1": Rational(1, 3), "d2": Rational(1, 5), "d3": Rational(-1, 7)}


def test_h1_of_equation_12_has_no_spurious_factor():
    first, _ = parametrize(derive("AAA").at(_random_angles()))
    assert first.degree() == 8
    assert first.is_irreducible


def test_example_6_2_is_special_for_equation_12():
    """There h1 is the square of the first polynomial of (13), and h2 vanishes at its roots."""
    given = dict.fromkeys(derive("AAA").parameters, Rational(0))
    given |= {"l1": Rational(1), "l3": Rational(1), "m0": Rational(1), "m2": Rational(1)}
    cosines = {"d1": Rational(1, 3), "d2": Rational(1, 5), "d3": Rational(-1, 7)}
    h1, h2, *_ = derive("AAA").at(given | cosines)
    square = derive("6.2").at(cosines)[0].as_expr() ** 2
    assert (h1.as_expr() - square).expand() == 0
    assert h2.degree(h2.ring.gens[1]) == 0


@pytest.fixture(scope="module")
def quaternions():
    """The entries of N·R as quadratic forms in a quaternion, N, and the symbols for r_ij."""
    domain, *gens = ring(["e0", "e1", "e2", "e3"], ZZ)
    e0, e1, e2, e3 = gens
    entries = (
        e0**2 + e1**2 - e2**2 - e3**2, 2 * (e1 * e2 - e0 * e3), 2 * (e1 * e3 + e0 * e2),
        2 * (e1 * e2 + e0 * e3), e0**2 - e1**2 + e2**2 - e3**2, 2 * (e2 * e3 - e0 * e1),
        2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), e0**2 - e1**2 - e2**2 + e3**2,
    )  # fmt: skip
    return domain, dict(zip(R_NAMES, entries, strict=True)), e0**2 + e1**2 + e2**2 + e3**2


def _on_rotations(expression, quaternions):
    """Put R(e) into a polynomial in r_ij and clear denominators: zero iff it vanishes on SO(3)."""
    domain, entries, norm = quaternions
    polynomial = Poly(expression, *symbols(R_NAMES))
    degree = polynomial.total_degree()
    total = domain.zero
    for monomial, coefficient in polynomial.terms():
        term = domain(int(coefficient)) * norm ** (degree - sum(monomial))
        for name, exponent in zip(R_NAMES, monomial, strict=True):
            term *= entries[name] ** exponent
        total += term
    return total


def test_the_derived_relations_of_the_entries_hold_on_all_rotations(quaternions):
    for case, cosines in (("AAA", "r33 r33 r33"), ("6.2", "r33 r22 r11")):
        names = dict(zip(("d1", "d2", "d3"), symbols(cosines), strict=True))
        elements = derive(case).elements[4:] if case == "AAA" else derive(case).elements
        for element in elements:
            assert _on_rotations(element.polynomial.as_expr().subs(names), quaternions) == 0


def test_the_printed_h5_to_h9_of_equation_12_hold(quaternions):
    r11, r12, r13, r21, r22, r23, r31, r32, d1 = symbols(R_NAMES)
    w = (d1**2 - 1) * r22 - r23 * r32 * d1
    printed = (
        w * r21 - d1 * r22 * r23 * r31 - r31 * r32 + r23**2 * r31 * r32,
        w * r13 + r31 * r23**2 + (d1**2 - 1) * r31,
        r31 * r12 - d1 * r32 * r22 + (r32**2 - 1) * r23,
        r11 + r32 * r23 - r22 * d1,
    )
    assert [_on_rotations(p, quaternions) for p in printed] == [0, 0, 0, 0]
    # Their initials are r31 r13, so they need r13 ≠ 0 as well.
    assert _on_rotations(w - r31 * r13, quaternions) == 0


def test_the_printed_equation_13(quaternions):
    d3, r12, r13, r21, d2, r23, r31, r32, d1 = symbols(R_NAMES)
    printed = (
        r32**4 - (d3**2 - d1**2 - d2**2 + 1) * r32**2 + d3**2 - 2 * d3 * d2 * d1 + d2**2 * d1**2,
        (d1 * r32**2 - d3 * d2 + d2**2 * d1) * r31**2
        + (-d3 * d2 + d1 * d3**2) * r32**2
        + d2 * d1**2 * d3 - d1 * d3**2 + d3 * d2 - d2**2 * d1,
        r32 * r23 + d3 - d2 * d1,
        (d1 * r32**2 - d3 * d2 + d2**2 * d1) * r31 * r21
        + (d2 * d1 - d3 * d1**2 + d3**2 * d2 * d1 - d2**2 * d3) * r32,
        r31 * r13 - d1 * d3 + d2,
        (-d1 * r32**3 + (d3 * d2 - d2**2 * d1) * r32) * r31 * r12
        + (-(d3**2) * d2 - d1**3 * d3 + d2 * d1**2 + d1 * d3**3) * r32**2
        + 2 * d2 * d1**2 * d3**2 - d1 * d3**3 + d3**2 * d2 + d2**3 * d1**2
        - 2 * d2**2 * d1 * d3 - d2**2 * d1**3 * d3,
    )  # fmt: skip
    assert [_on_rotations(p, quaternions) == 0 for p in printed] == [True] * 6


def test_example_6_2_has_eight_solutions():
    """The ideal of the system and that of the set agree, and have eight common zeros."""
    triangular = derive("6.2")
    given = {"d1": Rational(1, 3), "d2": Rational(1, 5), "d3": Rational(-1, 7)}
    unknowns = symbols(triangular.variables[::-1])
    system = groebner(
        [p.as_expr() for p in triangular.system_at(given)], *unknowns, order="lex", domain=QQ
    )
    for element in triangular.at(given):
        assert system.contains(element.as_expr())
    ours = groebner([p.as_expr() for p in triangular.at(given)], *unknowns, order="lex", domain=QQ)
    assert list(system) == list(ours)
    assert triangular.solutions == 8
    h1 = Poly(triangular.at(given)[0].as_expr(), symbols("r32"))
    assert h1.is_irreducible


def test_expanded_second_polynomial_of_equation_12():
    """h2 written out in the parameters is sane; its leading coefficients show a common factor."""
    triangular = derive("AAA")
    ring_ = triangular.ring
    gens = {str(s): ring_(s) for s in ring_.symbols}
    h2 = triangular.elements[1]
    assert set(coefficients(h2.polynomial, ORDER[:2])) == {
        (3, 1), (2, 1), (1, 1), (0, 1), (4, 0), (3, 0), (2, 0), (1, 0), (0, 0),
    }  # fmt: skip
    known = triangular.values({name: gens[name] for name in triangular.parameters}, ring_.one)
    l3, m3 = gens["l3"], gens["m3"]
    assert (known["z24"] * 2 * l3 * m3 - known["z20"] * (m3**2 - l3**2)) == 0
    assert len(known["z28"]) == 84
    l1, m1, n1, m0, n0, m2 = (gens[name] for name in ("l1", "m1", "n1", "m0", "n0", "m2"))
    square = (m0 * n1 - n0 * m1) ** 2 + (n0 * l1) ** 2 + (m0 * l1) ** 2
    assert known["z30"] == m2**4 * square**2 * (l3**2 + m3**2) ** 2
