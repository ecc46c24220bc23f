"""Singular: dimension, degree and all solutions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.export.format import SystemFormat
from gspcli.export.polynomials import Style

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem


def write(system: PolynomialSystem, digits: int) -> str:
    """Return a script for ``Singular -q``."""
    exact = system.rounded(digits)
    rows = ",\n".join(Style().written(row.cleared) for row in exact.polynomials)
    return (
        f"// {system.title}\n"
        'LIB "solve.lib";\n'
        "printlevel = -10;\n"
        f"ring r = 0,({','.join(system.names)}),dp;\n"
        f"ideal i =\n{rows};\n"
        "option(redSB);\n"
        "ideal s = slimgb(i);\n"
        'print("# dimension "+string(dim(s))+", degree "+string(vdim(s)));\n'
        "if (dim(s) == 0) {\n"
        '  def solved = solve(s, 20, "nodisplay");\n'
        "  setring solved;\n"
        f'  print("{system.heading}");\n'
        "  int j, k; string line;\n"
        "  for (j = 1; j <= size(SOL); j++) {\n"
        '    line = "";\n'
        "    for (k = 1; k <= size(SOL[j]); k++) {\n"
        '      line = line+string(repart(SOL[j][k]))+","+string(impart(SOL[j][k]))+",";\n'
        "    }\n"
        "    print(line[1, size(line)-1]);\n"
        "  }\n"
        "}\n"
        "quit;\n"
    )


FORMAT = SystemFormat(write, "decimals")
