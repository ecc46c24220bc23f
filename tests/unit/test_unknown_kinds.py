"""Every chain over the kinds of constraint ends in an error for one that it does not know."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gspcli import Line, Plane, Point, certify, distance, measure, solve
from gspcli.atlas.modular_equations import FramedPrimitive, equation
from gspcli.catalogue.counts import law
from gspcli.catalogue.kinds import DPP, Kind, Primitive, Quantity
from gspcli.certification.counting import count_exactly
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.frames import OWN
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.export.chains import chain
from gspcli.export.motion_coordinates import study
from gspcli.export.polynomial_systems import system
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.constraint_polynomials import polynomial
from gspcli.geometry.distance_forms import measures
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.numbers import Number
from gspcli.pictures.strokes import Ends, arms, connection
from gspcli.solver.study_systems import target_systems

#: What a wider definition might add: the distance of two planes, and other angles than the four
#: (the same primitives, but not the same kinds).
PLANES = Kind(Quantity.DISTANCE, Primitive.PLANE, Primitive.PLANE, 10)
LINES = Kind(Quantity.ANGLE, Primitive.LINE, Primitive.LINE, 11)
MIXED = Kind(Quantity.ANGLE, Primitive.LINE, Primitive.PLANE, 12)
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


DISTANCES: dict[str, Callable[[Kind], Any]] = {
    "equation modulo a prime": lambda kind: equation(kind, BODY, BODY, 1),
    "generic count": lambda kind: law((kind, *[DPP] * 5)),
    "forms of distances": lambda kind: measures(arrangement(kind)),
    "connection in a picture": lambda kind: connection(kind, Z, UNIT, Z, UNIT),
}
ANGLES: dict[str, Callable[[Kind], Any]] = {
    "angle in a picture": lambda kind: arms(kind, Ends(Z, Z, UNIT, UNIT)),
    "cosine in balls": lambda kind: BallSystem(platform(kind), 64).statements[0].cosine,
}
EITHER: dict[str, Callable[[Kind], Any]] = {
    "polynomial": polynomial,
    "measured": lambda kind: measured(arrangement(kind), np.eye(3)[None], np.zeros((1, 3))),
    "jacobian": lambda kind: jacobian(arrangement(kind), np.eye(3)[None], np.zeros((1, 3))),
    "measure": lambda kind: measure(platform(kind), np.eye(3), np.zeros(3)),
    "quadrics": lambda kind: target_systems(arrangement(kind).normalized),
    "solve": lambda kind: solve(platform(kind)),
    "certify": lambda kind: certify(platform(kind), np.eye(3)[None], np.zeros((1, 3))),
    "proofs of values": lambda kind: ValueProofs(platform(kind), ONE).decide(
        ONE, ONE, np.zeros((1, 1, 1, 8), complex), OWN
    ),
    "exact count": lambda kind: count_exactly(platform(kind)),
    "exported system": lambda kind: system(platform(kind), study()),
    "exported chain": lambda kind: chain(kind, Z, UNIT, UNIT, UNIT),
}


@pytest.mark.parametrize("kind", [PLANES, LINES, MIXED], ids=str)
@pytest.mark.parametrize("what", [*DISTANCES, *ANGLES, *EITHER])
def test_an_unknown_kind_is_an_error(kind: Kind, what: str) -> None:
    use = EITHER | (DISTANCES if kind.is_distance else ANGLES)
    if what not in use:
        return
    with pytest.raises((ValueError, KeyError), match=kind.name):
        use[what](kind)
