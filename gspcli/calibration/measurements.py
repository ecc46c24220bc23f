"""What was measured: readings of the values, and what is known about poses.

Each sort gives residuals with their derivatives by the parameters of the model and by a twist of
each pose, divided by the standard deviation of what was measured; what was not measured is NaN.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, fields, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.model import Model
from gspcli.catalogue.kinds import DLL
from gspcli.geometry.coordinates import Body
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import Gradient, by_twist, gradients, measured
from gspcli.geometry.quaternions import cross_matrix, rotation_from_vector, vector_from_rotation
from gspcli.motion.files.value_files import nominal_values
from gspcli.records import dataclass

Array = NDArray[np.float64]

_VERTICAL = np.array([0.0, 0.0, 1.0])
#: What is exact has a deviation of this part of a length: of rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Noise:
    """Standard deviations of what is measured; lengths, and angles in radians."""

    #: Of readings of distances and of angles; value may be zero where drives have all the noise.
    value: float
    angle: float
    #: Of a coordinate of a position (or point), and of a turn of a pose about an axis; both zero if
    #: poses are exact.
    position: float
    rotation: float
    #: Of an inclination, and of the readings of cranks and slides.
    inclination: float
    crank: float
    slide: float

    @property
    def exact(self) -> bool:
        """Whether poses are exact."""
        return self.position == 0 and self.rotation == 0

    @classmethod
    def usual(cls, length: float) -> Noise:
        """Return what is assumed if nothing is said: 1e-5 of a typical length and of a radian."""
        return cls(1e-5 * length, 1e-5, 1e-5 * length, 1e-5, 1e-5, 1e-5, 1e-5 * length)

    def of_drives(self, model: Model) -> Array:
        """Return the deviations of the readings of a model's drives, shape (m,)."""
        sorts = {"crank": self.crank, "slide": self.slide}
        return np.array([sorts[drive.sort] for drive in model.drives])


class WhitenedRows(NamedTuple):
    """Residuals of n poses, whitened."""

    residual: Array
    """Shape (n, q)."""
    by_model: Array
    """By all p parameters, shape (n, q, p)."""
    by_pose: Array
    """By a twist of the pose (rotation about the platform's origin, translation), (n, q, 6)."""


@dataclass(frozen=True, eq=False)
class Measurements:
    """What was measured at n poses; NaN where it was not."""

    #: Of the values, in units of length and radians; DPH and DHP signed, shape (n, 6).
    readings: Array
    #: Shape (n, 3, 3).
    rotations: Array
    #: Of the pivot, shape (n, 3).
    positions: Array
    #: In the platform's (target's) frame, shape (3,).
    pivot: Array
    #: Points of the platform by the names of their primitives, or of the target, each (n, 3).
    points: Mapping[str, Array] = field(default_factory=dict)
    #: Where the latter are on the target, by name, each (3,).
    targets: Mapping[str, Array] = field(default_factory=dict)
    #: Angles of the platform's x and y axes above the horizontal, in radians, shape (n, 2).
    inclinations: Array = field(default_factory=lambda: np.zeros((0, 2)))
    #: Readings of the cranks and slides, in radians and lengths, a column for each, shape (n, m);
    #: None if there are none.
    drives: Array | None = None
    #: Where each row stands, for people: its t or its number, shape (n,).
    lines: tuple[str, ...] = ()
    #: The order of the axes of rx, ry, rz in degrees, if rotations were stated by them.
    euler: str = ""
    #: Which values are those of rods without readings or stay, which are constants of the machine
    #: and have no noise but that of the drives that move them, shape (6,); see `constant_rods`.
    rods: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(6, bool))
    #: Of a part of the rows: `measured_sorts` of all; None of all.
    sorts: tuple[bool, bool] | None = None
    #: Which residuals of `rows` do not count, shape (n, q); None if all do.
    left_out: NDArray[np.bool_] | None = None

    def __len__(self) -> int:
        return len(self.readings)

    @cached_property
    def measured_sorts(self) -> tuple[bool, bool]:
        """Whether rotations and positions were measured in any row."""
        if self.sorts is not None:
            return self.sorts
        return bool(np.isfinite(self.rotations).any()), bool(np.isfinite(self.positions).any())

    def taken(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> Measurements:
        """Return those of some rows, by index or mask."""
        changes = {}
        for one in fields(self):
            part = getattr(self, one.name)
            if one.name == "points":
                part = {name: seen[rows] for name, seen in part.items()}
            elif one.name == "lines":
                sliced = isinstance(rows, slice)
                part = part[rows] if sliced else tuple(np.array(part, object)[rows].tolist())
            elif (
                one.name not in ("pivot", "targets", "rods", "sorts", "euler")
                and part is not None
                and len(part)
            ):
                part = part[rows]
            changes[one.name] = part
        return replace(self, **changes)

    @cached_property
    def numbers(self) -> NDArray[np.int64]:
        """How many numbers each row has, those of drives not counted, shape (n,)."""
        parts = [self.readings, self.positions, self.rotations[:, 0], *self.points.values()]
        if len(self.inclinations):
            parts.append(self.inclinations)
        found: NDArray[np.int64] = sum(np.isfinite(part).sum(axis=1) for part in parts)
        return found

    @cached_property
    def whole(self) -> NDArray[np.bool_]:
        """Which rows have a full pose, shape (n,)."""
        there = np.isfinite(self.positions).all(axis=1)
        return np.asarray(there & np.isfinite(self.rotations).all(axis=(1, 2)))

    def rows(self, model: Model, R: Array, T: Array, noise: Noise) -> WhitenedRows:
        """Return all rows at poses; only those of values where poses are exact."""
        parts = [value_rows(model, R, T, self, noise)]
        if not noise.exact:
            turned, placed = self.measured_sorts
            if turned:
                parts.append(_rotation_rows(model, R, self.rotations, noise.rotation))
            if placed:
                parts.append(
                    _point_rows(model, R, T, self.pivot, self.positions, noise.position, moves=None)
                )
            for name, seen in self.points.items():
                at = self.targets.get(name)
                moves = name if at is None else None
                parts.append(_point_rows(model, R, T, at, seen, noise.position, moves=moves))
            if len(self.inclinations):
                parts.append(_inclination_rows(model, R, self.inclinations, noise.inclination))
        r, J, P = (np.concatenate(arrays, axis=1) for arrays in zip(*parts, strict=True))
        if self.left_out is not None:
            r = np.where(self.left_out, np.nan, r)
        return WhitenedRows(r, J, P)


def constant_rods(instance: Instance, model: Model, seen: Measurements) -> Measurements:
    """Return what was measured, with the stated values of constants that were not read.

    A leg with a crank or a slide is a rod if it has no reading in any row; and a value that stays,
    as in a tripod, is a constant, too.
    """
    unread = ~np.asarray(np.isfinite(seen.readings).any(axis=0))
    rods = unread & (Machine.of(instance).fixed | model.driven(seen.drives))
    if not rods.any():
        return seen
    readings = np.where(rods, nominal_values(instance), seen.readings)
    return replace(seen, readings=readings, rods=seen.rods | rods)


def alike(seen: Measurements, R: Array, T: Array, drives: Array | None) -> Measurements:
    """Return measurements at n poses of the sorts that were made, as they would be without errors.

    Readings and points are zero: only derivatives mean something.
    """
    n, nothing = len(R), np.nan
    readings = np.where(np.isfinite(seen.readings).any(axis=0), 0.0, nothing)
    turned = bool(np.isfinite(seen.rotations).any())
    placed = bool(np.isfinite(seen.positions).any())
    return replace(
        seen,
        readings=np.tile(readings, (n, 1)),
        rotations=R if turned else np.full((n, 3, 3), nothing),
        positions=T + R @ seen.pivot if placed else np.full((n, 3), nothing),
        points={name: np.zeros((n, 3)) for name in seen.points},
        inclinations=np.zeros((n if len(seen.inclinations) else 0, 2)),
        drives=drives,
        lines=("",) * n,
        left_out=None,
    )


def value_rows(model: Model, R: Array, T: Array, seen: Measurements, noise: Noise) -> WhitenedRows:
    """Return ``f - v (1 + s) - o`` for each reading v of each pose."""
    bodies = model.bodies(seen.drives)
    values, by = measured(bodies, R, T), gradients(bodies, bodies.placed(R, T))
    skew = [k for k, kind in enumerate(model.kinds) if kind is DLL]
    if skew:
        # Readings of the distance of two lines have no sign.
        sign = np.where(values[:, skew] < 0, -1.0, 1.0)
        values[:, skew] *= sign
        for part in by:
            part[:, skew] *= sign[..., None]
    residual = values - seen.readings * (1 + model.scales) - model.offsets
    by_model = np.zeros((*residual.shape, len(model.free)))
    for block, span in model.spans():
        for rows, moves, turns in model.displacements(block, seen.drives):
            by_point, by_unit = _in_body(by, R, block.body, rows)
            by_model[:, rows, span] = by_point @ np.swapaxes(moves, 1, 2) + by_unit @ turns.T
    at, numbers = model.geometry, np.arange(6)
    by_model[:, numbers, at + numbers] = -1
    by_model[:, numbers, at + 6 + numbers] = -seen.readings
    sigma = np.array([noise.value if kind.is_distance else noise.angle for kind in model.kinds])
    exact = _ROUNDING * np.array([model.length if x.is_distance else 1.0 for x in model.kinds])
    sigma = np.where(seen.rods & ~model.driven(seen.drives), exact, sigma)
    _, w, arm = bodies.placed(R, T)
    found = WhitenedRows(residual, by_model, by_twist(by, arm, w))
    if seen.drives is not None and model.drives:
        return _whitened(found, *_errors(model, R, by, seen, noise, sigma), model)
    weight = (1 / sigma)[:, None]
    return WhitenedRows(residual * weight[:, 0], by_model * weight, found.by_pose * weight)


def _in_body(by: Gradient, R: Array, body: Body, rows: list[int]) -> tuple[Array, Array]:
    """Return the derivatives by a point and a direction in the frame of their body, (n, k, 3)."""
    if body == "base":
        return -by.r[:, rows], by.v[:, rows]
    return by.r[:, rows] @ R, by.w[:, rows] @ R


def _errors(
    model: Model, R: Array, by: Gradient, seen: Measurements, noise: Noise, sigma: Array
) -> tuple[Array, Array]:
    """Return the deviations of values without drives, (6,), and those by their drive, (n, 6)."""
    assert seen.drives is not None
    by_reading = np.zeros(by.r.shape[:2])
    deviations, moved = noise.of_drives(model), np.zeros(len(model.kinds), bool)
    for k, point, rate in model.by_drives(seen.drives):
        rows = list(point.rows)
        by_point, _ = _in_body(by, R, point.body, rows)
        by_reading[:, rows] = deviations[k] * np.einsum("nka,na->nk", by_point, rate)
        moved[rows] = deviations[k] > 0
    exact = np.maximum(np.where(seen.rods, 0.0, sigma), _ROUNDING * model.length)
    return np.where(moved, exact, sigma), by_reading


def _whitened(rows: WhitenedRows, sigma: Array, by_reading: Array, model: Model) -> WhitenedRows:
    """Return rows whose errors are independent and have the deviation one.

    Errors of one drive are common to all legs that it moves: the covariance of their rows is
    ``S (1 + h h^T) S`` with the diagonal S of their own deviations, (6,), and its root is known;
    S h are those that come from the reading of the drive, with their signs, (n, 6).
    """
    weight = 1 / np.hypot(sigma, by_reading)
    groups = [list(drive.rows) for drive in model.drives if len(drive.rows) > 1]
    for group in groups:
        weight[:, group] = 1 / sigma[group]
    found = [part * weight.reshape(*weight.shape, *[1] * (part.ndim - 2)) for part in rows]
    for group in groups:
        # A leg without a reading has no part in the error of the others.
        there = np.isfinite(rows.residual[:, group])
        h = np.where(there, by_reading[:, group] / sigma[group], 0.0)
        square = np.einsum("nk,nk->n", h, h)
        # (1 + h h^T)^(-1/2) = 1 - factor h h^T
        root = np.sqrt(1 + square)
        factor = 1 / (root * (1 + root))
        for part in found:
            own = part[:, group].reshape(*there.shape, -1)
            common = np.einsum("nk,nka->na", h, np.where(there[..., None], own, 0.0))
            own = own - (factor[:, None] * h)[..., None] * common[:, None]
            part[:, group] = own.reshape(part[:, group].shape)
    return WhitenedRows(*found)


def _frames(model: Model) -> tuple[Array, Array, Array, Array]:
    """Return the pose of the base in the device's frame and of the target in the platform's."""
    turns = rotation_from_vector(model.frames.reshape(2, 2, 3)[:, 0])
    return turns[0], model.frames[3:6], turns[1], model.frames[9:]


def _rotation_rows(model: Model, R: Array, seen: Array, sigma: float) -> WhitenedRows:
    """Return the turns from rotations measured to those of the target in the device's frame."""
    A, _, B, _ = _frames(model)
    there = A @ R @ B
    turn = vector_from_rotation(there @ np.swapaxes(np.nan_to_num(seen, nan=0.5), 1, 2))
    turn[~np.isfinite(seen).all(axis=(1, 2))] = np.nan
    # The inverse of the left Jacobian matrix of the exponential, to its third order.
    K = cross_matrix(turn)
    inverse = np.eye(3) - K / 2 + K @ K / 12
    by_model = np.zeros((len(R), 3, len(model.free)))
    at = model.geometry + 12
    by_model[:, :, at : at + 3] = inverse @ left_jacobian(model.frames[:3])
    by_model[:, :, at + 6 : at + 9] = inverse @ A @ R @ left_jacobian(model.frames[6:9])
    by_pose = np.concatenate((inverse @ A, np.zeros((len(R), 3, 3))), axis=2)
    return WhitenedRows(turn / sigma, by_model / sigma, by_pose / sigma)


def left_jacobian(omega: Array) -> Array:
    """Return the left Jacobian matrix of the exponential: how a rotation turns with its vector."""
    angle = float(np.linalg.norm(omega))
    K = cross_matrix(omega)
    if angle < 1e-6:
        return np.asarray(np.eye(3) + K / 2)
    flat = (1 - np.cos(angle)) / angle**2
    return np.asarray(np.eye(3) + flat * K + (angle - np.sin(angle)) / angle**3 * K @ K)


def _point_rows(
    model: Model,
    R: Array,
    T: Array,
    at: Array | None,
    seen: Array,
    sigma: float,
    *,
    moves: str | None,
) -> WhitenedRows:
    """Return how far a point is from where it was seen in the device's frame, (n, 3).

    It is a point `at` in the target's frame, (3,), or that of the primitive of the platform that
    it `moves` with.
    """
    A, a, B, b = _frames(model)
    first, by_model = model.geometry + 12, np.zeros((len(R), 3, len(model.free)))
    if at is not None:
        local = B @ at + b
        by_model[:, :, first + 6 : first + 9] = (
            -A @ R @ cross_matrix(B @ at) @ left_jacobian(model.frames[6:9])
        )
        by_model[:, :, first + 9 :] = A @ R
    else:
        block, span = next(
            (block, span)
            for block, span in model.spans()
            if (block.body, block.name, block.sort) == ("platform", moves, "point")
        )
        local = block.point
        by_model[:, :, span] = A @ R @ block.shifts.T
    arm = R @ local
    place = (arm + T) @ A.T
    by_model[:, :, first : first + 3] = -cross_matrix(place) @ left_jacobian(model.frames[:3])
    by_model[:, :, first + 3 : first + 6] = np.eye(3)
    by_pose = np.concatenate((-A @ cross_matrix(arm), np.broadcast_to(A, R.shape)), axis=2)
    return WhitenedRows((place + a - seen) / sigma, by_model / sigma, by_pose / sigma)


def _inclination_rows(model: Model, R: Array, seen: Array, sigma: float) -> WhitenedRows:
    """Return how far the axes x and y of the target are from the inclinations measured."""
    A, _, B, _ = _frames(model)
    up = A.T @ _VERTICAL
    here = np.swapaxes(R, 1, 2) @ up
    sines = (here @ B)[:, :2]
    slope = 1 / np.sqrt(np.maximum(1 - sines**2, 1e-12))
    # A turn omega of R changes R^T up by R^T (up x omega), one of A likewise; one of B by B^T (up
    # x).
    by_pose = np.zeros((len(R), 2, 6))
    by_pose[:, :, :3] = (B.T @ np.swapaxes(R, 1, 2) @ cross_matrix(up))[:, :2]
    by_model = np.zeros((len(R), 2, len(model.free)))
    at = model.geometry + 12
    turned = (
        B.T @ np.swapaxes(R, 1, 2) @ A.T @ cross_matrix(_VERTICAL) @ left_jacobian(model.frames[:3])
    )
    by_model[:, :, at : at + 3] = turned[:, :2]
    by_model[:, :, at + 6 : at + 9] = (B.T @ cross_matrix(here) @ left_jacobian(model.frames[6:9]))[
        :, :2
    ]
    weight = slope[..., None] / sigma
    return WhitenedRows(
        (np.arcsin(np.clip(sines, -1, 1)) - seen) / sigma, by_model * weight, by_pose * weight
    )
