"""`gsp clearance`: how far values or poses may change before a mode can meet a singularity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.analyze import poses_to_analyze
from gspcli.cli.names import load_instance
from gspcli.cli.number_types import Whole
from gspcli.cli.output import Column, Output, Table, emit, output_options
from gspcli.cli.pose_options import pose_options
from gspcli.cli.progress_bars import progress
from gspcli.errors import GspError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion.singularities.clearances import Clearance
    from gspcli.motion.singularities.pose_clearances import PoseClearance

    Array = NDArray[np.float64]


@click.command()
@click.argument("spec", metavar="SPEC")
@click.option("--mode", type=Whole(1), metavar="K", help="Only mode K.")
@click.option("--pose", metavar="NUMBERS", help="A pose instead: x,y,z,qw,qx,qy,qz.")
@pose_options
@click.option(
    "--of",
    type=click.Choice(["values", "pose"]),
    default="values",
    show_default=True,
    help="What changes.",
)
@click.option(
    "--points",
    metavar="X,Y,Z;...",
    help="With --of pose: the points of the platform, in its frame, whose displacements count.  "
    "[default: those of the distances]",
)
@click.option("--refine", is_flag=True, help="Better bounds: a few seconds for each mode.")
@output_options()
def command(
    spec: str,
    mode: int | None,
    pose: str | None,
    euler: str | None,
    pivot: str | None,
    of: str,
    points: str | None,
    refine: bool,
    output: Output,
) -> None:
    """Bound how far values, or the pose, may change before a mode meets a singularity.

    A clearance of r means that every value may change by r times its weight, all at once and in
    any combination, and the mode exists all the while and is not singular. The weight is half the
    range of the constraint, if each has one in SPEC; else 1 in the unit of the value.

    The lower bound is proved for the whole box of values. The upper bound is a proved fold of the
    same mode, the nearest one found, with the values at which it is.

    With --of pose: how far the platform may move, whatever the values, before the six screws
    become dependent. Distances of poses are root mean squares of the displacements of the
    platform's points. The lower bound is proved for all poses within; the upper bound is that of
    the nearest singular pose found, where the determinant is proved to change its sign.

    \b
    Examples:
      gsp clearance platform.yaml
      gsp clearance platform.yaml --mode 1 --refine
      gsp clearance platform.yaml --of pose
      gsp clearance platform.yaml --pose 0,0,1.5,1,0,0,0 --format json
    """
    if mode is not None and pose is not None:
        message = "give either --mode or --pose"
        raise click.UsageError(message)
    if points is not None and of != "pose":
        message = "--points needs --of pose"
        raise click.UsageError(message)
    from gspcli.motion.poses.inverse_kinematics import measure
    from gspcli.motion.singularities.clearances import clearance, range_weights
    from gspcli.motion.singularities.pose_clearances import pose_clearance

    instance = load_instance(spec)
    chosen = None if points is None else _points(points)
    R, T, numbers = poses_to_analyze(instance, mode, pose, euler, pivot)
    weights = range_weights(instance)
    rows = []
    for k in progress(range(len(R)), total=len(R), label="modes"):
        found: Clearance | PoseClearance
        at = None
        if of == "pose":
            found = pose_clearance(instance, R[k], T[k], points=chosen, refine=refine)
            if found.R is not None and found.T is not None:
                at = measure(instance, found.R, found.T), found.R, found.T
        else:
            found = clearance(instance, R[k], T[k], weights=weights, refine=refine)
            if found.values is not None and found.fold is not None:
                at = found.values, found.fold.R, found.fold.T
        rows.append(_row(numbers[k], found, at))
    unit = _unit(instance, of, ranged=weights is not None)
    emit(output, _table(instance, rows, of, unit), document=_document(instance, of, rows))


def _points(text: str) -> list[list[float]]:
    """Return the points that are written as coordinates, between semicolons."""
    from gspcli.motion.files.number_tables import wrong_number

    points = [[cell.strip() for cell in point.split(",")] for point in text.split(";")]
    for point in points:
        if len(point) != 3:
            message = f"--points: found {len(point)} coordinates, expected X,Y,Z;X,Y,Z;..."
            raise GspError(message)
        for cell in point:
            if wrong := wrong_number(cell):
                message = f"--points: {wrong}"
                raise GspError(message)
    return [[float(cell) for cell in point] for point in points]


def _row(
    number: int | None,
    item: Clearance | PoseClearance,
    at: tuple[Array, Array, Array] | None,
) -> dict[str, Any]:
    """Return what is known of one mode; `at` are values and pose where it is singular."""
    row: dict[str, Any] = {"mode": number, "lower": item.lower, "upper": None, "ratio": None}
    if at is not None:
        values, R, T = at
        row |= {"upper": item.upper, "ratio": item.ratio if item.lower > 0 else None}
        row |= {str(k): value for k, value in enumerate(values.tolist(), 1)}
        row |= {"R": R.tolist(), "T": T.tolist()}
    return row


def _unit(instance: Instance, of: str, *, ranged: bool) -> str:
    units = instance.units
    if of == "pose":
        return f"{units.length}, root mean squares of the displacements of points"
    if ranged:
        return "units of half the range of each value"
    return f"units of 1 {units.length} for distances, 1 {units.angle.value} for angles"


def _table(instance: Instance, rows: list[dict[str, Any]], of: str, unit: str) -> Table:
    columns = [
        Column("mode", align="right", essential=True),
        Column("lower", "proved free", align="right", essential=True),
        Column(
            "upper", "singular at" if of == "pose" else "fold at", align="right", essential=True
        ),
        Column("ratio", align="right"),
    ]
    columns += [
        Column(str(k), f"{k} {constraint.kind.name}", align="right")
        for k, constraint in enumerate(instance.constraints, 1)
    ]
    title = instance.title
    nearest = "singular pose" if of == "pose" else "fold"
    note = f"clearances in {unit}; last columns: the values of the nearest {nearest} found"
    return Table(columns, rows, title=title, notes=[note])


def _document(instance: Instance, of: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    keys = [str(k) for k in range(1, len(instance.constraints) + 1)]
    return {
        "schema": "gsp.clearance/1",
        **instance.to_json(),
        "of": of,
        "modes": [
            {
                **{key: row.get(key) for key in ("mode", "lower", "upper", "ratio", "R", "T")},
                "values": [row[key] for key in keys] if keys[0] in row else None,
            }
            for row in rows
        ],
    }
