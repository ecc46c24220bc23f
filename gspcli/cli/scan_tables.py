"""The table of `gsp scan` over values."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.cli.output import Column, Table
from gspcli.wording import counted

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.motion.singularities.scan_results import ScanResult
    from gspcli.motion.singularities.value_scans import Scan


_POSITION = ("Tx", "Ty", "Tz")
_POSE = (*_POSITION, "qw", "qx", "qy", "qz")


def scan_table(result: ScanResult, form: str) -> Table:
    """Return the table of the nodes, or that of the folds."""
    found, limits, instance = result.found, result.limits, result.found.instance
    if result.folds:
        columns = [Column("change", align="right", essential=True)]
        # People tell mirror images apart by their positions.
        shown = _POSE if form == "csv" else _POSITION
        columns += [Column(key, align="right", minor=1, aligned=True) for key in shown]
    else:
        columns = [
            Column("modes", align="right", essential=True),
            Column("condition", align="right"),
        ]
        if found.clearances is not None:
            columns.append(Column("clearance", align="right"))
    notes = [_note(found)]
    if limits.curves:
        cusps = sum(len(curve.cusps) for curve in limits.curves)
        curves = counted(len(limits.curves), "curve")
        notes.append(f"discriminant: {curves}, {counted(cusps, 'cusp')}")
    return Table(
        [
            *(Column(name, _heading(instance, name), "right", True) for name in result.names),
            *columns,
        ],
        result.rows(),
        title=instance.title,
        notes=notes,
    )


def _heading(instance: Instance, name: str) -> str:
    return f"{name} {instance.constraints[int(name) - 1].kind.name}"


def _note(found: Scan) -> str:
    numbers, counts = _tally(found)
    parts = [f"{modes} at {count}" for modes, count in zip(numbers, counts, strict=True)]
    return f"{found.modes.size} nodes; modes: {', '.join(parts)}"


def _tally(found: Scan) -> tuple[list[int], list[int]]:
    import numpy as np

    numbers, counts = np.unique(found.modes[found.modes >= 0], return_counts=True)
    return numbers.tolist(), counts.tolist()
