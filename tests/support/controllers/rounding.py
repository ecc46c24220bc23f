"""The equations of a controller in ball arithmetic, from the numbers of the file.

A proof of a step needs to know by how much the equations and their derivatives in doubles differ
from the exact ones (``error`` and ``slant`` in ``platform.c``). The frames, units and rounded
numbers of the program are not used here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import arb
from numpy.typing import NDArray

from gspcli.certification.numbers.balls import cross, dot
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.geometry.machine import driven_points
from gspcli.motion.following.follower import PlatformNumbers

Array = NDArray[np.float64]
Vector = list[arb]


class ExactEquations:
    """The equations of an instance as its file states them, in the unit of a controller."""

    def __init__(self, instance: Instance, numbers: PlatformNumbers) -> None:
        self._reach = arb(float(numbers.reach))
        self._middle, self._origin = (
            [arb(float(x)) for x in part] for part in (numbers.middle, numbers.origin)
        )
        radian = arb.pi() / 180 if instance.units.angle is AngleUnit.DEGREE else arb(1)
        self._rows: list[tuple[str, _Body, _Body, tuple[arb, arb, arb], arb]] = []
        for row, kind in zip(instance.constraints, numbers.kinds, strict=True):
            one, other = _Body(row.platform), _Body(row.base)
            is_angle = kind[0] == "A" or kind.endswith("CRANK")
            drive = next((one.drive for one in driven_points(row)), None)
            corrected = row if drive is None else drive
            offset = arb(0) if corrected.offset is None else corrected.offset.ball()
            factor = arb(1) if corrected.scale is None else 1 + corrected.scale.ball()
            unit = radian if is_angle else 1 / self._reach
            rod = row.value.ball() / self._reach
            self._rows.append((kind, one, other, (unit, factor, offset), rod))

    def translation(self, frame: Array, pose: Array) -> Vector:
        """Return by how much the translation of a frame is off from that of a pose."""
        R, T = (_rotation([arb(float(x)) for x in pose[3:]]), [arb(float(x)) for x in pose[:3]])
        moved = _minus(
            [a + b for a, b in zip(T, _times(R, self._middle), strict=True)], self._origin
        )
        return [arb(float(t)) - x / self._reach for t, x in zip(frame, moved, strict=False)]

    def at(self, frame: Array, values: Array) -> tuple[list[arb], list[Vector]]:
        """Return the six equations and their derivatives by a twist about the middle."""
        R, T = _rotation([arb(float(x)) for x in frame[3:]]), [arb(float(x)) for x in frame[:3]]
        F, J = [], []
        for (kind, one, other, reading, rod), value in zip(self._rows, values, strict=True):
            unit, factor, offset = reading
            c = (arb(float(value)) * factor + offset) * unit
            # The way of a slide in the file's unit.
            q = c * self._reach if kind.endswith("SLIDE") else c
            driven = "CRANK" in kind or "SLIDE" in kind
            y = one.at(q, driven and kind.startswith("PLATFORM"))
            x = other.at(q, driven and kind.startswith("BASE"))
            arm = [z / self._reach for z in _times(R, _minus(y, self._middle))]
            x = [z / self._reach for z in _minus(x, self._origin)]
            r = [a + t - b for a, t, b in zip(arm, T, x, strict=True)]
            w = _times(R, one.direction) if one.direction else []
            f, row = _equation(kind, r, arm, w, other.direction, rod if driven else c)
            F.append(f)
            J.append(row)
        return F, J


class _Body:
    """A primitive in balls: a point, a unit direction, and the circle or rail of a drive."""

    def __init__(self, geometry: Any) -> None:
        self.place = [x.ball() for x in geometry.position]
        vector = getattr(geometry, "vector", None)
        self.direction = _unit([x.ball() for x in vector]) if vector is not None else []
        crank = getattr(geometry, "crank", None)
        self._axis = _unit([x.ball() for x in crank.axis]) if crank else []
        self._centre = [x.ball() for x in crank.centre] if crank else []
        slide = getattr(geometry, "slide", None)
        self._rail = _unit([x.ball() for x in slide.direction]) if slide else []

    def at(self, angle: arb, moved: bool) -> Vector:
        """Return the point, moved by its drive."""
        if not moved:
            return self.place
        if self._rail:
            return [a + angle * x for a, x in zip(self.place, self._rail, strict=True)]
        arm = _minus(self.place, self._centre)
        along = [dot(arm, self._axis) * x for x in self._axis]
        across, flat = cross(self._axis, arm), _minus(arm, along)
        return [
            c + h + angle.cos() * a + angle.sin() * b
            for c, h, a, b in zip(self._centre, along, flat, across, strict=True)
        ]


def _equation(
    kind: str, r: Vector, arm: Vector, w: Vector, v: Vector, c: arb
) -> tuple[arb, Vector]:
    """Return the equation of a constraint and its derivative by a twist, six numbers."""
    zero = [arb(0)] * 3
    if kind[0] == "A":
        sign = -1 if kind == "AHH" else 1
        n = cross(w, v)
        cosine = c.cos() if kind in ("ALL", "AHH") else c.sin()
        return sign * dot(w, v) - cosine, [*(sign * x for x in n), *zero]
    if kind == "DPH":
        return dot(r, v) - c, [*cross(arm, v), *v]
    if kind == "DHP":
        down = [-x for x in w]
        return dot(r, down) - c, [*cross(_minus(arm, r), down), *down]
    if kind == "DLL":
        n = cross(w, v)
        sine = dot(n, n).sqrt()
        turned = cross(w, cross(v, r))
        rise = c * dot(w, v) / sine
        moment = [a + b + rise * z for a, b, z in zip(cross(arm, n), turned, n, strict=True)]
        return dot(r, n) - c * sine, [*moment, *n]
    line = w if kind == "DLP" else v if kind == "DPL" else []
    if line:
        along = dot(r, line)
        r = [x - along * z for x, z in zip(r, line, strict=True)]
        if kind == "DLP":
            arm = [x - along * z for x, z in zip(arm, line, strict=True)]
    force = [2 * x for x in r]
    return dot(r, r) - c * c, [*cross(arm, force), *force]


def _minus(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def _times(R: list[Vector], a: Vector) -> Vector:
    return [dot(row, a) for row in R]


def _unit(a: Vector) -> Vector:
    length = dot(a, a).sqrt()
    return [x / length for x in a]


def _rotation(q: list[arb]) -> list[Vector]:
    w, x, y, z = q
    n = w * w + x * x + y * y + z * z
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return [[entry / n for entry in row] for row in rows]
