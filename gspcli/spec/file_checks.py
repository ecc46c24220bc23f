"""Checks beyond the structure of a file: names, kinds, ranges, sums."""

from __future__ import annotations

from collections.abc import Mapping as Table
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias

from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS, DPP, KINDS_BY_NAME, Kind
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import CONSTRAINTS, MAX_ANGLES
from gspcli.errors import Mistake, TypeNameError
from gspcli.geometry.checking import ONE_SIDE
from gspcli.geometry.instance import (
    AngleUnit,
    Constraint,
    Instance,
    Side,
    Units,
    as_read,
)
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Cone, Geometry, Line, Plane, Point, Vector
from gspcli.geometry.ranges import wrong_half_angle, wrong_scale, wrong_value
from gspcli.spec.document import Mapping, Scalar, Sequence, Value
from gspcli.spec.meaning import remarks
from gspcli.spec.plain import ConstraintFields, InstanceFields, PrimitiveFields
from gspcli.wording import listed, shown, suggestion

if TYPE_CHECKING:
    from gspcli.geometry.home_pose import Frames, HomePose
    from gspcli.geometry.masses import Dynamics
    from gspcli.geometry.shapes import Shapes
    from gspcli.spec.models import ConstraintModel, InstanceModel, PrimitiveModel

    #: The content of a constraint, read by `plain` or by `models`.
    AnyConstraint: TypeAlias = ConstraintModel | ConstraintFields
    AnyInstance: TypeAlias = InstanceModel | InstanceFields
    AnyPrimitive: TypeAlias = PrimitiveModel | PrimitiveFields

_SORTS = {Point: "point", Line: "line", Plane: "plane"}


def _vector(components: list[Number]) -> Vector:
    x, y, z = components
    return (x, y, z)


def _geometry(model: AnyPrimitive | None) -> Geometry | None:
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
    from gspcli.spec.drive_checks import crank_of, slide_of

    crank_read = crank_of(crank)
    slide_read = None if crank_read is not None else slide_of(slide)
    return Point(_vector(model.point), tilt, crank_read, slide_read)


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
        self,
        root: Mapping,
        model: AnyInstance,
        mistakes: list[Mistake],
        *,
        any_number: bool = False,
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
    def _body(
        models: Table[str, AnyPrimitive | None] | None,
    ) -> Body | None:
        if models is None:
            return None
        body = {name: _geometry(model) for name, model in models.items()}
        if any(model is not None and model.partner is not None for model in models.values()):
            from gspcli.spec.drive_checks import joined

            return joined(body, models)
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

    def _constraint(self, node: Value, model: AnyConstraint | None) -> Constraint | None:
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
        self, node: Mapping, kind: Kind, platform: Geometry, base: Geometry, model: AnyConstraint
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
        from gspcli.geometry.home_values import home_value

        return home_value(kind, Side(model.side or "both"), platform, base, home, self.unit)

    def _corrected(self, row: Constraint, model: AnyConstraint, node: Mapping) -> Constraint:
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
                from gspcli.spec.drive_checks import mistakes_of_drives

                self.mistakes += mistakes_of_drives(self.root[Scalar(where)], body, self.unit)

    def _dynamics(self, constraints: list[Constraint | None]) -> Dynamics | None:
        """Return the masses, and note their mistakes."""
        if self.model.dynamics is None:
            return None
        from gspcli.spec.mass_checks import dynamics_of, mistakes_of_masses

        dynamics = dynamics_of(self.model.dynamics)
        rows = [row for row in constraints if row is not None]
        if dynamics is not None and len(rows) == len(constraints) and self.model.units:
            length = self.model.units.length
            self.mistakes += mistakes_of_masses(self.root, dynamics, rows, length)
        return dynamics

    def _shapes(self, constraints: list[Constraint | None]) -> Shapes | None:
        """Return the shapes of legs and bodies, and note their mistakes."""
        stated = self.model.shapes
        if stated is None:
            return None
        from gspcli.geometry.shape_mistakes import mistakes
        from gspcli.geometry.shapes import Shapes

        shapes = Shapes(
            stated.diameter, stated.platform or (), stated.base or (), stated.near_joint
        )
        rows = [row for row in constraints if row is not None]
        if len(rows) == len(constraints):
            for place, message in mistakes(shapes, rows):
                node: Any = self.root[Scalar("shapes")]
                for part in place:
                    node = node[Scalar(part) if isinstance(part, str) else part]
                self._note(node, message)
        return shapes

    def _home(self) -> HomePose | None:
        stated = self.model.home
        if stated is None:
            return None
        from gspcli.geometry.home_pose import HomePose

        return HomePose(stated.position, **_rotation(stated))

    def _frames(self) -> Frames | None:
        stated = self.model.frames
        if stated is None or stated.tool is stated.work is None:
            return None
        from gspcli.geometry.home_pose import Frame, Frames

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
                from gspcli.spec.drive_checks import doubts_of_drives

                found += doubts_of_drives(self.root[Scalar(where)], body)
        return found


def _rotation(stated: Any) -> dict[str, Any]:
    """Return the rotation of home or of a frame, as the arguments of `HomePose`."""
    if stated.euler is None:
        return {"quaternion": stated.quaternion}
    angles = [angle or Number.of(0) for angle in (stated.rx, stated.ry, stated.rz)]
    return {"euler": stated.euler, "angles": angles}
