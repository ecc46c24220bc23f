"""Polynomials with exact coefficients, and how programs write them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from math import lcm

from gspcli.records import dataclass

#: The symbols of a monomial in alphabetical order, each as often as its exponent says.
Monomial = tuple[str, ...]


@dataclass(frozen=True)
class Polynomial:
    """A polynomial in named symbols over the rational numbers.

    Attributes
    ----------
    terms
        Coefficients by monomial, none zero.
    """

    terms: Mapping[Monomial, Fraction]

    @classmethod
    def constant(cls, value: Fraction | int) -> Polynomial:
        """Return a constant."""
        return cls({(): Fraction(value)} if value else {})

    @classmethod
    def symbol(cls, name: str) -> Polynomial:
        """Return a symbol."""
        return cls({(name,): Fraction(1)})

    @property
    def value(self) -> Fraction | None:
        """The number that the polynomial is, or None."""
        return None if set(self.terms) - {()} else self.terms.get((), Fraction(0))

    @cached_property
    def cleared(self) -> dict[Monomial, int]:
        """Integer coefficients: multiplied by the least common denominator."""
        common = lcm(*(value.denominator for value in self.terms.values()))
        return {monomial: int(value * common) for monomial, value in self.terms.items()}

    def replaced(self, values: Mapping[str, Fraction | int | Polynomial]) -> Polynomial:
        """Return the polynomial with values for some symbols."""
        result: dict[Monomial, Fraction] = {}
        for monomial, coefficient in self.terms.items():
            kept = tuple(name for name in monomial if name not in values)
            factor = Polynomial({kept: coefficient})
            for name in monomial:
                if name in values:
                    factor = factor * values[name]
            for key, value in factor.terms.items():
                result[key] = result.get(key, Fraction(0)) + value
        return _without_zeros(result)

    def __add__(self, other: Operand) -> Polynomial:
        result = dict(self.terms)
        for monomial, value in _of(other).terms.items():
            result[monomial] = result.get(monomial, Fraction(0)) + value
        return _without_zeros(result)

    def __mul__(self, other: Operand) -> Polynomial:
        factors = _of(other).terms
        result: dict[Monomial, Fraction] = {}
        for m, p in self.terms.items():
            for n, q in factors.items():
                monomial = tuple(sorted(m + n))
                result[monomial] = result.get(monomial, Fraction(0)) + p * q
        return _without_zeros(result)

    def __neg__(self) -> Polynomial:
        return Polynomial({monomial: -value for monomial, value in self.terms.items()})

    def __sub__(self, other: Operand) -> Polynomial:
        return self + -_of(other)

    def __rsub__(self, other: Operand) -> Polynomial:
        return _of(other) - self

    __radd__ = __add__
    __rmul__ = __mul__


Operand = Polynomial | Fraction | int


def _of(value: Operand) -> Polynomial:
    return value if isinstance(value, Polynomial) else Polynomial.constant(value)


def _without_zeros(terms: dict[Monomial, Fraction]) -> Polynomial:
    return Polynomial({monomial: value for monomial, value in terms.items() if value})


def dot(a: Sequence[Operand], b: Sequence[Operand]) -> Polynomial:
    """Return the scalar product of two vectors."""
    return sum((_of(p) * q for p, q in zip(a, b, strict=True)), start=Polynomial({}))


def cross(a: Sequence[Operand], b: Sequence[Operand]) -> list[Polynomial]:
    """Return the vector product of two vectors."""
    return [_of(a[i - 2]) * b[i - 1] - _of(a[i - 1]) * b[i - 2] for i in range(3)]


@dataclass(frozen=True)
class Style:
    """How a program writes polynomials.

    Attributes
    ----------
    power
        Between a symbol and its exponent.
    quotient
        Between numerator and denominator.
    imaginary
        The imaginary unit.
    exponent
        The letter before the exponent of a floating-point number.
    """

    power: str = "^"
    quotient: str = "/"
    imaginary: str = "I"
    exponent: str = "e"

    def written(
        self, terms: Mapping[Monomial, complex | Fraction] | Iterable[tuple[complex, Monomial]]
    ) -> str:
        """Return the text of a polynomial, ``0`` for none."""
        pairs = (
            ((value, monomial) for monomial, value in terms.items())
            if isinstance(terms, Mapping)
            else terms
        )
        # msolve and Singular do not understand a sign before the first term.
        text = "".join(self._term(value, monomial) for value, monomial in pairs)
        return text.removeprefix("+") or "0"

    def _term(self, value: complex | Fraction, monomial: Monomial) -> str:
        # Written as a product with powers: msolve does not understand x*x.
        return "*".join([self._number(value), *self._powers(monomial)])

    def _powers(self, monomial: Monomial) -> Iterator[str]:
        for name in dict.fromkeys(monomial):
            count = monomial.count(name)
            yield name if count == 1 else f"{name}{self.power}{count}"

    def _number(self, value: complex | Fraction) -> str:
        if isinstance(value, Fraction | int):
            below = "" if value.denominator == 1 else f"{self.quotient}{value.denominator}"
            return f"{value.numerator:+d}{below}"
        real = self._float(complex(value).real)
        imaginary = complex(value).imag
        return f"+({real}{self._float(imaginary)}*{self.imaginary})" if imaginary else real

    def _float(self, value: float) -> str:
        return f"{value:+.16e}".replace("e", self.exponent)
