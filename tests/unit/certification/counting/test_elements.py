"""None"""

from __future__ import annotations

import itertools
from fractions import Fraction

import pytest

from gspcli.certification.counting.elements import FieldElement, NoElementError, element, in_radians
from gspcli.certification.counting.modular_platform import Requirements, homomorphisms
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


# Relations between the numbers hold between their images, and no others are made.


def images(*texts: str, primes: int = 3):
    """The images of some numbers, modulo a few primes."""
    elements = [element(parse_number(text)) for text in texts]
    requirements = Requirements(elements)
    for homomorphism in itertools.islice(homomorphisms(requirements, "test"), primes):
        yield homomorphism, [homomorphism(x) for x in elements]


@pytest.mark.parametrize(
    ("root", "expression"),
    [
        ("sqrt(3)", "2*cos(pi/6)"),
        ("sqrt(2)", "2*cos(pi/4)"),
        ("sqrt(5)", "4*cos(pi/5) - 1"),
        ("sqrt(7)", "2*sin(2*pi/7) + 2*sin(4*pi/7) + 2*sin(8*pi/7)"),
        ("sqrt(13)", "1 + 4*(cos(2*pi/13) + cos(6*pi/13) + cos(8*pi/13))"),
        ("sqrt(6)", "4*cos(pi/6)*cos(pi/4)"),
        ("sqrt(15)", "sqrt(3)*sqrt(5)"),
        ("sqrt(1001)*sqrt(77)", "77*sqrt(13)"),
        ("sqrt(3.25)", "sqrt(13)/2"),
        ("cos(1)", "4*cos(1/3)*cos(1/3)*cos(1/3) - 3*cos(1/3)"),
        ("cos(pi/7 + 1)", "cos(pi/7)*cos(1) - sin(pi/7)*sin(1)"),
    ],
)
def test_relations_are_kept(root, expression):
    assert abs(float(parse_number(root)) - float(parse_number(expression))) < 1e-12
    for _, (a, b) in images(root, expression):
        assert a == b


def test_the_signs_of_roots_are_those_of_the_reals():
    # cos(pi/12) = (sqrt(6) + sqrt(2))/4 fails if one of the roots has the other sign.
    for _, (a, b) in images("4*cos(pi/12)", "sqrt(6) + sqrt(2)"):
        assert a == b


def test_independent_numbers_stay_different():
    for _, numbers in images("sqrt(2)", "sqrt(3)", "sqrt(6)", "cos(1)", "sin(1)", "1.41421356"):
        assert len({int(x) for x in numbers}) == len(numbers)


def test_primes_are_large_and_suit_the_angles():
    primes = [h.prime for h, _ in images("cos(41.37*pi/180)")]
    assert len(set(primes)) == 3
    assert all(2**60 < p < 2**61 and p % 12000 == 1 for p in primes)


def test_the_same_text_gives_the_same_prime():
    first = [(h.prime, int(x)) for h, (x,) in images("cos(1)")]
    assert first == [(h.prime, int(x)) for h, (x,) in images("cos(1)")]


def test_many_independent_roots_are_refused():
    primes = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47)
    with pytest.raises(NoElementError, match="15 independent square roots"):
        Requirements([element(parse_number(f"sqrt({n})")) for n in primes])


def test_pi_beside_exponentials_is_refused():
    with pytest.raises(NoElementError, match="pi beside"):
        Requirements([element(parse_number("pi")), element(parse_number("cos(1)"))])
