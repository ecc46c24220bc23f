"""The structure of an instance file as pydantic models; `docs/` has their JSON Schema.

Their parts, and the way in which mistakes are noted, are in `sections`.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo, WithJsonSchema
from pydantic.json_schema import SkipJsonSchema

from gspcli.errors import Mistake
from gspcli.geometry.numbers import Number
from gspcli.spec import entries
from gspcli.spec.document import Mapping, Sequence, Value
from gspcli.spec.entries import MAX_NAME, complain, proper_name, version
from gspcli.spec.mass_models import DynamicsModel, Numbers, one_or_several
from gspcli.spec.sections import (
    Direction,
    OptionalText,
    Real,
    Section,
    Text,
    Tolerant,
    Vector,
    choice_of,
    list_of,
    mistakes_of,
)
from gspcli.wording import shown

_NAME_PATTERN = rf"^\S{{1,{MAX_NAME}}}$"
_NAMES: dict[str, Any] = {"propertyNames": {"pattern": _NAME_PATTERN}}
Named = Annotated[
    str,
    BeforeValidator(entries.name),
    WithJsonSchema({"type": "string", "pattern": _NAME_PATTERN}),
]

Range = Annotated[
    list[Real], Field(min_length=2, max_length=2), list_of("two numbers [low, high]", 2)
]
#: A number, or None for ``home``.
RealOrHome = Annotated[
    Number | None,
    BeforeValidator(entries.number_or_home),
    WithJsonSchema(
        {
            "type": ["number", "string"],
            "description": "A number, exactly as written, or an expression such as sqrt(3)/2; or "
            "home: what the constraint measures at the home pose.",
        }
    ),
]
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


def _body(value: Value, info: ValidationInfo) -> Mapping:
    if not isinstance(value, Mapping):
        raise complain(value, "a mapping of names to primitives")
    for name in value:
        if not proper_name(name):
            message = (
                f"found the name {shown(name)}, expected at most {MAX_NAME} characters, no blanks"
            )
            mistakes_of(info).append(Mistake(name.location, name.path, message))
    return value


def _turn(axis: str) -> Any:
    return Field(None, description=f"The angle about {axis}, with euler. Default: 0.")


class UnitsModel(Section):
    """The units of all numbers in the file."""

    length: Text = Field(description="The unit of length, by any name.")
    angle: Annotated[Literal["deg", "rad"], choice_of("deg", "rad")] = Field(
        description="The unit of angle values."
    )


class LineModel(Section):
    """A line: a point on it and its direction, a nonzero vector of any length."""

    point: Vector
    direction: Direction


class PlaneModel(Section):
    """A plane: a point in it and its normal, a nonzero vector; it points to the positive side."""

    point: Vector
    normal: Direction


class ConeModel(Section):
    """How far a joint can tilt: the directions of its legs, at most the half angle off the axis."""

    axis: Direction
    half_angle: Real = Field(description="Above 0 and below 180 degrees, in the unit of angles.")


class DriveModel(Section):
    """What cranks and slides can state of the values of their motors."""

    range: Range | SkipJsonSchema[None] = Field(
        None, description="The least and the greatest reading; 0 is where the point is stated."
    )
    tolerance: Real | SkipJsonSchema[None] = Field(
        None, description="How far the value may be off, at least zero."
    )
    offset: Real | SkipJsonSchema[None] = Field(
        None, description="What is added to readings to make them values. Default: 0."
    )
    scale: Real | SkipJsonSchema[None] = Field(
        None,
        description="Readings are multiplied by one plus this before the offset is added; "
        "between -1 and 1. Default: 0.",
    )


class CrankModel(DriveModel):
    """The arm of a motor, which turns a point about an axis; angles in the unit of angles."""

    centre: Vector = Field(description="A point of the axis.")
    axis: Direction = Field(description="Positive angles turn about it by the right-hand rule.")
    diameter: Real | SkipJsonSchema[None] = Field(
        None, description="Of the arm, a cylinder with round ends from the axis to the point."
    )


class SlideModel(DriveModel):
    """The carriage of a rail, which moves a point along a line."""

    direction: Direction = Field(description="Along the rail; positive values move along it.")


class PrimitiveModel(Section):
    """A point, a line or a plane, in the frame of its body."""

    one_of = ("point", "line", "plane")
    needs: ClassVar[dict[str, str]] = dict.fromkeys(("crank", "slide", "with", "cone"), "point")
    excludes = (("slide", "crank"), ("with", "crank"), ("with", "slide"))

    point: Vector | SkipJsonSchema[None] = None
    line: LineModel | SkipJsonSchema[None] = None
    plane: PlaneModel | SkipJsonSchema[None] = None
    crank: CrankModel | SkipJsonSchema[None] = Field(
        None, description="What turns the point, which is stated at the angle zero."
    )
    slide: SlideModel | SkipJsonSchema[None] = Field(
        None, description="What moves the point along a rail; it is stated at zero."
    )
    partner: Named | SkipJsonSchema[None] = Field(
        None,
        alias="with",
        description="A point of the same body whose crank or slide moves this one, too.",
    )
    cone: ConeModel | SkipJsonSchema[None] = Field(
        None, description="Of a point: which directions the point-point distances from it can have."
    )


Pair = Annotated[
    list[Named],
    Field(min_length=2, max_length=2),
    list_of("two names: [platform's primitive, base's primitive]", 2),
]


class ConstraintModel(Section):
    """A distance or an angle between a primitive of the platform and one of the base."""

    one_of = ("distance", "angle")

    distance: Pair | SkipJsonSchema[None] = None
    angle: Pair | SkipJsonSchema[None] = None
    value: RealOrHome
    range: Range | SkipJsonSchema[None] = Field(
        None, description="The smallest and the largest value that the machine can have there."
    )
    tolerance: Real | SkipJsonSchema[None] = Field(
        None, description="How far the machine's value may be off, at least zero."
    )
    offset: Real | SkipJsonSchema[None] = Field(
        None,
        description="What is added to value and range to make them the distance or angle itself; "
        "a calibration finds it. Default: 0.",
    )
    scale: Real | SkipJsonSchema[None] = Field(
        None,
        description="Value and range are multiplied by one plus this before the offset is added; "
        "between -1 and 1. Default: 0.",
    )
    side: Annotated[
        Literal["positive", "negative", "both"] | SkipJsonSchema[None],
        choice_of("positive", "negative", "both"),
    ] = Field(None, description="The side of the plane on which the point lies. Default: both.")


Body = Annotated[dict[str, Tolerant[PrimitiveModel]], BeforeValidator(_body)]


Quaternion = Annotated[
    list[Real] | SkipJsonSchema[None],
    Field(min_length=4, max_length=4),
    list_of("four numbers [w, x, y, z]", 4),
    AfterValidator(entries.turning),
]
_MAKERS = "PI|pi|LinuxCNC|linuxcnc|Symetrie|symetrie|Symétrie|symétrie"
Order = Annotated[
    str | SkipJsonSchema[None],
    BeforeValidator(entries.axes),
    WithJsonSchema({"type": "string", "pattern": f"^([xyz]{{3}}|[XYZ]{{3}}|{_MAKERS})$"}),
]
#: Angles need the order of their axes, and are given instead of a quaternion.
_ORDERED = {"rx": "euler", "ry": "euler", "rz": "euler"}
_EITHER = (("quaternion", "euler"),)


class HomeModel(Section):
    """The pose of the machine at home: x_base = R x_platform + position."""

    needs: ClassVar[dict[str, str]] = _ORDERED
    excludes = _EITHER

    position: Vector = Field(description="Of the platform's origin in the base.")
    quaternion: Quaternion = Field(
        None, description="The rotation R, of any length but zero. Default: no turn."
    )
    rx: Real | SkipJsonSchema[None] = _turn("x")
    ry: Real | SkipJsonSchema[None] = _turn("y")
    rz: Real | SkipJsonSchema[None] = _turn("z")
    euler: Order = Field(
        None,
        description="The order of the axes of rx, ry and rz: capitals turn with the platform, "
        "small letters about the axes of the base.",
    )


class FrameModel(Section):
    """A frame that is fixed in a body: x_body = R x_frame + point."""

    needs: ClassVar[dict[str, str]] = _ORDERED
    excludes = _EITHER

    point: Vector = Field(description="Its origin, in the frame of the body.")
    quaternion: Quaternion = Field(
        None, description="Its rotation R, of any length but zero. Default: no turn."
    )
    rx: Real | SkipJsonSchema[None] = _turn("x")
    ry: Real | SkipJsonSchema[None] = _turn("y")
    rz: Real | SkipJsonSchema[None] = _turn("z")
    euler: Order = Field(
        None,
        description="The order of the axes of rx, ry and rz: capitals turn about the axes of the "
        "frame, small letters about those of the body.",
    )


class FramesModel(Section):
    """The frames in which commands read and print poses: the tool's in the work frame."""

    tool: FrameModel | SkipJsonSchema[None] = Field(
        None, description="A frame of the platform. Default: its own."
    )
    work: FrameModel | SkipJsonSchema[None] = Field(
        None, description="A frame of the base. Default: its own."
    )


class InstanceModel(Section):
    """A generalized Stewart platform with numbers."""

    gsp: Tolerant[Annotated[Literal[1], BeforeValidator(version)]] = Field(
        description="The version of the file format."
    )
    name: Tolerant[OptionalText] = Field(None, description="A name of the instance.")
    source: Tolerant[OptionalText] = Field(None, description="Where the numbers come from.")
    type: Tolerant[OptionalText] = Field(
        None,
        description="The type of the platform: six kinds in any spelling, or its number; checked.",
        json_schema_extra={"type": ["string", "integer"]},
    )
    units: Tolerant[UnitsModel]
    platform: Tolerant[Body] = Field(
        description="The primitives of the moving platform.", json_schema_extra=_NAMES
    )
    base: Tolerant[Body] = Field(
        description="The primitives of the base.", json_schema_extra=_NAMES
    )
    constraints: Tolerant[
        Annotated[list[Tolerant[ConstraintModel]], list_of("a list of six constraints")]
    ] = Field(
        description="Six distances and angles, the platform's primitive first.",
        json_schema_extra={"minItems": 6, "maxItems": 6},
    )
    dynamics: Tolerant[DynamicsModel] = Field(
        None, description="Masses, inertias and drives, for forces and natural frequencies."
    )
    home: Tolerant[HomeModel] = Field(
        None, description="The pose at home: the real pose nearest to it is the home mode."
    )
    frames: Tolerant[FramesModel] = Field(
        None, description="The frames in which commands read and print poses."
    )
    readings: Tolerant[Annotated[list[Tolerant[Text]], list_of("a list of readings")]] = Field(
        None,
        description="What further sensors read at the pose of the values, such as "
        "'leg P7 B7 = 212.4 ± 0.1': for gsp solve --fit.",
    )
    shapes: Tolerant[ShapesModel] = Field(
        None, description="The diameters of legs and the hulls of bodies, for gaps between them."
    )
