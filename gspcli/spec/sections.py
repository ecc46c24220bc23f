"""Parts of the models of an instance file: sections, lists, numbers, and notes of mistakes.

A wrong element does not hide the mistakes in others: it is noted with its place in the list that is
the validation context, and replaced by None.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, ClassVar, TypeVar

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

from gspcli.errors import Mistake
from gspcli.geometry.numbers import Number
from gspcli.spec.document import Mapping, Missing, Scalar, Sequence, Value, locate
from gspcli.spec.entries import complain, found, nonzero, number, optional_text, text
from gspcli.wording import listed, nearest, shown, suggestion

Item = TypeVar("Item")


def note(error: ValidationError, mistakes: list[Mistake]) -> None:
    """Add the mistakes of a validation error, each at the place of its value."""
    for detail in error.errors(include_url=False):
        value = detail["input"]
        # None replaces optional and wrong elements only; no file contains it.
        if isinstance(value, Missing) or detail["type"] == "none_required":
            continue
        cause = detail.get("ctx", {}).get("error")
        message = str(cause) if cause else detail["msg"]
        mistakes.append(Mistake(value.location, value.path, message))


def mistakes_of(info: ValidationInfo) -> list[Mistake]:
    """Return the list in which mistakes are noted."""
    mistakes: list[Mistake] = info.context  # type: ignore[assignment]
    return mistakes


def _tolerate(value: Any, handler: Callable[[Any], Item], info: ValidationInfo) -> Item | None:
    try:
        return handler(value)
    except ValidationError as error:
        note(error, mistakes_of(info))
        return None


Tolerant = Annotated[Item | SkipJsonSchema[None], WrapValidator(_tolerate)]


def list_of(expected: str, length: int | None = None) -> BeforeValidator:
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


def choice_of(*choices: str) -> BeforeValidator:
    """Check that a value is one of some words."""

    def check(value: Value) -> str:
        if value not in choices:
            near = suggestion(value, choices) if isinstance(value, Scalar) else ""
            message = f"found {found(value)}, expected {listed(choices)}{near}"
            raise ValueError(message)
        return str(value)

    return BeforeValidator(check)


Text = Annotated[str, BeforeValidator(text)]
OptionalText = Annotated[str | SkipJsonSchema[None], BeforeValidator(optional_text)]
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
    list[Real], Field(min_length=3, max_length=3), list_of("three numbers [x, y, z]", 3)
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
    refused = [{"required": list(pair)} for pair in model.excludes]
    if len(refused) == 1:
        schema["not"] = refused[0]
    elif refused:
        schema["not"] = {"anyOf": refused}


class Section(BaseModel):
    """A mapping with known keys.

    Attributes
    ----------
    one_of
        Keys of which exactly one must be given.
    needs
        Keys that need another key.
    excludes
        Pairs of keys of which at most one is given.
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
    excludes: ClassVar[tuple[tuple[str, str], ...]] = ()

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, section: Value, info: ValidationInfo) -> Mapping:
        """Note wrong keys and return the section without them; `Missing` for a missing key."""
        fields = {field.alias or name: field for name, field in cls.model_fields.items()}
        known = list(fields)
        if not isinstance(section, Mapping):
            keys = listed(cls.one_of) if cls.one_of else listed(known, "and")
            raise complain(section, f"a mapping with {keys}")
        mistakes = mistakes_of(info)
        kept, misspelt = Mapping(), set()
        for key, value in section.items():
            if key in known:
                kept[key] = value
                continue
            near = nearest(key, [name for name in known if name not in section])
            misspelt.add(near)
            hint = f": did you mean {near}?" if near else ""
            message = f"found the unknown key {shown(key)}, expected {listed(known)}{hint}"
            mistakes.append(Mistake(key.location, key.path, message))
        required = [name for name, field in fields.items() if field.is_required()]
        absent = [name for name in required if name not in kept]
        for name in absent:
            kept[Scalar(name)] = locate(Missing(), section.location, section.path)
        if unnamed := [name for name in absent if name not in misspelt]:
            words = (
                f"key {unnamed[0]} is"
                if len(unnamed) == 1
                else f"keys {listed(unnamed, 'and')} are"
            )
            mistakes.append(Mistake(section.location, section.path, f"the {words} missing"))
        given = [name for name in cls.one_of if name in kept]
        if len(given) > 1 or (cls.one_of and not given and not misspelt & set(cls.one_of)):
            what = listed(given, "and") if given else "none of them"
            message = f"found {what}, expected exactly one of {listed(cls.one_of)}"
            mistakes.append(Mistake(section.location, section.path, message))
        for needy, other in cls.needs.items():
            if needy in kept and other not in kept and (given or not cls.one_of):
                place = kept[Scalar(needy)]
                message = f"found {needy} without {other}, expected both"
                if given:
                    message = f"found {needy} at a {given[0]}, expected it only at a {other}"
                mistakes.append(Mistake(place.location, place.path, message))
        for one, other in cls.excludes:
            if one in kept and other in kept:
                place = kept[Scalar(one)]
                message = f"found {one} beside {other}, expected one of them"
                mistakes.append(Mistake(place.location, place.path, message))
        return locate(kept, section.location, section.path)
