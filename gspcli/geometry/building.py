"""Instances from Python objects: arrays of joints, or primitives and constraints.

The result equals that of `gspcli.loads` for a file with the same numbers. Primitives are named P1,
L1, H1 and so on in the order of their first use. Equal primitives of a body are one primitive,
which its constraints share. A number is anything that `Number.of` takes; it is kept exactly.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS, DPP, KINDS_BY_NAME, Kind, Primitive
from gspcli.catalogue.types import CONSTRAINTS
from gspcli.errors import ArgumentError
from gspcli.geometry.checking import checked, wrong_scale
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units, as_read
from gspcli.geometry.numbers import Number, Real
from gspcli.geometry.primitives import Geometry, Line, Plane, Point
from gspcli.wording import listed, shortened, shown

_SORTS = {Primitive.POINT: "point", Primitive.LINE: "line", Primitive.PLANE: "plane"}


def hexapod(
    base: Any,
    platform: Any,
    lengths: Any,
    *,
    length: str = "mm",
    name: str | None = None,
    source: str | None = None,
) -> Instance:
    """Return the platform with six legs, distances of points (6 DPP).

    Parameters
    ----------
    base, platform
        The joints of the legs on the base and on the platform, each in the frame of its body,
        shape (6, 3): an array or a DataFrame, or rows of numbers, fractions or texts such as
        ``"sqrt(3)/2"``.
        A float is the decimal that it prints as.
    lengths
        The lengths of the legs, shape (6,).
    length
        The name of the unit of length.
    name, source
        The name and the source of the platform.

    Raises
    ------
    ArgumentError
        Naming what is wrong, such as ``base[3][1]``.

    Examples
    --------
    >>> import numpy as np
    >>> angles = np.radians([0, 20, 120, 140, 240, 260])
    >>> ring = np.stack((np.cos(angles), np.sin(angles), 0 * angles), axis=1)
    >>> made = hexapod(300 * ring, 200 * ring[[5, 0, 1, 2, 3, 4]], [250, 255] * 3)
    >>> made.type.number, made.expected
    (3389, 40)
    """
    ends = _joints(base, "base"), _joints(platform, "platform")
    values = _rows(lengths, "lengths", "lengths of legs")
    constraints = []
    try:
        for there, here, value in zip(*ends, values, strict=True):
            constraints.append(Constraint(DPP, here, there, value))
    except ArgumentError as error:
        raise ArgumentError(error.message, f"lengths[{len(constraints)}]") from None
    try:
        return instance(constraints, length=length, name=name, source=source)
    except ArgumentError as error:
        where = error.where.replace("constraints", "lengths").removesuffix(".value")
        raise ArgumentError(error.message, where) from None


def _joints(rows: Any, where: str) -> list[Point]:
    points = []
    for index, row in enumerate(_rows(rows, where, "points")):
        try:
            points.append(Point(row))
        except ArgumentError as error:
            part = error.where.removeprefix("position")
            raise ArgumentError(error.message, f"{where}[{index}]{part}") from None
    return points


def _rows(values: Any, where: str, what: str) -> Sequence[Any]:
    # Frames and series of pandas, and arrays.
    values = values.to_numpy() if hasattr(values, "to_numpy") else values
    rows = values.tolist() if isinstance(values, np.ndarray) else values
    if not isinstance(rows, Sequence) or isinstance(rows, str):
        raise ArgumentError(f"found a {type(values).__name__}, expected six {what}", where)
    if len(rows) != CONSTRAINTS:
        raise ArgumentError(f"found {len(rows)} {what}, expected six", where)
    return rows


def distance(
    platform: Geometry,
    base: Geometry,
    value: Real,
    *,
    side: Side | str = Side.BOTH,
    range: tuple[Real, Real] | None = None,
    offset: Real | None = None,
    scale: Real | None = None,
) -> Constraint:
    """Return a distance between a primitive of the platform and one of the base.

    Parameters
    ----------
    platform, base
        The primitives, each in the frame of its body.
    value
        The distance, at least 0, in the unit of length of the instance.
    side
        Of a point and a plane: ``positive`` if the point lies where the normal points,
        ``negative``, or ``both``.
    range
        The smallest and the largest value that the machine can have there.
    offset
        What is added to ``value`` and ``range`` (readings) to make them the distance itself.
    scale
        They are multiplied by one plus this before.

    Raises
    ------
    ArgumentError
        If there is no such distance, as between two planes, or a number is none.
    """
    return _constraint("distance", platform, base, value, side, range, offset, scale)


def angle(
    platform: Geometry,
    base: Geometry,
    value: Real,
    *,
    range: tuple[Real, Real] | None = None,
    offset: Real | None = None,
    scale: Real | None = None,
) -> Constraint:
    """Return an angle between a line or plane of the platform and one of the base.

    Parameters
    ----------
    platform, base
        The primitives, each in the frame of its body.
    value
        The angle, in the angle unit of the instance: of two lines or two planes between 0 and
        180 degrees, of a line and a plane between -90 and 90.
    range
        The smallest and the largest value that the machine can have there.
    offset
        What is added to ``value`` and ``range`` (readings) to make them the angle itself.
    scale
        They are multiplied by one plus this before.

    Raises
    ------
    ArgumentError
        If there is no such angle, as of a point, or a number is none.
    """
    return _constraint("angle", platform, base, value, Side.BOTH, range, offset, scale)


def _constraint(
    quantity: str,
    platform: Geometry,
    base: Geometry,
    value: Real,
    side: Side | str,
    limits: tuple[Real, Real] | None,
    offset: Real | None,
    scale: Real | None,
) -> Constraint:
    for where, primitive in (("platform", platform), ("base", base)):
        if not isinstance(primitive, Point | Line | Plane):
            raise ArgumentError(
                f"found a {type(primitive).__name__}, expected a Point, a Line or a Plane", where
            )
    kind = _kind(quantity, platform, base)
    sides = [known.value for known in Side]
    if side not in (*Side, *sides):
        raise ArgumentError(f"found {shown(str(side))}, expected {listed(sides)}", "side")
    ends = None if limits is None else _limits(limits)
    # Any number: the constraint makes it exact.
    made = Constraint(kind, platform, base, value, Side(side), limits=ends)  # type: ignore[arg-type]
    if offset is scale is None:
        return made
    given = {
        name: None if number is None else Number.of(number, name)
        for name, number in (("offset", offset), ("scale", scale))
    }
    if given["scale"] is not None and (wrong := wrong_scale(given["scale"])):
        raise ArgumentError(f"found {given['scale']}, {wrong}", "scale")
    return as_read(made, **given)


def _limits(limits: Any) -> tuple[Number, Number]:
    if not isinstance(limits, Sequence) or len(limits) != 2:
        raise ArgumentError(
            f"found {shortened(repr(limits))}, expected two numbers (low, high)", "range"
        )
    low, high = (Number.of(end, f"range[{k}]") for k, end in enumerate(limits))
    return low, high


def _kind(quantity: str, platform: Geometry, base: Geometry) -> Kind:
    sorts = platform.primitive, base.primitive
    kind = KINDS_BY_NAME.get(quantity[0].upper() + sorts[0].value + sorts[1].value)
    if kind is None:
        exist = DISTANCE_KINDS if quantity == "distance" else ANGLE_KINDS
        names = " ".join(known.short for known in exist)
        raise ArgumentError(
            f"found the {quantity} of a {_SORTS[sorts[0]]} and a {_SORTS[sorts[1]]}, "
            f"expected one of {names}: there is no other"
        )
    return kind


def instance(
    constraints: Iterable[Constraint],
    *,
    length: str = "mm",
    angle: AngleUnit | str = AngleUnit.DEGREE,
    name: str | None = None,
    source: str | None = None,
) -> Instance:
    """Return a generalized Stewart platform from its six constraints.

    Parameters
    ----------
    constraints
        Six of `distance` and `angle`.
    length
        The name of the unit of length.
    angle
        The unit of angles, ``deg`` or ``rad``.
    name, source
        The name and the source of the platform.

    Raises
    ------
    ArgumentError
        Naming what is wrong, such as ``constraints[4].value``.

    Examples
    --------
    >>> axis = Line([0, 0, 0], [0, 0, 1])
    >>> tilted = Line([1, 0, 0], [0, "sqrt(3)/2", 0.5])
    >>> floor = Plane([0, 0, 0], [0, 0, 1])
    >>> points = [Point([x, y, 0]) for x, y in ((0, 0), (3, 0), (0, 4))]
    >>> made = instance(
    ...     [distance(point, axis, 6) for point in points]
    ...     + [angle(tilted, axis, 60), angle(axis, floor, 30), angle(floor, floor, 80)]
    ... )
    >>> str(made.type)
    'DPL DPL DPL ALL ALH AHH'
    """
    units = [known.value for known in AngleUnit]
    if angle not in (*AngleUnit, *units):
        raise ArgumentError(f"found {shown(str(angle))}, expected {listed(units)}", "angle")
    rows = list(constraints)
    for index, row in enumerate(rows):
        if not isinstance(row, Constraint):
            raise ArgumentError(
                f"found a {type(row).__name__}, expected a Constraint: use distance or angle",
                f"constraints[{index}]",
            )
    platform, base = _Names(), _Names()
    named = tuple(
        replace(row, platform_name=platform.of(row.platform), base_name=base.of(row.base))
        for row in rows
    )
    return checked(Instance(named, Units(length, AngleUnit(angle)), name, source))


class _Names:
    """Names of the primitives of a body, in the order of their first use."""

    def __init__(self) -> None:
        self.names: dict[Geometry, str] = {}
        self.counts = {"P": 0, "L": 0, "H": 0}

    def of(self, geometry: Geometry) -> str:
        """Return the name of a primitive; equal primitives have one name."""
        name = self.names.get(geometry)
        if name is None:
            letter = geometry.primitive.value
            self.counts[letter] += 1
            name = self.names[geometry] = f"{letter}{self.counts[letter]}"
        return name
