"""The interface of an expression, and the arithmetic in which it can be evaluated.

Three files use only this interface of an exact number: `intervals` encloses it, `separation` bounds
its distance from zero, and `signs` proves its sign. The trees are made in
`gspcli.geometry.numbers`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, Protocol, TypeVar

Element = TypeVar("Element")


class Field(Protocol[Element]):
    """Arithmetic in which an `Expression` can be evaluated; elements support ``+ - * /``."""

    def rational(self, value: Fraction) -> Element:
        """Return the element of a rational number."""
        ...

    def pi(self) -> Element:
        """Return the element of pi."""
        ...

    def function(self, name: str, argument: Element) -> Element:
        """Return sqrt, sin, cos, tan, asin, acos or atan of an element."""
        ...


class Expression(Protocol):
    """An exact real number as a tree: see `gspcli.geometry.numbers.Number`."""

    @property
    def operation(self) -> str:
        """The operation on the operands, or the sort of a leaf."""
        ...

    @property
    def arguments(self) -> tuple[Any, ...]:
        """The operands."""
        ...

    @property
    def fraction(self) -> Fraction | None:
        """The number as a fraction if its tree has only rational operations, else None."""
        ...

    @property
    def value(self) -> float:
        """The number rounded to a float."""
        ...

    def evaluate(self, field: Field[Element]) -> Element:
        """Evaluate the tree in some arithmetic."""
        ...


#: The functions that an expression may use, for floating-point evaluation.
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "sqrt": math.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
}
#: Operations with a rational result for rational operands.
RATIONAL_OPERATIONS: dict[str, Callable[..., Any]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "neg": lambda a: -a,
}
#: A number is zero or of a magnitude in this range: its fourth power is still a finite float.
SMALLEST, LARGEST = 1e-60, 1e60


def rounded_ratio(numerator: int, denominator: int) -> float:
    """Return a fraction rounded to a float, infinite above the largest float."""
    try:
        return numerator / denominator
    except OverflowError:
        return math.inf if numerator > 0 else -math.inf


class _FloatField:
    def rational(self, value: Fraction) -> float:
        return rounded_ratio(value.numerator, value.denominator)

    def pi(self) -> float:
        return math.pi

    def function(self, name: str, argument: float) -> float:
        return FUNCTIONS[name](argument)


#: Floating point, for `Expression.evaluate`.
FLOATS = _FloatField()
