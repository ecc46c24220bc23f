"""`gsp export`: a platform as a file for another program."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gspcli.cli.names import load_instance
from gspcli.cli.number_types import Whole
from gspcli.cli.output import Output, check_writable, write
from gspcli.cli.progress_bars import working
from gspcli.cli.streams import say
from gspcli.errors import GspError
from gspcli.export.format import ControllerFormat, PoseFormat, SystemFormat
from gspcli.export.formats import FORMATS
from gspcli.wording import listed

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.solver import Solution

#: What is given a pose, what is a program, and what is given equations.
_POSES = {name: form for name, form in FORMATS.items() if isinstance(form, PoseFormat)}
_PROGRAMS = {name: form for name, form in FORMATS.items() if isinstance(form, ControllerFormat)}
_SYSTEMS = {name: form for name, form in FORMATS.items() if isinstance(form, SystemFormat)}
_COORDINATES = ("study", "study-affine", "rt")


@click.command()
@click.argument("spec", metavar="SPEC")
@click.option(
    "--to",
    "target",
    type=click.Choice((*_POSES, *_PROGRAMS, *_SYSTEMS)),
    required=True,
    help="For which.",
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
    help=f"For {listed((*_POSES, *_PROGRAMS), 'and')}: the real pose to build, in the order of "
    "`gsp solve`.  "
    "[default: 1]",
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
    "--prefix",
    metavar="NAME",
    help="For c: what names begin with.  [default: the name of the file]",
)
@click.option(
    "--tries",
    type=click.IntRange(1, 1000),
    default=48,
    show_default=True,
    help="For c: how many parts of a line of values a step tries: its time is bounded by them.",
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
    prefix: str | None,
    tries: int,
    path: str | None,
) -> None:
    """Write a platform as a file for another program.

    {poses}

    {programs}

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
      gsp export @nano-hexapod --to c -o nano_hexapod.c
      gsp export @dietmaier --to msolve -o d.ms && msolve -f d.ms -o d.out
      gsp certify @dietmaier d.out
    """
    from gspcli.spec import set_values

    file = None if path in (None, "-") else Path(str(path))
    if file is not None:
        check_writable(file)
    instance = set_values(load_instance(spec), settings)
    if target in _PROGRAMS:
        _write_program(instance, _PROGRAMS[target], file, prefix, tries, mode)
        return
    if target in _POSES:
        text = _POSES[target].write(instance, _pose(instance, mode or 1))
    else:
        text = _system(instance, _SYSTEMS[target], coordinates, digits)
    write(Output(target, file), text)


def _irrational() -> str:
    """Return what irrational numbers become for which programs."""
    names: dict[str, list[str]] = {"exact": [], "decimals": [], "doubles": []}
    for name, form in _SYSTEMS.items():
        names[form.irrational].append(name)
    return ", ".join(f"{how} for {listed(those, 'and')}" for how, those in names.items())


command.help = str(command.help).format(
    poses="\n\n".join(form.what for form in _POSES.values()),
    programs="\n\n".join(form.what for form in _PROGRAMS.values()),
    irrational=_irrational(),
)


def _write_program(
    instance: Instance,
    form: ControllerFormat,
    source: Path | None,
    prefix: str | None,
    tries: int,
    mode: int | None,
) -> None:
    """Write the two files of a program."""
    last, suffix = form.suffixes[0], form.suffixes[1]
    if source is None or source.suffix != suffix:
        message = f"two files are written: expected -o NAME{suffix}, NAME{last} is then beside it"
        raise GspError(message)
    header = source.with_suffix(last)
    check_writable(header)
    name = re.sub(r"\W", "_", source.stem, flags=re.ASCII) if prefix is None else prefix
    texts = form.write(instance, name, tries, source.stem, _home(instance, mode))
    for path, text in zip((header, source), texts, strict=True):
        write(Output(path.suffix[1:], path), text)


def _home(instance: Instance, mode: int | None) -> Solution | None:
    """Return the pose of a mode; without a number the first one, if there is any."""
    from gspcli.solver import solve

    if mode is not None:
        return _pose(instance, mode)
    with working("solving"):
        real = solve(instance, certify=False).real_solutions
    return real[0] if real else None


def _pose(instance: Instance, number: int) -> Solution:
    """Return the real pose with a number, from 1."""
    from gspcli.solver import solve

    with working("solving"):
        real = solve(instance, certify=False).real_solutions
    if number > len(real):
        found = f"{len(real)} real pose" + "s" * (len(real) != 1)
        message = f"found {found}, expected one with the number {number} (`gsp solve` lists them)"
        raise GspError(message)
    return real[number - 1]


def _system(instance: Instance, form: SystemFormat, coordinates: str, digits: int) -> str:
    from gspcli.export.motion_coordinates import MOTIONS
    from gspcli.export.polynomial_systems import system

    found = system(instance, MOTIONS[coordinates]())
    if found.constants and form.irrational != "exact":
        how = f"decimals of {digits} digits" if form.irrational == "decimals" else "doubles"
        count = len(found.constants)
        numbers = "1 irrational number" if count == 1 else f"{count} irrational numbers"
        say(f"{numbers} became {how}")
    return form.write(found, digits)
