"""Cones of joints along a trajectory, as quadrics that are positive if a leg keeps its cone.

The length of a leg (DPP) is its value. So it is within its cone if and only if its height along the
axis is at least the value times the cosine of the half angle. Times N this is a quadric like that
of a distance to a plane, with coefficients that move like those of the equations (`taylor`).
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb

from gspcli.certification.branches.parametric_quadrics import Equation, Shape, ValueFunction
from gspcli.certification.branches.taylor import Element, MovingSystem
from gspcli.certification.equations.quadratic_forms import base_height, platform_height, scaled
from gspcli.certification.numbers.balls import ball, norm
from gspcli.geometry.coordinates import Coordinate
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import JointCone, joint_cones


class MovingCones(MovingSystem):
    """The quadrics of the cones of an instance: positive where a leg keeps its cone.

    Distances must not be negative.

    Parameters
    ----------
    instance, chosen
        As for `MovingSystem`.
    """

    def __init__(self, instance: Instance, chosen: Sequence[Coordinate]) -> None:
        #: In the order of the quadrics.
        self.cones = joint_cones(instance)
        super().__init__(instance, chosen)

    def _all(
        self, values: Sequence[Element], moving: dict[Coordinate, Element]
    ) -> list[tuple[Equation, Element]]:
        return [self._cone(joint, values[joint.constraint], moving) for joint in self.cones]

    def _cone(
        self, joint: JointCone, value: Element, moving: dict[Coordinate, Element]
    ) -> tuple[Equation, Element]:
        row = self.instance.constraints[joint.constraint]
        a, _ = self._placed("platform", row.platform_name, row.platform, moving)
        b, _ = self._placed("base", row.base_name, row.base, moving)
        given = [ball(number) for number in joint.cone.axis]
        axis = [entry / norm(given) for entry in given]
        end, name = (
            (row.base, row.base_name) if joint.body == "base" else (row.platform, row.platform_name)
        )
        axis = self._with_arm(joint.body, name, end, axis, moving)
        # The direction of the leg is away from the joint.
        height = (
            base_height(a, b, axis)
            if joint.body == "base"
            else scaled(platform_height(a, b, axis), arb(-1))
        )
        cosine = (ball(joint.cone.half_angle) * self._unit).cos()
        return (Shape.PLAIN, ValueFunction.LINEAR, 1.0, [height]), cosine * value / arb(self.scale)
