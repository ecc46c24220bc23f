"""The table and the document of `gsp scan` over values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.cli.output import Column, Table
from gspcli.wording import counted

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion.singularities.crossings import Boundary, Crossing
    from gspcli.motion.singularities.value_scans import Scan

    Array = NDArray[np.float64]


_POSITION = ("Tx", "Ty", "Tz")
_POSE = (*_POSITION, "qw", "qx", "qy", "qz")


def scan_table(found: Scan, limits: Boundary, folds: bool, form: str) -> Table:
    """Return the table of the nodes, or that of the folds."""
    names, instance = _names(found), found.instance
    if folds:
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
        [*(Column(name, _heading(instance, name), "right", True) for name in names), *columns],
        _crossing_rows(limits.crossings, names) if folds else _node_rows(found, names),
        title=instance.title,
        notes=notes,
    )


def scan_document(found: Scan, limits: Boundary, folds: bool) -> dict[str, Any]:
    """Return the nodes, or the folds with their curves, for JSON."""
    names, instance = _names(found), found.instance
    document: dict[str, Any] = {
        "schema": "gsp.scan/1",
        **instance.to_json(),
        "vary": {name: list(axis.values) for name, axis in zip(names, found.axes, strict=True)},
    }
    if not folds:
        return document | {"nodes": _node_rows(found, names)}
    curves = [
        {
            "closed": curve.closed,
            "values": curve.values.tolist(),
            "cusps": curve.cusps.tolist(),
        }
        for curve in limits.curves
    ]
    return document | {"folds": _crossing_rows(limits.crossings, names), "curves": curves}


def _names(found: Scan) -> list[str]:
    return [str(axis.constraint + 1) for axis in found.axes]


def _heading(instance: Instance, name: str) -> str:
    return f"{name} {instance.constraints[int(name) - 1].kind.name}"


def _node_rows(found: Scan, names: list[str]) -> list[dict[str, Any]]:
    import numpy as np

    from gspcli.motion.singularities.value_scans import MISSING

    rows = []
    for node in np.ndindex(*found.modes.shape):
        row: dict[str, Any] = {
            name: axis.values[k] for name, axis, k in zip(names, found.axes, node, strict=True)
        }
        modes = int(found.modes[node])
        if modes == MISSING:
            continue
        row |= {
            "modes": None if modes < 0 else modes,
            "condition": _finite(found.conditions[node]),
        }
        if found.clearances is not None:
            row["clearance"] = _finite(found.clearances[node])
        rows.append(row)
    return rows


def _finite(number: Any) -> float | None:
    return float(number) if number < float("inf") else None


def _crossing_rows(found: list[Crossing], names: list[str]) -> list[dict[str, Any]]:
    from gspcli.geometry.quaternions import quaternion_from_rotation

    def quaternion(R: Array) -> list[float]:
        return list(quaternion_from_rotation(R).tolist())

    return [
        {
            **dict(zip(names, one.values, strict=True)),
            "change": one.change,
            **dict(zip(_POSE, [*one.T.tolist(), *quaternion(one.R)], strict=True)),
        }
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
