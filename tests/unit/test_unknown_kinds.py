"""Every chain over the kinds of constraint ends in an error for one that it does not know."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gspcli import Line, Plane, Point, distance, measure, solve
from gspcli.catalogue.kinds import ANGLE_KINDS, Kind, Law, Primitive, Quantity
from gspcli.certification.counting import count_exactly
from gspcli.certification.equations.local_frames import OWN
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.export.chains import chain
from gspcli.export.polynomial_systems import study, system
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.measurement import jacobian, polynomial
from gspcli.geometry.numbers import Number
from gspcli.geometry.three_angles import measures
from gspcli.pictures.stage import connection
from gspcli.solver.study_systems import target_systems
from tools.atlas.groebner import FramedPrimitive, equation

#: What a wider definition might add: the distance of two parallel planes.
PLANES = Kind(Quantity.DISTANCE, Primitive.PLANE, Primitive.PLANE, 10, Law.SIGNED, "a")
BODY = FramedPrimitive((0, 0, 1), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
Z, UNIT = np.zeros(3), np.array([0.0, 0.0, 1.0])
ONE = np.ones((1, 6))


def platform(kind: Kind) -> Instance:
    sorts: dict[Primitive, Any] = {
        Primitive.POINT: Point([0, 0, 1]),
        Primitive.LINE: Line([0, 0, 1], [0, 1, 1]),
        Primitive.PLANE: Plane([0, 0, 1], [0, 1, 1]),
    }
    odd = Constraint(kind, sorts[kind.platform], sorts[kind.base], Number.of(1))
    legs = [distance(Point([k, k * k, 1]), Point([1, k, k**3]), k + 1) for k in range(5)]
    return Instance((odd, *legs), Units("mm", AngleUnit.DEGREE))


def arrangement(kind: Kind) -> Arrangement:
    return Arrangement.of(platform(kind))


STATEMENTS: dict[str, Callable[[Kind], Any]] = {
    "polynomial": polynomial,
    "forms of distances": lambda kind: measures(arrangement(kind)),
    "quadrics": lambda kind: target_systems(arrangement(kind).normalized),
    "proofs of values": lambda kind: ValueProofs(platform(kind), ONE).decide(
        ONE, np.zeros((1, 1, 1, 8), complex), OWN, rows=ONE
    ),
    "exact count": lambda kind: count_exactly(platform(kind)),
    "equation modulo a prime": lambda kind: equation(kind, BODY, BODY, 1),
    "exported system": lambda kind: system(platform(kind), study()),
    "exported chain": lambda kind: chain(kind, Z, UNIT, UNIT, UNIT),
    "connection in a picture": lambda kind: connection(kind, Z, UNIT, Z, UNIT),
}
#: They follow from these.
DERIVED: dict[str, Callable[[Kind], Any]] = {
    "measure": lambda kind: measure(platform(kind), np.eye(3), np.zeros(3)),
    "jacobian": lambda kind: jacobian(arrangement(kind), np.eye(3)[None], np.zeros((1, 3))),
    "solve": lambda kind: solve(platform(kind)),
}


@pytest.mark.parametrize("what", [*STATEMENTS, *DERIVED])
def test_an_unknown_distance_is_an_error(what: str) -> None:
    with pytest.raises((ValueError, KeyError), match=PLANES.name):
        (STATEMENTS | DERIVED)[what](PLANES)


@pytest.mark.parametrize("kind", ANGLE_KINDS, ids=str)
def test_the_law_of_an_angle_is_that_of_its_equation(kind: Kind) -> None:
    """The law in the table of the kinds against the angle of the wedge of the two primitives."""
    planes = (kind.platform, kind.base).count(Primitive.PLANE)
    for angle in (0.3, 1.1, 2.5):
        stated = kind.law.sign * (math.cos(angle) if kind.law.is_cosine else math.sin(angle))
        assert stated == pytest.approx(math.cos(planes * math.pi / 2 - angle), abs=1e-15)
