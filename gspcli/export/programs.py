"""Systems of polynomials as files of other programs.

Rational coefficients are exact everywhere. Irrational constants (square roots, cosines) are exact
for SymPy; for programs that know only rational numbers they are decimal fractions of as many digits
as are asked for, and for those that compute in doubles they are doubles.

The scripts for Macaulay2, Singular and HomotopyContinuation.jl print a line ``# dimension ..,
degree ..`` where they know it, and the solutions as CSV that `gsp certify` reads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from gspcli import __version__
from gspcli.export.polynomials import Monomial, Polynomial, Style
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem

DIGITS = 40
_STYLE = Style()
_WIDTH = 95


def rounded(system: PolynomialSystem, digits: int = DIGITS) -> PolynomialSystem:
    """Return a system with decimal fractions, of so many digits, for its irrational constants."""
    from gspcli.certification.numbers.balls import decimal_near

    values = {name: decimal_near(number, digits) for name, number in system.constants.items()}
    rows = tuple(row.replaced(values) for row in system.polynomials)
    return replace(system, polynomials=rows, constants={})


def msolve(system: PolynomialSystem, digits: int = DIGITS) -> str:
    """Return the input of msolve."""
    exact = rounded(system, digits)
    return msolve_input(exact.names, (row.cleared for row in exact.polynomials), 0)


def msolve_input(
    names: Sequence[str], rows: Iterable[Mapping[Monomial, int]], characteristic: int
) -> str:
    """Return the input of msolve: variables, characteristic, polynomials."""
    texts = (_STYLE.written(row) for row in rows)
    return f"{','.join(names)}\n{characteristic}\n" + ",\n".join(texts) + "\n"


def phcpack(system: PolynomialSystem, digits: int = DIGITS) -> str:
    """Return the input of PHCpack's ``phc -b``; it computes in doubles."""
    del digits
    exact = rounded(system, 20)
    return phcpack_input(_STYLE.written(_scaled(row)) for row in exact.polynomials)


def phcpack_input(rows: Iterable[str]) -> str:
    """Return the input of PHCpack for written polynomials."""
    texts = list(rows)
    return f"{len(texts)}\n" + "".join(f"{text};\n" for text in texts)


def macaulay2(system: PolynomialSystem, digits: int = DIGITS) -> str:
    """Return a script for ``M2 --script``."""
    exact = rounded(system, digits)
    rows = ",\n".join(_STYLE.written(row.cleared) for row in exact.polynomials)
    return (
        f"-- {_head(system)}\n"
        f"R = QQ[{', '.join(system.names)}];\n"
        f"I = ideal(\n{rows});\n"
        '<< "# dimension " << dim I << ", degree " << degree I << endl;\n'
        # By eigenvalues, and improved: its path tracking loses solutions without a word.
        'needsPackage "EigenSolver";\n'
        'needsPackage "NumericalAlgebraicGeometry";\n'
        "S = CC[gens R];\n"
        "found = if dim I != 0 then {} else\n"
        "  refine(polySystem flatten entries sub(gens I, S), zeroDimSolve I, Bits => 53);\n"
        f'<< "{_heading(system.names)}" << endl;\n'
        'plain = z -> format(0, 17, 17, 17, "e", z);\n'
        'scan(found, s -> << demark(",",\n'
        "  flatten apply(coordinates s, z -> {plain realPart z, plain imaginaryPart z}))"
        " << endl);\n"
    )


def singular(system: PolynomialSystem, digits: int = DIGITS) -> str:
    """Return a script for ``Singular -q``."""
    exact = rounded(system, digits)
    rows = ",\n".join(_STYLE.written(row.cleared) for row in exact.polynomials)
    return (
        f"// {_head(system)}\n"
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
        f'  print("{_heading(system.names)}");\n'
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


def hcjl(system: PolynomialSystem, digits: int = DIGITS) -> str:
    """Return a script for Julia with HomotopyContinuation.jl."""
    del digits
    style = Style(quotient="//")
    rows = ",\n".join(style.written(row.terms) for row in system.polynomials)
    constants = "".join(
        f"{name} = {number.value!r} # {number}\n" for name, number in system.constants.items()
    )
    return (
        f"# {_head(system)}\n"
        "using HomotopyContinuation\n"
        f"@var {' '.join(system.names)}\n"
        f"{constants}"
        f"F = System([\n{rows}\n], variables = [{', '.join(system.names)}])\n"
        "found = solutions(solve(F))\n"
        f'println("{_heading(system.names)}")\n'
        "for s in found\n"
        '    println(join(["$(real(z)),$(imag(z))" for z in s], ","))\n'
        "end\n"
    )


def sympy(system: PolynomialSystem, digits: int = DIGITS) -> str:
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
        f'"""{_head(system)}"""\n\n'
        "from sympy import Rational, symbols, sympify\n"
        f'\nunknowns = {", ".join(system.names)} = symbols("{names}")\n'
        + "".join(
            f'{name} = sympify("{number}", rational=True)\n'
            for name, number in system.constants.items()
        )
        + f"system = [\n    {rows},\n]\n"
    )


@dataclass(frozen=True)
class Program:
    """A program that solves systems of polynomials.

    Attributes
    ----------
    write
        Its input for a system and a number of digits.
    irrational
        What it is given for irrational constants: the constants themselves, decimal fractions of
        so many digits, or doubles.
    """

    write: Callable[[PolynomialSystem, int], str]
    irrational: Literal["exact", "decimals", "doubles"]


#: The programs by the names that the command line gives them.
PROGRAMS = {
    "msolve": Program(msolve, "decimals"),
    "phcpack": Program(phcpack, "doubles"),
    "macaulay2": Program(macaulay2, "decimals"),
    "singular": Program(singular, "decimals"),
    "hcjl": Program(hcjl, "doubles"),
    "sympy": Program(sympy, "exact"),
}


def _head(system: PolynomialSystem) -> str:
    return (
        f"gsp {__version__}: {len(system.polynomials)} polynomials in {len(system.names)} unknowns"
    )


def _heading(names: Sequence[str]) -> str:
    return ",".join(f"{name},{name}_imag" for name in names)


def _scaled(polynomial: Polynomial) -> dict[Monomial, float]:
    """Return coefficients in floating point, the largest one."""
    size = max(abs(value) for value in polynomial.terms.values())
    return {monomial: float(value / size) for monomial, value in polynomial.terms.items()}


def _denominator(polynomial: Polynomial) -> int:
    monomial, value = next(iter(polynomial.terms.items()))
    return int(polynomial.cleared[monomial] / value)
