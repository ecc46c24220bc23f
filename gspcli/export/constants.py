"""The exact numbers of an instance as polynomials in named constants such as ``k1 = sqrt(3)``."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import isqrt

from gspcli.export.polynomials import Polynomial, dot
from gspcli.geometry.instance import AngleUnit, Constraint
from gspcli.geometry.numbers import Number

_COSINES = {0: "1", 60: "1/2", 90: "0", 120: "-1/2", 180: "-1"}
_ROOTS = {30: ("1/2", 3), 45: ("1/2", 2), 135: ("-1/2", 2), 150: ("-1/2", 3)}
_HALF = Number.of(180)
_PI = Number("pi")


class Constants:
    """Numbers as polynomials; each irrational one gets a name when it is first met.

    Attributes
    ----------
    names
        The irrational numbers by name.
    """

    def __init__(self) -> None:
        self.names: dict[str, Number] = {}
        self._squares: dict[str, Fraction] = {}

    def number(self, number: Number) -> Polynomial:
        """Return an exact number."""
        if number.fraction is not None:
            return Polynomial.constant(number.fraction)
        parts = number.arguments
        match number.operation:
            case "+":
                return self.number(parts[0]) + self.number(parts[1])
            case "-":
                return self.number(parts[0]) - self.number(parts[1])
            case "*":
                return self.reduced(self.number(parts[0]) * self.number(parts[1]))
            case "neg":
                return -self.number(parts[0])
            case "/":
                below = self.number(parts[1]).value
                if below:
                    return self.number(parts[0]) * (1 / below)
            case "sqrt":
                inside = self.number(parts[0]).value
                if inside is not None:
                    return self.root(inside)
        return self._named(number)

    def vector(self, numbers: Sequence[Number]) -> list[Polynomial]:
        """Return an exact vector."""
        return [self.number(number) for number in numbers]

    def square(self, number: Number) -> Polynomial:
        """Return the square of a number; for a square root this is the radicand."""
        if number.operation == "sqrt":
            return self.number(number.arguments[0])
        value = self.number(number)
        return self.reduced(value * value)

    def norm(self, numbers: Sequence[Number]) -> Polynomial:
        """Return the length of a vector."""
        vector = self.vector(numbers)
        square = self.reduced(dot(vector, vector)).value
        if square is not None:
            return self.root(square)
        total = Number.of(0)
        for number in numbers:
            total = Number("+", (total, Number("*", (number, number))))
        return self._named(Number("sqrt", (total,)))

    def root(self, square: Fraction) -> Polynomial:
        """Return the square root of a fraction that is not negative."""
        root = Fraction(isqrt(square.numerator), isqrt(square.denominator))
        if root * root == square:
            return Polynomial.constant(root)
        # sqrt(p/q) = sqrt(p q) / q
        inside, below = square.numerator * square.denominator, square.denominator
        outside = 1
        for factor in range(2, 1000):
            while inside % (factor * factor) == 0:
                inside, outside = inside // (factor * factor), outside * factor
        name = self._named(Number("sqrt", (Number.of(inside),)))
        (key,) = name.terms
        self._squares[key[0]] = Fraction(inside)
        return name * Fraction(outside, below)

    def cosine(self, constraint: Constraint, unit: AngleUnit) -> Polynomial:
        """Return the value of ``R u . v`` of an angle, by Section 4."""
        angle, law = constraint.value, constraint.kind.law
        if law.is_cosine:
            return self._cosine(angle, unit) * law.sign
        quarter = Number.of(90) if unit is AngleUnit.DEGREE else Number("/", (_PI, Number.of(2)))
        function = _undone("asin", angle, unit)
        if function is not None:
            return self.number(function)
        return self._cosine(Number("-", (quarter, angle)), unit)

    def _cosine(self, angle: Number, unit: AngleUnit) -> Polynomial:
        inside = _undone("acos", angle, unit)
        if inside is not None:
            return self.number(inside)
        degrees = angle.fraction
        if unit is AngleUnit.DEGREE and degrees is not None and degrees.denominator == 1:
            whole = int(degrees)
            if whole in _COSINES:
                return Polynomial.constant(Fraction(_COSINES[whole]))
            if whole in _ROOTS:
                factor, square = _ROOTS[whole]
                return self.root(Fraction(square)) * Fraction(factor)
        if unit is AngleUnit.DEGREE:
            angle = Number("/", (Number("*", (angle, _PI)), _HALF))
        return (
            self.number(Number("cos", (angle,))) if angle.fraction != 0 else Polynomial.constant(1)
        )

    def reduced(self, value: Polynomial) -> Polynomial:
        """Return a polynomial without squares of the constants that are roots of fractions."""
        for name, square in self._squares.items():
            terms: dict[tuple[str, ...], Fraction] = {}
            for monomial, coefficient in value.terms.items():
                pairs = monomial.count(name) // 2
                if pairs:
                    first = monomial.index(name)
                    monomial = monomial[:first] + monomial[first + 2 * pairs :]
                terms[monomial] = terms.get(monomial, Fraction(0)) + coefficient * square**pairs
            value = Polynomial({key: number for key, number in terms.items() if number})
        return value

    def _named(self, number: Number) -> Polynomial:
        for name, known in self.names.items():
            if known == number:
                return Polynomial.symbol(name)
        name = f"k{len(self.names) + 1}"
        self.names[name] = number
        return Polynomial.symbol(name)


def _undone(function: str, angle: Number, unit: AngleUnit) -> Number | None:
    """Return x if an angle is written as ``acos(x)`` or, in degrees, ``acos(x)*180/pi``."""
    if unit is AngleUnit.DEGREE:
        if angle.operation != "/" or angle.arguments[1] != _PI:
            return None
        angle = angle.arguments[0]
        if angle.operation != "*" or angle.arguments[1].fraction != 180:
            return None
        angle = angle.arguments[0]
    if angle.operation != function:
        return None
    inside: Number = angle.arguments[0]
    return inside
