"""`gsp import`: a machine from the file of another program."""

from __future__ import annotations

import re
from pathlib import Path

import click

from gspcli.cli.options import Command, Finite, Options, Whole, file_option, option
from gspcli.cli.render import write
from gspcli.cli.specs import refuse_to_replace
from gspcli.cli.streams import say
from gspcli.defaults import IMPORTED_DIGITS, MEETING_SHARE
from gspcli.errors import GspError
from gspcli.wording import named


@click.command(cls=Command)
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@option("--base NAME", "Which body is the base.  [default: found]")
@option("--platform NAME", "Which is the platform.  [default: found]")
@option(
    "--meet SHARE",
    "Axes that pass each other at up to this share of the machine's size count as meeting.",
    type=Finite(0, 1, max_open=True),
    default=MEETING_SHARE,
)
@option(
    "--digits",
    "Digits of the numbers that are written, counted from the first digit of the machine's size.",
    type=Whole(3, 17),
    default=IMPORTED_DIGITS,
)
@file_option("yaml")
def command(o: Options) -> None:
    """Read a machine from the file of another program and write its instance file.

    {formats}

    Stderr has one line for each constraint that was found, and says what was assumed and what the
    file does not state. A machine without exactly six constraints is refused, and the message lists
    those found. Only the file, and the files named here beside it, are opened: no mesh, no other
    model.

    \b
    Examples:
      gsp import robot.xml -o machine.yaml
      gsp import robot.xml --base world --platform table > machine.yaml
      gsp import joints.csv | gsp solve -
    """
    from gspcli.machines.api import import_machine

    refuse_to_replace(str(o.file))
    path = o.output.path
    if path is not None and path.is_file() and not o.output.force:
        # Machines of other programs have several files: only an instance file is replaced.
        head = path.read_bytes()[:65536]
        if head and not re.search(rb"\A(\s*(#.*)?\n)*(---\n)?gsp\s*:", head):
            raise GspError(f"-o {named(path)}: it is no instance file: choose another, or --force")
    found = import_machine(o.file, base=o.base, platform=o.platform, meet=o.meet, digits=o.digits)
    say(f"{o.file}: {found.described}")
    for line in (*found.chains, *found.notes):
        say(line)
    write(o.output, found.text)


command.help = str(command.help).format(
    formats="FILE is one of these: MJCF (for MuJoCo; the package mujoco is needed), SDF, "
    "URDF with loops in NAME.yaml beside NAME.urdf. Or it is "
    "NAME_bodies.xml of CASPR with NAME_cables.xml, a HAL file of LinuxCNC with its INI file, "
    "or a table of joints (CSV, TSV). The format is recognized by the "
    "content."
)
