"""Errors of a pose that follow from errors of the geometry."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import gradients
from gspcli.geometry.primitives import Geometry, Point
from gspcli.geometry.quaternions import apply
from gspcli.motion.poses.inverse_kinematics import value_signs
from gspcli.motion.statics.wrenches import Wrenches
from gspcli.records import dataclass

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GeometrySlopes:
    """Derivatives of measured values by the numbers of the primitives.

    Attributes
    ----------
    names
        The names of the m columns: ``platform.P1.x`` for a coordinate of the point of a primitive
        in the frame of its body; ``base.L2.tilt1`` for a small rotation of a direction or normal
        about one of two axes perpendicular to it.
    tilts
        Which columns are rotations (radians), shape (m,); the others are lengths.
    slopes
        Derivatives of the values of `measure` (lengths and radians), shape (..., 6, m). A primitive
        that several constraints share has one set of columns.
    """

    names: tuple[str, ...]
    tilts: NDArray[np.bool_]
    slopes: Array


def geometry_slopes(
    instance: Instance, R: Array, T: Array, arrangement: Arrangement | None = None
) -> GeometrySlopes:
    """Return the exact derivatives of the values by the geometry at poses.

    Parameters
    ----------
    instance
        The platform.
    R, T
        Poses, shapes (..., 3, 3) and (..., 3).
    arrangement
        The platform with its points where drives have them; as it is stated if None.
    """
    R, T = np.asarray(R, float), np.asarray(T, float)
    arrangement = arrangement or Arrangement.of(instance)
    by = gradients(arrangement, arrangement.placed(R, T))
    signs = value_signs(arrangement, R, T)
    columns: dict[tuple[str, str], list[tuple[str, Array]]] = {}
    for k, row in enumerate(instance.constraints):
        for body, name, primitive in (
            ("platform", row.platform_name, row.platform),
            ("base", row.base_name, row.base),
        ):
            found = columns.setdefault((body, name or f"of {k + 1}"), [])
            for column, (what, motion, turns) in enumerate(_motions(primitive)):
                if body == "platform":
                    part = by.w if turns else by.r
                    moved = apply(R, np.broadcast_to(motion, T.shape))
                else:
                    part = by.v if turns else -by.r
                    moved = np.broadcast_to(motion, T.shape)
                if column == len(found):
                    found.append((what, np.zeros((*T.shape[:-1], len(instance.constraints)))))
                found[column][1][..., k] = np.einsum("...i,...i->...", part[..., k, :], moved)
    listed = [
        (f"{body}.{name}.{what}", values)
        for (body, name), parts in columns.items()
        for what, values in parts
    ]
    names = tuple(name for name, _ in listed)
    return GeometrySlopes(
        names,
        np.array(["tilt" in name.rpartition(".")[2] for name in names]),
        signs[..., None] * np.stack([values for _, values in listed], axis=-1),
    )


def _motions(primitive: Geometry) -> list[tuple[str, Array, bool]]:
    """Return the errors of a primitive: name, change of the point or direction, and which one."""
    found = [(axis, row, False) for axis, row in zip("xyz", np.eye(3), strict=True)]
    if not isinstance(primitive, Point):
        across = np.linalg.svd(primitive.unit[None])[2][1:]
        found += [
            (f"tilt{k}", np.cross(axis, primitive.unit), True) for k, axis in enumerate(across, 1)
        ]
    return found


@dataclass(frozen=True, eq=False)
class GeometryAccuracy:
    """Errors of n poses (rx, ry, rz in radians, and a point) from errors of the geometry.

    All are exact to first order in the errors of the geometry, except for the last two. These may
    be too large: the worst cases of the three axes need not occur together.

    Attributes
    ----------
    worst
        The largest error of each of rx, ry, rz, x, y, z, shape (n, 6).
    rms
        Root mean squares for independent errors, with the tolerances as standard deviations, shape
        (n, 6).
    turn, shift
        Upper bounds, to first order, of the angle of rotation and of the distance, shape (n,).
    """

    worst: Array
    rms: Array
    turn: Array
    shift: Array


def geometry_accuracy(given: Wrenches, coordinates: float, tilts: float = 0.0) -> GeometryAccuracy:
    """Return the errors of poses from errors of the geometry; the values are as stated.

    Parameters
    ----------
    given
        The poses, shape (n, ...), and the point whose position is meant.
    coordinates
        The largest error of each coordinate of the point of each primitive, in length units.
    tilts
        The largest rotation of each direction and normal about each of two axes perpendicular to
        it, in the angle unit of the instance.

    Raises
    ------
    ArgumentError
        If a tolerance is negative or not finite.
    """
    for name, value in (("coordinates", coordinates), ("tilts", tilts)):
        if not (np.isfinite(value) and value >= 0):
            message = f"found {value}, expected a number of at least zero"
            raise ArgumentError(message, name)
    found = geometry_slopes(given.instance, given.R, given.T, given.arrangement)
    radian = given.instance.units.angle.in_radians
    sizes = np.where(found.tilts, tilts * radian, coordinates)
    # The values stay constant: the change by the geometry and the change by the pose cancel.
    columns = -given.inverse @ found.slopes * sizes
    worst = np.abs(columns).sum(axis=2)
    bounds = [
        np.minimum(
            np.linalg.norm(worst[:, part], axis=1),
            np.linalg.norm(columns[:, part], axis=1).sum(axis=1),
        )
        for part in (slice(0, 3), slice(3, 6))
    ]
    return GeometryAccuracy(worst, np.sqrt((columns**2).sum(axis=2)), *bounds)
