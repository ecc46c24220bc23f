"""The formats of `gsp export`: what each states about itself, and how it is written.

Rational coefficients are exact everywhere. Irrational constants (square roots, cosines) are exact
for SymPy. For programs that have only rational numbers they are decimal fractions with as many
digits as are asked for. For programs that compute in doubles they are doubles.

The scripts for Macaulay2, Singular and HomotopyContinuation.jl print a line ``# dimension ..,
degree ..`` where they know it, and the solutions as CSV that `gsp certify` reads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal

from gspcli.export.polynomial_systems import Monomial, Polynomial, Style
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem
    from gspcli.geometry.instance import Instance
    from gspcli.solver import Solution


@dataclass(frozen=True)
class SystemFormat:
    """The input of a program that solves systems of polynomials.

    Attributes
    ----------
    write
        Its text for a system and a number of digits.
    irrational
        What it has for irrational constants: the constants themselves, decimal fractions of this
        many digits, or doubles.
    """

    write: Callable[[PolynomialSystem, int], str]
    irrational: Literal["exact", "decimals", "doubles"]


@dataclass(frozen=True)
class ModeFormat:
    """The input of a program that is given the platform in one real assembly mode.

    Attributes
    ----------
    write
        The texts of its files for an instance and a pose of it.
    what
        What that is, for the help.
    suffixes
        What the names of the files end with if there are two; the last is what `-o` names.
    """

    write: Callable[[Instance, Solution], tuple[str, ...]]
    what: str
    suffixes: tuple[str, ...] = ("",)


@dataclass(frozen=True)
class ControllerFormat:
    """A program for the controller of one platform: a header and a source.

    Attributes
    ----------
    write
        The function that writes their texts. It takes an instance, what names begin with, how many
        parts of a line of values are tried, and the name of the files. It also takes a pose for the
        header, or None, and by which part of its range a value may leave it.
    suffixes
        What the names of the two files end with.
    what
        What that is, for the help.
    """

    write: Callable[[Instance, str, int, str, Solution | None, float], tuple[str, str]]
    suffixes: tuple[str, str]
    what: str


def _controller(
    instance: Instance,
    prefix: str,
    tries: int,
    name: str,
    home: Solution | None,
    margin: float,
) -> tuple[str, str]:
    """Return the header and the source."""
    from gspcli.export.controller.writing import controller

    return controller(instance, prefix, tries=tries, name=name, home=home, margin=margin)


def _julia(system: PolynomialSystem, digits: int) -> str:
    """Return a script for Julia with HomotopyContinuation.jl."""
    del digits
    style = Style(quotient="//")
    rows = ",\n".join(style.written(row.terms) for row in system.polynomials)
    constants = "".join(
        f"{name} = {number.value!r} # {number}\n" for name, number in system.constants.items()
    )
    return (
        f"# {system.title}\n"
        "using HomotopyContinuation\n"
        f"@var {' '.join(system.names)}\n"
        f"{constants}"
        f"F = System([\n{rows}\n], variables = [{', '.join(system.names)}])\n"
        "found = solutions(solve(F))\n"
        f'println("{system.heading}")\n'
        "for s in found\n"
        '    println(join(["$(real(z)),$(imag(z))" for z in s], ","))\n'
        "end\n"
    )


def _macaulay2(system: PolynomialSystem, digits: int) -> str:
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


def _mjcf(instance: Instance, pose: Solution) -> tuple[str]:
    """Return the model as XML."""
    from gspcli.export.mjcf import mjcf

    return (mjcf(instance, pose.R.real, pose.T.real),)


def _msolve(system: PolynomialSystem, digits: int) -> str:
    """Return the input of msolve."""
    exact = system.rounded(digits)
    return msolve_input(exact.names, (row.cleared for row in exact.polynomials), 0)


def msolve_input(
    names: Sequence[str], rows: Iterable[Mapping[Monomial, int]], characteristic: int
) -> str:
    """Return the input of msolve: variables, characteristic, polynomials."""
    texts = (Style().written(row) for row in rows)
    return f"{','.join(names)}\n{characteristic}\n" + ",\n".join(texts) + "\n"


def _phcpack(system: PolynomialSystem, digits: int) -> str:
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


def _sdf(instance: Instance, pose: Solution) -> tuple[str]:
    """Return the model as XML."""
    from gspcli.export.robot_models import sdf

    return (sdf(instance, pose.R.real, pose.T.real),)


def _singular(system: PolynomialSystem, digits: int) -> str:
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


def _sympy(system: PolynomialSystem, digits: int) -> str:
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


def _urdf(instance: Instance, pose: Solution) -> tuple[str, str]:
    """Return the loops in YAML and the robot as XML."""
    from gspcli.export.robot_models import urdf

    return urdf(instance, pose.R.real, pose.T.real)


#: By the names that the command line gives them.
FORMATS: dict[str, ControllerFormat | ModeFormat | SystemFormat] = {
    "c": ControllerFormat(
        _controller,
        (".h", ".c"),
        "c is a header and a source in C99 for the controller of this platform: inverse "
        "kinematics, Jacobian matrix, and the next pose from six new values. It is proved "
        "that this pose continues the last one; else it is refused. Of a pose out of reach it "
        "finds the nearest one within ranges and cones. No allocation, bounded time. -o "
        "NAME.c writes NAME.h beside it; the pose of --mode is a constant in it. Values of "
        "cranks and slides are their angles and ways.",
    ),
    "hcjl": SystemFormat(_julia, "doubles"),
    "macaulay2": SystemFormat(_macaulay2, "decimals"),
    "mjcf": ModeFormat(
        _mjcf,
        "mjcf is a model for MuJoCo: the platform as a free body in one assembly mode, held "
        "by six chains of joints. The joint value_k is what constraint k measures, in metres "
        "or radians; the equality hold_k keeps it (its first coefficient is the change), and "
        "without it the actuator drive_k moves it. A crank or slide is the joint drive_k of "
        "an arm or a carriage.",
    ),
    "msolve": SystemFormat(_msolve, "decimals"),
    "phcpack": SystemFormat(_phcpack, "doubles"),
    "sdf": ModeFormat(
        _sdf,
        "sdf is a model for Gazebo and other readers of SDF 1.9: six chains of joints from "
        "the base to the platform, which close loops. The joint value_k is what constraint k "
        "measures, less its value.",
    ),
    "singular": SystemFormat(_singular, "decimals"),
    "sympy": SystemFormat(_sympy, "exact"),
    "urdf": ModeFormat(
        _urdf,
        "urdf is NAME.urdf, a tree in which the first chain carries the platform, and "
        "NAME.yaml, which has the loops of the others: closed_loop, type and name_mot, as the "
        "robots of example-parallel-robots have them.",
        (".yaml", ".urdf"),
    ),
}
