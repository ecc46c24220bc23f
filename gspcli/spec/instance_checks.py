"""Checks beyond the structure of a file: names, kinds, ranges, sums."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Mapping as Table
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS, DPP, KINDS_BY_NAME, Kind
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import CONSTRAINTS, MAX_ANGLES
from gspcli.errors import Mistake, TypeNameError
from gspcli.geometry.checking import ONE_SIDE, turns, wrong_half_angle, wrong_scale, wrong_value
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units, as_read
from gspcli.geometry.numbers import Number, value_of
from gspcli.geometry.primitives import Cone, Crank, Geometry, Line, Plane, Point, Slide, Vector
from gspcli.spec.document import Mapping, Scalar, Sequence, Value
from gspcli.spec.meaning import remarks
from gspcli.wording import listed, shown, suggestion

if TYPE_CHECKING:
    from gspcli.geometry.instance import Frames, HomePose, Shapes
    from gspcli.geometry.masses import Dynamics


_SORTS = {Point: "point", Line: "line", Plane: "plane"}


def _vector(components: list[Number]) -> Vector:
    x, y, z = components
    return (x, y, z)


def _geometry(model: Any) -> Geometry | None:
    if model is None:
        return None
    if model.line is not None:
        return Line(_vector(model.line.point), _vector(model.line.direction))
    if model.plane is not None:
        return Plane(_vector(model.plane.point), _vector(model.plane.normal))
    if model.point is None:
        return None
    cone, crank, slide = model.cone, model.crank, model.slide
    tilt = None if cone is None else Cone(_vector(cone.axis), cone.half_angle)
    if crank is None and slide is None:
        return Point(_vector(model.point), tilt)
    turned = _crank_of(crank)
    return Point(_vector(model.point), tilt, turned, _slide_of(slide) if turned is None else None)


Body = dict[str, Geometry | None]


def _has_drives(body: Body, nodes: Mapping) -> bool:
    """Return whether a point has a crank or a slide, or names another point that may have one."""
    return any(
        isinstance(one, Point) and (one.drive is not None or "with" in nodes[Scalar(name)])
        for name, one in body.items()
    )


#: The command for files with another number of constraints.
_ANY_NUMBER = "; gsp freedoms takes any number"


class FileChecker:
    """Checks beyond the structure of a file: names, kinds, ranges, sums."""

    def __init__(
        self, root: Mapping, model: Any, mistakes: list[Mistake], *, any_number: bool = False
    ) -> None:
        self.root = root
        #: Whether there may be fewer constraints than six, or more.
        self.any_number = any_number
        self.model = model
        self.mistakes = mistakes
        self.platform = self._body(model.platform)
        self.base = self._body(model.base)
        self.unit = AngleUnit(model.units.angle) if model.units else None

    @staticmethod
    def _body(models: Table[str, Any] | None) -> Body | None:
        if models is None:
            return None
        body = {name: _geometry(model) for name, model in models.items()}
        if any(model is not None and model.partner is not None for model in models.values()):
            return _with_partners(body, models)
        return body

    def _note(self, value: Value, message: str) -> None:
        self.mistakes.append(Mistake(value.location, value.path, message))

    def instance(self) -> Instance | None:
        """Return the instance, or None if there are mistakes."""
        models = self.model.constraints
        if models is None:
            return None
        nodes = self.root[Scalar("constraints")]
        constraints = [self._constraint(*pair) for pair in zip(nodes, models, strict=True)]
        self._check_repetitions(nodes, constraints)
        self._check_numbers(nodes)
        self._check_cones(constraints)
        self._check_drives()
        shapes = self._shapes(constraints)
        complete = tuple(constraint for constraint in constraints if constraint is not None)
        units = self.model.units
        dynamics = self._dynamics(constraints)
        if self.mistakes or units is None or not self._enough(len(complete)):
            return None
        instance = Instance(
            complete,
            Units(units.length, AngleUnit(units.angle)),
            self.model.name,
            self.model.source,
            self._further(complete),
            dynamics,
            self._home(),
            self._frames(),
            tuple(one for one in self.model.readings or () if one is not None),
            shapes,
        )
        if not self.any_number:
            self._check_type(instance)
        return instance

    def _enough(self, count: int) -> bool:
        """Whether there can be this many constraints."""
        return count > 0 if self.any_number else count == CONSTRAINTS

    def _further(
        self, constraints: tuple[Constraint, ...]
    ) -> tuple[tuple[str, str, Geometry], ...]:
        """Return the primitives that no constraint uses, with their bodies and names."""
        used = {("platform", row.platform_name) for row in constraints}
        used |= {("base", row.base_name) for row in constraints}
        return tuple(
            (where, str(name), geometry)
            for where, body in (("platform", self.platform), ("base", self.base))
            for name, geometry in (body or {}).items()
            if geometry is not None and (where, name) not in used
        )

    def _constraint(self, node: Value, model: Any) -> Constraint | None:
        if not isinstance(node, Mapping):
            return None
        quantity = "distance" if "distance" in node else "angle"
        pair = node.get(Scalar(quantity))
        if not isinstance(pair, Sequence) or len(pair) != 2:
            return None
        platform = self._primitive(pair[0], "platform", self.platform, self.base)
        base = self._primitive(pair[1], "base", self.base, self.platform)
        if platform is None or base is None:
            return None
        kind = self._kind(pair, quantity, platform, base)
        if kind is None or model is None:
            return None
        if model.side is not None and not kind.has_sides:
            message = f"found a side for {kind.name}, expected one only for DPH and DHP"
            self._note(node[Scalar("side")], message)
        value = model.value or self._at_home(node, kind, platform, base, model)
        if value is None:
            return None
        row = Constraint(
            kind,
            platform,
            base,
            value,
            Side(model.side or "both"),
            str(pair[0]),
            str(pair[1]),
            None if model.range is None else (model.range[0], model.range[1]),
            model.tolerance,
        )
        row = self._corrected(row, model, node)
        if model.value is None:
            # The home pose gives the value, not the reading.
            row = replace(row, value=value)
        self._check_value(row, node[Scalar("value")], row.value)
        self._check_limits(row, node)
        tolerance = model.tolerance
        if tolerance is not None and tolerance.value < 0:
            written = node[Scalar("tolerance")]
            self._note(written, f"found {shown(written)}, expected a tolerance of at least 0")
        return row

    def _at_home(
        self, node: Mapping, kind: Kind, platform: Geometry, base: Geometry, model: Any
    ) -> Number | None:
        """Return the value of a constraint that states ``value: home``."""
        home = self._home()
        if home is None or self.unit is None:
            if "home" not in self.root:
                message = (
                    "found home, but the file states no home pose: home: {position: [x, y, z]}"
                )
                self._note(node[Scalar("value")], message)
            return None
        from gspcli.geometry.expressed_instances import home_value

        return home_value(kind, Side(model.side or "both"), platform, base, home, self.unit)

    def _corrected(self, row: Constraint, model: Any, node: Mapping) -> Constraint:
        """Return a constraint that is written as readings, with its offset and scale."""
        if model.offset is not None and row.kind.has_sides and row.side is Side.BOTH:
            message = f"found an offset for {row.kind.name}, {ONE_SIDE}"
            self._note(node[Scalar("offset")], message)
        if model.scale is not None and (wrong := wrong_scale(model.scale)):
            written = node[Scalar("scale")]
            self._note(written, f"found {shown(written)}, {wrong}")
            return row
        if model.offset is model.scale is None:
            return row
        return as_read(row, offset=model.offset, scale=model.scale)

    def _check_value(self, row: Constraint, written: Scalar, value: Number) -> None:
        """Check a value or limit that is written as a reading, with its offset and scale."""
        if self.unit is not None and (wrong := wrong_value(row.kind, value, self.unit)):
            given = {"offset": row.offset, "scale": row.scale}
            stated = [f"{key} {number}" for key, number in given.items() if number is not None]
            found = " with ".join((shown(written), *([listed(stated, "and")] if stated else [])))
            self._note(written, f"found {found}, {wrong}")

    def _check_limits(self, row: Constraint, node: Mapping) -> None:
        if row.limits is None:
            return
        written = node[Scalar("range")]
        for number, text in zip(row.limits, written, strict=True):
            self._check_value(row, text, number)
        low, high = row.limits
        if low.value > high.value:
            message = f"found {shown(written[0])} above {shown(written[1])}, expected [low, high]"
            self._note(written, message)

    def _primitive(
        self, name: Value, where: str, body: Body | None, other: Body | None
    ) -> Geometry | None:
        if body is None or not isinstance(name, Scalar) or not name:
            return None
        if name not in body:
            if other is not None and name in other:
                hint = ": the platform's primitive comes first, the base's second"
            else:
                hint = suggestion(name, body) or (f": {listed(body)}" if 0 < len(body) < 10 else "")
            message = f"found the unknown name {shown(name)}, expected a primitive of the {where}"
            self._note(name, message + hint)
        return body.get(name)

    def _kind(
        self, pair: Sequence, quantity: str, platform: Geometry, base: Geometry
    ) -> Kind | None:
        sorts = platform.primitive.value + base.primitive.value
        kind = KINDS_BY_NAME.get(quantity[0].upper() + sorts)
        if kind is None:
            exist = DISTANCE_KINDS if quantity == "distance" else ANGLE_KINDS
            what = f"{quantity} of a {_SORTS[type(platform)]} and a {_SORTS[type(base)]}"
            names = " ".join(kind.short for kind in exist)
            self._note(pair, f"found the {what}, expected one of {names}: there is no other")
        return kind

    def _check_repetitions(self, nodes: Sequence, constraints: list[Constraint | None]) -> None:
        first: dict[tuple[Kind, str, str], str] = {}
        for node, constraint in zip(nodes, constraints, strict=True):
            if constraint is None:
                continue
            key = (constraint.kind, constraint.platform_name, constraint.base_name)
            if key in first:
                what = "distance" if constraint.kind.is_distance else "angle"
                message = f"found the {what} of {first[key]} again, expected each only once"
                self._note(node, message)
            first.setdefault(key, f"{node.path} ({key[1]}, {key[2]})")

    def _check_numbers(self, nodes: Sequence) -> None:
        if not self._enough(len(nodes)):
            plural = "" if len(nodes) == 1 else "s"
            expected = "one at least" if self.any_number else f"exactly six{_ANY_NUMBER}"
            message = f"found {len(nodes)} constraint{plural}, expected {expected}"
            self._note(nodes, message)
        if self.any_number:
            return
        angles = [node for node in nodes if isinstance(node, Mapping) and "angle" in node]
        for node in angles[MAX_ANGLES:]:
            message = (
                f"found {len(angles)} angles, expected at most three: "
                "three fix the orientation (Definition 2.1)"
            )
            self._note(node, message)
            break

    def _check_cones(self, constraints: list[Constraint | None]) -> None:
        """Check the half angles of cones, and that each limits at least one leg."""
        legs = [row for row in constraints if row is not None and row.kind is DPP]
        ends = ({row.platform_name for row in legs}, {row.base_name for row in legs})
        bodies = (("platform", self.platform), ("base", self.base))
        for (where, body), joined in zip(bodies, ends, strict=True):
            for name, geometry in (body or {}).items():
                if not isinstance(geometry, Point) or geometry.cone is None:
                    continue
                node = self.root[Scalar(where)][name][Scalar("cone")]
                written, angle = node[Scalar("half_angle")], geometry.cone.half_angle
                if self.unit is not None and (wrong := wrong_half_angle(angle, self.unit)):
                    self._note(written, f"found {shown(written)}, {wrong}")
                if name not in joined and None not in constraints:
                    message = (
                        f"found a cone at {name}, which no point-point distance uses: "
                        "a cone limits the directions of legs"
                    )
                    self._note(node, message)

    def _check_drives(self) -> None:
        """Check cranks, slides and the names of the points that others ride with."""
        for where, body in (("platform", self.platform), ("base", self.base)):
            if body is not None and _has_drives(body, self.root[Scalar(where)]):
                self.mistakes += _mistakes_of_drives(self.root[Scalar(where)], body, self.unit)

    def _dynamics(self, constraints: list[Constraint | None]) -> Dynamics | None:
        """Return the masses, and note their mistakes."""
        if self.model.dynamics is None:
            return None
        dynamics = _dynamics_of(self.model.dynamics)
        rows = [row for row in constraints if row is not None]
        if dynamics is not None and len(rows) == len(constraints) and self.model.units:
            length = self.model.units.length
            self.mistakes += _mistakes_of_masses(self.root, dynamics, rows, length)
        return dynamics

    def _shapes(self, constraints: list[Constraint | None]) -> Shapes | None:
        """Return the shapes of legs and bodies, and note their mistakes."""
        stated = self.model.shapes
        if stated is None:
            return None
        from gspcli.geometry.checking import shape_mistakes
        from gspcli.geometry.instance import Shapes

        shapes = Shapes(
            stated.diameter, stated.platform or (), stated.base or (), stated.near_joint
        )
        rows = [row for row in constraints if row is not None]
        if len(rows) == len(constraints):
            for place, message in shape_mistakes(shapes, rows):
                node: Any = self.root[Scalar("shapes")]
                for part in place:
                    node = node[Scalar(part) if isinstance(part, str) else part]
                self._note(node, message)
        return shapes

    def _home(self) -> HomePose | None:
        stated = self.model.home
        if stated is None:
            return None
        from gspcli.geometry.instance import HomePose

        return HomePose(stated.position, **_rotation(stated))

    def _frames(self) -> Frames | None:
        stated = self.model.frames
        if stated is None or stated.tool is stated.work is None:
            return None
        from gspcli.geometry.instance import Frame, Frames

        tool, work = (
            None if one is None else Frame(one.point, **_rotation(one))
            for one in (stated.tool, stated.work)
        )
        return Frames(tool, work)

    def _check_type(self, instance: Instance) -> None:
        if self.model.type is None:
            return
        node = self.root[Scalar("type")]
        try:
            stated = parse_type(self.model.type)
        except TypeNameError as error:
            self._note(node, str(error))
            return
        if stated != instance.type:
            message = f"found {stated}, but the constraints make {instance.type}"
            self._note(node, message)

    def warnings(self, instance: Instance) -> list[Mistake]:
        """Return the warnings about a correct file."""
        nodes = self.root[Scalar("constraints")]
        found = [
            Mistake(nodes[index].location, nodes[index].path, message)
            for index, message in remarks(instance)
        ]
        used = {
            "platform": {constraint.platform_name for constraint in instance.constraints},
            "base": {constraint.base_name for constraint in instance.constraints},
        }
        for where, body in (("platform", self.platform), ("base", self.base)):
            places: dict[Geometry, str] = {}
            for key in self.root[Scalar(where)]:
                geometry = (body or {})[key]
                message = ""
                if key not in used[where]:
                    message = "not used by any constraint"
                elif geometry in places:
                    message = f"the same as {places[geometry]}: one name would show the sharing"
                elif geometry is not None:
                    places[geometry] = str(key)
                if message:
                    found.append(Mistake(key.location, key.path, message))
            if body is not None and _has_drives(body, self.root[Scalar(where)]):
                found += _doubts_of_drives(self.root[Scalar(where)], body)
        return found


def _rotation(stated: Any) -> dict[str, Any]:
    """Return the rotation of home or of a frame, as the arguments of `HomePose`."""
    if stated.euler is None:
        return {"quaternion": stated.quaternion}
    angles = [angle or Number.of(0) for angle in (stated.rx, stated.ry, stated.rz)]
    return {"euler": stated.euler, "angles": angles}


#: Quarter turns of one turn, the widest range of a crank.
_TURN = 4


def _crank_of(model: Any) -> Crank | None:
    """Return a crank with its range as values."""
    if model is None:
        return None
    return Crank(model.centre, model.axis, *_of_readings(model), model.diameter)


def _slide_of(model: Any) -> Slide | None:
    """Return a slide with its range as values."""
    return None if model is None else Slide(model.direction, *_of_readings(model))


def _of_readings(
    model: Any,
) -> tuple[list[Number] | None, Number | None, Number | None, Number | None]:
    limits = model.range
    if limits is not None and not (model.scale is not None and wrong_scale(model.scale)):
        limits = [value_of(limit, model.scale, model.offset) for limit in limits]
    return limits, model.tolerance, model.offset, model.scale


def _with_partners(body: Body, models: Table[str, Any]) -> dict[str, Geometry | None]:
    """Return a body whose points have the drives of the points that they ride with."""
    found = dict(body)
    for name, model in models.items():
        point = body[name]
        if model is None or model.partner is None or not isinstance(point, Point):
            continue
        other = body.get(model.partner)
        if isinstance(other, Point) and not other.partner:
            found[name] = replace(
                point, crank=other.crank, slide=other.slide, partner=model.partner
            )
    return found


def _mistakes_of_drives(nodes: Mapping, body: Body, unit: AngleUnit | None) -> Iterator[Mistake]:
    """Yield the mistakes in the cranks and slides of a body.

    Parameters
    ----------
    nodes
        The section of the body in the file.
    body
        Its primitives, after `_with_partners`.
    unit
        The unit of angles, or None if the file does not state it.
    """
    for name, geometry in body.items():
        node = nodes[Scalar(name)]
        if not isinstance(geometry, Point) or not isinstance(node, Mapping):
            continue
        if "with" in node:
            if message := _wrong_partner(name, node[Scalar("with")], body):
                yield _at(node[Scalar("with")], message)
        elif geometry.drive is not None:
            yield from _of_drive(node[Scalar(geometry.drive.sort)], geometry.drive, unit)


def _wrong_partner(name: str, partner: Value, body: Body) -> str:
    """Return what is wrong with the name after ``with``, or nothing."""
    expected = "expected a point of the same body with a crank or a slide"
    if not isinstance(partner, Scalar) or partner == name:
        return f"found the point itself, {expected}"
    if partner not in body:
        driven = [key for key, one in body.items() if _own_drive(one) and key != name]
        hint = suggestion(partner, driven) or (f": {listed(driven)}" if driven else "")
        return f"found the unknown name {shown(partner)}, {expected}{hint}"
    other = body[partner]
    if other is None or _own_drive(other):
        return ""
    if isinstance(other, Point) and other.partner:
        return f"found {shown(partner)}, which rides with {other.partner}: write {other.partner}"
    return f"found {shown(partner)}, which has none, {expected}"


def _own_drive(geometry: Geometry | None) -> bool:
    return isinstance(geometry, Point) and geometry.drive is not None and not geometry.partner


def _of_drive(node: Mapping, drive: Crank | Slide, unit: AngleUnit | None) -> Iterator[Mistake]:
    if drive.scale is not None and (wrong := wrong_scale(drive.scale)):
        written = node[Scalar("scale")]
        yield _at(written, f"found {shown(written)}, {wrong}")
    if drive.tolerance is not None and drive.tolerance.value < 0:
        written = node[Scalar("tolerance")]
        yield _at(written, f"found {shown(written)}, expected a tolerance of at least 0")
    if isinstance(drive, Crank) and drive.diameter is not None and drive.diameter.value < 0:
        written = node[Scalar("diameter")]
        yield _at(written, f"found {shown(written)}, expected a diameter of at least 0")
    if drive.limits is None:
        return
    low, high = drive.limits
    written = node[Scalar("range")]
    if low.value > high.value:
        message = f"found {shown(written[0])} above {shown(written[1])}, expected [low, high]"
        yield _at(written, message)
    elif isinstance(drive, Crank) and unit is not None:
        width = high - low
        if turns(width, unit) > _TURN:
            turn = "360" if unit is AngleUnit.DEGREE else "2*pi"
            message = f"found a range of {width.value:.6g}, expected at most one turn, {turn}"
            yield _at(written, message)


def _at(node: Value, message: str) -> Mistake:
    return Mistake(node.location, node.path, message)


def _doubts_of_drives(nodes: Mapping, body: Body) -> Iterator[Mistake]:
    """Yield warnings about unusual drives; arguments as for `_mistakes_of_drives`."""
    for name, geometry in body.items():
        if not isinstance(geometry, Point) or geometry.drive is None:
            continue
        drive, node = geometry.drive, nodes[Scalar(name)]
        if isinstance(drive, Crank) and not _has_arm(geometry, drive):
            message = "the point lies on the axis of its crank, which does not move it"
            place = node[Scalar("with" if geometry.partner else "crank")]
            yield _at(place, message)
        if geometry.partner or drive.limits is None:
            continue
        low, high = drive.limits
        if not low.value <= 0 <= high.value:
            ends = " to ".join(str(drive.reading_of(limit)) for limit in (low, high))
            stated = drive.reading_of(Number.of(0))
            message = f"the stated point, at {stated}, is outside the range from {ends}"
            yield _at(node[Scalar(drive.sort)][Scalar("range")], message)


def _has_arm(point: Point, crank: Crank) -> bool:
    arm = [a - b for a, b in zip(point.position, crank.centre, strict=True)]
    (a, b, c), (x, y, z) = arm, crank.axis
    products = ((b, z, c, y), (c, x, a, z), (a, y, b, x))
    return any((p * q - r * s).value for p, q, r, s in products)


def _dynamics_of(model: Any) -> Dynamics | None:
    """Return the masses in a file; None if they cannot be read."""
    from gspcli.geometry import masses

    if any(None in (part or ()) for part in (model.legs, model.arms, model.carriages)):
        return None

    def body(stated: Any) -> masses.LegBody | None:
        if stated is None:
            return None
        moments = stated.inertia or 0, stated.axial or 0
        return masses.LegBody(stated.mass, stated.centre, *moments)

    platform, drives = model.platform, model.drives
    return masses.Dynamics(
        masses.RigidBody(platform.mass, platform.centre, platform.inertia),
        [masses.Leg(body(leg.cylinder), body(leg.rod), leg.universal) for leg in model.legs or ()],
        None
        if drives is None
        else masses.Drives(0 if drives.inertia is None else drives.inertia, drives.stiffness),
        model.gravity or masses.GRAVITY,
        [masses.Arm(arm.mass, arm.centre, arm.inertia or 0) for arm in model.arms or ()],
        [masses.Carriage(one.mass) for one in model.carriages or ()],
    )


def _mistakes_of_masses(
    root: Mapping, dynamics: Dynamics, rows: list[Constraint], length: str
) -> Iterator[Mistake]:
    """Yield the mistakes in the masses of a file, each with its place."""
    from gspcli.geometry.checking import mass_mistakes

    for place, message in mass_mistakes(dynamics, rows, length):
        node: Any = root
        for part in place:
            if isinstance(node, Sequence) and isinstance(part, str):
                # One leg for all, in brackets.
                (node,) = node
            node = node[part]
        yield Mistake(node.location, node.path, message)
