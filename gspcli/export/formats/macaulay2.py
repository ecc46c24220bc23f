"""Macaulay2: dimension, degree and all solutions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.export.format import SystemFormat
from gspcli.export.polynomials import Style

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem


def write(system: PolynomialSystem, digits: int) -> str:
    """Return a script for ``M2 --script``."""
    exact = system.rounded(digits)
    rows = ",\n".join(Style().written(row.cleared) for row in exact.polynomials)
    return (
        f"-- {system.title}\n"
        f"R = QQ[{', '.join(system.names)}];\n"
        f"I = ideal(\n{rows});\n"
        '<< "# dimension " << dim I << ", degree " << degree I << endl;\n'
        # By eigenvalues, and improved: its path tracking loses solutions without a message.
        'needsPackage "EigenSolver";\n'
        'needsPackage "NumericalAlgebraicGeometry";\n'
        "S = CC[gens R];\n"
        "found = if dim I != 0 then {} else\n"
        "  refine(polySystem flatten entries sub(gens I, S), zeroDimSolve I, Bits => 53);\n"
        f'<< "{system.heading}" << endl;\n'
        'plain = z -> format(0, 17, 17, 17, "e", z);\n'
        'scan(found, s -> << demark(",",\n'
        "  flatten apply(coordinates s, z -> {plain realPart z, plain imaginaryPart z}))"
        " << endl);\n"
    )


FORMAT = SystemFormat(write, "decimals")
