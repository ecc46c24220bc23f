"""Errors of a pose that follow from tolerances of its values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement, Array
from gspcli.geometry.enclosures import Enclosure, Jet, Matrix, roundings
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import gradients, value_signs
from gspcli.geometry.primitives import Geometry, Point
from gspcli.geometry.quaternions import (
    ROTATION_FORMS,
    TRANSLATION_FORMS,
    apply,
    conjugate,
    quaternion_product,
)
from gspcli.motion.following.branch_follower import MovingPlatform, apart
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.singularities.neighbourhoods import SIGNS, Neighbourhood, corners
from gspcli.motion.statics.wrenches import Wrenches
from gspcli.records import dataclass


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Errors of n poses: rotation (rx, ry, rz, in radians), and position of a point."""

    #: The largest error of each of rx, ry, rz, x, y, z for any values within the tolerances, exact
    #: to first order, shape (n, 6).
    worst: Array
    #: The largest angle of rotation and the largest distance of the point, likewise, shape (n,).
    worst_turn: Array
    worst_shift: Array
    #: Proved bounds of these errors, with second order and rounding; infinite if the tolerances are
    #: too large for a proof.
    bound: Array
    bound_turn: Array
    bound_shift: Array
    #: Root mean squares of the errors if the values' errors are independent, with the tolerances as
    #: standard deviations, to first order, shape (n, 6).
    rms: Array


def accuracy(given: Wrenches, tolerances: ArrayLike, motors: ArrayLike | None = None) -> Accuracy:
    """Return the errors of poses from tolerances of their values.

    Parameters
    ----------
    given
        The poses, shape (n, ...), and the point whose position has errors.
    tolerances
        The largest error of each value, in the units of the instance, shape (6,).
    motors
        The largest error of each crank or slide, in lengths and radians, shape (m,); zero for
        driven values, whose errors are among those of the values. All are zero if None.

    Raises
    ------
    ArgumentError
        If a tolerance is negative or not finite.
    """
    instance = given.instance
    limits = np.asarray(tolerances, float)
    if limits.shape != (6,) or not (np.isfinite(limits) & (limits >= 0)).all():
        message = f"found {limits.tolist()}, expected six numbers of at least zero"
        raise ArgumentError(message, "tolerances")
    errors = np.where(given.angles, limits * instance.units.angle.in_radians, limits)
    off = np.zeros(given.drives.count) if motors is None else np.asarray(motors, float)
    columns, squares = _columns(given, errors, off)
    signs = corners(columns.shape[-1])
    turned, shifted = (
        np.linalg.norm(np.einsum("nik,sk->nsi", part, signs), axis=2).max(axis=1)
        for part in (columns[:, :3], columns[:, 3:])
    )
    bound, bound_turn, bound_shift = _moved_bounds(given, limits, off)
    return Accuracy(
        np.abs(columns).sum(axis=2),
        turned,
        shifted,
        bound,
        bound_turn,
        bound_shift,
        np.sqrt((squares**2).sum(axis=2)),
    )


def _columns(given: Wrenches, errors: Array, off: Array) -> tuple[Array, Array]:
    """Return twists for the largest errors, each with either sign, and for independent errors.

    Errors of a rod and of its own drive have one direction and are added in the first. Shapes
    (n, 6, sources).
    """
    inverse, drives = given.inverse, given.drives
    moved = inverse @ given.matrix * off
    shared = [k for k in range(drives.count) if len(drives.users(k)) > 1 and off[k]]
    alone = np.isin(drives.index, shared, invert=True)
    own = np.abs(given.gains) * off[drives.index] * alone
    columns = inverse * (errors + own)[:, None, :]
    if shared:
        columns = columns[:, :, np.any(columns != 0, axis=(0, 1))]
    columns = np.concatenate((columns, moved[:, :, shared]), axis=2)
    return columns, np.concatenate((inverse * errors, moved), axis=2)


def _moved_bounds(given: Wrenches, limits: Array, off: Array) -> tuple[Array, Array, Array]:
    """Return proved bounds as `_bounds`, where drives have moved points and have errors.

    A rod's length to the stated place of its joint changes by at most the way of the joint, which
    is the arm times the error of a crank, or the error of a slide.
    """
    drives = given.drives
    ways = np.where(drives.driven, drives.arms * off[drives.index], 0.0)
    # Moved points are rounded.
    size = np.abs(drives.points(given.q)).max() + np.abs(drives.middle).max()
    ways += np.where(drives.driven, roundings(4, size), 0.0)
    n = len(given.T)
    found = np.empty((n, 6)), np.empty(n), np.empty(n)
    _, first, index = np.unique(
        given.q[:, drives.moved], axis=0, return_index=True, return_inverse=True
    )
    for k, q in enumerate(given.q[first]):
        rows = np.flatnonzero(index.ravel() == k)
        part = replace(
            given,
            R=given.R[rows],
            T=given.T[rows],
            point=given.point[rows],
            jacobian=given.jacobian[rows],
        )
        there = drives.with_points_at(q)
        for whole, bound in zip(found, _bounds(there, part, limits + ways), strict=True):
            whole[rows] = bound
    return found


def _bounds(instance: Instance, given: Wrenches, limits: Array) -> tuple[Array, Array, Array]:
    """Return proved bounds of each error (n, 6), of the rotation and of the distance (n,)."""
    platform = MovingPlatform(apart(instance), LocalFrames.none())
    values = platform.internal(values_at(instance, given.R, given.T))
    points = platform.points(given.R, given.T)
    box = Neighbourhood(platform, points, values).box(platform.internal(limits))
    e = points[:, :4]
    size = np.linalg.norm(e, axis=1)
    least = np.where(box.measure < 1, size - box.radius, np.nan)
    # The vector part of e conj(e0) / |e0| is |e| n sin(angle / 2), and zero at e0.
    units = np.eye(4)[None]
    turning = quaternion_product(units, conjugate(e / size[:, None])[:, None])[..., 1:]
    rows = np.concatenate((np.swapaxes(turning, 1, 2), np.zeros((len(e), 3, 4))), axis=2)
    change = box.change
    moved = change.under(rows[:, None])
    lin, rest = moved.lin[:, 0], moved.rad[:, 0]
    parts, whole = np.abs(lin).sum(axis=2) + rest[:, None], _worst(lin) + rest
    with np.errstate(invalid="ignore"):
        half = np.arcsin(np.minimum(whole / least, 1.0))
        turn = 2 * half
        # The ratio of the angle to twice the sine of its half.
        more = np.where(half > 0, half / np.maximum(np.sin(half), 1e-300), 1.0)
        turns = 2 * parts / least[:, None] * more[:, None]
    shift, shifts = _shifts(platform, given, points, change, box.radius, least)
    every = np.concatenate((turns, shifts), axis=1)
    return tuple(  # type: ignore[return-value]
        np.where(np.isfinite(bound), bound * (1 + 1e-9) + 1e-15, np.inf)
        for bound in (every, turn, shift)
    )


def _worst(lin: Array) -> Array:
    """Return the largest norm of linear functions on a cube, at a corner, ``(n, m, 6) -> (n,)``."""
    worst: Array = np.linalg.norm(np.einsum("njk,sk->nsj", lin, SIGNS), axis=2).max(axis=1)
    return worst


def _shifts(
    platform: MovingPlatform,
    given: Wrenches,
    points: Array,
    change: Enclosure,
    radius: Array,
    least: Array,
) -> tuple[Array, Array]:
    """Bound the distance and the coordinates by which the point moves, (n,) and (n, 3).

    With P the quadric of N p for the coordinate p of the point, p - p0 = (P - p0 N) / N.
    """
    scale = platform.equations.scale
    at = (given.point - given.T) / scale
    arm = apply(np.swapaxes(given.R, 1, 2), at)
    position = given.point / scale
    hessians = np.zeros((len(points), 3, 8, 8))
    turning = np.einsum("nj,ijkl->nikl", arm, ROTATION_FORMS.reshape(3, 3, 4, 4))
    hessians[..., :4, :4] = turning + np.swapaxes(turning, -1, -2)
    hessians[..., :4, 4:] = TRANSLATION_FORMS
    hessians[..., 4:, :4] = np.swapaxes(TRANSLATION_FORMS, -1, -2)
    hessians[..., :4, :4] -= 2 * position[..., None, None] * np.eye(4)
    matrix = Matrix.exact(hessians, roundings(1, np.linalg.norm(hessians, axis=(2, 3))))
    jet = Jet.quadric(matrix, Enclosure(points[:, None]))
    moved = (jet.value + jet.gradient.dot(change)).widened(matrix.most * radius[:, None] ** 2 / 2)
    lin, rest = moved.lin[..., 0, :], np.abs(moved.mid[..., 0]) + moved.rad
    with np.errstate(invalid="ignore"):
        each = (np.abs(lin).sum(axis=2) + rest) / (least**2)[:, None]
        whole = (_worst(lin) + np.linalg.norm(rest, axis=1)) / least**2
    return whole * scale, each * scale


@dataclass(frozen=True, eq=False)
class GeometrySlopes:
    """Derivatives of measured values by the numbers of the primitives."""

    #: The names of the m columns: ``platform.P1.x`` for a coordinate of the point of a primitive in
    #: the frame of its body; ``base.L2.tilt1`` for a small rotation of a direction or normal about
    #: one of two axes perpendicular to it.
    names: tuple[str, ...]
    #: Which columns are rotations (radians), shape (m,); the others are lengths.
    tilts: NDArray[np.bool_]
    #: Derivatives of the values of `measure` (lengths and radians), shape (..., 6, m). A primitive
    #: that several constraints share has one set of columns.
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
    """

    #: The largest error of each of rx, ry, rz, x, y, z, shape (n, 6).
    worst: Array
    #: Root mean squares for independent errors, with the tolerances as standard deviations, shape
    #: (n, 6).
    rms: Array
    #: Upper bounds, to first order, of the angle of rotation and of the distance, shape (n,).
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
