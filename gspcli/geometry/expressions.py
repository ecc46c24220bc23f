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
from collections.abc import Callable
from fractions import Fraction
from typing import Generic, TypeVar

from gspcli.geometry.evaluation import FUNCTIONS, LARGEST, SMALLEST, Expression
from gspcli.geometry.separation import multiple_of_pi
from gspcli.geometry.signs import sign_of
from gspcli.wording import shown, similar

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
