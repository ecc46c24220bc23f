"""`gsp scan --over`: the determinant of the Jacobian matrix where coordinates of the pose vary."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gspcli.cli.grids import PARAMETERS, axes_of
from gspcli.cli.output import DRAWINGS, Column, Output, Table, emit, write
from gspcli.cli.pose_options import pose_format

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.motion.pose_scanning import PoseScan


def scan_poses(
    instance: Instance,
    texts: Sequence[str],
    pose: str,
    given: tuple[str | None, str | None],
    folds: bool,
    output: Output,
) -> None:
    """Scan poses and show what was found.

    Parameters
    ----------
    instance
        Geometry and units.
    texts
        The axes.
    pose
        What does not vary.
    given
        ``--euler`` and ``--pivot``.
    folds
        Whether to show where the determinant changes its sign instead of the nodes.
    output
        Where to.
    """
    from gspcli.motion.pose_scanning import PoseAxis, PoseScan

    axes = tuple(PoseAxis(*axis) for axis in axes_of("--over", texts, PARAMETERS))
    found = PoseScan(instance, axes, pose, pose_format(instance, *given))
    if output.format in DRAWINGS:
        from gspcli.pictures.maps import determinant_map

        write(output, determinant_map(found, output.format))
        return
    names = [axis.name for axis in axes]
    rows = _singular_rows(found, names) if folds else _node_rows(found, names)
    columns = [Column(name, align="right", essential=True) for name in names]
    if not folds:
        columns.append(Column("determinant", align="right", essential=True))
        columns.append(Column("condition", align="right"))
    signs = [int((found.determinants * sign > 0).sum()) for sign in (1, -1)]
    note = f"{found.determinants.size} poses; determinant positive at {signs[0]}, negative at "
    table = Table(
        columns,
        rows,
        title=instance.title,
        notes=[f"{note}{signs[1]}; {len(found.singular)} singular poses on edges of the grid"],
    )
    document: dict[str, Any] = {
        "schema": "gsp.scan/1",
        **instance.to_json(),
        "over": {axis.name: list(axis.values) for axis in axes},
        "singular" if folds else "nodes": rows,
    }
    if folds:
        document["curves"] = [{"values": curve.tolist()} for curve in found.curves]
    emit(output, table, document=document)


def _node_rows(found: PoseScan, names: list[str]) -> list[dict[str, Any]]:
    import numpy as np

    rows = []
    for node in np.ndindex(*found.determinants.shape):
        determinant, condition = found.determinants[node], found.conditions[node]
        rows.append(
            {
                **dict(zip(names, found.places[node].tolist(), strict=True)),
                "determinant": float(determinant) if np.isfinite(determinant) else None,
                "condition": float(condition) if np.isfinite(condition) else None,
            }
        )
    return rows


def _singular_rows(found: PoseScan, names: list[str]) -> list[dict[str, Any]]:
    points = sorted(point.tolist() for point in found.singular.values())
    return [dict(zip(names, point, strict=True)) for point in points]
