"""Relations between the numbers hold between their images, and no others are made."""

import itertools

import pytest

from gspcli.certification.counting.elements import NoElementError, element
from gspcli.certification.counting.modular_platform import Requirements, homomorphisms
from gspcli.geometry.numbers import parse_number


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
