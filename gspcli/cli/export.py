"""`gsp export`: a platform as a file for another program."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import click

from gspcli.cli.mode_option import Mode, chosen, mode_option
from gspcli.cli.names import load_instance
from gspcli.cli.number_types import Whole
from gspcli.cli.output import Output, check_writable, file_option, write
from gspcli.cli.progress_bars import working
from gspcli.cli.streams import say
from gspcli.cli.value_options import Changes, value_options
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
@value_options
@mode_option(f"what is built for {listed((*_POSES, *_PROGRAMS), 'and')}.  [default: home]")
@click.option(
    "--coordinates",
    type=click.Choice(_COORDINATES),
    default=_COORDINATES[0],
    show_default=True,
    help="For systems: the unknowns.",
)
@click.option(
    "--significant-digits",
    type=Whole(1, 1000),
    default=40,
    show_default=True,
    metavar="N",
    help="For systems: to how many digits irrational numbers are written.",
)
@click.option(
    "--prefix",
    metavar="NAME",
    help="For c: what names begin with.  [default: the name of the file]",
)
@click.option(
    "--tries",
    type=Whole(1, 1000),
    default=48,
    show_default=True,
    metavar="N",
    help="For c: how many parts of a line of values a step tries: its time is bounded by them.",
)
@file_option("export")
def command(
    spec: str,
    target: str,
    changes: Changes,
    mode: Mode | None,
    coordinates: str,
    significant_digits: int,
    prefix: str | None,
    tries: int,
    output: Output,
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
    instance = load_instance(spec, changes)
    if target in _PROGRAMS:
        _write_program(instance, _PROGRAMS[target], output, prefix, tries, mode)
        return
    if target in _POSES:
        text = _POSES[target].write(instance, _pose(instance, mode))
    else:
        text = _system(instance, _SYSTEMS[target], coordinates, significant_digits)
    write(output, text)


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
    output: Output,
    prefix: str | None,
    tries: int,
    mode: Mode | None,
) -> None:
    """Write the two files of a program."""
    last, suffix = form.suffixes[0], form.suffixes[1]
    source = output.path
    if source is None or source.suffix != suffix:
        message = f"two files are written: expected -o NAME{suffix}, NAME{last} is then beside it"
        raise GspError(message)
    header = source.with_suffix(last)
    check_writable(header)
    name = re.sub(r"\W", "_", source.stem, flags=re.ASCII) if prefix is None else prefix
    home = _pose(instance, mode) if mode is not None or _has_modes(instance) else None
    texts = form.write(instance, name, tries, source.stem, home)
    for path, text in zip((header, source), texts, strict=True):
        write(Output(path.suffix[1:], path), text)


def _has_modes(instance: Instance) -> bool:
    from gspcli.solver import solve

    with working("solving"):
        return bool(solve(instance, certify=False).counts.real)


def _pose(instance: Instance, mode: Mode | None) -> Solution:
    """Return the real pose that is asked for, by default home."""
    from gspcli.solver import solve

    with working("solving"):
        result = solve(instance, certify=False).drawn
    return result.real_solutions[chosen(mode, result.home, result.counts.real) - 1]


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
