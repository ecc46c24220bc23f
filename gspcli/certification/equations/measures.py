"""The stated distances and angles, measured on a pose in balls.

The distance or the angle itself is measured (paper, Section 4), not the polynomial of
`ball_system`: so each checks the other. Neither uses the floating-point statement in
`gspcli.geometry.measurement`.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import acb, arb

from gspcli.catalogue.kinds import DLL, Law
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.pose_balls import PoseBall
from gspcli.certification.equations.statement import Statement
from gspcli.certification.numbers.balls import cross, dot, largest, norm, rotated
from gspcli.records import dataclass


@dataclass(frozen=True)
class Measurement:
    """A constraint measured on a real pose, in the units of the instance.

    Attributes
    ----------
    value
        A ball of the distance or angle.
    target
        A ball of the value that the constraint states.
    height
        For PH and HP a ball of the signed distance, positive where the normal points.
    """

    value: arb
    target: arb
    height: arb | None = None


def measure(system: BallSystem, pose: PoseBall) -> list[Measurement]:
    """Measure all constraints on a real pose."""
    R = [[entry.real for entry in row] for row in pose.rotation]
    T = [entry.real for entry in pose.translation]
    return [_measure(statement, R, T) for statement in system.statements]


def _measure(given: Statement, R: list[list[arb]], T: list[arb]) -> Measurement:
    kind, target = given.kind, given.value * given.unit
    u = rotated(R, given.u) if given.u else []
    if not kind.is_distance:
        angle = _angle(u, given.v)
        if kind.law is not Law.COSINE:
            angle = (arb.pi() if kind.law.is_cosine else arb.pi() / 2) - angle
        return Measurement(angle * given.unit, target)
    w = [x + t - y for x, t, y in zip(rotated(R, given.a), T, given.b, strict=True)]
    if kind.law is Law.MOMENT:
        common = cross(u, given.v)
        return Measurement(abs(dot(w, common)) / norm(common) * given.unit, target)
    axis = u or given.v
    if kind.law is Law.SQUARE:
        distance = norm(cross(w, axis)) / norm(axis) if axis else norm(w)
        return Measurement(distance * given.unit, target)
    height = dot(w, axis) / norm(axis) * given.unit
    height = -height if u else height
    return Measurement(abs(height), target, height)


def _angle(u: list[arb], v: list[arb]) -> arb:
    """Return the angle of two vectors, in [0, pi]; it is accurate near 0 and pi, too."""
    return arb.atan2(norm(cross(u, v)), dot(u, v))


def residual(measurements: Sequence[Measurement]) -> arb:
    """Bound the largest difference of a measured and a stated value."""
    return largest([m.value - m.target for m in measurements])


def satisfies_constraints(system: BallSystem, pose: PoseBall, *, real: bool) -> bool:
    """Whether the stated constraints are proved to hold.

    Only the equation of a distance of two lines has other solutions: parallel lines at any
    distance.
    """
    if real and any(not m.value.overlaps(m.target) for m in measure(system, pose)):
        return False
    for given in system.statements:
        if given.kind is DLL:
            normal = cross(
                rotated(pose.rotation, [acb(x) for x in given.u]), list(map(acb, given.v))
            )
            if dot(normal, normal).contains(0):
                return False
    return True
