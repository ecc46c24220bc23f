"""Clearances of made-up equations and screws, of which all singularities are known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.certification.branches.parametric_quadrics import MovingEquations, Shape, ValueFunction
from gspcli.geometry.random_instances import random_instance
from gspcli.motion.following.branch_follower import MovingPlatform
from gspcli.motion.singularities import pose_clearances
from gspcli.motion.singularities.neighbourhoods import Neighbourhood
from gspcli.motion.singularities.pose_clearances import (
    Displacements,
    Regular,
    Screws,
    _divided,
    regular,
)
from tests.support.systems import quadric

#: Equations about x^2 = c on points (1, x, 0, ...), with a double solution at c = 0: shape, A, B.
EQUATIONS = {
    "plain": (Shape.PLAIN, quadric(e11=1), None),
    "product": (Shape.PRODUCT, quadric(e11=2), quadric(e01=1)),
    "product of squares": (Shape.PRODUCT, quadric(e11=1), quadric(e11=3)),
    "lines": (Shape.LINES, quadric(e01=1), quadric(e01=1)),
    "lines that turn": (Shape.LINES, quadric(e01=1), quadric(e11=3)),
}
#: The law of the value, and the value at which c is some number.
LAWS = {
    "linear": (ValueFunction.LINEAR, lambda c: c),
    "square": (ValueFunction.SQUARE, np.sqrt),
    "sine": (ValueFunction.SINE, np.arcsin),
}


def residual(name: str, c: float, x: float) -> float:
    shape, a, b = EQUATIONS[name]
    z = np.array([1, x, 0, 0, 0, 0, 0, 0])
    n, first = 1 + x * x, z @ a @ z / 2
    second = 0.0 if b is None else z @ b @ z / 2
    return {
        Shape.PLAIN: first - c * n,
        Shape.PRODUCT: n * (first - c * n) - second**2,
        Shape.LINES: first**2 - c * (n * n - second**2),
    }[shape]


def solution(name: str, c: float) -> float:
    """Return the positive x for a number c that is not negative."""
    low, high = 0.0, 1.6 * np.sqrt(c) + 1e-300
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (low, middle) if residual(name, c, middle) > 0 else (middle, high)
    return low


def near(name: str, law: str, c: float) -> tuple[Neighbourhood, float]:
    """Return the equations near the solution for a number c, and the value."""
    shape, a, b = EQUATIONS[name]
    hessians = np.zeros((6, 2, 8, 8))
    hessians[0, 0] = a
    hessians[1:, 0] = [quadric(**{f"e0{k}": 1}) for k in (2, 3, 5, 6, 7)]
    if b is not None:
        hessians[0, 1] = b
    sizes = np.linalg.norm(hessians, ord=2, axis=(2, 3))
    platform = MovingPlatform.__new__(MovingPlatform)
    platform.equations = MovingEquations(
        1.0,
        np.array([shape, *[Shape.PLAIN] * 5], np.int32),
        np.array([LAWS[law][0], *[ValueFunction.LINEAR] * 5], np.int32),
        np.ones(6),
        hessians,
        sizes,
        sizes,
    )
    x, value = solution(name, c), float(LAWS[law][1](c))
    z = np.array([1, x, 0, 0, 0, 0, 0, 0]) / np.hypot(1, x)
    values = np.zeros((1, 6))
    values[0, 0] = value
    return Neighbourhood(platform, z[None], values), value


SHARES = (0.1, 0.3, 0.6, 0.9, 0.99, 1.001, 1.1, 1.4, 2.0, 4.0)


@pytest.mark.parametrize("name", EQUATIONS)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("c", [1e-6, 1e-3, 0.01])
def test_no_box_of_values_reaches_over_a_singularity(name: str, law: str, c: float) -> None:
    there, value = near(name, law, c)
    for share in SHARES:
        box = there.box(np.array([share * value, 0, 0, 0, 0, 0]))
        assert share < 1 or not box.measure[0] < 1
        assert share > 0.2 or box.measure[0] < 1


@pytest.mark.parametrize("name", EQUATIONS)
@pytest.mark.parametrize("law", LAWS)
def test_solutions_are_as_near_as_a_box_says(name: str, law: str) -> None:
    """On the patch of the point; and as near to the change of first order."""
    c = 0.01
    there, value = near(name, law, c)
    z, claims = there.points[0], 0
    for share in SHARES:
        box = there.box(np.array([share * value, 0, 0, 0, 0, 0]))
        if not box.measure[0] < 1:
            continue
        claims += 1
        for way in (-1, -0.5, 0.5, 1):
            moved = value * (1 + way * share)
            number = {"linear": moved, "square": moved**2, "sine": np.sin(moved)}[law]
            other = np.array([1, solution(name, number), 0, 0, 0, 0, 0, 0])
            change = other / (z @ other) - z
            assert np.linalg.norm(change) <= box.radius[0] * (1 + 1e-9)
            assert np.linalg.norm(change - way * box.shifts[0, 0]) <= box.rest[0] * (1 + 1e-9)
    assert claims


TYPES = [
    "6PP",
    "6DLP",
    "3PP 3DPL",
    "DPP DPP DPH DHP DPP DPP",
    "DLL DLL DPP DPP DPP DPP",
    "4PP ALL AHL",
]


@pytest.mark.parametrize("kinds", TYPES)
@pytest.mark.parametrize("cube", [True, False])
def test_no_pose_of_a_set_that_is_regular_is_singular(kinds: str, cube: bool) -> None:
    """The largest sets about a pose that are proved, and determinants in them: of one sign."""
    proved = 0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        instance, (R, T) = random_instance(parse_type(kinds), rng)
        try:
            home = Displacements(instance, R[None], T[None], rng.normal(size=(4, 3)))
        except ValueError:
            continue
        screws = Screws(home)
        middle = 0.3 * rng.normal(size=(1, 6)) * home.farthest / 4
        ways = rng.normal(size=(400, 6))
        ways /= (
            np.abs(ways).max(axis=1, keepdims=True)
            if cube
            else np.linalg.norm(ways, axis=1)[:, None]
        )
        for size in np.geomspace(1e-3, 1, 14) * home.farthest:
            half = np.full((1, 6), size) * [1, 1, 1, 0.7, 0.7, 0.7]
            sign = screws.judge(middle, half, cube=cube).sign[0]
            if not sign:
                break
            proved += 1
            inside = middle + ways * half
            inside = inside[home.turns(inside) < 1]
            many = Displacements(
                instance,
                np.repeat(R[None], len(inside), 0),
                np.repeat(T[None], len(inside), 0),
                home.points,
            )
            found = np.sign(many.determinants(inside))
            assert abs(found.sum()) == len(found)
    assert proved


def compared(rows, linear, rest, *, cube: bool) -> float:
    """Return the sign that matrices are proved to have."""
    return float(regular(rows[None], linear[None], rest[None], cube=cube)[0][0])


@pytest.mark.parametrize("cube", [True, False])
def test_matrices_are_regular_up_to_where_one_is_singular(cube: bool) -> None:
    """The unit matrix with a first entry 1 - s x, x from -1 to 1, and one of two by two."""
    nothing = np.zeros((6, 6))
    for size in (0.1, 0.5, 0.95, 1.0, 1.05, 1.5, 1.9, 3):
        linear = np.zeros((6, 6, 6))
        linear[0, 0, 0] = size
        assert (compared(np.eye(6), linear, nothing, cube=cube) == 1) == (size < 1)
        # Off the diagonal, both ways: 1 - s^2.
        linear = np.zeros((6, 6, 6))
        linear[0, 1, 0] = linear[1, 0, 0] = size
        assert (compared(np.eye(6), linear, nothing, cube=cube) == 1) == (size < 1)
        # The same for the terms of higher order.
        rest = np.zeros((6, 6))
        rest[0, 0] = size
        assert (compared(np.eye(6), 0 * linear, rest, cube=cube) == 1) == (size < 1)
    swapped = np.eye(6)[[1, 0, 2, 3, 4, 5]]
    assert compared(swapped, np.zeros((6, 6, 6)), nothing, cube=cube) == -1


@pytest.mark.parametrize("cube", [True, False])
def test_several_parameters_move_a_matrix_further_in_a_cube(cube: bool) -> None:
    """Four that each move the first entry by 0.4: by 1.6 in a cube, by 0.8 in a ball."""
    linear = np.zeros((6, 6, 6))
    linear[0, 0, :4] = 0.4
    assert (compared(np.eye(6), linear, np.zeros((6, 6)), cube=cube) == 1) == (not cube)


def test_a_ball_that_is_divided_ends_before_the_nearest_singular_pose(monkeypatch) -> None:
    """The singular poses are those beyond a plane at 0.7, or beyond a corner."""
    monkeypatch.setattr(pose_clearances, "_BOXES", 3000)
    home = SimpleNamespace(turns=lambda s: np.zeros(len(s)))

    def judged(is_free):
        def judge(s, half, *, cube):
            assert cube
            sign = np.where(is_free(s, half), 1.0, 0.0)
            return Regular(sign, half * 1.0)

        return SimpleNamespace(judge=judge, home=home)

    plane = judged(lambda s, half: (s + half)[:, 0] < 0.7)
    assert 0.55 < _divided(plane, 0.5, 1.2) <= 0.7
    corner = judged(lambda s, half: ((s + half)[:, :2] < 0.7).any(axis=1))
    found = _divided(corner, 0.5, 1.2)
    assert 0.7 < found <= 0.7 * np.sqrt(2)
    nothing = judged(lambda s, half: np.ones(len(s), bool))
    assert 1.49 < _divided(nothing, 0.1, 1.5) <= 1.5
