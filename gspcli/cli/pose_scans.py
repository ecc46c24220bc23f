"""`gsp scan --pose`: the determinant of the Jacobian matrix where coordinates of the pose vary."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gspcli.cli.grids import PARAMETERS, axes_of
from gspcli.cli.output import DRAWINGS, Column, Output, Table, emit, write
from gspcli.cli.progress_bars import working

if TYPE_CHECKING:
    from gspcli.cli.pose_type import GivenPose
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat
    from gspcli.motion.singularities.pose_scans import PoseScan


def scan_poses(
    instance: Instance,
    texts: Sequence[str],
    pose: GivenPose,
    form: PoseFormat,
    folds: bool,
    quantity: str,
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
        The pose whose coordinates vary, and the other coordinates of all nodes.
    form
        How the numbers of a pose are meant: order of axes, pivot, units.
    folds
        Whether to show where the determinant changes its sign instead of the nodes.
    quantity
        What pictures show; ``clearance`` is a column then.
    output
        Where to.
    """
    from gspcli.motion.singularities.pose_scans import PoseAxis, PoseScan

    axes = tuple(PoseAxis(*axis) for axis in axes_of(texts, PARAMETERS))
    pose.read(form)
    found = PoseScan(instance, axes, pose.numbers(form), form)
    if quantity == "clearance" and not folds:
        with working("clearances"):
            found.clearances  # noqa: B018
    if output.format in DRAWINGS:
        from gspcli.pictures.maps import pose_map

        write(output, pose_map(found, quantity, output.format))
        return
    names = [axis.name for axis in axes]
    cleared = quantity == "clearance"
    rows = _singular_rows(found, names) if folds else _node_rows(found, names, cleared=cleared)
    columns = [Column(name, align="right", essential=True) for name in names]
    if not folds:
        columns.append(Column("determinant", align="right", essential=True))
        columns.append(Column("condition", align="right"))
        columns += [Column("clearance", align="right")] * cleared
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


def _node_rows(found: PoseScan, names: list[str], *, cleared: bool) -> list[dict[str, Any]]:
    import numpy as np

    from gspcli.geometry.printed_numbers import printed_conditions

    conditions, rows = printed_conditions(found.conditions), []
    for node in np.ndindex(*found.determinants.shape):
        determinant, condition = found.determinants[node], conditions[node]
        rows.append(
            {
                **dict(zip(names, found.places[node].tolist(), strict=True)),
                "determinant": float(determinant) if np.isfinite(determinant) else None,
                "condition": float(condition) if np.isfinite(condition) else None,
                **({"clearance": float(found.clearances[node])} if cleared else {}),
            }
        )
    return rows


def _singular_rows(found: PoseScan, names: list[str]) -> list[dict[str, Any]]:
    points = sorted(point.tolist() for point in found.singular.values())
    return [dict(zip(names, point, strict=True)) for point in points]
