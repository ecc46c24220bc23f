"""`gsp export`: a platform as a file for another program."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from gspcli.cli.names import load_instance
from gspcli.cli.number_types import Whole
from gspcli.cli.output import Output, check_writable, write
from gspcli.cli.progress_bars import working
from gspcli.cli.streams import say
from gspcli.errors import GspError
from gspcli.export.programs import PROGRAMS
from gspcli.wording import listed

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

_MODEL = "mjcf"
_COORDINATES = ("study", "study-affine", "rt")


@click.command()
@click.argument("spec", metavar="SPEC")
@click.option(
    "--to", "target", type=click.Choice((_MODEL, *PROGRAMS)), required=True, help="For which."
)
@click.option(
    "--set",
    "settings",
    metavar="N=VALUE",
    multiple=True,
    help="Give constraint N (from 1) another value; may be repeated.",
)
@click.option(
    "--mode",
    type=Whole(1),
    metavar="K",
    help="For mjcf: the real pose to build, in the order of `gsp solve`.  [default: 1]",
)
@click.option(
    "--coordinates",
    type=click.Choice(_COORDINATES),
    default=_COORDINATES[0],
    show_default=True,
    help="For systems: the unknowns.",
)
@click.option(
    "--digits",
    type=click.IntRange(1, 1000),
    default=40,
    show_default=True,
    help="For systems: significant digits of irrational numbers.",
)
@click.option(
    "-o", "--output", "path", metavar="FILE", help="Write to FILE instead of stdout, replacing it."
)
def command(
    spec: str,
    target: str,
    settings: tuple[str, ...],
    mode: int | None,
    coordinates: str,
    digits: int,
    path: str | None,
) -> None:
    """Write a platform as a file for another program.

    mjcf is a model for MuJoCo: the platform as a free body in one assembly mode, held by
    six chains of joints. The joint value_k is what constraint k measures, in metres or radians;
    the equality hold_k keeps it (its first coefficient is the change), and without it the
    actuator drive_k moves it.

    The others are systems of polynomials for programs that solve them, with rational
    coefficients exactly as in SPEC: study are unit dual quaternions q, f (each pose twice),
    study-affine those with q0 = 1 (without half turns), rt the entries of R and T. Irrational
    numbers are {irrational}; what is not exact is said on stderr. `gsp certify SPEC FILE` reads
    what the programs write.

    SPEC is an instance file, - for standard input, or @NAME of an example (`gsp example`).

    \b
    Examples:
      gsp export @rubin-m2 --to mjcf -o m2.xml
      gsp export platform.yaml --to mjcf --mode 3 > model.xml
      gsp export @dietmaier --to msolve -o d.ms && msolve -f d.ms -o d.out
      gsp certify @dietmaier d.out
    """
    from gspcli.spec import set_values

    file = None if path in (None, "-") else Path(str(path))
    if file is not None:
        check_writable(file)
    instance = set_values(load_instance(spec), settings)
    if target == _MODEL:
        text = _model(instance, mode)
    else:
        text = _system(instance, target, coordinates, digits)
    write(Output(target, file), text)


def _irrational() -> str:
    """Return what irrational numbers become for which programs."""
    names: dict[str, list[str]] = {"exact": [], "decimals": [], "doubles": []}
    for name, program in PROGRAMS.items():
        names[program.irrational].append(name)
    return ", ".join(f"{how} for {listed(those, 'and')}" for how, those in names.items())


command.help = str(command.help).format(irrational=_irrational())


def _model(instance: Instance, mode: int | None) -> str:
    from gspcli.export.mjcf import mjcf
    from gspcli.solver import solve

    with working("solving"):
        real = solve(instance, certify=False).real_solutions
    number = mode or 1
    if number > len(real):
        found = f"{len(real)} real pose" + "s" * (len(real) != 1)
        message = f"found {found}, expected one with the number {number} (`gsp solve` lists them)"
        raise GspError(message)
    pose = real[number - 1]
    return mjcf(instance, pose.R.real, pose.T.real)


def _system(instance: Instance, target: str, coordinates: str, digits: int) -> str:
    from gspcli.export.motion_coordinates import MOTIONS
    from gspcli.export.polynomial_systems import system

    program = PROGRAMS[target]
    found = system(instance, MOTIONS[coordinates]())
    if found.constants and program.irrational != "exact":
        how = f"decimals of {digits} digits" if program.irrational == "decimals" else "doubles"
        count = len(found.constants)
        numbers = "1 irrational number" if count == 1 else f"{count} irrational numbers"
        say(f"{numbers} became {how}")
    return program.write(found, digits)
