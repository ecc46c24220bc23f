"""`gsp export`: a platform as a file for another program."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from gspcli.cli.names import load_instance
from gspcli.cli.output import Output, check_writable, write
from gspcli.errors import GspError

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

_TARGETS = ("mjcf",)


@click.command()
@click.argument("spec", metavar="SPEC")
@click.option("--to", "target", type=click.Choice(_TARGETS), required=True, help="For which.")
@click.option(
    "--set",
    "settings",
    metavar="N=VALUE",
    multiple=True,
    help="Give constraint N (from 1) another value; may be repeated.",
)
@click.option(
    "--mode",
    type=click.IntRange(min=1),
    metavar="K",
    help="For mjcf: the real pose to build, in the order of `gsp solve`.  [default: 1]",
)
@click.option(
    "-o", "--output", "path", metavar="FILE", help="Write to FILE instead of stdout, replacing it."
)
def command(
    spec: str, target: str, settings: tuple[str, ...], mode: int | None, path: str | None
) -> None:
    """Write a platform as a file for another program.

    mjcf is a model for MuJoCo: the platform as a free body in one assembly mode, held by
    six chains of joints. The joint value_k is what constraint k measures, in metres or radians;
    the equality hold_k keeps it (its first coefficient is the change), and without it the
    actuator drive_k moves it.

    SPEC is an instance file, - for standard input, or @NAME of an example (`gsp example`).

    \b
    Examples:
      gsp export @rubin-m2 --to mjcf -o m2.xml
      gsp export platform.yaml --to mjcf --mode 3 > model.xml
    """
    from gspcli.spec import set_values

    file = None if path in (None, "-") else Path(str(path))
    if file is not None:
        check_writable(file)
    instance = set_values(load_instance(spec), settings)
    write(Output(target, file), _model(instance, mode))


def _model(instance: Instance, mode: int | None) -> str:
    from gspcli.export.mjcf import mjcf
    from gspcli.solver import solve

    real = solve(instance, certify=False).real_solutions
    number = mode or 1
    if number > len(real):
        found = f"{len(real)} real pose" + "s" * (len(real) != 1)
        message = f"found {found}, expected one with the number {number} (`gsp solve` lists them)"
        raise GspError(message)
    pose = real[number - 1]
    return mjcf(instance, pose.R.real, pose.T.real)
