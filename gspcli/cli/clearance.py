"""`gsp clearance`: how far values may change before a mode can meet a singularity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.analyze import poses_to_analyze
from gspcli.cli.names import load_instance
from gspcli.cli.output import Column, Output, Table, emit, output_options
from gspcli.cli.pose_options import pose_options
from gspcli.cli.progress_bars import progress

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.motion.clearances import Clearance


@click.command()
@click.argument("spec", metavar="SPEC")
@click.option("--mode", type=click.IntRange(min=1), metavar="K", help="Only mode K.")
@click.option("--pose", metavar="NUMBERS", help="A pose instead: x,y,z,qw,qx,qy,qz.")
@pose_options
@click.option("--refine", is_flag=True, help="Better bounds: a few seconds for each mode.")
@output_options()
def command(
    spec: str,
    mode: int | None,
    pose: str | None,
    euler: str | None,
    pivot: str | None,
    refine: bool,
    output: Output,
) -> None:
    """Bound how far all values may change before a mode can meet a singularity.

    A clearance of r means that every value may change by r times its weight, all at once and in
    any combination, and the mode exists all the while and is not singular. The weight is half the
    range of the constraint, if each has one in SPEC; else 1 in the unit of the value.

    The lower bound is proved for the whole box of values. The upper bound is a proved fold of the
    same mode, the nearest one found, with the values at which it is.

    \b
    Examples:
      gsp clearance platform.yaml
      gsp clearance platform.yaml --mode 1 --refine
      gsp clearance platform.yaml --pose 0,0,1.5,1,0,0,0 --format json
    """
    if mode is not None and pose is not None:
        message = "give either --mode or --pose"
        raise click.UsageError(message)
    from gspcli.motion.clearances import clearance, range_weights

    instance = load_instance(spec)
    R, T, numbers = poses_to_analyze(instance, mode, pose, euler, pivot)
    weights = range_weights(instance)
    found = [
        clearance(instance, R[k], T[k], weights=weights, refine=refine)
        for k in progress(range(len(R)), total=len(R), label="modes")
    ]
    rows = [_row(number, item) for number, item in zip(numbers, found, strict=True)]
    emit(output, _table(instance, rows, weights is not None), document=_document(instance, rows))


def _row(number: int | None, item: Clearance) -> dict[str, Any]:
    row: dict[str, Any] = {"mode": number, "lower": item.lower, "upper": None, "ratio": None}
    if item.fold is not None and item.values is not None:
        row |= {"upper": item.upper, "ratio": item.ratio if item.lower > 0 else None}
        row |= {str(k): value for k, value in enumerate(item.values.tolist(), 1)}
        row |= {"R": item.fold.R.tolist(), "T": item.fold.T.tolist()}
    return row


def _table(instance: Instance, rows: list[dict[str, Any]], ranged: bool) -> Table:
    columns = [
        Column("mode", align="right", essential=True),
        Column("lower", "proved free", align="right", essential=True),
        Column("upper", "fold at", align="right", essential=True),
        Column("ratio", align="right"),
    ]
    columns += [
        Column(str(k), f"{k} {constraint.kind.name}", align="right")
        for k, constraint in enumerate(instance.constraints, 1)
    ]
    units = instance.units
    weight = (
        "half the range of each value"
        if ranged
        else f"1 {units.length} for distances, 1 {units.angle.value} for angles"
    )
    title = ": ".join(part for part in (instance.name, instance.type.id) if part)
    note = f"clearances in units of {weight}; last columns: the values of the nearest fold found"
    return Table(columns, rows, title=title, notes=[note])


def _document(instance: Instance, rows: list[dict[str, Any]]) -> dict[str, Any]:
    keys = [str(k) for k in range(1, len(instance.constraints) + 1)]
    return {
        "schema": "gsp.clearance/1",
        **instance.to_json(),
        "modes": [
            {
                **{key: row.get(key) for key in ("mode", "lower", "upper", "ratio", "R", "T")},
                "values": [row[key] for key in keys] if keys[0] in row else None,
            }
            for row in rows
        ],
    }
