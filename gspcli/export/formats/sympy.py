"""SymPy: the system as a module of Python, exactly."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.export.format import SystemFormat
from gspcli.export.polynomials import Polynomial, Style

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem


def write(system: PolynomialSystem, digits: int) -> str:
    """Return a Python module that defines ``unknowns`` and ``system`` with exact constants."""
    del digits
    style = Style(power="**")
    # Fractions of integers would be floating-point numbers in Python.
    rows = ",\n    ".join(
        f"Rational(1, {_denominator(row)})*({style.written(row.cleared)})"
        for row in system.polynomials
    )
    names = " ".join(system.names)
    return (
        f'"""{system.title}"""\n\n'
        "from sympy import Rational, symbols, sympify\n"
        f'\nunknowns = {", ".join(system.names)} = symbols("{names}")\n'
        + "".join(
            f'{name} = sympify("{number}", rational=True)\n'
            for name, number in system.constants.items()
        )
        + f"system = [\n    {rows},\n]\n"
    )


def _denominator(polynomial: Polynomial) -> int:
    monomial, value = next(iter(polynomial.terms.items()))
    return int(polynomial.cleared[monomial] / value)


FORMAT = SystemFormat(write, "exact")
