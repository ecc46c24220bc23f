"""Exported equations vanish at the poses of the solver, in all coordinates, and nowhere near."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.export.answers import read_answer
from gspcli.export.formats import FORMATS, SystemFormat
from gspcli.export.polynomial_systems import (
    MOTIONS,
    Constants,
    Polynomial,
    Style,
    cross,
    dot,
    system,
)
from gspcli.geometry.instance import AngleUnit, Constraint
from gspcli.geometry.numbers import parse_number
from gspcli.geometry.primitives import Line, vector
from gspcli.geometry.quaternions import study_from_pose
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load

NAMES = ["dietmaier", "example-6.8", "figure-2", "nano-hexapod", "surfaces-pcc", "parallel-lines"]

SYSTEMS = {name: form for name, form in FORMATS.items() if isinstance(form, SystemFormat)}


def points(coordinates, names, result):
    """Return the unknowns at the poses, those that the coordinates have."""
    if coordinates == "rt":
        columns = np.concatenate([result.R.reshape(-1, 9), result.T], axis=1).T
        return dict(zip(names, columns, strict=True))
    e, f = study_from_pose(result.R, result.T)
    if coordinates == "study":
        return dict(zip(names, np.concatenate([e, f], axis=1).T, strict=True))
    whole = np.abs(e[:, 0]) > 1e-3
    e, f = (part[whole] / e[whole, :1] for part in (e, f))
    inverse = 1 / (e * e).sum(axis=1, keepdims=True)
    return dict(zip(names, np.concatenate([e[:, 1:], f, inverse], axis=1).T, strict=True))


def worst(polynomials, known):
    """Return the largest value of the polynomials, relative to that of their terms."""
    found = 0.0
    for polynomial in polynomials:
        value, size = 0.0, 0.0
        for monomial, coefficient in polynomial.terms.items():
            term = float(coefficient) * np.prod([known[name] for name in monomial], axis=0)
            value, size = value + term, size + np.abs(term)
        scale = max(abs(float(number)) for number in polynomial.terms.values())
        found = max(found, float((np.abs(value) / (size + scale)).max()))
    return found


@pytest.mark.parametrize("coordinates", MOTIONS)
@pytest.mark.parametrize("name", NAMES)
def test_poses_satisfy_the_equations(name, coordinates):
    instance = load(instance_files()[name])
    exported = system(instance, MOTIONS[coordinates]()).rounded(40)
    assert not exported.constants
    assert len(exported.polynomials) == len(exported.names)
    known = points(coordinates, exported.names, solve(instance))
    assert worst(exported.polynomials, known) < 1e-13
    moved = {key: column + 1e-3 for key, column in known.items()}
    assert worst(exported.polynomials, moved) > 1e-5


def test_rational_platforms_have_no_constants():
    assert not system(load(instance_files()["dietmaier"]), MOTIONS["rt"]()).constants


def test_the_files_are_what_the_programs_read():
    small = system(load(instance_files()["six-planes"]), MOTIONS["rt"]())
    texts = {name: program.write(small, 20) for name, program in SYSTEMS.items()}
    beginnings = {
        "msolve": "r11,r12,r13,r21,r22,r23,r31,r32,r33,t1,t2,t3\n0\n",
        "phcpack": "12\n",
        "macaulay2": "R = QQ[r11, r12",
        "singular": "ring r = 0,(r11,r12",
        "hcjl": "@var r11 r12",
        "sympy": "unknowns = r11, r12",
    }
    assert set(beginnings) == set(texts)
    for name, beginning in beginnings.items():
        assert beginning in texts[name]
    assert texts["phcpack"].count(";\n") == 12
    compile(texts["sympy"], "system", "exec")


def test_irrational_constants_become_what_the_table_says():
    curved = system(load(instance_files()["surfaces-pps"]), MOTIONS["rt"]())
    assert curved.constants
    for name, program in SYSTEMS.items():
        same = program.write(curved, 20) == program.write(curved, 30)
        assert same == (program.irrational != "decimals"), name


PHC = """\
THE SOLUTIONS :
1 8
===========================================================================
solution 1 :    start residual :  1.0E-16   #iterations : 1   success
t :  0.00000000000000E+00   0.00000000000000E+00
m : 1
the solution for t :
 q0 :  1.00000000000000E+00   0.0
 q1 :  0.0   0.0
 q2 :  0.0   0.0
 q3 :  0.0   0.0
 f0 :  0.0   0.0
 f1 :  1.00000000000000E+00   5.00000000000000E-01
 f2 :  0.0   0.0
 f3 :  0.0   0.0
== err :  1.0E-15 = rco :  3.5E-02 = res :  6.5E-15 = complex regular ==
"""


def test_phcpack_is_read():
    found = read_answer(PHC, "x")
    assert found is not None
    assert np.allclose(found.T, [[2 + 1j, 0, 0]])
    assert np.allclose(found.R, np.eye(3))


def test_opposite_points_are_one_pose():
    heading = ",".join(f"{letter}{k}" for letter in "qf" for k in range(4))
    text = f"# dimension 0, degree 4\n{heading}\n1,0,0,0,0,1,0,0\n-1,0,0,0,0,-1,0,0\n"
    found = read_answer(text + "0,1,0,0,0,0,0,1\n", "x")
    assert found is not None
    assert len(found.R) == 2
    again = read_answer(text + "1,0,0,0,0,1,0,0\n", "x")
    assert again is not None
    # A point that is listed twice stays listed twice.
    assert len(again.R) == 2


def test_boxes_of_msolve_are_told_apart_by_what_they_satisfy():
    def box(numbers):
        return "[" + ", ".join(f"[{n} / 2^1, {n} / 2^1]" for n in numbers) + "]"

    study = read_answer(f"[0, [1,\n[{box([2, 0, 0, 0, 0, 2, 0, 0])}]\n]]:\n", "x")
    affine = read_answer(f"[0, [1,\n[{box([0, 0, 0, 0, 2, 0, 0, 2])}]\n]]:\n", "x")
    assert study is not None
    assert affine is not None
    assert np.allclose(study.T, affine.T)
    assert study.claimed_real == (True,)
    none = read_answer("[0, [1,\n[]\n]]:\n", "x")
    assert none is not None
    assert len(none.R) == 0


@pytest.mark.parametrize("text", ['[{"R": []}]', "qw,qx,qy,qz,tx,ty,tz\n1,0,0,0,0,0,0\n", ""])
def test_other_files_are_left_to_others(text):
    assert read_answer(text, "x") is None


# Exact numbers of instances: rational where they are, one name for each irrational one.


LINE = Line(vector(0, 0, 0), vector(0, 0, 1))


def value(polynomial, constants):
    return float(
        polynomial.replaced(
            {name: Fraction(number.value) for name, number in constants.names.items()}
        ).value
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1/3 + 0.5*2", Fraction(4, 3)),
        ("sqrt(9/4)", Fraction(3, 2)),
        ("sqrt(2)*sqrt(2)", 2),
        ("sqrt(8)*sqrt(2)", 4),
        ("-(sqrt(3)*sqrt(3)/2)", Fraction(-3, 2)),
        ("sqrt(sqrt(16))", 2),
    ],
)
def test_rational_numbers_stay_rational(text, expected):
    assert Constants().number(parse_number(text)).value == expected


@pytest.mark.parametrize("text", ["1 + sqrt(3)/4", "pi/sqrt(2)", "cos(1)*2 - sqrt(12)", "atan(2)"])
def test_irrational_numbers_have_their_value(text):
    constants = Constants()
    number = parse_number(text)
    assert value(constants.number(number), constants) == pytest.approx(number.value, rel=1e-14)


def test_a_number_has_one_name():
    constants = Constants()
    constants.vector([parse_number("sqrt(3)"), parse_number("1 - sqrt(3)/2"), parse_number("pi")])
    assert [str(number) for number in constants.names.values()] == ["sqrt(3)", "pi"]


def test_norms_of_irrational_vectors():
    constants = Constants()
    vee = [parse_number(text) for text in ("1/2", "-sqrt(3)/2", "1")]
    square = constants.norm(vee) * constants.norm(vee)
    assert constants.reduced(square).value == 2
    other = [parse_number(text) for text in ("1", "pi", "0")]
    assert value(constants.norm(other), constants) == pytest.approx(math.hypot(1, math.pi))


@pytest.mark.parametrize(
    ("kind", "angle", "unit", "expected"),
    [
        ("ALL", "60", "deg", Fraction(1, 2)),
        ("AHH", "60", "deg", Fraction(-1, 2)),
        ("ALH", "30", "deg", Fraction(1, 2)),
        ("AHL", "-90", "deg", -1),
        ("ALL", "acos(1/3)*180/pi", "deg", Fraction(1, 3)),
        ("AHH", "acos(1/3)", "rad", Fraction(-1, 3)),
        ("ALH", "asin(2/7)", "rad", Fraction(2, 7)),
        ("ALL", "0", "rad", 1),
    ],
)
def test_cosines_that_are_rational(kind, angle, unit, expected):
    row = Constraint(KINDS_BY_NAME[kind], LINE, LINE, parse_number(angle))
    assert Constants().cosine(row, AngleUnit(unit)).value == expected


@pytest.mark.parametrize(
    ("kind", "angle", "unit"),
    [("ALL", "41.37", "deg"), ("ALH", "-17", "deg"), ("AHH", "1.2", "rad"), ("AHL", "0.3", "rad")],
)
def test_other_cosines_have_their_value(kind, angle, unit):
    constants = Constants()
    row = Constraint(KINDS_BY_NAME[kind], LINE, LINE, parse_number(angle))
    radians = float(angle) * AngleUnit(unit).in_radians
    expected = {"ALL": math.cos, "AHH": lambda a: -math.cos(a)}.get(kind, math.sin)(radians)
    assert value(constants.cosine(row, AngleUnit(unit)), constants) == pytest.approx(expected)


# Exact polynomials: ring laws by evaluation, and how programs are given them.


NAMES_OF_POLYNOMIALS = ("a", "b", "c")
POINT = {"a": Fraction(3, 2), "b": Fraction(-5), "c": Fraction(7, 3)}
terms = st.dictionaries(
    st.lists(st.sampled_from(NAMES_OF_POLYNOMIALS), max_size=3).map(sorted).map(tuple),
    st.fractions(-9, 9, max_denominator=7).filter(bool),
    max_size=4,
)
polynomials = terms.map(Polynomial)


def at(polynomial: Polynomial) -> Fraction:
    value = polynomial.replaced(POINT).value
    assert value is not None
    return value


@given(polynomials, polynomials)
def test_sums_and_products_evaluate(p, q):
    assert at(p + q) == at(p) + at(q)
    assert at(p - q) == at(p) - at(q)
    assert at(p * q) == at(p) * at(q)
    assert at(2 - p) == 2 - at(p)
    assert p + (-p) == Polynomial({})
    assert all((p * q).terms.values())


def test_vectors():
    a = [Polynomial.symbol(name) for name in NAMES_OF_POLYNOMIALS]
    assert dot(a, cross(a, [1, 2, 3])) == Polynomial({})
    assert at(cross(a, [1, 0, 0])[1]) == POINT["c"]


def test_denominators_are_cleared():
    p = Polynomial({("a",): Fraction(1, 6), (): Fraction(-3, 4)})
    assert p.cleared == {("a",): 2, (): -9}
    assert p.value is None
    assert Polynomial.constant(3).value == 3
    assert Polynomial.constant(0).value == 0


def test_programs_write_differently():
    p = {("a", "a", "b"): Fraction(-1, 2), (): Fraction(3)}
    assert Style().written(p) == "-1/2*a^2*b+3"
    assert Style(power="**", quotient="//").written(p) == "-1//2*a**2*b+3"
    assert Style().written({}) == "0"
    complex_terms = [(1 + 2j, ("a",)), (0.5, ())]
    assert Style(imaginary="ii", exponent="E").written(complex_terms) == (
        "(+1.0000000000000000E+00+2.0000000000000000E+00*ii)*a+5.0000000000000000E-01"
    )
