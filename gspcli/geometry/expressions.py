"""The numbers of an instance file: decimals and closed expressions, read exactly.

The grammar, with any blanks between the tokens::

    sum     = product { ("+" | "-") product }
    product = signed { ("*" | "/") signed }
    signed  = { "+" | "-" } atom
    atom    = decimal | "pi" | function "(" sum ")" | "(" sum ")"

The functions are those of `gspcli.geometry.evaluation.FUNCTIONS`, whose trigonometric ones take and
give radians, and sind, cosd and tand of degrees: ``cosd(x)`` is ``cos(x*pi/180)``. Subexpressions
that are rational are kept as one fraction; so are products with zero, roots of squares, and the
functions of zero and of those multiples of pi whose values are rational.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from math import isqrt, lcm
from typing import Any, Generic, NamedTuple, TypeVar

from gspcli.geometry.evaluation import FLOATS, FUNCTIONS, LARGEST, SMALLEST, Expression
from gspcli.geometry.intervals import INTERVALS, FineIntervals, Interval
from gspcli.wording import shown, similar

# The sign of an exact number, and the nearest double, where doubles do not suffice.
#
# ``sqrt(2) - 1.414213562373095`` is 4.9e-17, but zero in floating point; ``sqrt(2)*sqrt(2) - 2`` is
# zero, but 4e-16 in floating point. More digits prove that a number is not zero. An algebraic
# number is zero if its modulus is below the bound that follows.


#: Precisions that are tried in turn, and the largest one for a proof that a number is zero.
_BITS, _MOST_BITS = (128, 512, 2048), 2**15
#: Relative width of an interval within which a double is known.
_NARROW = 2.0**-40


def sign_of(number: Expression) -> int | None:
    """Return 1, 0 or -1, proved; None if the sign is not known.

    Raises
    ------
    ValueError
        If the number does not exist, such as the root of a negative one.
    """
    if number.fraction is not None:
        return (number.fraction > 0) - (number.fraction < 0)
    interval = _in_doubles(number)
    if interval is not None and interval.without_zero:
        return 1 if interval.low > 0 else -1
    for low, high in _finer(number, _BITS):
        if low > 0 or high < 0:
            return 1 if low > 0 else -1
    separation = separation_bits(number)
    if separation is None or separation > _MOST_BITS:
        return None
    for low, high in _finer(number, (separation + _BITS[0],)):
        if low > 0 or high < 0:
            return 1 if low > 0 else -1
        if max(-low, high) * 2**separation < 1:
            return 0
    return None


def nearest(number: Expression) -> float:
    """Return a double that is within a few units in the last place of a number.

    Raises
    ------
    ZeroDivisionError, OverflowError, ValueError
        If the number does not exist, or cannot be distinguished from one that does not.
    """
    interval = _in_doubles(number)
    if interval is None or not _is_narrow(interval.low, interval.high):
        for low, high in _finer(number, _BITS):
            if _is_narrow(low, high):
                return float((low + high) / 2)
        if sign_of(number) == 0:
            return 0.0
    return number.evaluate(FLOATS)


def _in_doubles(number: Expression) -> Interval | None:
    """Return an interval in floating point; None next to the end of a domain."""
    try:
        return number.evaluate(INTERVALS)
    except (ZeroDivisionError, ValueError):
        return None


def _finer(number: Expression, precisions: tuple[int, ...]) -> Iterator[tuple[Any, Any]]:
    """Yield the ends of intervals with ever more digits."""
    for bits in precisions:
        field = FineIntervals(bits)
        try:
            yield field.ends(number.evaluate(field))
        except ArithmeticError:
            continue


def _is_narrow(low: Any, high: Any) -> bool:
    size = max(abs(low), abs(high))
    return bool(math.inf > size > 0 and high - low <= _NARROW * size)


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
    roots: frozenset[Expression]
    order: int


def separation_bits(number: Expression) -> int | None:
    """Return b such that a number is zero or at least ``2^-b`` in modulus.

    The result is None if the number is not known to be algebraic.
    """
    found = _bounds(number)
    if found is None:
        return None
    degree = found.order << len(found.roots)
    return found.above.bit_length() * (degree - 1) + found.below.bit_length()


def _bounds(number: Expression) -> _Bounds | None:
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


def _trigonometric(operation: str, angle: Expression) -> _Bounds | None:
    halves = multiple_of_pi(angle)
    if halves is None:
        return None
    # The sine is a cosine of an angle that is a quarter turn less.
    order = lcm(2 * halves.denominator, 4)
    # A tangent is a quotient of two such numbers.
    size = 4 if operation == "tan" else 2
    return _Bounds(size, size, frozenset(), order)


def multiple_of_pi(number: Expression) -> Fraction | None:
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


#: A tree of some class.
Tree = TypeVar("Tree", bound=Expression)

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
#: The rational values of the sine (by Niven's theorem there are no others), by the angle in turns.
_SINES: dict[Fraction, Fraction | int] = {
    Fraction(0): 0,
    Fraction(1, 12): Fraction(1, 2),
    Fraction(1, 4): 1,
    Fraction(5, 12): Fraction(1, 2),
    Fraction(1, 2): 0,
    Fraction(7, 12): Fraction(-1, 2),
    Fraction(3, 4): -1,
    Fraction(11, 12): Fraction(-1, 2),
}
#: Those of the tangent, by the angle in half turns.
_TANGENTS: dict[Fraction, int] = {Fraction(0): 0, Fraction(1, 4): 1, Fraction(3, 4): -1}
#: Operations on numbers that are not zero which may give zero without being rational.
_MAY_BE_ZERO = ("+", "-", "sin", "cos")
_AT_ZERO: dict[str, int] = {"sin": 0, "tan": 0, "asin": 0, "atan": 0, "cos": 1}
_HALF = Fraction(1, 2)
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


def parsed(text: str, node: Callable[..., Tree]) -> Tree:
    """Return the tree of the exact number that a text denotes.

    Parameters
    ----------
    text
        As it was written.
    node
        Makes a tree of an operation and a tuple of operands.

    Raises
    ------
    ValueError
        If the text denotes no number; the message says what was found and what is expected.
    """
    if not text.strip():
        message = "found nothing, expected a number"
        raise ValueError(message)
    if len(text) > MAX_LENGTH:
        message = f"found {len(text)} characters, expected a number of at most {MAX_LENGTH}"
        raise ValueError(message)
    if _DATE.fullmatch(text):
        raise ValueError(
            f"found the date {shown(text)}, expected a number: write a difference with blanks"
        )
    number = _Parser(text, node).number()
    size = abs(number.value)
    if number.fraction == 0 or (SMALLEST <= size <= LARGEST and sign_of(number)):
        return number
    if number.fraction is None and size <= LARGEST and not sign_of(number):
        message = f"found {shown(text)}, which may be zero: write 0, or a simpler expression"
        raise ValueError(message)
    message = f"found {shown(text)}, expected 0 or a magnitude from {SMALLEST:g} to {LARGEST:g}"
    raise ValueError(message)


class _Parser(Generic[Tree]):
    """Recursive descent over one expression."""

    def __init__(self, text: str, node: Callable[..., Tree]) -> None:
        self.text = text
        self.node = node
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

    def number(self) -> Tree:
        number = self._sum()
        kind, _ = self.tokens[self.position]
        if kind != "end":
            product = "write a product with *" if kind in ("name", "decimal") else None
            raise self._unexpected("an operator or the end", product)
        return number

    def _sum(self) -> Tree:
        number = self._product()
        while symbol := self._take("+", "-"):
            number = self._apply(symbol, number, self._product())
        return number

    def _product(self) -> Tree:
        number = self._signed()
        while symbol := self._take("*", "/"):
            if symbol == "*" and self.tokens[self.position] == ("symbol", "*"):
                raise self._unexpected("a number", _HINTS["^"])
            number = self._apply(symbol, number, self._signed())
        return number

    def _signed(self) -> Tree:
        negative = False
        while sign := self._take("+", "-"):
            negative ^= sign == "-"
        number = self._atom()
        return self._apply("neg", number) if negative else number

    def _atom(self) -> Tree:
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

    def _decimal(self, token: str) -> Tree:
        exponent = token.lower().partition("e")[2]
        if exponent and abs(int(exponent)) > _MAX_EXPONENT:
            raise self._error(shown(token), f"an exponent of at most {_MAX_EXPONENT}")
        return self.node("rational", (Fraction(token),))

    def _named(self, name: str) -> Tree:
        if name == "pi":
            return self.node("pi", ())
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
            turned = self._apply("*", argument, self.node("pi", ()))
            radians = self._apply("/", turned, self.node("rational", (Fraction(180),)))
            return self._apply(_OF_DEGREES[name], radians)
        return self._apply(name, argument)

    def _parenthesis(self) -> Tree:
        self.nesting += 1
        if self.nesting > MAX_NESTING:
            raise self._error(f"more than {MAX_NESTING} nested parentheses", "a simpler expression")
        number = self._sum()
        if not self._take(")"):
            raise self._unexpected(")")
        self.nesting -= 1
        return number

    def _apply(self, operation: str, *arguments: Tree) -> Tree:
        """Return the number of an operation, checked to exist; a fraction if it is rational."""
        number = self.node(operation, arguments)
        try:
            exact = number.fraction
            if exact is None:
                exact = _rational_value(operation, arguments)
            # Evaluated at each step, so that no intermediate value can grow without limit.
            _ = number.value
            if operation in _MAY_BE_ZERO and exact is None and sign_of(number) == 0:
                exact = Fraction(0)
            if operation in ("/", "tan") and not sign_of(self._divisor(operation, arguments)):
                raise ZeroDivisionError
        except ZeroDivisionError:
            if operation == "tan":
                raise self._error("the tangent of a right angle", "another angle") from None
            zero = "zero" if arguments[1].fraction == 0 else "a number that may be zero"
            raise self._error(f"a division by {zero}", "a nonzero divisor") from None
        except OverflowError:
            raise self._error("a number that is too large", f"at most {LARGEST:g}") from None
        except ValueError:
            argument = arguments[0].value
            domain = "an argument of at least 0" if operation == "sqrt" else "one from -1 to 1"
            raise self._error(f"{operation} of {argument:.6g}", domain) from None
        return number if exact is None else self.node("rational", (exact,))

    def _divisor(self, operation: str, arguments: tuple[Tree, ...]) -> Tree:
        return arguments[1] if operation == "/" else self.node("cos", arguments)


def _rational_value(operation: str, arguments: tuple[Expression, ...]) -> Fraction | None:
    """Return the value of an operation with an operand that is not rational, if the value is.

    Raises
    ------
    ZeroDivisionError
        For the tangent of an odd multiple of a quarter turn.
    """
    fractions = [argument.fraction for argument in arguments]
    value: Fraction | int | None = None
    if (operation == "*" and 0 in fractions) or (operation == "/" and fractions[0] == 0):
        return Fraction(0)
    (first, *_) = arguments
    if operation == "sqrt" and first.fraction is not None and first.fraction >= 0:
        roots = math.isqrt(first.fraction.numerator), math.isqrt(first.fraction.denominator)
        root = Fraction(*roots)
        return root if root * root == first.fraction else None
    if operation == "acos" and first.fraction == 1:
        return Fraction(0)
    if first.fraction == 0 and operation in _AT_ZERO:
        return Fraction(_AT_ZERO[operation])
    if operation not in ("sin", "cos", "tan"):
        return None
    halves = multiple_of_pi(first)
    if halves is None:
        return None
    if operation == "tan":
        if halves % 1 == _HALF:
            raise ZeroDivisionError
        value = _TANGENTS.get(halves % 1)
    else:
        value = _SINES.get((halves + (_HALF if operation == "cos" else 0)) / 2 % 1)
    return None if value is None else Fraction(value)
