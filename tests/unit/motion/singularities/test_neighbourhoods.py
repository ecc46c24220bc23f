"""Boxes of values about an angle of zero, where a cosine changes to second order alone."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.certification.branches.parametric_quadrics import (
    MovingEquations,
    Shape,
    ValueFunction,
    moving_equations,
)
from gspcli.geometry.enclosures import Enclosure, Jet
from gspcli.geometry.random_instances import random_instance
from gspcli.motion.following.branch_follower import MovingPlatform, apart
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.singularities.neighbourhoods import Neighbourhood, equations
from tests.support.enclosures import Exact, ExactJet, mp, outside


def test_a_cosine_changes_at_an_angle_of_zero() -> None:
    """x^2 / (1 + x^2) = cos v - 0.99 has a double solution at cos v = 0.99."""
    hessians = np.zeros((6, 2, 8, 8))
    hessians[0, 0, :4, :4] = np.diag([1.98, 3.98, 1.98, 1.98])
    for k, j in enumerate((2, 3, 5, 6, 7), 1):
        hessians[k, 0, 0, j] = hessians[k, 0, j, 0] = 1
    sizes = np.linalg.norm(hessians, ord=2, axis=(2, 3))
    platform = MovingPlatform.__new__(MovingPlatform)
    laws = np.array([ValueFunction.COSINE, *[ValueFunction.LINEAR] * 5], np.int32)
    shapes = np.full(6, Shape.PLAIN, np.int32)
    platform.equations = MovingEquations(1.0, shapes, laws, np.ones(6), hessians, sizes, sizes)
    x = np.sqrt(0.01 / 0.99)
    point = np.array([1, x, 0, 0, 0, 0, 0, 0]) / np.hypot(1, x)
    there = Neighbourhood(platform, point[None], np.zeros((1, 6)))
    singular = np.arccos(0.99)
    for share, proved in ((0.3, True), (1.01, False), (1.5, False)):
        box = there.box(np.array([share * singular, 0, 0, 0, 0, 0]))
        assert (box.measure[0] < 1) == proved


# The equations near poses: enclosures of values and derivatives contain those of exact members.


@pytest.mark.parametrize("name", ["PP PL LP PH HP DLL", "PP DPL DLL ALL ALH AHH"])
@pytest.mark.parametrize("reach", [0.0, 1e-9, 0.1])
def test_members_are_enclosed(name: str, reach: float) -> None:
    """The coefficient, the point and the matrices are members at the edge, or exact."""
    rng = np.random.default_rng(3)
    instance, _ = random_instance(parse_type(name), rng)
    given = moving_equations(instance)
    for k in range(6):
        for _ in range(6):
            z, c = rng.normal(size=8), rng.normal(size=1)
            room = reach * rng.integers(0, 2)
            moduli = given.moduli[[k]] * 10.0 ** rng.choice([0, 8])
            spectral = given.spectral[[k]]
            one = SimpleNamespace(
                shapes=given.shapes[[k]],
                hessians=given.hessians[[k]],
                spectral=spectral,
                moduli=moduli,
            )
            platform = SimpleNamespace(equations=one)
            points = Enclosure(z[None, None], reach)
            ((_, found, factor),) = equations(platform, points, Enclosure(c[None, None], room))
            for _ in range(3):
                x = Exact(z, rng).member(reach)
                number = Exact(c, rng).member(room)
                ((_, true, other),) = equations(platform, x, number, ExactJet)
                for enclosed, exact in ((found, true), (factor, other)):
                    assert_contains(enclosed, exact)


def assert_contains(found: Jet, exact: ExactJet) -> None:
    value, gradient = found.value, found.gradient
    assert outside(Enclosure(value.mid.ravel(), value.rad), Exact([exact.value])) <= 0
    assert outside(Enclosure(gradient.mid.ravel(), gradient.rad), exact.gradient) <= 0
    middle = np.reshape(found.bend.mid, (8, 8))
    off = [row - Exact(at) for row, at in zip(exact.bend, middle, strict=True)]
    values = mp.eigsy(mp.matrix([row.x for row in off]), eigvals_only=True)
    assert max(abs(x) for x in values) <= mp.mpf(float(np.squeeze(found.bend.rad)))


def test_derivatives_are_those_of_differences() -> None:
    """Of values, and of gradients: a wrong formula would be wrong in enclosures and members."""
    rng = np.random.default_rng(1)
    instance, (R, T) = random_instance(parse_type("PP PL LP PH ALL DLL"), rng)
    platform = MovingPlatform(apart(instance))
    values = platform.internal(values_at(instance, R[None], T[None]))
    z = platform.points(R[None], T[None])
    here = Neighbourhood(platform, z, values)
    assert np.abs(here.residuals).max() < 1e-12
    np.testing.assert_allclose(here.jacobian, platform.jacobian(z[0], values[0])[None], atol=1e-13)
    h = 1e-6
    for step in np.eye(8):
        ahead, behind = (Neighbourhood(platform, z + s * h * step, values) for s in (1, -1))
        slope = (ahead.residuals - behind.residuals)[0] / (2 * h)
        np.testing.assert_allclose(here.jacobian[0] @ step, slope, atol=1e-7)
        bend = (ahead.jacobian - behind.jacobian)[0] / (2 * h)
        np.testing.assert_allclose(here.hessians[0] @ step, bend, atol=1e-7)
        slope = (ahead.factors - behind.factors)[0] / (2 * h)
        np.testing.assert_allclose(here.factor_gradients[0] @ step, slope, atol=1e-7)
