"""Polynomials of triangular sets as people write them: in plain text, LaTeX and for programs."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from gspcli.records import dataclass
from gspcli.symbolic.sparse_polynomials import Polynomial, coefficients, symbols_of
from gspcli.symbolic.triangular import Definition


@dataclass(frozen=True)
class Notation:
    """How products and powers are written.

    Attributes
    ----------
    times
        What stands between factors.
    symbol
        Writes a generator.
    power
        Writes a generator, already written, to a power above one.
    brackets
        What encloses a sum.
    quotient
        Writes a quotient of a numerator (and whether it is a sum) and a divisor (likewise).
    """

    times: str
    symbol: Callable[[str], str]
    power: Callable[[str, int], str]
    brackets: tuple[str, str]
    quotient: Callable[[str, bool, str, bool], str]


def _latex_symbol(name: str) -> str:
    letter, index = re.fullmatch(r"([a-z]+)(\d*)", name).groups()  # type: ignore[union-attr]
    return f"{letter}_{{{index}}}" if index else letter


def _in_line(numerator: str, long: bool, divisor: str, sum_: bool) -> str:
    return (f"({numerator})" if long else numerator) + "/" + (f"({divisor})" if sum_ else divisor)


#: Powers as ``x^2``.
TEXT = Notation("*", str, lambda base, k: f"{base}^{k}", ("(", ")"), _in_line)
#: Python's and sympy's own.
CODE = Notation("*", str, lambda base, k: f"{base}**{k}", ("(", ")"), _in_line)
LATEX = Notation(
    " ",
    _latex_symbol,
    lambda base, k: f"{base}^{{{k}}}",
    (r"\left(", r"\right)"),
    lambda numerator, _, divisor, __: rf"\frac{{{numerator}}}{{{divisor}}}",
)


def write_polynomial(polynomial: Polynomial, unknowns: Sequence[str], notation: Notation) -> str:
    """Write a polynomial by descending powers of its unknowns, the highest unknown first.

    Parameters
    ----------
    polynomial
        The polynomial, not zero.
    unknowns
        The unknowns in ascending order; all other generators count as coefficients.
    notation
        One of `TEXT`, `CODE` and `LATEX`.
    """
    present = symbols_of(polynomial)
    return _sum(_terms(polynomial, [name for name in unknowns if name in present], notation))


def write_definition(definition: Definition, notation: Notation) -> str:
    """Write the right-hand side of a definition."""
    numerator = write_polynomial(definition.numerator, (), notation)
    if definition.divisor == 1:
        return numerator
    divisor = write_polynomial(definition.divisor, (), notation)
    return notation.quotient(
        numerator, len(definition.numerator) > 1, divisor, len(definition.divisor) > 1
    )


#: A sign (whether it is a minus) and a term without its sign.
_Term = tuple[bool, str]


def _sum(terms: Sequence[_Term]) -> str:
    (negative, first), *others = terms
    text = ("-" if negative else "") + first
    return text + "".join((" - " if minus else " + ") + term for minus, term in others)


def _terms(polynomial: Polynomial, unknowns: list[str], notation: Notation) -> list[_Term]:
    if not unknowns:
        return _plain_terms(polynomial, notation)
    *lower, leading = unknowns
    terms: list[_Term] = []
    for (degree,), part in coefficients(polynomial, [leading]).items():
        inner = _terms(part, lower, notation)
        if degree == 0:
            terms += inner
            continue
        power = _power(leading, degree, notation)
        if len(inner) == 1:
            ((negative, factor),) = inner
            product = power if factor == "1" else factor + notation.times + power
            terms.append((negative, product))
        else:
            opening, closing = notation.brackets
            terms.append((False, opening + _sum(inner) + closing + notation.times + power))
    return terms


def _plain_terms(polynomial: Polynomial, notation: Notation) -> list[_Term]:
    names = [str(symbol) for symbol in polynomial.ring.symbols]
    terms: list[_Term] = []
    for monomial, coefficient in polynomial.terms():
        factors = [
            _power(name, exponent, notation)
            for name, exponent in zip(names, monomial, strict=True)
            if exponent
        ]
        if abs(coefficient) != 1 or not factors:
            factors.insert(0, str(abs(coefficient)))
        terms.append((coefficient < 0, notation.times.join(factors)))
    # A sum does not begin with a minus if it need not.
    first = next((place for place, (negative, _) in enumerate(terms) if not negative), 0)
    return [terms[first], *terms[:first], *terms[first + 1 :]]


def _power(name: str, exponent: int, notation: Notation) -> str:
    base = notation.symbol(name)
    return base if exponent == 1 else notation.power(base, exponent)
