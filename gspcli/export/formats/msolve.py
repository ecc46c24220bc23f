"""msolve: Gröbner bases, real solutions isolated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from gspcli.export.format import SystemFormat
from gspcli.export.polynomials import Monomial, Style

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem


def write(system: PolynomialSystem, digits: int) -> str:
    """Return the input of msolve."""
    exact = system.rounded(digits)
    return msolve_input(exact.names, (row.cleared for row in exact.polynomials), 0)


def msolve_input(
    names: Sequence[str], rows: Iterable[Mapping[Monomial, int]], characteristic: int
) -> str:
    """Return the input of msolve: variables, characteristic, polynomials."""
    texts = (Style().written(row) for row in rows)
    return f"{','.join(names)}\n{characteristic}\n" + ",\n".join(texts) + "\n"


FORMAT = SystemFormat(write, "decimals")
