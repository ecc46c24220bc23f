"""Every chain over the kinds of constraint ends in an error for one that it does not know."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from flint import ctx

from gspcli import Line, Plane, Point, distance, measure, solve
from gspcli.catalogue.kinds import ANGLE_KINDS, Kind, Law, Primitive, Quantity
from gspcli.certification.branches.parametric_quadrics import moving_equations
from gspcli.certification.counting import count_exactly
from gspcli.certification.counting.modular_platform import ModularPlatform
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.local_frames import OWN
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.export.chains import chain
from gspcli.export.polynomial_systems import study, system
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.expressed_instances import home_value
from gspcli.geometry.instance import AngleUnit, Constraint, HomePose, Instance, Side, Units
from gspcli.geometry.measurement import jacobian, polynomial
from gspcli.geometry.numbers import Number
from gspcli.geometry.study import _FORMS as forms
from gspcli.geometry.study import base_height
from gspcli.geometry.three_angles import measures
from gspcli.pictures.stage import connection
from gspcli.solver.study_systems import target_systems
from tools.atlas.groebner import FramedPrimitive, equation

#: What a wider definition might add: the distance of two parallel planes.
PLANES = Kind(Quantity.DISTANCE, Primitive.PLANE, Primitive.PLANE, 10, Law.SIGNED, "a")
BODY = FramedPrimitive((0, 0, 1), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
ENDS = Plane([0, 0, 1], [0, 1, 1]), Plane([0, 0, 2], [0, 1, 1])
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


@pytest.mark.parametrize(
    "use",
    [
        lambda kind: target_systems(arrangement(kind).normalized),
        lambda kind: BallSystem(platform(kind), 64),
        lambda kind: moving_equations(platform(kind)),
        lambda kind: ModularPlatform(platform(kind), 0).equations([1] * 6),
        lambda kind: home_value(kind, Side.BOTH, *ENDS, HomePose([0, 0, 1]), AngleUnit.DEGREE),
    ],
    ids=["paths", "proofs", "moving values", "count", "value at home"],
)
def test_equations_of_a_kind_follow_from_its_quadrics(
    use: Callable[[Kind], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A kind of a law that there is needs no other statement to be solved, proved and counted."""
    kind = Kind(Quantity.DISTANCE, Primitive.PLANE, Primitive.PLANE, 10, Law.SIGNED, "p")
    monkeypatch.setitem(forms, kind, lambda a, b, u, v: [base_height(a, b, v)])
    with ctx.workprec(64):
        use(kind)


@pytest.mark.parametrize("kind", ANGLE_KINDS, ids=str)
def test_the_law_of_an_angle_is_that_of_its_equation(kind: Kind) -> None:
    """The law in the table of the kinds against the angle of the wedge of the two primitives."""
    planes = (kind.platform, kind.base).count(Primitive.PLANE)
    for angle in (0.3, 1.1, 2.5):
        stated = kind.law.sign * (math.cos(angle) if kind.law.is_cosine else math.sin(angle))
        assert stated == pytest.approx(math.cos(planes * math.pi / 2 - angle), abs=1e-15)
