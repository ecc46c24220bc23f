from fractions import Fraction

import pytest

from gspcli.certification.counting.elements import FieldElement, NoElementError, element, in_radians
from gspcli.geometry.instance import AngleUnit
from gspcli.geometry.numbers import Number, parse_number


def of(text: str) -> FieldElement:
    return element(parse_number(text))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.25 + 1/3", Fraction(19, 12)),
        ("sqrt(2)*sqrt(8)", 4),
        ("sqrt(2)*sqrt(3)*sqrt(6)", 6),
        ("sqrt(12)/sqrt(27)", Fraction(2, 3)),
        ("sqrt(50) - 5*sqrt(2) + 1", 1),
        ("cos(0.3)*cos(0.3) + sin(0.3)*sin(0.3)", 1),
        ("cos(pi/9)*cos(pi/9) + sin(pi/9)*sin(pi/9)", 1),
        ("cos(pi/3)", Fraction(1, 2)),
        ("cos(2*pi/3)*sin(pi/6)", Fraction(-1, 4)),
        ("sin(-pi/4)*sqrt(2)", -1),
        ("tan(pi/4)", 1),
        ("pi/pi + sin(pi)", 1),
        ("cos(acos(0.37))", Fraction(37, 100)),
        ("cos(2*acos(1/3))", Fraction(-7, 9)),
        ("sin(atan(3/4))", Fraction(3, 5)),
        ("cos(acos(3/5) - asin(3/5))", Fraction(24, 25)),
    ],
)
def test_expressions_with_a_rational_value(text, value):
    assert of(text).fraction == value


@pytest.mark.parametrize(
    "text", ["sqrt(1 + sqrt(2))", "atan(1/2)", "cos(sqrt(2))", "sqrt(pi)", "cos(acos(1/3)/2)"]
)
def test_what_lies_outside_is_refused(text):
    with pytest.raises(NoElementError):
        of(text)


def test_degrees_and_radians():
    right = in_radians(Number.of(90), AngleUnit.DEGREE)
    assert right.cos().is_zero
    assert right.sin().fraction == 1
    assert in_radians(Number.of(1), AngleUnit.RADIAN).cos().fraction is None


def test_arcs_in_degrees():
    angle = in_radians(parse_number("acos(0.123)*180/pi + 90"), AngleUnit.DEGREE)
    assert angle.sin().fraction == Fraction(123, 1000)


def test_irrational_numbers_are_not_called_rational():
    assert of("sqrt(2) + sqrt(3)").fraction is None
    assert of("cos(pi/5)").fraction is None
    # In an instance file this would be refused: doubles cannot tell it from zero.
    close = Number("-", (parse_number("sqrt(2)"), parse_number("1.414213562373095")))
    assert not element(close).is_zero
