"""The shape of an instance file as pydantic models; their JSON Schema is published in `docs/`.

A broken element never hides the mistakes in another: it is noted with its place in the list that is
given as the validation context, and None stands in for it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)
from pydantic.json_schema import SkipJsonSchema

from gspcli.errors import Problem
from gspcli.geometry.numbers import Number
from gspcli.spec import entries
from gspcli.spec.document import Mapping, Missing, Scalar, Sequence, Value, locate
from gspcli.spec.entries import (
    MAX_NAME,
    complain,
    found,
    nonzero,
    number,
    optional_text,
    proper_name,
    text,
    version,
)
from gspcli.wording import listed, nearest, shown, suggestion

Item = TypeVar("Item")


def note(error: ValidationError, problems: list[Problem]) -> None:
    """Add the problems of a validation error, each at the place of the value it is about."""
    for detail in error.errors(include_url=False):
        value = detail["input"]
        # None stands in for optional and for broken elements only; no file contains it.
        if isinstance(value, Missing) or detail["type"] == "none_required":
            continue
        cause = detail.get("ctx", {}).get("error")
        message = str(cause) if cause else detail["msg"]
        problems.append(Problem(value.location, value.path, message))


def _problems(info: ValidationInfo) -> list[Problem]:
    problems: list[Problem] = info.context  # type: ignore[assignment]
    return problems


def _tolerate(value: Any, handler: Callable[[Any], Item], info: ValidationInfo) -> Item | None:
    try:
        return handler(value)
    except ValidationError as error:
        note(error, _problems(info))
        return None


Tolerant = Annotated[Item | SkipJsonSchema[None], WrapValidator(_tolerate)]


def _list(expected: str, length: int | None = None) -> BeforeValidator:
    """Check that a value is a list, of a certain length."""

    def check(value: Value) -> Value:
        if not isinstance(value, Sequence):
            raise complain(value, expected)
        if length is not None and len(value) != length:
            entries = "1 entry" if len(value) == 1 else f"{len(value)} entries"
            message = f"found {entries}, expected {expected}"
            raise ValueError(message)
        return value

    return BeforeValidator(check)


def _body(value: Value, info: ValidationInfo) -> Mapping:
    if not isinstance(value, Mapping):
        raise complain(value, "a mapping of names to primitives")
    for name in value:
        if not proper_name(name):
            message = (
                f"found the name {shown(name)}, expected at most {MAX_NAME} characters, no blanks"
            )
            _problems(info).append(Problem(name.location, name.path, message))
    return value


def _one_of(*choices: str) -> BeforeValidator:
    def check(value: Value) -> str:
        if value not in choices:
            near = suggestion(value, choices) if isinstance(value, Scalar) else ""
            message = f"found {found(value)}, expected {listed(choices)}{near}"
            raise ValueError(message)
        return str(value)

    return BeforeValidator(check)


Text = Annotated[str, BeforeValidator(text)]
OptionalText = Annotated[str | SkipJsonSchema[None], BeforeValidator(optional_text)]
_NAME_PATTERN = rf"^\S{{1,{MAX_NAME}}}$"
_NAMES: dict[str, Any] = {"propertyNames": {"pattern": _NAME_PATTERN}}
Named = Annotated[
    str,
    BeforeValidator(entries.name),
    WithJsonSchema({"type": "string", "pattern": _NAME_PATTERN}),
]
Real = Annotated[
    Number,
    BeforeValidator(number),
    WithJsonSchema(
        {
            "type": ["number", "string"],
            "description": "A number, exactly as written, or an expression such as sqrt(3)/2.",
        }
    ),
]
Vector = Annotated[
    list[Real], Field(min_length=3, max_length=3), _list("three numbers [x, y, z]", 3)
]
Direction = Annotated[Vector, AfterValidator(nonzero)]


def _schema_of(schema: dict[str, Any], model: type[Section]) -> None:
    if model.one_of:
        schema["oneOf"] = [{"required": [key]} for key in model.one_of]
    for entry in schema["properties"].values():
        entry.pop("default", None)
        entry.pop("title", None)
    if model.needs:
        schema["dependentRequired"] = {key: [other] for key, other in model.needs.items()}


class Section(BaseModel):
    """A mapping with known keys.

    Attributes
    ----------
    one_of
        Keys of which exactly one must be given.
    needs
        Keys that make sense only beside another one.
    """

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        arbitrary_types_allowed=True,
        json_schema_extra=_schema_of,
        defer_build=True,
    )
    one_of: ClassVar[tuple[str, ...]] = ()
    needs: ClassVar[dict[str, str]] = {}

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, section: Value, info: ValidationInfo) -> Mapping:
        """Note wrong keys and return the section without them; `Missing` where one lacks."""
        known = list(cls.model_fields)
        if not isinstance(section, Mapping):
            keys = listed(cls.one_of) if cls.one_of else listed(known, "and")
            raise complain(section, f"a mapping with {keys}")
        problems = _problems(info)
        kept, misspelt = Mapping(), set()
        for key, value in section.items():
            if key in known:
                kept[key] = value
                continue
            near = nearest(key, [name for name in known if name not in section])
            misspelt.add(near)
            hint = f": did you mean {near}?" if near else ""
            message = f"found the unknown key {shown(key)}, expected {listed(known)}{hint}"
            problems.append(Problem(key.location, key.path, message))
        required = [name for name, field in cls.model_fields.items() if field.is_required()]
        absent = [name for name in required if name not in kept]
        for name in absent:
            kept[Scalar(name)] = locate(Missing(), section.location, section.path)
        if unnamed := [name for name in absent if name not in misspelt]:
            words = (
                f"key {unnamed[0]} is"
                if len(unnamed) == 1
                else f"keys {listed(unnamed, 'and')} are"
            )
            problems.append(Problem(section.location, section.path, f"the {words} missing"))
        given = [name for name in cls.one_of if name in kept]
        if len(given) > 1 or (cls.one_of and not given and not misspelt & set(cls.one_of)):
            what = listed(given, "and") if given else "none of them"
            message = f"found {what}, expected exactly one of {listed(cls.one_of)}"
            problems.append(Problem(section.location, section.path, message))
        for needy, other in cls.needs.items():
            if needy in kept and other not in kept and given:
                place = kept[Scalar(needy)]
                message = f"found a {needy} at a {given[0]}, expected one only at a {other}"
                problems.append(Problem(place.location, place.path, message))
        return locate(kept, section.location, section.path)


class UnitsModel(Section):
    """The units of all numbers in the file."""

    length: Text = Field(description="The unit of length, by any name.")
    angle: Annotated[Literal["deg", "rad"], _one_of("deg", "rad")] = Field(
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


class CrankModel(Section):
    """What turns a point: a point of the axis, and a nonzero vector along it."""

    centre: Vector
    axis: Direction


class PrimitiveModel(Section):
    """A point, a line or a plane, in the frame of its body."""

    one_of = ("point", "line", "plane")
    needs = {"crank": "point", "cone": "point"}

    point: Vector | SkipJsonSchema[None] = None
    line: LineModel | SkipJsonSchema[None] = None
    plane: PlaneModel | SkipJsonSchema[None] = None
    crank: CrankModel | SkipJsonSchema[None] = Field(
        None, description="What turns the point, which is stated at the angle zero."
    )
    cone: ConeModel | SkipJsonSchema[None] = Field(
        None, description="Of a point: which directions the point-point distances from it can have."
    )


Pair = Annotated[
    list[Named],
    Field(min_length=2, max_length=2),
    _list("two names: [platform's primitive, base's primitive]", 2),
]


class ConstraintModel(Section):
    """A distance or an angle between a primitive of the platform and one of the base."""

    one_of = ("distance", "angle")

    distance: Pair | SkipJsonSchema[None] = None
    angle: Pair | SkipJsonSchema[None] = None
    value: Real
    range: Annotated[
        list[Real] | SkipJsonSchema[None],
        Field(min_length=2, max_length=2),
        _list("two numbers [low, high]", 2),
    ] = Field(
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
    side: Annotated[
        Literal["positive", "negative", "both"] | SkipJsonSchema[None],
        _one_of("positive", "negative", "both"),
    ] = Field(None, description="The side of the plane on which the point lies. Default: both.")


Body = Annotated[dict[str, Tolerant[PrimitiveModel]], BeforeValidator(_body)]


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
        Annotated[list[Tolerant[ConstraintModel]], _list("a list of six constraints")]
    ] = Field(
        description="Six distances and angles, the platform's primitive first.",
        json_schema_extra={"minItems": 6, "maxItems": 6},
    )
