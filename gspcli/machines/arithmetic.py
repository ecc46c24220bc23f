"""Expressions of numbers in files of machines: sums, products, powers and functions."""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable, Mapping

#: Characters of an expression at most.
_LONGEST = 400
_LARGEST_POWER = 16.0
_FUNCTIONS: dict[str, Callable[..., float]] = {
    name: getattr(math, name)
    for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "hypot")
} | {"abs": abs}
_OPERATIONS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


def value_of(text: str, names: Mapping[str, float], *, whole: bool = False) -> float:
    """Return the value of an expression.

    Parameters
    ----------
    text
        Numbers, names, ``+ - * / **``, parentheses and functions, as Python writes them.
    names
        The values of names; ``pi`` has its own.
    whole
        Whether the quotient of two whole numbers is a whole number, as in Ruby.

    Raises
    ------
    ValueError
        If it is no such expression, or has no value; the text says why.
    """
    if len(text) > _LONGEST:
        message = f"an expression of more than {_LONGEST} characters"
        raise ValueError(message)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(text.strip(), mode="eval").body
        value = _Evaluation({"pi": math.pi, **names}, whole).of(tree)
    except (SyntaxError, MemoryError, RecursionError):
        message = "no expression of numbers"
        raise ValueError(message) from None
    except (ArithmeticError, TypeError):
        message = "an expression without a value"
        raise ValueError(message) from None
    if not math.isfinite(value):
        message = "an expression without a value"
        raise ValueError(message)
    return value


class _Evaluation:
    def __init__(self, names: Mapping[str, float], whole: bool) -> None:
        self.names, self.whole = names, whole

    def of(self, node: ast.expr) -> float:
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return float(number) if abs(number) > 1 << 53 else number
            case ast.Name(id=name) if name in self.names:
                return self.names[name]
            case ast.Name(id=name):
                message = f"the name {name[:40]}, which has no value"
                raise ValueError(message)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return -self.of(operand)
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.of(operand)
            case ast.BinOp(left=left, op=operation, right=right):
                return self._joined(self.of(left), operation, self.of(right))
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if (
                name in _FUNCTIONS
            ):
                return _FUNCTIONS[name](*map(self.of, arguments))
        message = "no expression of numbers"
        raise ValueError(message)

    def _joined(self, left: float, operation: ast.operator, right: float) -> float:
        if isinstance(operation, ast.Pow):
            if abs(right) > _LARGEST_POWER:
                message = f"a power above {_LARGEST_POWER:g}"
                raise ValueError(message)
            power = left**right
            if isinstance(power, complex):
                message = "a power that is no real number"
                raise ValueError(message)
            return float(power) if abs(power) > 1 << 53 else power
        if type(operation) not in _OPERATIONS:
            message = "no expression of numbers"
            raise ValueError(message)
        if self.whole and isinstance(operation, ast.Div) and isinstance(left, int):
            return left // right if isinstance(right, int) else left / right
        return _OPERATIONS[type(operation)](left, right)
