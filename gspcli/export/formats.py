"""The formats of `gsp export`: what each states about itself, and how it is written.

Rational coefficients are exact everywhere. Irrational constants (square roots, cosines) are exact
for SymPy. For programs that have only rational numbers they are decimal fractions with as many
digits as are asked for. For programs that compute in doubles they are doubles.

The scripts for Macaulay2, Singular and HomotopyContinuation.jl print a line ``# dimension ..,
degree ..`` where they know it, and the solutions as CSV that `gsp certify` reads.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal

from gspcli.errors import ArgumentError
from gspcli.export.polynomial_systems import MOTIONS, Monomial, Polynomial, Style, system
from gspcli.records import dataclass
from gspcli.wording import counted, listed, shown

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem
    from gspcli.geometry.instance import Instance
    from gspcli.solver import Solution


@dataclass(frozen=True)
class SystemFormat:
    """The input of a program that solves systems of polynomials."""

    #: Its text for a system and a number of digits.
    write: Callable[[PolynomialSystem, int], str]
    #: What it has for irrational constants: the constants themselves, decimal fractions of this
    #: many digits, or doubles.
    irrational: Literal["exact", "decimals", "doubles"]


@dataclass(frozen=True)
class ModelFormat:
    """A model of the platform in one real assembly mode, or a program for its controller."""

    #: What that is, for the help.
    what: str
    #: What the names of the files end with if there are two; `-o` names one of them.
    suffixes: tuple[str, ...] = ("",)


def _julia(system: PolynomialSystem, _: int) -> str:
    """Return a script for Julia with HomotopyContinuation.jl."""
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


def _phcpack(system: PolynomialSystem, _: int) -> str:
    """Return the input of PHCpack's ``phc -b``; it computes in doubles."""
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


def _sympy(system: PolynomialSystem, _: int) -> str:
    """Return a Python module that defines ``unknowns`` and ``system`` with exact constants."""
    style = Style(power="**")
    # Fractions of integers would be floating-point numbers in Python.
    rows = []
    for row in system.polynomials:
        monomial, value = next(iter(row.terms.items()))
        denominator = int(row.cleared[monomial] / value)
        rows.append(f"Rational(1, {denominator})*({style.written(row.cleared)})")
    joined = ",\n    ".join(rows)
    names = " ".join(system.names)
    return (
        f'"""{system.title}"""\n\n'
        "from sympy import Rational, symbols, sympify\n"
        f'\nunknowns = {", ".join(system.names)} = symbols("{names}")\n'
        + "".join(
            f'{name} = sympify("{number}", rational=True)\n'
            for name, number in system.constants.items()
        )
        + f"system = [\n    {joined},\n]\n"
    )


#: By the names that the command line gives them.
FORMATS: dict[str, ModelFormat | SystemFormat] = {
    "mjcf": ModelFormat(
        "mjcf is a model for MuJoCo: the platform as a free body in one assembly mode, held "
        "by six chains of joints. The joint value_k is what constraint k measures, in metres "
        "or radians; the equality hold_k keeps it (its first coefficient is the change), and "
        "without it the actuator drive_k moves it. A crank or slide is the joint drive_k of "
        "an arm or a carriage."
    ),
    "sdf": ModelFormat(
        "sdf is a model for Gazebo and other readers of SDF 1.9: six chains of joints from "
        "the base to the platform, which close loops. The joint value_k is what constraint k "
        "measures, less its value."
    ),
    "urdf": ModelFormat(
        "urdf is NAME.urdf, a tree in which the first chain carries the platform, and "
        "NAME.yaml, which has the loops of the others: closed_loop, type and name_mot, as the "
        "robots of example-parallel-robots have them.",
        (".yaml", ".urdf"),
    ),
    "c": ModelFormat(
        "c is a header and a source in C99 for the controller of this platform: inverse "
        "kinematics, Jacobian matrix, and the next pose from six new values. It is proved "
        "that this pose continues the last one; else it is refused. Of a pose out of reach it "
        "finds the nearest one within ranges and cones. No allocation, bounded time. -o "
        "NAME.c writes NAME.h beside it; the pose of --mode is a constant in it. Values of "
        "cranks and slides are their angles and ways.",
        (".h", ".c"),
    ),
    "hcjl": SystemFormat(_julia, "doubles"),
    "macaulay2": SystemFormat(_macaulay2, "decimals"),
    "msolve": SystemFormat(_msolve, "decimals"),
    "phcpack": SystemFormat(_phcpack, "doubles"),
    "singular": SystemFormat(_singular, "decimals"),
    "sympy": SystemFormat(_sympy, "exact"),
}


#: Names of the unknowns of systems of polynomials.
COORDINATES = ("study", "study-affine", "rt")
#: Digits of irrational numbers, and parts that a step of a controller tries.
DIGITS, TRIES = 40, 48
#: Models in which the frames of an instance are marked.
_MARKED = ("mjcf", "sdf")


@dataclass(frozen=True, eq=False)
class Export:
    """What is written for another program."""

    #: The program, as `gsp export --to` names it.
    target: str
    #: The texts of the files by the ends of their names: one, whose end is empty, or two, as the
    #: header and the source of a controller.
    files: dict[str, str]
    #: Notes: which mode it is, what is not exact.
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        size = sum(len(text.encode()) for text in self.files.values())
        return f"<Export to {self.target}: {counted(len(self.files), 'file')}, {size} bytes>"

    def __str__(self) -> str:
        return "".join(self.files.values())


def exported(
    instance: Instance,
    target: str,
    *,
    mode: int | None = None,
    coordinates: str = COORDINATES[0],
    digits: int = DIGITS,
    name: str = "platform",
    prefix: str | None = None,
    tries: int = TRIES,
    margin: float = 0.0,
) -> Export:
    """Write a platform for another program: its text is ``str`` of the result.

    Parameters
    ----------
    instance
        The platform.
    target
        The program: mjcf (MuJoCo), sdf, urdf, c (a controller), or a solver of polynomials, as
        `gsp export --help` lists them.
    mode
        The number of the real pose that is built; home if None.
    coordinates
        The unknowns of a system of polynomials: study, study-affine or rt.
    digits
        To how many digits irrational numbers are written in it.
    name
        Of the two files of a controller, without their ends.
    prefix
        What names in them begin with; the name if None.
    tries
        How many parts of a line of values a step of the controller tries.
    margin
        The part of its range by which a value may leave it in a step of the controller.

    Raises
    ------
    GspError
        If there is no such program, unknowns or mode.
    """
    if target not in FORMATS:
        raise ArgumentError(f"found {shown(target)}, expected {listed(FORMATS)}", "target")
    form = FORMATS[target]
    if isinstance(form, SystemFormat):
        return _system(instance, target, form, coordinates, digits)
    pose, notes = _pose(instance, mode, needed=target != "c")
    if instance.frames is not None and target not in _MARKED:
        notes += ("poses are those of the platform itself: the frames of SPEC are left out",)
    if target == "c":
        from gspcli.export.controller.writing import controller

        prefix = re.sub(r"\W", "_", name, flags=re.ASCII) if prefix is None else prefix
        texts: tuple[str, ...] = controller(
            instance, prefix, tries=tries, name=name, home=pose, margin=margin
        )
    else:
        assert pose is not None
        texts = _model(target, instance, pose)
    return Export(target, dict(zip(form.suffixes, texts, strict=True)), notes)


def _model(target: str, instance: Instance, pose: Solution) -> tuple[str, ...]:
    """Return the texts of the files of a model."""
    from gspcli.export.mjcf import mjcf
    from gspcli.export.robot_models import sdf, urdf

    R, T = pose.R.real, pose.T.real
    if target == "urdf":
        return urdf(instance, R, T)
    return (mjcf(instance, R, T) if target == "mjcf" else sdf(instance, R, T),)


def _pose(
    instance: Instance, mode: int | None, *, needed: bool
) -> tuple[Solution | None, tuple[str, ...]]:
    """Return the real pose that is asked for, by default home, and a note about it."""
    from gspcli.motion.poses.mode_filters import chosen_mode
    from gspcli.solver import solve

    result = solve(instance).drawn
    home, count = result.home, result.counts.real
    if home is None and mode is None and not needed:
        return None, ()
    number = chosen_mode(mode, home, count)
    assert home is not None
    said = (home.text,) if mode is None and count > 1 else ()
    return result.real_solutions[number - 1], said


def _system(
    instance: Instance, target: str, form: SystemFormat, coordinates: str, digits: int
) -> Export:
    if coordinates not in MOTIONS:
        message = f"found {shown(coordinates)}, expected {listed(COORDINATES)}"
        raise ArgumentError(message, "coordinates")
    if digits < 1:
        raise ArgumentError(f"found {digits}, expected at least 1", "digits")
    found = system(instance, MOTIONS[coordinates]())
    notes: tuple[str, ...] = ()
    if found.constants and form.irrational != "exact":
        how = f"decimals of {digits} digits" if form.irrational == "decimals" else "doubles"
        notes = (f"{counted(len(found.constants), 'irrational number')} became {how}",)
    return Export(target, {"": form.write(found, digits)}, notes)
