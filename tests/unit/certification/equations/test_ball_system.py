"""None"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from flint import acb, arb, ctx, fmpq

from gspcli.catalogue.kinds import DPL, KINDS
from gspcli.certification.equations.ball_system import (
    BallSystem,
    PoseBall,
    measure,
    pose_of_point,
    residual,
)
from gspcli.certification.numbers.balls import float_above
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Point, vector
from gspcli.geometry.study import product

SINGLE = "DPP DPH DHP DPP ALL ALH"
MIXED = [SINGLE, "DPP DPL DLP DPH DHP DLL", "DPL DPL DLL ALL ALH AHH", "DLP DLL DHP DPP AHL AHH"]


def exact(known) -> PoseBall:
    def entry(value) -> acb:
        return acb(arb(fmpq(value.numerator, value.denominator)))

    return PoseBall([[entry(x) for x in row] for row in known.R], [entry(x) for x in known.T])


def scaled(pose: PoseBall, scale: float) -> PoseBall:
    return PoseBall(pose.rotation, [entry / scale for entry in pose.translation])


def quaternion(R) -> list[float]:
    """Return a quaternion of an exact rotation (its trace part must not vanish)."""
    return [
        1 + R[0][0] + R[1][1] + R[2][2],
        R[2][1] - R[1][2],
        R[0][2] - R[2][0],
        R[1][0] - R[0][1],
    ]


def study_point(known, scale: float) -> list[acb]:
    e = [acb(arb(fmpq(x.numerator, x.denominator))) for x in quaternion(known.R)]
    T = [entry / scale for entry in exact(known).translation]
    return [*e, *(entry / 2 for entry in product([acb(0), *T], e))]


@pytest.mark.parametrize("kind", KINDS, ids=str)
@pytest.mark.parametrize("sided", [True, False])
def test_an_exact_solution_solves_the_equations_of_its_kind(
    kind, sided: bool, known: Callable
) -> None:
    for seed in range(3):
        platform = known(" ".join([kind.name] * 6), seed, sided=sided)
        with ctx.workprec(200):
            system = BallSystem(platform.instance, 200)
            point = study_point(platform, system.scale)
            values, _ = system.at(
                point, system.sides_near(point, pose_of_point(point), (0,) * 6)[0]
            )
            assert all(value.contains(0) for value in values.entries())
            assert max(float_above(value) for value in values.entries()) < 1e-40
            assert not system.excludes(scaled(exact(platform), system.scale))
            measured = measure(system, scaled(exact(platform), system.scale))
            assert residual(measured) < 1e-25


@pytest.mark.parametrize("names", MIXED)
def test_a_pose_off_by_little_is_excluded(names: str, known: Callable) -> None:
    platform = known(names, 7)
    with ctx.workprec(100):
        system = BallSystem(platform.instance, 100)
        pose = scaled(exact(platform), system.scale)
        moved = PoseBall(pose.rotation, [pose.translation[0] + arb(1e-9), *pose.translation[1:]])
        assert system.excludes(moved)
        assert not system.excludes(moved.widened(2e-9, 1.0))
        assert residual(measure(system, moved)) > 1e-12


def test_the_wrong_side_is_excluded(known: Callable) -> None:
    platform = known("DPH DHP DPH DHP DPH DHP", 1)
    other = {Side.POSITIVE: Side.NEGATIVE, Side.NEGATIVE: Side.POSITIVE}
    for k, row in enumerate(platform.instance.constraints):
        rows = list(platform.instance.constraints)
        rows[k] = replace(row, side=other[row.side])
        with ctx.workprec(100):
            system = BallSystem(Instance(tuple(rows), platform.instance.units), 100)
            assert system.excludes(scaled(exact(platform), system.scale))


@pytest.mark.parametrize("names", MIXED)
def test_the_jacobian_is_the_derivative(names: str, known: Callable) -> None:
    source = np.random.default_rng(2)
    with ctx.workprec(300):
        system = BallSystem(known(names, 3).instance, 300)
        point = [acb(x, y) for x, y in source.standard_normal((8, 2)).tolist()]
        _, jacobian = system.at(point, (0,) * 6)
        h = arb(2) ** -100
        for column in range(8):
            ends = []
            for sign in (1, -1):
                moved = list(point)
                moved[column] += sign * h
                ends.append(system.at(moved, (0,) * 6)[0])
            slope = (ends[0] - ends[1]) / (2 * h)
            for row in range(7):
                assert abs(slope[row, 0] - jacobian[row, column]) < 1e-50


def test_curvatures_bound_the_second_derivatives() -> None:
    """For a point on a line through both origins hardly anything cancels in them."""
    origin, third = vector(0, 0, 0), vector(0, 0, 1)
    row = Constraint(DPL, Point(origin), Line(origin, third), Number.of("0.99"))
    instance = Instance((row,) * 6, Units("m", AngleUnit.DEGREE))
    point, h = np.array([1.0, 1, 1, 1, 0, 0, 0, 0]), 1e-6
    with ctx.workprec(128):
        system = BallSystem(instance, 128)
        bounds = system.curvatures(np.abs(point))
        total = np.zeros(7)
        for column in range(8):
            ends = []
            for sign in (1, -1):
                moved = point.copy()
                moved[column] += sign * h
                _, jacobian = system.at([acb(x) for x in moved.tolist()], (0,) * 6)
                ends.append(np.array([[complex(x) for x in r] for r in jacobian.tolist()]))
            total += np.abs(ends[0] - ends[1]).sum(axis=1) / (2 * h)
    assert (total <= bounds * (1 + 1e-6)).all()
    assert (total > bounds / 4).all()


@pytest.mark.parametrize("names", MIXED)
def test_the_jacobian_varies_no_more_than_its_curvature_allows(names: str, known: Callable) -> None:
    source = np.random.default_rng(4)
    radius = 0.125
    with ctx.workprec(64):
        system = BallSystem(known(names, 4).instance, 64)
        centre = source.standard_normal(8) + 1j * source.standard_normal(8)
        bounds = system.curvatures(np.abs(centre) + radius + 1e-9)
        _, before = system.at([acb(x) for x in centre.tolist()], (0,) * 6)
        for _ in range(50):
            shift = source.standard_normal(8) + 1j * source.standard_normal(8)
            shift *= radius / np.abs(shift).max()
            _, after = system.at([acb(x) for x in (centre + shift).tolist()], (0,) * 6)
            change = np.array([[float_above(x) for x in r] for r in (after - before).tolist()])
            assert (change.sum(axis=1) <= bounds * radius).all()


# Poses of Study points in balls.


def test_a_ball_that_holds_a_point_without_norm_is_no_pose() -> None:
    """N is zero for (1, i, 0, 0): also away from the middle of the ball."""
    rest = [acb(0)] * 6
    for middle, radius, is_pose in ((1 + 1e-10, 1e-9, False), (1 + 1e-8, 1e-9, True)):
        point = [acb(1), acb(0, arb(middle, radius)), *rest]
        assert (pose_of_point(point) is not None) is is_pose
