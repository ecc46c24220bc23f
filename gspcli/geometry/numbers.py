"""Exact real numbers: rationals and the closed expressions that an instance file may contain.

A `Number` is an expression tree. Its rational parts are fractions; all else is enclosed by balls of
arb, so that what is proved is about the number that was written. The grammar, with any blanks
between the tokens::

    sum     = product { ("+" | "-") product }
    product = signed { ("*" | "/") signed }
    signed  = { "+" | "-" } atom
    atom    = decimal | "pi" | function "(" sum ")" | "(" sum ")"

The functions are those of `FUNCTIONS`, whose trigonometric ones take and give radians, and sind,
cosd and tand of degrees: ``cosd(x)`` is ``cos(x*pi/180)``. Subexpressions that are rational are
kept as one fraction; so are products with zero, roots of squares, and the functions of zero and of
those multiples of pi whose values are rational.
"""

from __future__ import annotations

import math
import numbers
import operator
import re
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from math import isqrt, lcm
from typing import TYPE_CHECKING, Any, NamedTuple, SupportsFloat, TypeAlias

from gspcli.errors import ArgumentError
from gspcli.records import dataclass
from gspcli.wording import shown, similar

if TYPE_CHECKING:
    from flint import arb

#: The functions that an expression may use, by the names of arb.
FUNCTIONS = ("sqrt", "sin", "cos", "tan", "asin", "acos", "atan")
#: Operations with a rational result for rational operands.
RATIONAL_OPERATIONS: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "neg": operator.neg,
}
#: A number is zero or of a magnitude in this range: its fourth power is still a finite float.
SMALLEST, LARGEST = 1e-60, 1e60

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
        raise ArgumentError(f"found {_quoted(value)}, expected a finite number")
    numerator, denominator = ratio
    if numerator and not SMALLEST <= abs(rounded_ratio(numerator, denominator)) <= LARGEST:
        expected = f"expected 0 or a magnitude from {SMALLEST:g} to {LARGEST:g}"
        raise ArgumentError(f"found {value}, {expected}")
    return Fraction(numerator, denominator)


def _decimal_ratio(text: str) -> tuple[int, int] | None:
    decimal = Decimal(text)
    return decimal.as_integer_ratio() if decimal.is_finite() else None


def _quoted(value: object) -> str:
    return str(value) if isinstance(value, numbers.Number) else f"a {type(value).__name__}"


class NoNumberError(ValueError):
    """An expression has no real value, such as the root of a negative number."""


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
        text may be an expression such as ``sqrt(3)/2``. Scalars of
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
        """The number rounded to a float.

        It is zero only if the number is zero, as far as `sign_of` can prove.

        Raises
        ------
        NoNumberError
            If the number does not exist, or cannot be distinguished from one that does not.
        """
        exact = self.fraction
        if exact is not None:
            return rounded_ratio(exact.numerator, exact.denominator)
        for bits in _BITS:
            enclosure = self.enclosed(bits)
            if enclosure.rel_accuracy_bits() >= _DOUBLE_BITS:
                return float(enclosure)
        if not enclosure.is_finite():
            raise NoNumberError("the number does not exist")
        return 0.0 if sign_of(self) == 0 else float(enclosure)

    def ball(self, *, clipped: bool = False) -> arb:
        """Return a ball that contains the number, at the precision of `flint.ctx`.

        Parameters
        ----------
        clipped
            Whether arguments of roots and arcs that may be outside of their domains are taken to be
            inside. Without, the ball is then NaN.
        """
        if self.operation == "rational":
            return _ratio(self.arguments[0])
        if self.operation == "pi":
            from flint import arb

            return arb.pi()
        parts = [argument.ball(clipped=clipped) for argument in self.arguments]
        if self.operation in RATIONAL_OPERATIONS:
            result: arb = RATIONAL_OPERATIONS[self.operation](*parts)
            return result
        if clipped and self.operation in _DOMAINS:
            return _monotone(self.operation, parts[0])
        image: arb = getattr(parts[0], self.operation)()
        return image

    def enclosed(self, bits: int) -> arb:
        """Return a ball with some bits, clipped."""
        from flint import ctx

        with ctx.workprec(bits):
            return self.ball(clipped=True)

    def __add__(self, other: Number | int) -> Number:
        """Return the sum; as all results of operators one fraction if it is rational."""
        other = Number.of(other)
        return self if other.fraction == 0 else _folded("+", self, other)

    def __sub__(self, other: Number | int) -> Number:
        other = Number.of(other)
        return self if other.fraction == 0 else _folded("-", self, other)

    def __mul__(self, other: Number | int) -> Number:
        other = Number.of(other)
        if self.fraction == 0 or other.fraction == 0:
            return Number("rational", (Fraction(0),))
        return _folded("*", self, other)

    def __truediv__(self, other: Number | int) -> Number:
        return _folded("/", self, Number.of(other))

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Number:
        return _folded("neg", self)

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


def rounded_ratio(numerator: int, denominator: int) -> float:
    """Return a fraction rounded to a float, infinite above the largest float."""
    try:
        return numerator / denominator
    except OverflowError:
        return math.inf if numerator > 0 else -math.inf


def _ratio(value: Fraction) -> arb:
    from flint import arb, fmpq

    return arb(fmpq(value.numerator, value.denominator))


#: The ends of the domains of functions that have them.
_DOMAINS = {"sqrt": (0, math.inf), "asin": (-1, 1), "acos": (-1, 1)}


def _monotone(name: str, argument: arb) -> arb:
    """Return a ball about the values of a function in its domain; NaN if it has none there."""
    from flint import arb

    least, most = _DOMAINS[name]
    low, high = max(argument.lower(), arb(least)), min(argument.upper(), arb(most))
    if not low <= high:
        return arb.nan()
    ends: list[arb] = [getattr(end, name)() for end in (low, high)]
    hull: arb = ends[0].union(ends[1])
    return hull


# The sign of an exact number where doubles do not suffice.
#
# ``sqrt(2) - 1.414213562373095`` is 4.9e-17, but zero in floating point; ``sqrt(2)*sqrt(2) - 2`` is
# zero, but 4e-16 in floating point. More digits prove that a number is not zero. An algebraic
# number is zero if its modulus is below the bound that follows.


#: Precisions that are tried in turn, and the largest one for a proof that a number is zero.
_BITS, _MOST_BITS = (128, 512, 2048), 2**15
#: Bits of a ball whose middle is rounded to a double.
_DOUBLE_BITS = 64


def sign_of(number: Number) -> int | None:
    """Return 1, 0 or -1, proved; None if the sign is not known."""
    if number.fraction is not None:
        return (number.fraction > 0) - (number.fraction < 0)
    for bits in _BITS:
        enclosure = number.enclosed(bits)
        if enclosure > 0 or enclosure < 0:
            return 1 if enclosure > 0 else -1
    separation = separation_bits(number)
    if separation is None or separation > _MOST_BITS:
        return None
    enclosure = number.enclosed(separation + _BITS[0])
    if enclosure > 0 or enclosure < 0:
        return 1 if enclosure > 0 else -1
    return 0 if enclosure.abs_upper() * 2**separation < 1 else None


# A lower bound of the modulus of an algebraic number that is not zero.
#
# The number is written as U / L with algebraic integers U and L, whose conjugates are at most u and
# l in modulus, of a field of degree D. If U is not zero its norm is a nonzero integer, so that
# ``|U| u^(D-1) >= 1``, and the number is at least ``1 / (u^(D-1) l)`` (C. Burnikel, S. Funke, K.
# Mehlhorn, S. Schirra, S. Schmitt, A separation bound for real algebraic expressions, 2001). A
# square root counts ``sqrt(U / L) = sqrt(U L) / L``; the cosine of a rational angle is half an
# algebraic integer with conjugates of at most 2.


class _Bounds(NamedTuple):
    """The bounds u and l of an expression, its square roots, and the order of its root of unity."""

    above: int
    below: int
    roots: frozenset[Number]
    order: int


def separation_bits(number: Number) -> int | None:
    """Return b such that a number is zero or at least ``2^-b`` in modulus.

    The result is None if the number is not known to be algebraic.
    """
    found = _bounds(number)
    if found is None:
        return None
    degree = found.order << len(found.roots)
    return found.above.bit_length() * (degree - 1) + found.below.bit_length()


def _bounds(number: Number) -> _Bounds | None:
    operation, arguments = number.operation, number.arguments
    if number.fraction is not None:
        p, q = number.fraction.as_integer_ratio()
        return _Bounds(abs(p), q, frozenset(), 1)
    if operation in ("sin", "cos", "tan"):
        return _trigonometric(operation, arguments[0])
    if operation not in ("neg", "sqrt", "+", "-", "*", "/"):
        return None
    parts = [_bounds(argument) for argument in arguments]
    if None in parts:
        return None
    first, second = parts[0], parts[-1]
    assert first is not None
    assert second is not None
    if operation == "neg":
        return first
    if operation == "sqrt":
        root = isqrt(first.above * first.below) + 1
        return first._replace(above=root, roots=first.roots | {number})
    both = first.roots | second.roots, lcm(first.order, second.order)
    if operation == "*":
        return _Bounds(first.above * second.above, first.below * second.below, *both)
    if operation == "/":
        return _Bounds(first.above * second.below, first.below * second.above, *both)
    return _Bounds(
        first.above * second.below + first.below * second.above, first.below * second.below, *both
    )


def _trigonometric(operation: str, angle: Number) -> _Bounds | None:
    halves = multiple_of_pi(angle)
    if halves is None:
        return None
    # The sine is a cosine of an angle that is a quarter turn less.
    order = lcm(2 * halves.denominator, 4)
    # A tangent is a quotient of two such numbers.
    size = 4 if operation == "tan" else 2
    return _Bounds(size, size, frozenset(), order)


def multiple_of_pi(number: Number) -> Fraction | None:
    """Return the rational factor if a number is written as a rational multiple of pi."""
    operation, arguments = number.operation, number.arguments
    if operation == "pi":
        return Fraction(1)
    if operation == "rational":
        return Fraction(0) if number.fraction == 0 else None
    if operation == "neg":
        factor = multiple_of_pi(arguments[0])
        return None if factor is None else -factor
    if operation not in ("+", "-", "*", "/"):
        return None
    left, right = map(multiple_of_pi, arguments)
    if operation in ("+", "-"):
        if left is None or right is None:
            return None
        return left + right if operation == "+" else left - right
    before: Fraction | None = arguments[0].fraction
    after: Fraction | None = arguments[1].fraction
    if left is not None and after is not None:
        return left * after if operation == "*" else left / after
    if right is not None and before is not None and operation == "*":
        return before * right
    return None


MAX_LENGTH = 400
MAX_NESTING = 20

_TOKEN = re.compile(
    r"\s*(?:(?P<decimal>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-z][A-Za-z0-9]*)|(?P<symbol>[-+*/()]))"
)
_MAX_EXPONENT = 100
#: Words of other programs for values that are not finite.
_NOT_FINITE = {"nan", "inf", "infinity"}
#: Functions of degrees, by what they are in radians.
_OF_DEGREES = {"sind": "sin", "cosd": "cos", "tand": "tan"}
#: Operations on numbers that are not zero which may give zero without being rational.
_MAY_BE_ZERO = ("+", "-", "sin", "cos")
#: What spreadsheets make of some numbers; as a difference it would be read silently.
_DATE = re.compile(r"(19|20)\d\d-(0[1-9]|1[0-2])-([0-2]\d|3[01])")
_HINTS = {
    "−": "write the minus sign as -",
    "–": "write the minus sign as -",
    "π": "write pi",
    "√": "write sqrt(...)",
    "×": "write *",
    "·": "write *",
    "°": "angles are in the unit that units.angle states",
    "^": "write a power as a product, x*x",
    "_": "write digits without separators",
    ",": "write decimals with a point",
    ":": "write 1:30 as 1.5",
}


def _folded(operation: str, *arguments: Number) -> Number:
    number = Number(operation, arguments)
    return number if number.fraction is None else Number("rational", (number.fraction,))


def parse_number(text: str) -> Number:
    """Return the exact number that a text denotes.

    Raises
    ------
    ValueError
        If it denotes none; the message says what was found and what is expected.
    """
    if not text.strip():
        raise ValueError("found nothing, expected a number")
    if len(text) > MAX_LENGTH:
        raise ValueError(f"found {len(text)} characters, expected a number of at most {MAX_LENGTH}")
    if _DATE.fullmatch(text):
        raise ValueError(
            f"found the date {shown(text)}, expected a number: write a difference with blanks"
        )
    number = _Parser(text).number()
    size = abs(number.value)
    if number.fraction == 0 or (SMALLEST <= size <= LARGEST and sign_of(number)):
        return number
    if number.fraction is None and size <= LARGEST and not sign_of(number):
        raise ValueError(
            f"found {shown(text)}, which may be zero: write 0, or a simpler expression"
        )
    raise ValueError(
        f"found {shown(text)}, expected 0 or a magnitude from {SMALLEST:g} to {LARGEST:g}"
    )


class _Parser:
    """Recursive descent over one expression."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = self._tokens()
        self.position = 0
        self.nesting = 0

    def _tokens(self) -> list[tuple[str, str]]:
        tokens, end = [], 0
        while end < len(self.text.rstrip()):
            match = _TOKEN.match(self.text, end)
            if match is None:
                character = self.text[end:].lstrip()[0]
                raise self._error(shown(character), "a number", _HINTS.get(character))
            tokens.append((str(match.lastgroup), match[str(match.lastgroup)]))
            end = match.end()
        return [*tokens, ("end", "the end")]

    def _error(self, found: str, expected: str, hint: str | None = None) -> ValueError:
        where = "" if found == shown(self.text) else f" in {shown(self.text)}"
        return ValueError(f"found {found}{where}, expected {expected}" + (f": {hint}" * bool(hint)))

    def _unexpected(self, expected: str, hint: str | None = None) -> ValueError:
        kind, token = self.tokens[self.position]
        return self._error(token if kind == "end" else shown(token), expected, hint)

    def _take(self, *symbols: str) -> str | None:
        kind, token = self.tokens[self.position]
        if kind == "symbol" and token in symbols:
            self.position += 1
            return token
        return None

    def number(self) -> Number:
        number = self._sum()
        kind, _ = self.tokens[self.position]
        if kind != "end":
            product = "write a product with *" if kind in ("name", "decimal") else None
            raise self._unexpected("an operator or the end", product)
        return number

    def _sum(self) -> Number:
        number = self._product()
        while symbol := self._take("+", "-"):
            number = self._apply(symbol, number, self._product())
        return number

    def _product(self) -> Number:
        number = self._signed()
        while symbol := self._take("*", "/"):
            if symbol == "*" and self.tokens[self.position] == ("symbol", "*"):
                raise self._unexpected("a number", _HINTS["^"])
            number = self._apply(symbol, number, self._signed())
        return number

    def _signed(self) -> Number:
        negative = False
        while sign := self._take("+", "-"):
            negative ^= sign == "-"
        number = self._atom()
        return self._apply("neg", number) if negative else number

    def _atom(self) -> Number:
        kind, token = self.tokens[self.position]
        if kind == "decimal":
            self.position += 1
            return self._decimal(token)
        if kind == "name":
            self.position += 1
            return self._named(token)
        if self._take("("):
            return self._parenthesis()
        raise self._unexpected("a number")

    def _decimal(self, token: str) -> Number:
        exponent = token.lower().partition("e")[2]
        if exponent and abs(int(exponent)) > _MAX_EXPONENT:
            raise self._error(shown(token), f"an exponent of at most {_MAX_EXPONENT}")
        return Number("rational", (Fraction(token),))

    def _named(self, name: str) -> Number:
        if name == "pi":
            return Number("pi", ())
        known = ["pi", *FUNCTIONS, *_OF_DEGREES]
        if name not in known:
            self.position -= 1
            if name.lower() in _NOT_FINITE:
                raise self._unexpected("a finite number")
            near = similar(name.lower(), known, 1)
            hint = f"did you mean {near[0]}?" if near else None
            raise self._unexpected(f"a number, {', '.join(known[:-1])} or {known[-1]}", hint)
        if not self._take("("):
            raise self._unexpected(f"( after {name}")
        argument = self._parenthesis()
        if name in _OF_DEGREES:
            turned = self._apply("*", argument, Number("pi", ()))
            radians = self._apply("/", turned, Number("rational", (Fraction(180),)))
            return self._apply(_OF_DEGREES[name], radians)
        return self._apply(name, argument)

    def _parenthesis(self) -> Number:
        self.nesting += 1
        if self.nesting > MAX_NESTING:
            raise self._error(f"more than {MAX_NESTING} nested parentheses", "a simpler expression")
        number = self._sum()
        if not self._take(")"):
            raise self._unexpected(")")
        self.nesting -= 1
        return number

    def _apply(self, operation: str, *arguments: Number) -> Number:
        """Return the number of an operation, checked to exist; a fraction if it is rational."""
        number = Number(operation, arguments)
        try:
            exact = number.fraction
            if exact is None:
                exact = _rational_value(operation, arguments)
            divisor = Number("cos", arguments) if operation == "tan" else arguments[-1]
            if operation in ("/", "tan") and not sign_of(divisor):
                raise ZeroDivisionError
            # Evaluated at each step, so that no intermediate value can grow without limit.
            if any(math.isinf(each.value) for each in (number, *arguments)):
                raise self._error("a number that is too large", f"at most {LARGEST:g}")
        except ZeroDivisionError:
            if operation == "tan":
                raise self._error("the tangent of a right angle", "another angle") from None
            zero = "zero" if arguments[1].fraction == 0 else "a number that may be zero"
            raise self._error(f"a division by {zero}", "a nonzero divisor") from None
        except NoNumberError:
            argument = arguments[0].value
            domain = "an argument of at least 0" if operation == "sqrt" else "one from -1 to 1"
            raise self._error(f"{operation} of {argument:.6g}", domain) from None
        if operation in _MAY_BE_ZERO and exact is None and sign_of(number) == 0:
            exact = Fraction(0)
        return number if exact is None else Number("rational", (exact,))


def _rational_value(operation: str, arguments: tuple[Number, ...]) -> Fraction | None:
    """Return the value of an operation with an operand that is not rational, if the value is.

    Raises
    ------
    ZeroDivisionError
        For the tangent of an odd multiple of a quarter turn.
    """
    fractions = [argument.fraction for argument in arguments]
    if (operation == "*" and 0 in fractions) or (operation == "/" and fractions[0] == 0):
        return Fraction(0)
    first, exact = arguments[0], fractions[0]
    if operation == "sqrt" and exact is not None and exact >= 0:
        root = Fraction(math.isqrt(exact.numerator), math.isqrt(exact.denominator))
        return root if root * root == exact else None
    if exact is not None and exact == {"asin": 0, "atan": 0, "acos": 1}.get(operation):
        return Fraction(0)
    halves = multiple_of_pi(first) if operation in ("sin", "cos", "tan") else None
    if halves is None:
        return None
    if operation == "tan" and halves % 1 == Fraction(1, 2):
        raise ZeroDivisionError
    # By Niven's theorem a rational one is a multiple of a half.
    number = Number(operation, arguments)
    near = Fraction(round(2 * number.value), 2)
    return near if sign_of(_folded("-", number, Number("rational", (near,)))) == 0 else None


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
    return _folded(operation, number, other)
