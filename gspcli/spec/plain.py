"""A reader of instance files without mistakes that does not load pydantic, for a quick start.

`models` reads all other files and states their mistakes. A file that is accepted here is accepted
there.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any, NamedTuple, TypeVar

from gspcli.geometry.numbers import Number
from gspcli.spec.document import Mapping, Scalar, Sequence, Value
from gspcli.spec.entries import (
    axes,
    name,
    nonzero,
    number,
    number_or_home,
    optional_text,
    proper_name,
    text,
    turning,
    version,
)

#: Optional texts about a platform.
_SAID = ("name", "source", "type")
_SECTIONS = ("dynamics", "home", "frames", "readings", "shapes")
Fields_ = TypeVar("Fields_")
#: Entries by their keys.
Fields = dict[str, Any]


class LineFields(NamedTuple):
    """As `models.LineModel`."""

    point: list[Number]
    direction: list[Number]


class PlaneFields(NamedTuple):
    """As `models.PlaneModel`."""

    point: list[Number]
    normal: list[Number]


class ConeFields(NamedTuple):
    """As `models.ConeModel`."""

    axis: list[Number]
    half_angle: Number


class ReadingFields(NamedTuple):
    """What constraints, cranks and slides can state of their readings."""

    range: list[Number] | None
    tolerance: Number | None
    offset: Number | None
    scale: Number | None


class CrankFields(NamedTuple):
    """As `models.CrankModel`."""

    centre: list[Number]
    axis: list[Number]
    range: list[Number] | None
    tolerance: Number | None
    offset: Number | None
    scale: Number | None
    diameter: Number | None


class SlideFields(NamedTuple):
    """As `models.SlideModel`."""

    direction: list[Number]
    range: list[Number] | None
    tolerance: Number | None
    offset: Number | None
    scale: Number | None


class PrimitiveFields(NamedTuple):
    """As `models.PrimitiveModel`."""

    point: list[Number] | None = None
    line: LineFields | None = None
    plane: PlaneFields | None = None
    crank: CrankFields | None = None
    slide: SlideFields | None = None
    partner: str | None = None
    cone: ConeFields | None = None


class ConstraintFields(NamedTuple):
    """As `models.ConstraintModel`, without the names."""

    value: Number | None
    range: list[Number] | None
    tolerance: Number | None
    offset: Number | None
    scale: Number | None
    side: str | None


class UnitsFields(NamedTuple):
    """As `models.UnitsModel`."""

    length: str
    angle: str


class RigidBodyFields(NamedTuple):
    """As `mass_models.RigidBodyModel`."""

    mass: Number
    centre: list[Number]
    inertia: list[Number]


class LegBodyFields(NamedTuple):
    """As `mass_models.LegBodyModel`."""

    mass: Number
    centre: Number
    inertia: Number | None
    axial: Number | None


class LegFields(NamedTuple):
    """As `mass_models.LegModel`."""

    cylinder: LegBodyFields | None
    rod: LegBodyFields | None
    universal: list[Number] | None


class ArmFields(NamedTuple):
    """As `mass_models.ArmModel`."""

    mass: Number
    centre: Number
    inertia: Number | None


class CarriageFields(NamedTuple):
    """As `mass_models.CarriageModel`."""

    mass: Number


class DrivesFields(NamedTuple):
    """As `mass_models.DrivesModel`."""

    inertia: list[Number] | None
    stiffness: list[Number] | None


class DynamicsFields(NamedTuple):
    """As `mass_models.DynamicsModel`."""

    gravity: list[Number] | None
    platform: RigidBodyFields
    legs: list[LegFields] | None
    drives: DrivesFields | None
    arms: list[ArmFields] | None
    carriages: list[CarriageFields] | None


class ShapesFields(NamedTuple):
    """As `models.ShapesModel`."""

    diameter: list[Number]
    platform: list[list[Number]] | None
    base: list[list[Number]] | None
    near_joint: Number | None


class HomeFields(NamedTuple):
    """As `models.HomeModel`."""

    position: list[Number]
    quaternion: list[Number] | None = None
    rx: Number | None = None
    ry: Number | None = None
    rz: Number | None = None
    euler: str | None = None


class FrameFields(NamedTuple):
    """As `models.FrameModel`."""

    point: list[Number]
    quaternion: list[Number] | None = None
    rx: Number | None = None
    ry: Number | None = None
    rz: Number | None = None
    euler: str | None = None


class FramesFields(NamedTuple):
    """As `models.FramesModel`."""

    tool: FrameFields | None = None
    work: FrameFields | None = None


class InstanceFields(NamedTuple):
    """As `models.InstanceModel`."""

    name: str | None
    source: str | None
    type: str | None
    units: UnitsFields
    platform: dict[str, PrimitiveFields]
    base: dict[str, PrimitiveFields]
    constraints: list[ConstraintFields]
    dynamics: DynamicsFields | None = None
    home: HomeFields | None = None
    frames: FramesFields | None = None
    readings: list[str] | None = None
    shapes: ShapesFields | None = None


def read_plainly(root: Value) -> InstanceFields | None:
    """Return the content of a document, or None if it may have a mistake."""
    try:
        return _instance(root)
    except ValueError:
        return None


def _section(value: Value, needed: Collection[str], allowed: Collection[str] = ()) -> Fields:
    """Return the entries of a mapping that has some keys, and no others but those allowed."""
    given = _entries(value)
    if not given.keys() >= set(needed) or not given.keys() <= {*needed, *allowed}:
        raise ValueError
    return given


def _entries(value: Value) -> Fields:
    if not isinstance(value, Mapping):
        raise ValueError
    return {str(key): entry for key, entry in value.items()}


def _list(value: Value, length: int | None = None) -> Sequence:
    if not isinstance(value, Sequence) or len(value) != (length or len(value)):
        raise ValueError
    return value


def _numbers(value: Value, length: int = 3) -> list[Number]:
    return [number(entry) for entry in _list(value, length)]


def _direction(value: Value) -> list[Number]:
    return nonzero(_numbers(value))


def _instance(root: Value) -> InstanceFields:
    needed = ("gsp", "units", "platform", "base", "constraints")
    given = _section(root, needed, (*_SAID, *_SECTIONS))
    version(given["gsp"])
    units = _section(given["units"], ("length", "angle"))
    said = [optional_text(given[key]) if key in given else None for key in _SAID]
    return InstanceFields(
        said[0],
        said[1],
        said[2],
        UnitsFields(text(units["length"]), _choice(units["angle"], "deg", "rad")),
        _body(given["platform"]),
        _body(given["base"]),
        [_constraint(entry) for entry in _list(given["constraints"])],
        _dynamics(given["dynamics"]) if "dynamics" in given else None,
        HomeFields(*_placed(given["home"], "position")) if "home" in given else None,
        _frames(given["frames"]) if "frames" in given else None,
        [text(entry) for entry in _list(given["readings"])] if "readings" in given else None,
        _shapes(given["shapes"]) if "shapes" in given else None,
    )


def _body(value: Value) -> dict[str, PrimitiveFields]:
    given = _entries(value)
    if not all(map(proper_name, given)):
        raise ValueError
    return {key: _primitive(entry) for key, entry in given.items()}


def _primitive(value: Value) -> PrimitiveFields:
    given = _entries(value)
    if "line" in given:
        line = _section(_section(value, ("line",))["line"], LineFields._fields)
        fields = LineFields(_numbers(line["point"]), _direction(line["direction"]))
        return PrimitiveFields(line=fields)
    if "plane" in given:
        plane = _section(_section(value, ("plane",))["plane"], PlaneFields._fields)
        return PrimitiveFields(
            plane=PlaneFields(_numbers(plane["point"]), _direction(plane["normal"]))
        )
    _section(value, ("point",), ("crank", "slide", "with", "cone"))
    if sum(key in given for key in ("crank", "slide", "with")) > 1:
        raise ValueError
    return PrimitiveFields(
        _numbers(given["point"]),
        crank=_crank(given["crank"]) if "crank" in given else None,
        slide=_slide(given["slide"]) if "slide" in given else None,
        partner=name(given["with"]) if "with" in given else None,
        cone=_cone(given["cone"]) if "cone" in given else None,
    )


def _crank(value: Value) -> CrankFields:
    given = _section(value, ("centre", "axis"), (*ReadingFields._fields, "diameter"))
    return CrankFields(
        _numbers(given["centre"]),
        _direction(given["axis"]),
        *_of_readings(given),
        number(given["diameter"]) if "diameter" in given else None,
    )


def _slide(value: Value) -> SlideFields:
    given = _section(value, ("direction",), ReadingFields._fields)
    return SlideFields(_direction(given["direction"]), *_of_readings(given))


def _of_readings(given: Fields) -> ReadingFields:
    return ReadingFields(
        _numbers(given["range"], 2) if "range" in given else None,
        number(given["tolerance"]) if "tolerance" in given else None,
        number(given["offset"]) if "offset" in given else None,
        number(given["scale"]) if "scale" in given else None,
    )


def _cone(value: Value) -> ConeFields:
    given = _section(value, ConeFields._fields)
    return ConeFields(_direction(given["axis"]), number(given["half_angle"]))


def _constraint(value: Value) -> ConstraintFields:
    quantity = "angle" if "angle" in _entries(value) else "distance"
    given = _section(value, (quantity, "value"), (*ReadingFields._fields, "side"))
    for entry in _list(given[quantity], 2):
        name(entry)
    return ConstraintFields(
        number_or_home(given["value"]),
        *_of_readings(given),
        _choice(given["side"], "positive", "negative", "both") if "side" in given else None,
    )


def _placed(value: Value, origin: str) -> tuple[Any, ...]:
    """Return an origin, a quaternion or None, three angles or None, and their order or None."""
    if "euler" not in _entries(value):
        given = _section(value, (origin,), ("quaternion",))
        quaternion = given.get("quaternion")
        turned = None if quaternion is None else turning(_numbers(quaternion, 4))
        return _numbers(given[origin]), turned
    turns = ("rx", "ry", "rz")
    given = _section(value, (origin, "euler"), turns)
    angles = [number(given[key]) if key in given else None for key in turns]
    return _numbers(given[origin]), None, *angles, axes(given["euler"])


def _frames(value: Value) -> FramesFields:
    given = _section(value, (), FramesFields._fields)
    return FramesFields(
        **{key: FrameFields(*_placed(entry, "point")) for key, entry in given.items()}
    )


def _shapes(value: Value) -> ShapesFields:
    given = _section(value, ("diameter",), ("platform", "base", "near_joint"))
    platform, base = (
        [_numbers(point) for point in _list(given[key])] if key in given else None
        for key in ("platform", "base")
    )
    if any(body == [] for body in (platform, base)):
        raise ValueError
    diameters = _several(given["diameter"])
    near = number(given["near_joint"]) if "near_joint" in given else None
    return ShapesFields(diameters or [], platform, base, near)


def _choice(value: Value, *choices: str) -> str:
    if not isinstance(value, Scalar) or value not in choices:
        raise ValueError
    return str(value)


def _dynamics(value: Value) -> DynamicsFields:
    given = _section(value, ("platform",), ("gravity", "legs", "drives", "arms", "carriages"))
    body = _section(given["platform"], RigidBodyFields._fields)
    drives = None
    if "drives" in given:
        stated = _section(given["drives"], (), DrivesFields._fields)
        drives = DrivesFields(*(_several(stated.get(key)) for key in DrivesFields._fields))
    return DynamicsFields(
        _numbers(given["gravity"]) if "gravity" in given else None,
        RigidBodyFields(
            number(body["mass"]), _numbers(body["centre"]), _numbers(body["inertia"], 6)
        ),
        _each(_leg, given.get("legs")),
        drives,
        _each(_arm, given.get("arms")),
        _each(_carriage, given.get("carriages")),
    )


def _each(read: Callable[[Value], Fields_], value: Value | None) -> list[Fields_] | None:
    """Return what is read of each entry of a list, or of one entry without brackets."""
    if value is None:
        return None
    return [read(entry) for entry in (value if isinstance(value, Sequence) else [value])]


def _several(value: Value | None) -> list[Number] | None:
    """Return a list of numbers, or one number as a list."""
    return _each(number, value)


def _arm(value: Value) -> ArmFields:
    given = _section(value, ("mass", "centre"), ("inertia",))
    inertia = number(given["inertia"]) if "inertia" in given else None
    return ArmFields(number(given["mass"]), number(given["centre"]), inertia)


def _carriage(value: Value) -> CarriageFields:
    return CarriageFields(number(_section(value, ("mass",))["mass"]))


def _leg(value: Value) -> LegFields:
    given = _section(value, (), LegFields._fields)
    return LegFields(
        _leg_body(given["cylinder"]) if "cylinder" in given else None,
        _leg_body(given["rod"]) if "rod" in given else None,
        _direction(given["universal"]) if "universal" in given else None,
    )


def _leg_body(value: Value) -> LegBodyFields:
    given = _section(value, ("mass", "centre"), ("inertia", "axial"))
    moments = [number(given[key]) if key in given else None for key in ("inertia", "axial")]
    return LegBodyFields(number(given["mass"]), number(given["centre"]), *moments)
