"""Polynomials in the rings of sympy: values for generators, coefficients, triangular systems."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, TypeAlias

from sympy import QQ, Poly, Symbol
from sympy.polys.rings import PolyElement, PolyRing

Polynomial: TypeAlias = PolyElement
#: Something that values can be put into polynomials for: numbers or elements of any ring.
Values: TypeAlias = Mapping[str, Any]


@cache
def positions(ring: PolyRing) -> dict[str, int]:
    """Return the place of each generator by its name."""
    return {str(symbol): place for place, symbol in enumerate(ring.symbols)}


def symbols_of(polynomial: Polynomial) -> set[str]:
    """Return the names of the generators that occur in a polynomial."""
    occurs = [any(exponents) for exponents in zip(*polynomial.itermonoms(), strict=True)]
    return {name for name, yes in zip(positions(polynomial.ring), occurs, strict=False) if yes}


def evaluate(polynomial: Polynomial, values: Values, one: Any) -> Any:
    """Put values for the generators of a polynomial.

    Parameters
    ----------
    polynomial
        A polynomial with integer coefficients.
    values
        A value for every generator that occurs.
    one
        The unity of the ring of the values.
    """
    names = list(positions(polynomial.ring))
    total = one * 0
    for monomial, coefficient in polynomial.iterterms():
        term = one * coefficient
        for name, exponent in zip(names, monomial, strict=True):
            if exponent:
                term = term * values[name] ** exponent
        total = total + term
    return total


def coefficients(
    polynomial: Polynomial, variables: Sequence[str]
) -> dict[tuple[int, ...], Polynomial]:
    """Split a polynomial by the monomials in some of its generators.

    Returns
    -------
    dict
        From the exponents of `variables` to the coefficient (in the same ring): the largest
        monomials first, where the last variable counts most.
    """
    ring = polynomial.ring
    places = [positions(ring)[name] for name in variables]
    parts: dict[tuple[int, ...], Polynomial] = {}
    for monomial, coefficient in polynomial.iterterms():
        key = tuple(monomial[place] for place in places)
        rest = tuple(0 if i in places else e for i, e in enumerate(monomial))
        parts[key] = parts.get(key, ring.zero) + ring({rest: coefficient})
    return dict(sorted(parts.items(), key=lambda item: item[0][::-1], reverse=True))


def coefficient(polynomial: Polynomial, variable: str, degree: int) -> Polynomial:
    """Return one coefficient of a polynomial seen as a polynomial in one generator."""
    return coefficients(polynomial, [variable]).get((degree,), polynomial.ring.zero)


def specialize(
    polynomials: Sequence[Polynomial], values: Values, variables: Sequence[str]
) -> list[Polynomial]:
    """Put rational numbers for all generators but the unknowns; the result is over QQ."""
    ring = PolyRing(list(variables), QQ)
    known = {**values, **dict(zip(variables, ring.gens, strict=True))}
    return [evaluate(polynomial, known, ring.one) for polynomial in polynomials]


def parametrize(elements: Sequence[Polynomial]) -> tuple[Poly, dict[str, Poly]]:
    """Solve a numerical triangular set whose elements after the first are linear.

    Parameters
    ----------
    elements
        Polynomials over QQ in the unknowns alone, as `TriangularSet.at` returns them; the i-th is
        led by the i-th unknown.

    Returns
    -------
    first : Poly
        The first element.
    unknowns : dict
        For every unknown the polynomial in the first unknown that gives its value, modulo `first`.

    Raises
    ------
    NotInvertible
        If an initial vanishes at a root of `first`.
    """
    names = list(positions(elements[0].ring))
    x = Symbol(names[0])
    one = Poly(1, x, domain=QQ)
    values = {names[0]: Poly(x, x, domain=QQ)}
    first = evaluate(elements[0], values, one)
    for name, element in zip(names[1:], elements[1:], strict=True):
        slope, rest = (
            evaluate(coefficient(element, name, degree), values, one).rem(first)
            for degree in (1, 0)
        )
        values[name] = (-rest * slope.invert(first)).rem(first)
    return first, values
