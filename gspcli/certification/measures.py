"""Poses as balls, and the constraints measured on them as they are stated.

What is measured here is the distance or the angle itself (paper, Section 4), not the polynomial
that `system` solves: a check of the one against the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ALL, ALH, AHL, DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.certification import study
from gspcli.certification.balls import (
    Ball,
    ball,
    cross,
    dot,
    largest,
    length_vector,
    norm,
    rotated,
)
from gspcli.certification.system import direction
from gspcli.geometry.instance import AngleUnit, Constraint, Instance


@dataclass(frozen=True)
class PoseBall:
    """Balls that contain a rotation, by rows, and a translation in length units."""

    rotation: list[list[acb]]
    translation: list[acb]

    @property
    def entries(self) -> list[acb]:
        """The twelve numbers."""
        return [*sum(self.rotation, []), *self.translation]

    def deviation(self, other: PoseBall, scale: float) -> arb:
        """Bound the largest difference of two poses' numbers, translations by `scale`."""
        ours, theirs = self.entries, other.entries
        turn = [x - y for x, y in zip(ours[:9], theirs[:9], strict=True)]
        shift = [(x - y) / scale for x, y in zip(ours[9:], theirs[9:], strict=True)]
        return largest(turn + shift)


def pose_of_point(point: Sequence[acb], scale: float) -> PoseBall | None:
    """Return the pose of a Study point, or None if N is not proved to differ from zero."""
    n, rotation, translation = study.motion(point)
    if n.contains(0):
        return None
    unit = 1 / n
    factor = unit * scale
    return PoseBall(
        [[entry * unit for entry in row] for row in rotation],
        [entry * factor for entry in translation],
    )


def pose_of_floats(R: NDArray[np.complex128], T: NDArray[np.complex128]) -> PoseBall:
    """Return a pose whose numbers are given, exactly: shapes (3, 3) and (3,)."""
    return PoseBall([[acb(x) for x in row] for row in R.tolist()], [acb(x) for x in T.tolist()])


@dataclass(frozen=True)
class Measurement:
    """A constraint measured on a real pose, in the units of the instance.

    Attributes
    ----------
    value
        A ball of the distance or angle.
    stated
        A ball of the value that the constraint states.
    height
        For PH and HP a ball of the signed distance, positive where the normal points.
    """

    value: arb
    stated: arb
    height: arb | None = None


def measure(instance: Instance, pose: PoseBall) -> list[Measurement]:
    """Measure all constraints on a real pose."""
    R = [[entry.real for entry in row] for row in pose.rotation]
    T = [entry.real for entry in pose.translation]
    return [_measure(constraint, instance.units.angle, R, T) for constraint in instance.constraints]


def _measure(
    constraint: Constraint, unit: AngleUnit, R: list[list[arb]], T: list[arb]
) -> Measurement:
    kind, stated = constraint.kind, ball(constraint.value)
    if not kind.is_distance:
        u, v = rotated(R, direction(constraint.platform)), direction(constraint.base)
        angle = _angle(u, v)
        if kind in (ALH, AHL):
            angle = arb.pi() / 2 - angle
        elif kind is not ALL:
            angle = arb.pi() - angle
        if unit is AngleUnit.DEGREE:
            angle = angle * 180 / arb.pi()
        return Measurement(angle, stated)
    a = length_vector(constraint.platform.position, arb(1))
    b = length_vector(constraint.base.position, arb(1))
    w = [x + t - y for x, t, y in zip(rotated(R, a), T, b, strict=True)]
    if kind is DPP:
        return Measurement(norm(w), stated)
    if kind in (DPL, DPH):
        along = direction(constraint.base)
    else:
        along = rotated(R, direction(constraint.platform))
    if kind in (DPL, DLP):
        return Measurement(norm(cross(w, along)) / norm(along), stated)
    if kind in (DPH, DHP):
        height = dot(w, along) / norm(along)
        height = height if kind is DPH else -height
        return Measurement(abs(height), stated, height)
    common = cross(along, direction(constraint.base))
    return Measurement(abs(dot(w, common)) / norm(common), stated)


def _angle(u: list[Ball], v: list[Ball]) -> arb:
    """Return the angle of two vectors, in [0, pi]; good near 0 and pi too."""
    return arb.atan2(norm(cross(u, v)), dot(u, v))


def residual(measurements: Sequence[Measurement]) -> arb:
    """Bound the largest difference between what is measured and what is stated."""
    return largest([m.value - m.stated for m in measurements])
