"""The structure of the shapes of legs and bodies in an instance file, as a pydantic model."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator, Field
from pydantic.json_schema import SkipJsonSchema

from gspcli.spec.document import Sequence, Value
from gspcli.spec.mass_models import Numbers, one_or_several
from gspcli.spec.sections import Real, Section, Vector, list_of

_POINTS = "a list of points [[x, y, z], ...]"


def _some(value: Value) -> Value:
    if isinstance(value, Sequence) and not value:
        message = f"found no point, expected {_POINTS}"
        raise ValueError(message)
    return value


#: Points of a body.
Hull = Annotated[list[Vector], Field(min_length=1), BeforeValidator(_some), list_of(_POINTS)]


class ShapesModel(Section):
    """The shapes of legs, cylinders with round ends, and of bodies, hulls of points."""

    diameter: Numbers = Field(
        description="Of the legs, distances of two points: one for all of them, or a list in their "
        "order.",
        json_schema_extra=one_or_several,
    )
    platform: Hull | SkipJsonSchema[None] = Field(
        None, description="Points of the platform: their convex hull is its shape."
    )
    base: Hull | SkipJsonSchema[None] = Field(
        None, description="Points of the base: their convex hull is its shape."
    )
    near_joint: Real | SkipJsonSchema[None] = Field(
        None,
        description="What of a leg is nearer to its joint is not compared with what it is joined "
        "to there. Default: legs that share a joint are not compared; a body needs it.",
    )
