"""Exact polynomials: ring laws by evaluation, and how programs are given them."""

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from gspcli.export.polynomial_systems import Polynomial, Style, cross, dot

NAMES = ("a", "b", "c")
POINT = {"a": Fraction(3, 2), "b": Fraction(-5), "c": Fraction(7, 3)}
terms = st.dictionaries(
    st.lists(st.sampled_from(NAMES), max_size=3).map(sorted).map(tuple),
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
    a = [Polynomial.symbol(name) for name in NAMES]
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
