"""The numbers and angles of instance files as exact elements.

Square roots are taken of rational elements only. Values of inverse functions are not in the ring,
but cosines and sines of their integer multiples are.
"""

from __future__ import annotations

from fractions import Fraction

from gspcli.certification.counting.elements import (
    HALF,
    ONE,
    WHOLE,
    FieldElement,
    NoElementError,
    Term,
    collected,
)
from gspcli.geometry.instance import AngleUnit
from gspcli.geometry.numbers import RATIONAL_OPERATIONS, Number, multiple_of_pi
from gspcli.records import dataclass

_ZERO, _UNIT = FieldElement.of(0), FieldElement.of(1)
_PI_TERM = ONE._replace(pi=1)
_PI = FieldElement({_PI_TERM: Fraction(1)}, WHOLE)
_I = FieldElement({ONE._replace(turn=Fraction(1, 4)): Fraction(1)}, WHOLE)


def element(number: Number) -> FieldElement:
    """Return the element of a number of an instance file.

    Raises
    ------
    NoElementError
        If it has none.
    """
    if number.fraction is not None:
        return FieldElement.of(number.fraction)
    arguments = number.arguments
    match number.operation:
        case "pi":
            return _PI
        case operation if operation in RATIONAL_OPERATIONS:
            result: FieldElement = RATIONAL_OPERATIONS[operation](*map(element, arguments))
            return result
        case "sqrt":
            return element(arguments[0]).sqrt()
        case "cos":
            return Angle.of(arguments[0]).cos()
        case "sin":
            return Angle.of(arguments[0]).sin()
        case "tan":
            return Angle.of(arguments[0]).sin() / Angle.of(arguments[0]).cos()
        case operation:
            message = f"{operation} outside an angle"
            raise NoElementError(message)


def squared(number: Number) -> FieldElement:
    """Return the square of a number; square roots of all elements have one.

    Raises
    ------
    NoElementError
        If it has none.
    """
    if number.fraction is None:
        parts = number.arguments
        match number.operation:
            case "sqrt":
                return element(parts[0])
            case "neg":
                return squared(parts[0])
            case "*":
                return squared(parts[0]) * squared(parts[1])
            case "/":
                return squared(parts[0]) / squared(parts[1])
    value = element(number)
    return value * value


_ARCS = ("acos", "asin", "atan")
_QUARTER = Fraction(1, 4)
#: Four times the squares of the cosines of the multiples of 30 and 45 degrees, by 24ths of a turn.
_SQUARED_COSINES = {0: 4, 2: 3, 3: 2, 4: 1, 6: 0, 8: 1, 9: 2, 10: 3, 12: 4}
_NONE = Fraction(0)


@dataclass(frozen=True)
class Angle:
    """An angle in radians: a multiple of pi, a rational number, and integer multiples of arcs.

    Attributes
    ----------
    constant
        The part without arcs.
    arcs
        Pairs of an arccosine, arcsine or arctangent and its factor.
    """

    constant: FieldElement
    arcs: tuple[tuple[Number, FieldElement], ...] = ()

    @classmethod
    def of(cls, number: Number) -> Angle:
        """Return the angle of a number.

        Raises
        ------
        NoElementError
            If the angle is not in the ring.
        """
        arguments = number.arguments
        if number.fraction is not None:
            return cls(FieldElement.of(number.fraction))
        factor = multiple_of_pi(number)
        if factor is not None:
            return cls(FieldElement({_PI_TERM: factor} if factor else {}, WHOLE))
        match number.operation:
            case "+":
                return cls.of(arguments[0]) + cls.of(arguments[1])
            case "-":
                return cls.of(arguments[0]) + cls.of(arguments[1]).times(-_UNIT)
            case "neg":
                return cls.of(arguments[0]).times(-_UNIT)
            case "*":
                first, second = cls.of(arguments[0]), cls.of(arguments[1])
                return second.times(first.constant) if first.is_constant else first * second
            case "/":
                return cls.of(arguments[0]) * cls(_UNIT / element(arguments[1]))
            case operation if operation in _ARCS:
                return cls(_ZERO, ((number, _UNIT),))
        return cls(element(number))

    @property
    def is_constant(self) -> bool:
        """Whether it contains no arcs."""
        return not self.arcs

    def times(self, factor: FieldElement) -> Angle:
        """Return a multiple."""
        arcs = tuple((arc, coefficient * factor) for arc, coefficient in self.arcs)
        return Angle(self.constant * factor, arcs)

    def __add__(self, other: Angle) -> Angle:
        return Angle(self.constant + other.constant, self.arcs + other.arcs)

    def __mul__(self, other: Angle) -> Angle:
        if not other.is_constant:
            message = "a product of arcs"
            raise NoElementError(message)
        return self.times(other.constant)

    def cos(self) -> FieldElement:
        """Return the cosine."""
        if self.is_constant:
            return _cosine(*self._turn_and_radians())
        plus, minus = self._exponentials()
        return (plus + minus) / FieldElement.of(2)

    def sin(self) -> FieldElement:
        """Return the sine."""
        if self.is_constant:
            turn, radians = self._turn_and_radians()
            return _cosine(turn - _QUARTER, radians)
        plus, minus = self._exponentials()
        return (plus - minus) / (FieldElement.of(2) * _I)

    def _turn_and_radians(self) -> tuple[Fraction, Fraction]:
        """Return q and r of the constant part ``2 pi q + r``."""
        numerator, denominator = self.constant.numerator, self.constant.denominator
        if denominator is WHOLE and len(numerator) == 1 and _PI_TERM in numerator:
            # The usual case.
            return numerator[_PI_TERM] / 2, _NONE
        radians = self.constant.fraction
        if radians is not None:
            return Fraction(0), radians
        if numerator.keys() <= {ONE, _PI_TERM} and denominator.keys() == {ONE}:
            unit = denominator[ONE]
            turn = numerator.get(_PI_TERM, _NONE) / unit / 2
            return turn, numerator.get(ONE, _NONE) / unit
        message = "an angle that is not rational in degrees or radians"
        raise NoElementError(message)

    def _exponentials(self) -> tuple[FieldElement, FieldElement]:
        """Return ``exp(i x)`` and ``exp(-i x)``."""
        turn, radians = self._turn_and_radians()
        results = [
            FieldElement(collected([(Term(1, s * turn, s * radians, 0), Fraction(1))]), WHOLE)
            for s in (1, -1)
        ]
        for arc, coefficient in self.arcs:
            times = coefficient.fraction
            if times is None or times.denominator != 1:
                message = f"a part of {arc.operation}"
                raise NoElementError(message)
            pair = _arc_exponentials(arc)
            for _ in range(abs(int(times))):
                for k in (0, 1):
                    results[k] *= pair[k if times > 0 else 1 - k]
        return results[0], results[1]


def _arc_exponentials(arc: Number) -> tuple[FieldElement, FieldElement]:
    """Return ``exp(i x)`` and ``exp(-i x)`` of an arccosine, arcsine or arctangent."""
    x = element(arc.arguments[0])
    if arc.operation == "atan":
        size = (_UNIT + x * x).sqrt()
        real, imaginary = _UNIT / size, x / size
    else:
        real, imaginary = x, (_UNIT - x * x).sqrt()
        if arc.operation == "asin":
            real, imaginary = imaginary, real
    return real + _I * imaginary, real - _I * imaginary


def _cosine(turn: Fraction, radians: Fraction) -> FieldElement:
    """Return the cosine of a part of a turn and some radians."""
    if radians:
        terms = [(Term(1, sign * turn, sign * radians, 0), HALF) for sign in (1, -1)]
        return FieldElement(collected(terms), WHOLE)
    whole = turn.denominator
    part = turn.numerator % whole
    part = min(part, whole - part)
    twentyfourths, rest = divmod(24 * part, whole)
    if not rest and twentyfourths in _SQUARED_COSINES:
        square = FieldElement.of(Fraction(_SQUARED_COSINES[twentyfourths], 4))
        return square.sqrt() if twentyfourths < 6 else -square.sqrt()
    # exp(-2 pi i q) is minus exp(2 pi i (1/2 - q)).
    terms_of_both = {
        Term(1, Fraction(part, whole), _NONE, 0): HALF,
        Term(1, Fraction(whole - 2 * part, 2 * whole), _NONE, 0): -HALF,
    }
    return FieldElement(terms_of_both, WHOLE)


def in_radians(angle: Number, unit: AngleUnit) -> Angle:
    """Return an angle of an instance in radians."""
    value = Angle.of(angle)
    return value if unit is AngleUnit.RADIAN else value.times(_PI / FieldElement.of(180))
