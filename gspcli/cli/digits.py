"""Proved decimals of poses: how `gsp solve` and `gsp certify` show them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.output import Column, Table

if TYPE_CHECKING:
    from gspcli.certification import Certificate
    from gspcli.geometry.instance import Instance

#: The columns of a refined pose, real parts first.
DECIMALS = tuple(
    f"refined_{name}{suffix}"
    for suffix in ("", "_imag")
    for name in (*(f"R{i}{j}" for i in "123" for j in "123"), "Tx", "Ty", "Tz")
)

digits_option = click.option(
    "--digits",
    type=click.IntRange(1, 100_000),
    metavar="N",
    help="Also print each certified solution to N proved digits.",
)


def refined(instance: Instance, certificate: Certificate, digits: int) -> dict[str, Any]:
    """Return R and T of a certified pose as decimal strings with proved digits, for JSON."""
    from gspcli.certification import refine

    pose = refine(instance, certificate, digits)
    return {
        key: value
        for key in ("R", "T", "R_imag", "T_imag")
        if (value := getattr(pose, key)) is not None
    }


def digit_cells(pose: Mapping[str, Any]) -> dict[str, str]:
    """Return a refined pose by the `DECIMALS` columns; nothing of an empty one."""
    flat = [
        text
        for suffix in ("", "_imag")
        if "R" + suffix in pose
        for text in [*(x for row in pose["R" + suffix] for x in row), *pose["T" + suffix]]
    ]
    return dict(zip(DECIMALS, flat, strict=False))


def digit_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Return one number a line, for people: fifty digits do not fit beside each other."""
    lines = [
        {"number": row["number"], "entry": key.removeprefix("refined_"), "value": row[key]}
        for row in rows
        for key in DECIMALS
        if key in row
    ]
    columns = (
        Column("number", "no.", align="right", essential=True),
        Column("entry", essential=True),
        Column("value", essential=True),
    )
    return Table(columns, lines, title="Proved digits", part="digits")
