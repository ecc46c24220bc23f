"""The modes on a grid of values, and the folds between its nodes, with their table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.printed_numbers import printed_conditions
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.ranges import wrong_value
from gspcli.geometry.readings import factors, is_corrected, offsets, without_corrections
from gspcli.motion.singularities.crossings import Boundary, boundary, in_order
from gspcli.motion.singularities.value_scans import MISSING, Axis, Scan
from gspcli.motion.singularities.value_scans import scan as scan_values
from gspcli.records import dataclass
from gspcli.wording import counted, listed, shown
from gspcli.workers import HERE, Workers

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: Columns of the pose at a fold.
POSE = ("Tx", "Ty", "Tz", "qw", "qx", "qy", "qz")


@dataclass(frozen=True, eq=False)
class ScanResult:
    """The result of a scan of values.

    Attributes
    ----------
    found
        The modes at the nodes.
    limits
        The folds between nodes; empty if they were not asked for.
    folds
        Whether tables show the folds instead of the nodes.
    """

    found: Scan
    limits: Boundary
    folds: bool = False

    def __repr__(self) -> str:
        known = self.found.modes[self.found.modes >= 0]
        modes = f", {known.min()} to {known.max()} modes" if known.size else ""
        folds = f", {counted(len(self.limits.crossings), 'fold')}" if self.folds else ""
        instance = self.found.instance
        size = counted(self.found.modes.size, "node")
        return f"<ScanResult of {instance.name or instance.type.id}: {size}{modes}{folds}>"

    @property
    def names(self) -> list[str]:
        """The numbers of the constraints, and the drives, that vary."""
        return [axis.name for axis in self.found.axes]

    def rows(self) -> list[dict[str, Any]]:
        """Return the nodes that are known, or the folds, as plain data."""
        return self._crossings() if self.folds else self._nodes()

    def to_frame(self) -> pd.DataFrame:
        """Return the nodes, or the folds, as a table (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.scan/1``."""
        axes = zip(self.names, self.found.axes, strict=True)
        document: dict[str, Any] = {
            "schema": "gsp.scan/1",
            **self.found.instance.to_json(),
            "vary": {name: list(axis.values) for name, axis in axes},
        }
        if not self.folds:
            return document | {"nodes": self.rows()}
        curves = [
            {
                "closed": curve.closed,
                "values": curve.values.tolist(),
                "cusps": curve.cusps.tolist(),
            }
            for curve in self.limits.curves
        ]
        meetings = [
            {
                "from": dict(zip(self.names, one.low, strict=True)),
                "to": dict(zip(self.names, one.high, strict=True)),
                "modes": [one.before, one.after],
                "poses": [
                    {
                        "modes": [before, after],
                        **dict(zip(POSE, _pose_numbers(R, T), strict=True)),
                    }
                    for before, after, R, T in one.poses
                ],
            }
            for one in self.limits.meetings
        ]
        return document | {"folds": self.rows(), "curves": curves, "meetings": meetings}

    def _nodes(self) -> list[dict[str, Any]]:
        found, rows = self.found, []
        conditions = printed_conditions(found.conditions)
        for node in np.ndindex(*found.modes.shape):
            axes = zip(self.names, found.axes, node, strict=True)
            row: dict[str, Any] = {name: axis.values[k] for name, axis, k in axes}
            modes = int(found.modes[node])
            if modes == MISSING:
                continue
            row |= {
                "modes": None if modes < 0 else modes,
                "condition": _finite(conditions[node]),
            }
            if found.clearances is not None:
                row["clearance"] = _finite(found.clearances[node])
            rows.append(row)
        return rows

    def _crossings(self) -> list[dict[str, Any]]:
        return [
            {
                **dict(zip(self.names, one.values, strict=True)),
                "change": one.change,
                **dict(zip(POSE, _pose_numbers(one.R, one.T), strict=True)),
            }
            for one in in_order(self.limits.crossings)
        ]


def scan(
    instance: Instance,
    vary: Mapping[int | str, ArrayLike],
    *,
    folds: bool = False,
    clearance: bool = False,
    seed: int = SEED,
    workers: Workers = HERE,
) -> ScanResult:
    """Count the real assembly modes while one or two values vary.

    Parameters
    ----------
    instance
        Geometry, units, sides, and the values that do not vary.
    vary
        Increasing values by the numbers of the constraints, from 1, or readings by the names of
        cranks and slides (``crank.B1``), in the units of the instance: one or two, shapes (n1,) and
        (n2,). Other cranks and slides stay where their points are stated.
    folds
        Whether to prove the folds between neighbouring nodes with different numbers.
    clearance
        Whether to bound the clearance of each pose, too.
    seed
        As for `solve_values`; nothing depends on it.
    workers
        The processes that do the work.

    Raises
    ------
    ArgumentError
        If a constraint or drive does not exist, or a value is impossible.
    """
    axes = [axis_of(instance, k, np.asarray(v, float).tolist()) for k, v in vary.items()]
    asked = Scan.empty(instance, axes, clearance=clearance)
    check_values(asked, "vary")
    platform, moved = corrected(asked)
    found = scan_values(platform, moved, clearance=clearance, seed=seed, workers=workers)
    result = as_read(asked, found, boundary(found) if folds else Boundary(), folds=folds)
    for array in (result.found.modes, result.found.conditions, result.found.clearances):
        if array is not None:
            array.setflags(write=False)
    return result


def axis_of(instance: Instance, name: int | str, values: Sequence[float]) -> Axis:
    """Return the axis of a constraint by its number, or of a crank or slide by its name.

    Raises
    ------
    ArgumentError
        If there is no such constraint or drive.
    """
    if not isinstance(name, str) and name in range(1, len(instance.constraints) + 1):
        return Axis(int(name) - 1, tuple(values))
    drives = Drives.of(instance)
    known = drive_names(instance)
    if not isinstance(name, str) or name not in known:
        what = shown(name) if isinstance(name, str) else f"constraint {name}"
        others = f" or {listed(known)}" if known else ""
        message = f"found {what}, expected a number from 1 to 6{others}"
        raise ArgumentError(message, "vary")
    return Axis(drives.users(drives.names.index(name))[0], tuple(values), name)


def drive_names(instance: Instance) -> list[str]:
    """Return the names of the cranks and slides of an instance."""
    drives = Drives.of(instance)
    return [name for name, moves in zip(drives.names, drives.moved, strict=True) if moves]


def corrected(asked: Scan) -> tuple[Instance, list[Axis]]:
    """Return the scan of values for a scan of readings: with offsets and scales applied."""
    if not is_corrected(asked.instance):
        return asked.instance, list(asked.axes)
    axes = [
        replace(axis, values=tuple(value * factor + offset for value in axis.values))
        for axis, factor, offset in zip(asked.axes, *_corrections(asked), strict=True)
    ]
    return without_corrections(asked.instance), axes


def as_read(asked: Scan, found: Scan, limits: Boundary, *, folds: bool) -> ScanResult:
    """Return the results with readings instead of values: offsets and scales are removed."""
    if not is_corrected(asked.instance):
        return ScanResult(found, limits, folds)
    scales, added = _corrections(asked)
    limits.crossings = [
        replace(one, values=tuple(((one.values - added) / scales).tolist()))
        for one in limits.crossings
    ]
    limits.curves = [
        replace(
            curve,
            values=(curve.values - added) / scales,
            cusps=(curve.cusps - added) / scales,
        )
        for curve in limits.curves
    ]
    limits.meetings = [
        replace(
            one,
            low=tuple(((one.low - added) / scales).tolist()),
            high=tuple(((one.high - added) / scales).tolist()),
        )
        for one in limits.meetings
    ]
    return ScanResult(replace(found, instance=asked.instance, axes=asked.axes), limits, folds)


def check_values(found: Scan, name: str) -> None:
    """Raise `ArgumentError` if a value is outside the range of its kind of constraint."""
    for axis in found.axes:
        if axis.drive:
            continue
        kind = found.instance.constraints[axis.constraint].kind
        for value in (axis.values[0], axis.values[-1]):
            wrong = wrong_value(kind, Number.of(value), found.instance.units.angle)
            if wrong and not kind.has_sides:
                message = f"found {value:g} for constraint {axis.constraint + 1}, {wrong}"
                raise ArgumentError(message, name)


def _corrections(asked: Scan) -> tuple[Array, Array]:
    """Return the factors of the values of the axes, and the numbers that are added to them."""
    chosen = [axis.constraint for axis in asked.axes]
    values = np.array([not axis.drive for axis in asked.axes])
    times, added = factors(asked.instance), offsets(asked.instance, signed=False)
    # Drives correct their own readings.
    return np.where(values, times[chosen], 1.0), np.where(values, added[chosen], 0.0)


def _pose_numbers(R: Array, T: Array) -> list[float]:
    return [*T.tolist(), *quaternion_from_rotation(R).tolist()]


def _finite(number: Any) -> float | None:
    return float(number) if number < float("inf") else None
