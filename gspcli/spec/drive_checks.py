"""Cranks and slides of a file: from its entries to what moves points, with their mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Mapping as Table
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

from gspcli.errors import Mistake
from gspcli.geometry.corrections import value_of
from gspcli.geometry.instance import AngleUnit
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Geometry, Point, Slide
from gspcli.geometry.ranges import turns, wrong_scale
from gspcli.spec.document import Mapping, Scalar, Value
from gspcli.spec.plain import CrankFields, PrimitiveFields, SlideFields
from gspcli.wording import listed, shown, suggestion

if TYPE_CHECKING:
    from gspcli.spec.models import CrankModel, PrimitiveModel, SlideModel

    #: The content of a crank or slide, read by `plain` or by `models`.
    AnyDrive: TypeAlias = CrankModel | CrankFields | SlideModel | SlideFields
    AnyPrimitive: TypeAlias = PrimitiveModel | PrimitiveFields

#: Quarter turns of one turn, the widest range of a crank.
_TURN = 4


def crank_of(model: CrankModel | CrankFields | None) -> Crank | None:
    """Return a crank with its range as values."""
    if model is None:
        return None
    return Crank(model.centre, model.axis, *_of_readings(model), model.diameter)


def slide_of(model: SlideModel | SlideFields | None) -> Slide | None:
    """Return a slide with its range as values."""
    return None if model is None else Slide(model.direction, *_of_readings(model))


def _of_readings(
    model: AnyDrive,
) -> tuple[list[Number] | None, Number | None, Number | None, Number | None]:
    limits = model.range
    if limits is not None and not (model.scale is not None and wrong_scale(model.scale)):
        limits = [value_of(limit, model.scale, model.offset) for limit in limits]
    return limits, model.tolerance, model.offset, model.scale


def joined(
    body: dict[str, Geometry | None], models: Table[str, AnyPrimitive | None]
) -> dict[str, Geometry | None]:
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


def mistakes_of_drives(
    nodes: Mapping, body: dict[str, Geometry | None], unit: AngleUnit | None
) -> Iterator[Mistake]:
    """Yield the mistakes in the cranks and slides of a body.

    Parameters
    ----------
    nodes
        The section of the body in the file.
    body
        Its primitives, after `joined`.
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


def _wrong_partner(name: str, partner: Value, body: dict[str, Geometry | None]) -> str:
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
        width = Number("-", (high, low))
        if turns(width, unit) > _TURN:
            turn = "360" if unit is AngleUnit.DEGREE else "2*pi"
            message = f"found a range of {width.value:.6g}, expected at most one turn, {turn}"
            yield _at(written, message)


def _at(node: Value, message: str) -> Mistake:
    return Mistake(node.location, node.path, message)


def doubts_of_drives(nodes: Mapping, body: dict[str, Geometry | None]) -> Iterator[Mistake]:
    """Yield warnings about unusual drives; arguments as for `mistakes_of_drives`."""
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
    arm = [Number("-", pair) for pair in zip(point.position, crank.centre, strict=True)]
    (a, b, c), (x, y, z) = arm, crank.axis
    products = ((b, z, c, y), (c, x, a, z), (a, y, b, x))
    return any(
        Number("-", (Number("*", (p, q)), Number("*", (r, s)))).value for p, q, r, s in products
    )
