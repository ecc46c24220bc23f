"""Triangular sets as text, LaTeX and JSON; what is written reads back as the same polynomial."""

import json

import pytest
from sympy import sympify

from gspcli.errors import GspError
from gspcli.symbolic.closed_forms import CASES, derive, expand_case, parse_case
from gspcli.symbolic.derivation import (
    LATEX,
    TEXT,
    to_document,
    to_latex,
    to_text,
    write_definition,
    write_polynomial,
)

XYZ = ("x", "y", "z")


@pytest.mark.parametrize("case", CASES)
def test_code_reads_back(case):
    triangular = derive(case)
    document = json.loads(json.dumps(to_document(triangular)))
    for entry, element in zip(document["set"], triangular.elements, strict=True):
        difference = sympify(entry["polynomial"]) - element.polynomial.as_expr()
        assert difference.expand() == 0
        assert entry["degree"] == element.degree
    for entry, definition in zip(document["coefficients"], triangular.definitions, strict=True):
        value = definition.numerator.as_expr() / definition.divisor.as_expr()
        assert (sympify(entry["value"]) - value).expand() == 0


def test_equation_16_is_written_as_in_the_paper():
    elements = [e.polynomial for e in derive("PSC").elements]
    assert [write_polynomial(p, XYZ, TEXT) for p in elements] == [
        "z6*x^4 + z7*x^3 + z8*x^2 + z9*x + z10",
        "(z1*x + z2)*y + z3*x^2 + z4*x + z5",
        "d3*z + d2*y + d1*x + d4",
    ]
    assert write_polynomial(elements[1], XYZ, LATEX) == (
        r"\left(z_{1} x + z_{2}\right) y + z_{3} x^{2} + z_{4} x + z_{5}"
    )


def test_signs_and_numbers():
    x, y, z = derive("PSC").ring.gens[:3]
    assert write_polynomial(-x * y + 1, XYZ, TEXT) == "-x*y + 1"
    assert write_polynomial(-2 * x**2 - z, XYZ, TEXT) == "-z - 2*x^2"
    assert write_polynomial(y - 3, (), TEXT) == "y - 3"
    assert write_polynomial(-y - 3 * x + z, (), TEXT) == "z - 3*x - y"


def test_quotients():
    definitions = {item.symbol: item for item in derive("PSC").definitions}
    assert write_definition(definitions["z10"], TEXT) == "(z5^2 - k16*z2)/d3^2"
    assert write_definition(definitions["z10"], LATEX) == (
        r"\frac{z_{5}^{2} - k_{16} z_{2}}{d_{3}^{2}}"
    )


def test_text_of_example_6_8():
    assert to_text(derive("6.8")) == (
        "6.8: three cylinders about the axes of coordinates\n"
        "Example 6.8, equations (17) and (18). Unknowns x < y < z.\n"
        "\n"
        "System\n"
        "  C1: y^2 + x^2 - r1^2 = 0\n"
        "  C2: z^2 + x^2 - r2^2 = 0\n"
        "  C3: z^2 + y^2 - r3^2 = 0\n"
        "\n"
        "Triangular set, 2·2·2 = 8 solutions\n"
        "  h1, degree 2 in x: 2*x^2 + r3^2 - r1^2 - r2^2 = 0\n"
        "  h2, degree 2 in y: 2*y^2 + r2^2 - r1^2 - r3^2 = 0\n"
        "  h3, degree 2 in z: 2*z^2 + r1^2 - r2^2 - r3^2 = 0\n"
        "\n"
        "Notes\n"
        "  The paper prints (18), and Table 2, with r2 and r3 exchanged.\n"
        "  The initials are constants: the set always describes all the solutions, with "
        "multiplicity where x, y or z is 0.\n"
    )


@pytest.mark.parametrize("case", CASES)
def test_latex_is_balanced(case):
    text = to_latex(derive(case))
    assert text.count("{") == text.count("}")
    assert text.count(r"\left(") == text.count(r"\right)")
    assert text.count(r"\begin{align*}") == text.count(r"\end{align*}")
    assert text.isascii()


@pytest.mark.parametrize(
    ("text", "case"),
    [
        ("psc", "PSC"),
        ("CSP", "PSC"),
        ("aaa", "AAA"),
        ("Example 6.2", "6.2"),
        ("example-6.8", "6.8"),
    ],
)
def test_spellings_of_a_case(text, case):
    assert parse_case(text) == case


@pytest.mark.parametrize("text", ["", "PPPP", "XYZ", "2.6", "SPP PPP"])
def test_no_case(text):
    with pytest.raises(GspError, match="is not a case; the cases are PPP, PPC"):
        parse_case(text)


def test_the_resultants_of_three_quadrics_are_not_expanded():
    with pytest.raises(GspError, match="CCC is not written out"):
        expand_case("CCC")
