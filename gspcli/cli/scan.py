"""`gsp scan`: how many assembly modes there are where values vary."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.names import load_instance
from gspcli.cli.output import (
    DRAWINGS,
    FORMATS,
    Column,
    Output,
    Table,
    emit,
    output_options,
    write,
)
from gspcli.cli.progress_bars import progress
from gspcli.errors import GspError, IncompleteError

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.motion.scanning import Axis, Crossing, Scan

_MOST_NODES = 1_000_000
_AXIS = re.compile(r"([1-6])=([^:]+):([^:]+):(\d+)")


@click.command()
@click.argument("spec", metavar="SPEC")
@click.option(
    "--vary",
    "texts",
    metavar="N=LOW:HIGH:COUNT",
    multiple=True,
    required=True,
    help="Let constraint N take COUNT values from LOW to HIGH; once or twice.",
)
@click.option(
    "--folds",
    is_flag=True,
    help="Instead of the nodes, or in pictures with them: where between neighbours the number "
    "changes, proved.",
)
@click.option(
    "--jobs", type=click.IntRange(min=1), default=1, show_default=True, metavar="N", help="Threads."
)
@output_options(formats=(*FORMATS, *DRAWINGS))
def command(spec: str, texts: tuple[str, ...], folds: bool, jobs: int, output: Output) -> None:
    """Count the real assembly modes where one or two values vary.

    All poses are found at every node of the grid: modes is the number of real ones, condition the
    smallest condition number of one. Between neighbouring nodes with different numbers the modes
    of the node that has more are followed with proof, and --folds gives the proved values at
    which a pair of them meets and vanishes: points of the discriminant.

    The exit code is 4 if not all poses could be found at some node; its modes are left out.

    \b
    Examples:
      gsp scan platform.yaml --vary 1=5:7:200 -o modes.csv
      gsp scan platform.yaml --vary 1=5:7:60 --vary 2=4:6:60 --folds -o discriminant.csv
      gsp scan platform.yaml --vary 1=5:7:60 --vary 2=4:6:60 --folds -o map.svg
    """
    from gspcli.motion.scanning import crossings, scan

    instance = load_instance(spec)
    axes = [_axis(text) for text in texts]
    total = 1
    for axis in axes:
        total *= len(axis.values)
    if total > _MOST_NODES:
        message = f"found {total} nodes, expected at most {_MOST_NODES}"
        raise GspError(message)
    steps = progress(range(total), total=total, label="nodes")
    found = scan(instance, axes, jobs=jobs, progress=steps)
    names = [str(axis.constraint + 1) for axis in axes]
    unknown = int((found.modes < 0).sum())
    crossed: list[Crossing] = []
    if folds:
        total_edges = sum(1 for _ in found.edges)
        for edge in progress(crossings(found), total=total_edges, label="folds"):
            crossed += edge
    if output.format in DRAWINGS:
        from gspcli.pictures.maps import mode_map

        write(output, mode_map(found, crossed, output.format))
        return
    if folds:
        rows = _crossing_rows(crossed, names)
        columns = [Column("change", align="right", essential=True)]
    else:
        rows = _node_rows(found, names)
        columns = [
            Column("modes", align="right", essential=True),
            Column("condition", align="right"),
        ]
    table = Table(
        [*(Column(name, _heading(instance, name), "right", True) for name in names), *columns],
        rows,
        title=": ".join(part for part in (instance.name, instance.type.id) if part),
        notes=[_note(found)],
    )
    kind = instance.type
    document = {
        "schema": "gsp.scan/1",
        "name": instance.name,
        "type": {"id": kind.id, "number": kind.number, "class": kind.platform_class.id},
        "units": {"length": instance.units.length, "angle": instance.units.angle.value},
        "vary": {name: list(axis.values) for name, axis in zip(names, axes, strict=True)},
        "folds" if folds else "nodes": rows,
    }
    emit(output, table, document=document)
    if unknown:
        message = f"at {unknown} of {total} nodes not all poses could be found"
        raise IncompleteError(message)


def _axis(text: str) -> Axis:
    import numpy as np

    from gspcli.motion.number_tables import wrong_number
    from gspcli.motion.scanning import Axis

    match = _AXIS.fullmatch(text.replace(" ", ""))
    if match is None or wrong_number(match[2]) or wrong_number(match[3]):
        message = f"--vary: found {text!r}, expected N=LOW:HIGH:COUNT, such as 1=5:7:200"
        raise GspError(message)
    low, high, count = float(match[2]), float(match[3]), int(match[4])
    if not low < high or count < 2:
        message = f"--vary: found {text!r}, expected LOW below HIGH and at least two values"
        raise GspError(message)
    return Axis(int(match[1]) - 1, tuple(np.linspace(low, high, count).tolist()))


def _heading(instance: Instance, name: str) -> str:
    return f"{name} {instance.constraints[int(name) - 1].kind.name}"


def _node_rows(found: Scan, names: list[str]) -> list[dict[str, Any]]:
    import numpy as np

    rows = []
    for node in np.ndindex(*found.modes.shape):
        row: dict[str, Any] = {
            name: axis.values[k] for name, axis, k in zip(names, found.axes, node, strict=True)
        }
        modes, condition = int(found.modes[node]), float(found.conditions[node])
        row |= {
            "modes": None if modes < 0 else modes,
            "condition": condition if condition < float("inf") else None,
        }
        rows.append(row)
    return rows


def _crossing_rows(found: list[Crossing], names: list[str]) -> list[dict[str, Any]]:
    return [
        {**dict(zip(names, one.values, strict=True)), "change": one.change}
        for one in sorted(found, key=lambda one: one.values)
    ]


def _note(found: Scan) -> str:
    numbers, counts = _tally(found)
    parts = [f"{modes} at {count}" for modes, count in zip(numbers, counts, strict=True)]
    return f"{found.modes.size} nodes; modes: {', '.join(parts)}"


def _tally(found: Scan) -> tuple[list[int], list[int]]:
    import numpy as np

    numbers, counts = np.unique(found.modes[found.modes >= 0], return_counts=True)
    return numbers.tolist(), counts.tolist()
