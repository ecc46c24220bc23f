"""Exact real numbers: rationals and the closed expressions that an instance file may contain.

A `Number` is an expression tree. Numerical code takes its `float`; certification evaluates the
same tree in ball arithmetic, so that what is proved is about the number that was written.
"""

from __future__ import annotations

import numbers
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from typing import Any, SupportsFloat, TypeAlias

from gspcli.errors import ArgumentError
from gspcli.geometry.evaluation import (
    FUNCTIONS,
    LARGEST,
    RATIONAL_OPERATIONS,
    SMALLEST,
    Element,
    Field,
    rounded_ratio,
)
from gspcli.geometry.expressions import nearest, parsed
from gspcli.records import dataclass

#: Types that are accepted as a number; NumPy's scalars are registered with `numbers.Real`.
Real: TypeAlias = "int | float | str | Fraction | Decimal | SupportsFloat | Number"


def _fraction(value: object) -> Fraction:
    """Return the fraction that a value stands for; see `Number.of`."""
    ratio: tuple[int, int] | None = None
    if isinstance(value, bool):
        pass
    elif isinstance(value, float):
        # Not repr: a float of NumPy shows its type there.
        ratio = _decimal_ratio(float.__repr__(value))
    elif isinstance(value, numbers.Rational):
        ratio = int(value.numerator), int(value.denominator)
    elif isinstance(value, numbers.Real | Decimal):
        ratio = _decimal_ratio(str(value))
    if ratio is None:
        message = f"found {_quoted(value)}, expected a finite number"
        raise ArgumentError(message)
    numerator, denominator = ratio
    if numerator and not SMALLEST <= abs(rounded_ratio(numerator, denominator)) <= LARGEST:
        expected = f"expected 0 or a magnitude from {SMALLEST:g} to {LARGEST:g}"
        message = f"found {value}, {expected}"
        raise ArgumentError(message)
    return Fraction(numerator, denominator)


def _decimal_ratio(text: str) -> tuple[int, int] | None:
    decimal = Decimal(text)
    return decimal.as_integer_ratio() if decimal.is_finite() else None


def _quoted(value: object) -> str:
    return str(value) if isinstance(value, numbers.Number) else f"a {type(value).__name__}"


@dataclass(frozen=True)
class Number:
    """An exact real number as an expression tree.

    Attributes
    ----------
    operation
        ``rational``, ``pi``, one of ``+ - * /``, ``neg``, or a name of `FUNCTIONS`.
    arguments
        The operands; of a rational, its one `fractions.Fraction`.
    """

    operation: str
    arguments: tuple[Any, ...] = ()

    @classmethod
    def of(cls, value: Real, where: str = "") -> Number:
        """Return the exact number that a value denotes; errors name it by `where`.

        A float stands for the shortest decimal that denotes it, as in a file: 0.1 is a tenth. A
        text may be an expression such as ``sqrt(3)/2`` (`gspcli.geometry.expressions`). Scalars of
        NumPy are accepted.

        Raises
        ------
        ArgumentError
            If the value is no finite number, or its magnitude is out of range.
        """
        if type(value) is float and (SMALLEST <= abs(value) <= LARGEST or not value):
            # As below, without the tests of the type: arrays of floats are the usual case.
            return cls("rational", (Fraction(*Decimal(repr(value)).as_integer_ratio()),))
        if isinstance(value, Number):
            return value
        try:
            if isinstance(value, str):
                return parse_number(value)
            return cls("rational", (_fraction(value),))
        except ArgumentError as error:
            raise error.within(where) from None
        except ValueError as error:
            raise ArgumentError(str(error), where) from None

    @property
    def fraction(self) -> Fraction | None:
        """The number as a fraction if its tree has only rational operations, else None."""
        if self.operation == "rational":
            value: Fraction = self.arguments[0]
            return value
        return self._reduced

    @cached_property
    def _reduced(self) -> Fraction | None:
        parts = [argument.fraction for argument in self.arguments]
        if self.operation not in RATIONAL_OPERATIONS or None in parts:
            return None
        result: Fraction = RATIONAL_OPERATIONS[self.operation](*parts)
        return result

    @cached_property
    def value(self) -> float:
        """The number rounded to a float, to a few units in its last place.

        It is zero only if the number is zero, as far as `gspcli.geometry.expressions` can prove.
        """
        exact = self.fraction
        if exact is not None:
            return rounded_ratio(exact.numerator, exact.denominator)
        return nearest(self)

    def evaluate(self, field: Field[Element]) -> Element:
        """Evaluate the tree in other arithmetic, such as balls."""
        if self.operation == "rational":
            return field.rational(self.arguments[0])
        if self.operation == "pi":
            return field.pi()
        parts: list[Any] = [argument.evaluate(field) for argument in self.arguments]
        if self.operation in RATIONAL_OPERATIONS:
            result: Element = RATIONAL_OPERATIONS[self.operation](*parts)
            return result
        return field.function(self.operation, parts[0])

    def __float__(self) -> float:
        return self.value

    def __hash__(self) -> int:
        # The hash of a fraction is slow, since it must equal that of an equal float.
        if self.operation == "rational":
            return hash((self.arguments[0].numerator, self.arguments[0].denominator))
        return hash((self.operation, self.arguments))

    def __str__(self) -> str:
        return _text(self, 0)

    def __repr__(self) -> str:
        return f"Number.of({str(self)!r})"


def parse_number(text: str) -> Number:
    """Return the exact number that a text denotes (`gspcli.geometry.expressions`).

    Raises
    ------
    ValueError
        If it denotes none; the message says what was found and what is expected.
    """
    return parsed(text, Number)


_PRECEDENCE = {"+": 1, "-": 1, "*": 2, "/": 2, "neg": 3}


def _decimal(value: Fraction) -> str:
    """Return a fraction as a finite decimal where there is one, else as p/q."""
    denominator, twos, fives = value.denominator, 0, 0
    while denominator % 2 == 0:
        denominator, twos = denominator // 2, twos + 1
    while denominator % 5 == 0:
        denominator, fives = denominator // 5, fives + 1
    if denominator != 1:
        return str(value)
    places = max(twos, fives)
    digits = str(abs(value.numerator) * 10**places // value.denominator).rjust(places + 1, "0")
    sign = "-" if value < 0 else ""
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)


def _text(number: Number, precedence: int) -> str:
    operation = number.operation
    if operation == "rational":
        text = _decimal(number.arguments[0])
        return f"({text})" if precedence and ("/" in text or text.startswith("-")) else text
    if operation == "pi":
        return "pi"
    if operation in FUNCTIONS:
        return f"{operation}({_text(number.arguments[0], 0)})"
    own = _PRECEDENCE[operation]
    if operation == "neg":
        text = "-" + _text(number.arguments[0], own)
    else:
        left, right = number.arguments
        text = f"{_text(left, own)} {operation} {_text(right, own + 1)}"
    return f"({text})" if own < precedence or (operation == "neg" and precedence) else text


_INVERSE = {"+": "-", "-": "+", "*": "/", "/": "*"}


def value_of(
    reading: Number, scale: Number | None, offset: Number | None, added: str = "+"
) -> Number:
    """Return the value of a reading.

    Parameters
    ----------
    reading
        What a file, a table or an encoder says.
    scale, offset
        None stands for zero.
    added
        The operation that applies the offset: ``+`` or ``-``.
    """
    if scale is not None:
        reading = combined(reading, "*", _factor(scale))
    return reading if offset is None else combined(reading, added, offset)


def reading_of(
    value: Number, scale: Number | None, offset: Number | None, added: str = "+"
) -> Number:
    """Return the reading at which the machine has a value; arguments as for `value_of`."""
    if offset is not None:
        value = combined(value, _INVERSE[added], offset)
    return value if scale is None else combined(value, "/", _factor(scale))


def _factor(scale: Number) -> Number:
    return combined(Number.of(1), "+", scale)


def combined(number: Number, operation: str, other: Number) -> Number:
    """Return a number after an operation; an operation and its inverse cancel exactly."""
    if number.operation == _INVERSE[operation] and number.arguments[1] == other:
        undone: Number = number.arguments[0]
        return undone
    result = Number(operation, (number, other))
    return result if result.fraction is None else Number("rational", (result.fraction,))
