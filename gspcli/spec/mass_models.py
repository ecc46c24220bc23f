"""The structure of masses, inertias and drives in an instance file, as pydantic models."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field
from pydantic.json_schema import SkipJsonSchema

from gspcli.spec.document import Sequence, Value, locate
from gspcli.spec.sections import Direction, Real, Section, Tolerant, Vector, list_of


def _several(value: Value) -> Value:
    """Return a list unchanged, and anything else as a list of one."""
    if isinstance(value, Sequence):
        return value
    return locate(Sequence([value]), value.location, value.path)


def one_or_several(schema: dict[str, Any]) -> None:
    """Allow one entry without brackets in the schema of a list."""
    listed = {key: schema.pop(key) for key in ("type", "items")}
    schema["anyOf"] = [listed["items"], listed]


#: One number, or a list of numbers.
Numbers = Annotated[list[Real], BeforeValidator(_several)]


class RigidBodyModel(Section):
    """A rigid body, in the frame of the platform."""

    mass: Real = Field(description="In kilogrammes.")
    centre: Vector = Field(description="The centre of mass.")
    inertia: Annotated[
        list[Real],
        Field(min_length=6, max_length=6),
        list_of("six numbers [xx, yy, zz, xy, xz, yz]", 6),
    ] = Field(
        description="The matrix of inertia about the centre of mass, in kilogrammes times the "
        "square of the unit of length: entries xx, yy, zz, xy, xz, yz."
    )


class LegBodyModel(Section):
    """One of the two bodies of a leg."""

    mass: Real = Field(description="In kilogrammes.")
    centre: Real = Field(description="From its joint to the centre of mass, along the leg.")
    inertia: Real | SkipJsonSchema[None] = Field(
        None, description="About axes through the centre of mass, across the leg. Default: 0."
    )
    axial: Real | SkipJsonSchema[None] = Field(
        None, description="About the leg itself. Default: 0."
    )


class LegModel(Section):
    """The bodies of a leg: the cylinder at the base, the rod at the platform."""

    cylinder: LegBodyModel | SkipJsonSchema[None] = None
    rod: LegBodyModel | SkipJsonSchema[None] = None
    universal: Direction | SkipJsonSchema[None] = Field(
        None,
        description="The first axis of the joint at the base, a vector of any length, if it is a "
        "universal joint. Default: the leg does not spin about itself.",
    )


class ArmModel(Section):
    """The arm of a crank."""

    mass: Real = Field(description="In kilogrammes.")
    centre: Real = Field(
        description="From the axis to the centre of mass, along the arm; negative for a "
        "counterweight."
    )
    inertia: Real | SkipJsonSchema[None] = Field(
        None, description="About its centre of mass, parallel to the axis. Default: 0."
    )


class CarriageModel(Section):
    """The carriage of a slide."""

    mass: Real = Field(description="In kilogrammes.")


class DrivesModel(Section):
    """What drives the values, cranks and slides: one number for all, or one for each drive."""

    inertia: Numbers | SkipJsonSchema[None] = Field(
        None,
        description="What each adds to the inertia of what it moves. Default: 0.",
        json_schema_extra=one_or_several,
    )
    stiffness: Numbers | SkipJsonSchema[None] = Field(
        None,
        description="How stiff each holds its length or angle, N/m or N m/rad.",
        json_schema_extra=one_or_several,
    )


class DynamicsModel(Section):
    """What a platform weighs and what drives it."""

    gravity: Vector | SkipJsonSchema[None] = Field(
        None,
        description="The acceleration of what falls, in the axes of the base, m/s^2. "
        "Default: [0, 0, -9.81].",
    )
    platform: RigidBodyModel = Field(description="The moving platform.")
    legs: Annotated[list[Tolerant[LegModel]], BeforeValidator(_several)] | SkipJsonSchema[None] = (
        Field(
            None,
            description="The legs, distances of two points: one for all of them, or a list in "
            "their order.",
            json_schema_extra=one_or_several,
        )
    )
    drives: DrivesModel | SkipJsonSchema[None] = Field(None, description="The drives.")
    arms: Annotated[list[Tolerant[ArmModel]], BeforeValidator(_several)] | SkipJsonSchema[None] = (
        Field(
            None,
            description="The arms of cranks: one for all of them, or a list in the order of the "
            "constraints.",
            json_schema_extra=one_or_several,
        )
    )
    carriages: (
        Annotated[list[Tolerant[CarriageModel]], BeforeValidator(_several)] | SkipJsonSchema[None]
    ) = Field(
        None,
        description="The carriages of slides, likewise.",
        json_schema_extra=one_or_several,
    )
