"""`gsp analyze`: what a platform does at a pose: screws, Jacobian matrix, forces, accuracy."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.analysis_tables import details, overview
from gspcli.cli.names import load_instance
from gspcli.cli.number_types import Positive, Whole
from gspcli.cli.output import Output, emit, output_options
from gspcli.cli.pose_options import pose_format, pose_options
from gspcli.cli.real_poses import real_poses
from gspcli.errors import GspError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion.statics.accuracy import Accuracy
    from gspcli.motion.statics.geometry_errors import GeometryAccuracy
    from gspcli.motion.statics.wrenches import Wrenches

    Array = NDArray[np.float64]

#: Formats for people.
_READABLE = ("table", "markdown", "latex")
_ZERO = 1e-12


@click.command()
@click.argument("spec", metavar="SPEC")
@click.option("--mode", type=Whole(1), metavar="K", help="Only mode K, in detail.")
@click.option("--pose", metavar="NUMBERS", help="A pose instead: x,y,z,qw,qx,qy,qz.")
@pose_options
@click.option(
    "--point",
    metavar="X,Y,Z",
    help="The point, in the base, that twists and wrenches are about.  [default: the mean of the "
    "platform's points]",
)
@click.option(
    "--length",
    type=Positive(),
    help="The length that makes angles and lengths comparable.  [default: the typical length]",
)
@click.option(
    "--load",
    metavar="FX,FY,FZ[,MX,MY,MZ][@X,Y,Z]",
    help="A force and moment on the platform, in the axes of the base, at a point of the base.",
)
@click.option("--stiffness", metavar="K", help="Stiffness of each constraint: one number or six.")
@click.option("--tolerance", metavar="D", help="How far each value may be off: one number or six.")
@click.option(
    "--geometry",
    metavar="D[,A]",
    help="How far each coordinate of each primitive may be off, and each direction be turned.",
)
@output_options(parts=("wrenches", "jacobian", "inverse", "stiffness", "errors", "geometry"))
def command(
    spec: str,
    mode: int | None,
    pose: str | None,
    euler: str | None,
    pivot: str | None,
    point: str | None,
    length: float | None,
    load: str | None,
    stiffness: str | None,
    tolerance: str | None,
    geometry: str | None,
    output: Output,
) -> None:
    """Analyze assembly modes: screws, Jacobian matrix, forces, stiffness and accuracy.

    Without --mode or --pose there is one line for each real pose. For one pose: the wrench of each
    constraint, a force along an axis with a pitch, or a couple for angles; the derivatives of the
    values by a twist (rotation in radians about the axes through the point, velocity of the point)
    and their inverse; singular values and manipulability of the matrix with lengths divided by the
    stated length, and the condition number that `gsp solve` gives.

    With --load the forces in the constraints (positive: it pushes towards a greater value) and
    moments for angles. With --tolerance (or tolerance: in SPEC) the largest errors of the pose:
    exact to first order, with a proved bound that includes second order, and root mean squares
    for independent errors. With --geometry the errors of the pose when the points, lines and planes
    are not quite where SPEC says: largest ones and root mean squares, exact to first order.

    \b
    Examples:
      gsp analyze platform.yaml
      gsp analyze platform.yaml --mode 1 --load 0,0,-100@0,0,250 --tolerance 0.01
      gsp analyze platform.yaml --pose 0,0,1.5,1,0,0,0 --stiffness 2e6
    """
    if mode is not None and pose is not None:
        message = "give either --mode or --pose"
        raise click.UsageError(message)
    from gspcli.motion.statics.accuracy import accuracy
    from gspcli.motion.statics.wrenches import wrenches

    instance = load_instance(spec)
    six = {
        name: _six(text, name)
        for name, text in (("stiffness", stiffness), ("tolerance", tolerance))
    }
    limits = six["tolerance"] or _stated_tolerances(instance)
    at = None if point is None else _numbers(point, (3,), "point")
    R, T, numbers = poses_to_analyze(instance, mode, pose, euler, pivot)
    given = wrenches(instance, R, T, point=at, length=length)
    errors = None if limits is None else accuracy(given, limits)
    shape = None if geometry is None else _geometry(given, geometry)
    reactions = None if load is None else given.reactions(*_load(load, given.point))
    stiff = None if six["stiffness"] is None else given.stiffness(six["stiffness"])
    entries = [
        _entry(given, k, number, errors, shape, reactions, stiff)
        for k, number in enumerate(numbers)
    ]
    detailed = mode is not None or pose is not None
    tables = details(entries[0], given) if detailed else [overview(entries, given)]
    if output.format in _READABLE:
        tables = [replace(table, rows=[_tidy(row) for row in table.rows]) for table in tables]
    emit(output, tables, document=_document(instance, given, entries))


def _tidy(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row for people, in which rounding errors about zero are zero."""
    return {
        key: 0.0 if isinstance(value, float) and abs(value) < _ZERO else value
        for key, value in row.items()
    }


def poses_to_analyze(
    instance: Instance, mode: int | None, pose: str | None, euler: str | None, pivot: str | None
) -> tuple[Array, Array, list[int | None]]:
    """Return poses, shapes (n, 3, 3) and (n, 3), and their numbers as modes."""
    if pose is not None:
        from gspcli.motion import read_pose

        given = read_pose(pose, pose_format(instance, euler, pivot))
        return given.R, given.T, [None]
    R, T = real_poses(instance, mode)
    if mode is None:
        return R, T, list(range(1, len(R) + 1))
    return R[mode - 1 : mode], T[mode - 1 : mode], [mode]


def _numbers(text: str, counts: tuple[int, ...], name: str) -> list[float]:
    from gspcli.motion.files.number_tables import wrong_number

    cells = [cell.strip() for cell in text.split(",")]
    for cell in cells:
        if wrong := wrong_number(cell):
            message = f"--{name}: {wrong}"
            raise GspError(message)
    if len(cells) not in counts:
        expected = " or ".join(map(str, counts))
        message = f"--{name}: found {len(cells)} numbers, expected {expected}"
        raise GspError(message)
    return [float(cell) for cell in cells]


def _six(text: str | None, name: str) -> list[float] | None:
    if text is None:
        return None
    numbers = _numbers(text, (1, 6), name)
    return numbers * 6 if len(numbers) == 1 else numbers


def _stated_tolerances(instance: Instance) -> list[float] | None:
    """Return the tolerances of the file if it has any; those left out are zero."""
    stated = [constraint.tolerance for constraint in instance.constraints]
    if all(tolerance is None for tolerance in stated):
        return None
    return [0.0 if tolerance is None else tolerance.value for tolerance in stated]


def _load(text: str, point: Array) -> tuple[list[float], list[float], Any]:
    wrench, _, where = re.sub(r"\s", "", text).partition("@")
    numbers = _numbers(wrench, (3, 6), "load")
    at = _numbers(where, (3,), "load") if where else point
    return numbers[:3], numbers[3:] or [0.0, 0.0, 0.0], at


def _entry(
    given: Wrenches,
    k: int,
    number: int | None,
    errors: Accuracy | None,
    shape: GeometryAccuracy | None,
    reactions: Array | None,
    stiffness: Array | None,
) -> dict[str, Any]:
    """Return all that is known of one pose, as plain data."""
    constraint, direction, reaction = given.worst_force
    entry: dict[str, Any] = {
        "mode": number,
        "R": given.R[k].tolist(),
        "T": given.T[k].tolist(),
        "point": given.point[k].tolist(),
        "condition": _finite(given.conditions[k]),
        "manipulability": float(given.manipulability[k]),
        "singular_values": given.singular_values[k].tolist(),
        "forces": given.forces[k].tolist(),
        "moments": given.moments[k].tolist(),
        "pitches": [_finite(pitch) for pitch in given.pitches[k]],
        "feet": [[_finite(x) for x in foot] for foot in given.feet[k]],
        "jacobian": given.jacobian[k].tolist(),
        "inverse": [[_finite(x) for x in row] for row in given.inverse[k]],
        "worst_force": {
            "constraint": int(constraint[k]) + 1,
            "direction": [_finite(x) for x in direction[k]],
            "reaction": _finite(reaction[k]),
        },
    }
    if reactions is not None:
        entry["reactions"] = [_finite(x) for x in reactions[k]]
    if stiffness is not None:
        entry["stiffness"] = stiffness[k].tolist()
    if errors is not None:
        entry["accuracy"] = {
            name: [_finite(x) for x in getattr(errors, name)[k]]
            for name in ("worst", "bound", "rms")
        } | {
            name: _finite(getattr(errors, name)[k])
            for name in ("worst_turn", "worst_shift", "bound_turn", "bound_shift")
        }
    if shape is not None:
        entry["geometry"] = {
            "worst": [_finite(x) for x in shape.worst[k]],
            "rms": [_finite(x) for x in shape.rms[k]],
            "turn": _finite(shape.turn[k]),
            "shift": _finite(shape.shift[k]),
        }
    return entry


def _geometry(given: Wrenches, text: str) -> GeometryAccuracy:
    from gspcli.motion.statics.geometry_errors import geometry_accuracy

    coordinates, *tilts = _numbers(text, (1, 2), "geometry")
    if min(coordinates, *tilts, 0) < 0:
        message = f"--geometry: found {text}, expected numbers of at least 0"
        raise GspError(message)
    return geometry_accuracy(given, coordinates, *tilts)


def _finite(value: Any) -> float | None:
    """Return a number for JSON, which has none that is not finite."""
    number = float(value)
    return number if abs(number) < float("inf") else None


def _document(instance: Instance, given: Wrenches, entries: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "schema": "gsp.analyze/1",
        **instance.to_json(),
        "length": given.length,
        "poses": entries,
    }
