"""Numbers of an instance file: what they mean and what is refused."""

import math
from fractions import Fraction

import flint
import pytest
import sympy

from gspcli.geometry.numbers import parse_number


@pytest.mark.parametrize(
    ("text", "exact"),
    [
        ("0", 0),
        ("-1.50", Fraction(-3, 2)),
        ("+.5", Fraction(1, 2)),
        ("5.", 5),
        ("1/3", Fraction(1, 3)),
        ("1e-3", Fraction(1, 1000)),
        ("0.1", Fraction(1, 10)),
        ("2 * (3 - 1/2) / -5", -1),
        ("--1", 1),
        ("0.1234567890123456789", Fraction(1234567890123456789, 10**19)),
    ],
)
def test_rational_numbers_are_exact(text, exact):
    assert parse_number(text).fraction == exact


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pi", math.pi),
        ("sqrt(3)/2", math.sqrt(3) / 2),
        ("pi / 6", math.pi / 6),
        ("2*cos(pi/5)", (1 + math.sqrt(5)) / 2),
        ("-pi * 2 - 1 - 1", -2 * math.pi - 2),
        ("acos(1/3)", math.acos(1 / 3)),
        ("atan(-tan(1))", -1),
        ("asin(sin(1))", 1),
        # By mpmath with 60 digits: doubles lose all but two, and all but nine.
        ("1/(sqrt(2) - 1.4142135623731)", -201971308182630.03),
        ("1/cos(1.5707963)", 37320539.58671655),
        ("sqrt(2) - 1.414213562373095", 4.88016887242097e-17),
        ("1.414213562373095 - sqrt(2)", -4.88016887242097e-17),
        ("sqrt(sqrt(2) - 1.414213562373095)", 6.985820547667231e-09),
        ("acos(1 - 1e-20)", 1.4142135623730951e-10),
        ("sqrt(10001)+sqrt(10003)-2*sqrt(10002)", -2.4992501952632936e-07),
    ],
)
def test_expressions_have_their_value(text, value):
    assert parse_number(text).fraction is None
    assert parse_number(text).value == pytest.approx(value, rel=4e-15, abs=0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (" ", "found nothing, expected a number"),
        ("1_000", "found '_' in '1_000', expected a number: write digits without separators"),
        ("1:30", "found ':' in '1:30', expected a number: write 1:30 as 1.5"),
        ("1,5", "found ',' in '1,5', expected a number: write decimals with a point"),
        ("−1", "found '−' in '−1', expected a number: write the minus sign as -"),
        ("2pi", "found 'pi' in '2pi', expected an operator or the end: write a product with *"),
        ("2^3", "found '^' in '2^3', expected a number: write a power as a product, x*x"),
        ("2**3", "found '*' in '2**3', expected a number: write a power as a product, x*x"),
        ("nan", "found 'nan', expected a finite number"),
        ("-Infinity", "found 'Infinity' in '-Infinity', expected a finite number"),
        (
            "sqr(2)",
            "found 'sqr' in 'sqr(2)', expected a number, pi, sqrt, sin, cos, tan, asin, acos, "
            "atan, sind, cosd or tand: did you mean sqrt?",
        ),
        ("sin 1", "found '1' in 'sin 1', expected ( after sin"),
        ("(1", "found the end in '(1', expected )"),
        ("1/(2-2)", "found a division by zero in '1/(2-2)', expected a nonzero divisor"),
        (
            "1/(sqrt(2)*sqrt(2)-2)",
            "found a division by zero in '1/(sqrt(2)*sqrt(2)-2)', expected a nonzero divisor",
        ),
        (
            "1/(atan(1) - pi/4)",
            "found a division by a number that may be zero in '1/(atan(1) - pi/4)', "
            "expected a nonzero divisor",
        ),
        (
            "sqrt(1.414213562373095 - sqrt(2))",
            "found sqrt of -4.88017e-17 in 'sqrt(1.414213562373095 - sqrt(2))', expected an "
            "argument of at least 0",
        ),
        ("0/(sqrt(3)*sqrt(3)-3)", None),
        ("1/(acos(1/3)+asin(1/3)-pi/2)", None),
        ("tan(atan(sqrt(2)) + atan(1/sqrt(2)))", None),
        (
            "atan(1) - pi/4",
            "found 'atan(1) - pi/4', which may be zero: write 0, or a simpler expression",
        ),
        ("sqrt(1-2)", "found sqrt of -1 in 'sqrt(1-2)', expected an argument of at least 0"),
        ("asin(2)", "found asin of 2 in 'asin(2)', expected one from -1 to 1"),
        ("1e999", "found '1e999', expected an exponent of at most 100"),
        ("1e61", "found '1e61', expected 0 or a magnitude from 1e-60 to 1e+60"),
        ("1e-61", "found '1e-61', expected 0 or a magnitude from 1e-60 to 1e+60"),
        ("1" * 401, "found 401 characters, expected a number of at most 400"),
        ("9" * 400, None),
        ("-" + "9" * 399, None),
        (f"sqrt({'9' * 330})", None),
        (f"sin({'9' * 330})", None),
        ("*".join(["1e99"] * 50), None),
        ("/".join(["1e99"] * 50), None),
        ("(" * 21 + "1" + ")" * 21, None),
        ("__import__('os')", None),
        ("nan", None),
        ("inf", None),
        ("0x10", None),
        ("１", None),
    ],
)
def test_what_is_no_number_is_refused_with_a_reason(text, message):
    with pytest.raises(ValueError, match=r"^found") as caught:
        parse_number(text)
    if message is not None:
        assert str(caught.value) == message


@pytest.mark.parametrize(
    ("text", "exact"),
    [
        ("sin(0)", "0"),
        ("150*sin(0*pi/180)", "0"),
        ("0*sqrt(2)", "0"),
        ("cosd(60)", "1/2"),
        ("sind(-30)", "-1/2"),
        ("tand(135)", "-1"),
        ("cosd(90)", "0"),
        ("sin(pi)", "0"),
        ("cos(2*pi/3)", "-1/2"),
        ("tan(pi/2 - pi/4)", "1"),
        ("sin(-(pi/6))", "-1/2"),
        ("sqrt(9/16)", "3/4"),
        ("acos(1)", "0"),
        # Zero by algebra: no other number so small has that degree.
        ("sqrt(2) - sqrt(2)", "0"),
        ("sqrt(2)*sqrt(2) - 2", "0"),
        ("sqrt(2) + sqrt(3) - sqrt(5 + 2*sqrt(6))", "0"),
        ("cosd(36) - (1 + sqrt(5))/4", "0"),
        ("tand(22.5) + 1 - sqrt(2)", "0"),
    ],
)
def test_what_is_rational_is_taken_so(text, exact):
    assert parse_number(text).fraction == Fraction(exact)


@pytest.mark.parametrize("degrees", [1, 41.37, 45, -720.5, 1e-3])
def test_functions_of_degrees(degrees):
    for name in ("sin", "cos", "tan"):
        number = parse_number(f"{name}d({degrees})")
        assert number.value == pytest.approx(getattr(math, name)(math.radians(degrees)), rel=1e-12)
        assert parse_number(str(number)) == number


def test_rational_values_are_right_at_every_multiple_of_15_degrees():
    for degrees in range(-360, 375, 15):
        for name in ("sin", "cos", "tan"):
            if name == "tan" and degrees % 180 == 90:
                with pytest.raises(ValueError, match="the tangent of a right angle"):
                    parse_number(f"tand({degrees})")
                continue
            value = getattr(math, name)(math.radians(degrees))
            assert parse_number(f"{name}d({degrees})").value == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize(
    "text", ["sqrt(3)/2", "-pi*2-1-1", "tan(1.57)", "atan(-tan(1))/acos(1/3)", "asin(sin(1))*7/3"]
)
def test_balls_contain_the_number(text):
    ball, digits = parse_number(text).ball(), sympy.sympify(text, rational=True).evalf(40)
    assert ball.contains(flint.arb(str(digits)))
    assert ball.rad() < 1e-11 * abs(digits)
