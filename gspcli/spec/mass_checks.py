"""Checks of masses beyond the structure of a file: possible bodies, numbers of legs, units."""

from __future__ import annotations

from collections.abc import Sequence as List
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from gspcli.errors import Mistake
from gspcli.geometry.instance import Constraint
from gspcli.geometry.mass_mistakes import mistakes
from gspcli.geometry.masses import (
    GRAVITY,
    Arm,
    Carriage,
    Drives,
    Dynamics,
    Leg,
    LegBody,
    RigidBody,
)
from gspcli.spec.document import Mapping, Sequence
from gspcli.spec.plain import DynamicsFields, LegBodyFields, LegFields

if TYPE_CHECKING:
    from gspcli.spec.mass_models import DynamicsModel, LegBodyModel, LegModel

    #: The content of masses, read by `plain` or by `mass_models`.
    AnyDynamics: TypeAlias = DynamicsModel | DynamicsFields
    AnyLeg: TypeAlias = LegModel | LegFields
    AnyLegBody: TypeAlias = LegBodyModel | LegBodyFields

Given = TypeVar("Given")


def dynamics_of(model: AnyDynamics | None) -> Dynamics | None:
    """Return the masses in a file; None if there are none, or they cannot be read."""
    if model is None:
        return None
    if any(None in (part or ()) for part in (model.legs, model.arms, model.carriages)):
        return None
    body, drives = model.platform, model.drives
    return Dynamics(
        RigidBody(body.mass, body.centre, body.inertia),
        [_leg(leg) for leg in model.legs or () if leg is not None],
        None if drives is None else Drives(_or_zero(drives.inertia), drives.stiffness),
        GRAVITY if model.gravity is None else model.gravity,
        [Arm(arm.mass, arm.centre, _or_zero(arm.inertia)) for arm in model.arms or () if arm],
        [Carriage(one.mass) for one in model.carriages or () if one is not None],
    )


def _or_zero(stated: Given | None) -> Given | int:
    return 0 if stated is None else stated


def _leg(model: AnyLeg) -> Leg:
    return Leg(_leg_body(model.cylinder), _leg_body(model.rod), model.universal)


def _leg_body(model: AnyLegBody | None) -> LegBody | None:
    if model is None:
        return None
    return LegBody(model.mass, model.centre, _or_zero(model.inertia), _or_zero(model.axial))


def mistakes_of_masses(
    root: Mapping, dynamics: Dynamics, rows: List[Constraint], length: str
) -> list[Mistake]:
    """Return the mistakes in the masses of a file, each with its place."""
    found = []
    for place, message in mistakes(dynamics, rows, length):
        node: Any = root
        for part in place:
            if isinstance(node, Sequence) and isinstance(part, str):
                # One leg for all, in brackets.
                (node,) = node
            node = node[part]
        found.append(Mistake(node.location, node.path, message))
    return found
