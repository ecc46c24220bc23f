"""Triangular sets: polynomial systems that are solved one variable after the other.

A set is written hierarchically. Its elements are polynomials in the unknowns. Their coefficients
are short polynomials in the parameters, or symbols (``z1``, ``z2``, ...). Each symbol is defined by
a polynomial in the parameters and in symbols defined before it. Section 6 of the paper prints its
sets in this form, without the definitions, for which it refers to a web page.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache, cached_property
from itertools import chain
from math import prod
from typing import Any, TypeAlias

from sympy import QQ, ZZ, Poly, Symbol
from sympy.polys.rings import PolyElement, PolyRing

from gspcli.records import dataclass

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


@dataclass(frozen=True)
class Definition:
    """What a coefficient symbol stands for: an exact quotient."""

    #: As ``z1``.
    symbol: str
    #: A polynomial in the parameters and in symbols defined before.
    numerator: Polynomial
    #: Such a polynomial that divides the numerator once both are written in the parameters.
    divisor: Polynomial

    def value(self, known: Values, one: Any) -> Any:
        """Return the value for given values of the parameters and earlier symbols."""
        numerator = evaluate(self.numerator, known, one)
        if self.divisor == 1:
            return numerator
        divisor = evaluate(self.divisor, known, one)
        return numerator.exquo(divisor) if isinstance(one, PolyElement) else numerator / divisor


@dataclass(frozen=True)
class Relation:
    """A named polynomial that vanishes: an equation of the system, or a step of its elimination."""

    name: str
    polynomial: Polynomial


@dataclass(frozen=True)
class TriangularPolynomial:
    """One polynomial of a triangular set."""

    #: As ``h1``.
    name: str
    #: The leading variable: the highest that occurs.
    leading: str
    #: The polynomial, set equal to zero.
    polynomial: Polynomial

    @cached_property
    def degree(self) -> int:
        """The degree in the leading variable."""
        return max(key[0] for key in coefficients(self.polynomial, [self.leading]))

    @cached_property
    def initial(self) -> Polynomial:
        """The coefficient of the highest power of the leading variable."""
        return coefficients(self.polynomial, [self.leading])[(self.degree,)]


@dataclass(frozen=True)
class NonVanishing:
    """Something that must not vanish, or the set does not describe all the solutions."""

    #: The polynomial that must not vanish (at the solutions, if unknowns occur in it).
    polynomial: Polynomial
    #: What it means geometrically if it vanishes.
    meaning: str
    #: The elements whose initial it is; empty for a divisor used in the elimination.
    elements: tuple[str, ...] = ()


@dataclass(frozen=True)
class TriangularSet:
    """A triangular set for a system of equations, with everything needed to check it."""

    #: As ``PSC``.
    case: str
    #: What is intersected, in words.
    title: str
    #: The place in the paper.
    source: str
    #: The unknowns in ascending order.
    variables: tuple[str, ...]
    #: The letters of the system's coefficients.
    parameters: tuple[str, ...]
    #: The equations that the set solves.
    system: tuple[Relation, ...]
    #: The coefficient symbols, each after those that it uses.
    definitions: tuple[Definition, ...]
    #: The set itself, ascending.
    elements: tuple[TriangularPolynomial, ...]
    #: When the set may fail to describe the solutions.
    conditions: tuple[NonVanishing, ...]
    #: Intermediate relations of the elimination, for the reader.
    steps: tuple[Relation, ...] = ()
    #: Remarks, such as differences from what the paper prints.
    notes: tuple[str, ...] = ()

    @property
    def ring(self) -> PolyRing:
        """The ring of all the polynomials: unknowns, parameters and coefficient symbols."""
        return self.system[0].polynomial.ring

    @property
    def degrees(self) -> tuple[int, ...]:
        """The degrees of the elements in their leading variables."""
        return tuple(element.degree for element in self.elements)

    @property
    def solutions(self) -> int:
        """The number of solutions where no condition fails: the product of the degrees."""
        return prod(self.degrees)

    def values(self, parameters: Values, one: Any) -> dict[str, Any]:
        """Return the values of the parameters and of all coefficient symbols.

        Parameters
        ----------
        parameters
            A value for every parameter.
        one
            The unity of the ring of the values.
        """
        known = dict(parameters)
        for item in self.definitions:
            known[item.symbol] = item.value(known, one)
        return known

    def expanded(self) -> TriangularSet:
        """Return the same set with every definition written in the parameters alone.

        Intermediate symbols and steps disappear. Can be enormous where the hierarchy is deep.
        """
        ring = self.ring
        place = positions(ring)
        known = self.values({name: ring.gens[place[name]] for name in self.parameters}, ring.one)
        shown = [item.polynomial for item in self.elements]
        shown += [item.polynomial for item in self.conditions]
        used = set().union(*map(symbols_of, shown))
        kept = [item.symbol for item in self.definitions if item.symbol in used]
        definitions = tuple(Definition(name, known[name], ring.one) for name in kept)
        return replace(self, definitions=definitions, steps=())

    def at(self, parameters: Mapping[str, Any]) -> list[Polynomial]:
        """Return the elements for rational parameters, as polynomials in the unknowns over QQ."""
        values = self.values({k: QQ.convert(v) for k, v in parameters.items()}, QQ.one)
        return specialize([item.polynomial for item in self.elements], values, self.variables)

    def system_at(self, parameters: Mapping[str, Any]) -> list[Polynomial]:
        """Return the system for rational parameters, as polynomials in the unknowns over QQ."""
        values = {k: QQ.convert(v) for k, v in parameters.items()}
        return specialize([item.polynomial for item in self.system], values, self.variables)


class Elimination:
    """The ring of one elimination, and the coefficient symbols defined so far.

    Parameters
    ----------
    variables
        The unknowns, ascending.
    parameters
        The letters of the system's coefficients.
    symbols
        The coefficient symbols in the order in which they will be defined, in series under a
        letter each: by convention ``z`` for those of the result and ``k`` for intermediate ones.
    """

    def __init__(
        self,
        variables: Sequence[str],
        parameters: Sequence[str],
        symbols: Mapping[str, Sequence[str]],
    ) -> None:
        self.variables = tuple(variables)
        self.ring = PolyRing([*variables, *parameters, *chain(*symbols.values())], ZZ)
        self.definitions: list[Definition] = []
        self._unused = {letter: iter(series) for letter, series in symbols.items()}

    def __getitem__(self, names: str) -> list[Polynomial]:
        """Return the generators of the given names, separated by spaces."""
        return [self.ring.gens[positions(self.ring)[name]] for name in names.split()]

    def define(
        self, value: Polynomial, letter: str = "z", divisor: Polynomial | None = None
    ) -> Polynomial:
        """Define the next symbol of a series as a polynomial, or as an exact quotient.

        A polynomial or quotient that already has a symbol keeps it.
        """
        divisor = divisor or self.ring.one
        for known in self.definitions:
            if (known.numerator, known.divisor) == (value, divisor):
                return self[known.symbol][0]
        symbol = next(self._unused[letter])
        self.definitions.append(Definition(symbol, value, divisor))
        return self[symbol][0]

    def named(
        self, polynomial: Polynomial, letter: str = "z", divisor: Polynomial | None = None
    ) -> Polynomial:
        """Replace the coefficients of a polynomial in the unknowns by symbols.

        Coefficients that are numbers, or generators up to sign, stay if nothing divides them.
        """
        unknowns = self.ring.gens[: len(self.variables)]
        result = self.ring.zero
        for exponents, value in coefficients(polynomial, self.variables).items():
            plain = divisor is None and _is_plain(value)
            kept = value if plain else self.define(value, letter, divisor)
            powers = (g**e for g, e in zip(unknowns, exponents, strict=True))
            result += prod(powers, start=kept)
        return result


def _is_plain(value: Polynomial) -> bool:
    """Whether a coefficient is a number, or a generator up to sign."""
    terms = list(value.iterterms())
    return value.is_ground or (len(terms) == 1 and sum(terms[0][0]) == 1 == abs(terms[0][1]))
