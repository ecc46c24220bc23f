"""Exact numbers of instances: rational where they are, one name for each irrational one."""

import math
from fractions import Fraction

import pytest

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.export.polynomial_systems import Constants
from gspcli.geometry.instance import AngleUnit, Constraint
from gspcli.geometry.numbers import parse_number
from gspcli.geometry.primitives import Line, vector

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
