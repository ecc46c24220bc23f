"""PHCpack: homotopies in doubles."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from gspcli.export.format import SystemFormat
from gspcli.export.polynomials import Monomial, Polynomial, Style

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem


def write(system: PolynomialSystem, digits: int) -> str:
    """Return the input of PHCpack's ``phc -b``; it computes in doubles."""
    del digits
    exact = system.rounded(20)
    return phcpack_input(Style().written(_scaled(row)) for row in exact.polynomials)


def phcpack_input(rows: Iterable[str]) -> str:
    """Return the input of PHCpack for written polynomials."""
    texts = list(rows)
    return f"{len(texts)}\n" + "".join(f"{text};\n" for text in texts)


def _scaled(polynomial: Polynomial) -> dict[Monomial, float]:
    """Return coefficients in floating point, the largest one."""
    size = max(abs(value) for value in polynomial.terms.values())
    return {monomial: float(value / size) for monomial, value in polynomial.terms.items()}


FORMAT = SystemFormat(write, "doubles")
