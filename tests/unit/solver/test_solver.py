"""Poses far away of platforms with points and lines, from points in planes."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from flint import acb_mat, arb_mat
from positions import ORIGIN, P, X, Y, Z, angles, at, cylinders, solved, spheres

import gspcli.certification.poses.far_points
from gspcli.catalogue.kinds import DLP, DPL, DPP
from gspcli.catalogue.names import parse_type
from gspcli.certification import Outcome, certify, refine
from gspcli.certification import certify as certify_alone
from gspcli.certification.counting import ExactCount, exact_count, with_points_for_lines
from gspcli.certification.equations.ball_system import BallSystem, heights
from gspcli.certification.poses.far_points import _Equations, far_points
from gspcli.certification.poses.locator import Located
from gspcli.continuation.quadrics import evaluate
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.geometry import study
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import measured, relative_residuals, residuals
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point, vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion.following.tracks import track
from gspcli.motion.singularities.clearances import clearances
from gspcli.pictures.stage import scene_of
from gspcli.solver import SolveResult, all_poses, further, solve
from gspcli.solver import certify as certify_poses
from gspcli.solver.all_poses import far_in_planes
from gspcli.solver.by_count import isolated_real_poses, poses_of_repeated
from gspcli.solver.poses import PoseSet, are_far
from gspcli.solver.problem import Problem
from gspcli.solver.search import Search
from gspcli.solver.side_search import SideSearch
from gspcli.solver.solved_starts import SolvedStarts
from gspcli.solver.study_systems import coefficients_at
from gspcli.spec import loads
from tests.support.posts import PLATE_ON_POSTS
from tests.support.strategies import added

VALUES = [1.2, 1.25, 1.22, 1.21, 0.7, 0.8]


SIX, SIDES = np.arange(6) * np.pi / 3, (-1.0) ** np.arange(6)
PAIRS = np.repeat(SIX[::2], 2)
#: Angles of joints on the platform and on the base, of which six are nearly regular.
ANGLES = PAIRS + 0.9 * SIDES, PAIRS + 0.3 * SIDES
REGULAR = SIX + np.pi / 6 + 0.1 * SIDES, SIX + 0.2 * SIDES


def guided(kinds, axes, digits=None, angles=ANGLES):
    """Return hexagons of which two pairs of joints are a point and a line, rounded to digits."""

    def ring(angles, radius):
        points = radius * np.c_[np.cos(angles), np.sin(angles), 0 * angles]
        points = points if digits is None else points.round(digits)
        return [Point(row) for row in (points + 0.0).tolist()]

    rows = []
    for i, (y, x) in enumerate(zip(ring(angles[0], 0.7), ring(angles[1], 1.0), strict=True)):
        kind, value = (DPP, *kinds)[max(0, i - 3)], Number.of(VALUES[i])
        if i > 3:
            axis = tuple(Number.of(c) for c in axes[i - 4])
            x = Line(x.position, axis) if kind is DPL else x
            y = Line(y.position, axis) if kind is DLP else y
        rows.append(Constraint(kind, y, x, value))
    return Instance(tuple(rows), Units("m", AngleUnit.RADIAN))


UP, IN, ACROSS = (0, 0, 1), (1, 0, 0), (-0.28, 0.96, 0)


@pytest.mark.parametrize(
    ("kinds", "axes", "digits"),
    [
        ((DPL, DPL), (IN, UP), None),
        ((DPL, DPL), (IN, UP), 6),
        ((DPL, DPL), (ACROSS, (-1, 0, 0)), 5),
        ((DLP, DLP), (ACROSS, UP), None),
        ((DLP, DPL), (ACROSS, IN), 4),
    ],
)
def test_poses_far_away_need_neither_more_paths_nor_elimination(kinds, axes, digits, monkeypatch):
    monkeypatch.setattr(TrackedPaths, "track", None)
    monkeypatch.setattr(further, "poses_by_elimination", None)
    found = solve(guided(kinds, axes, digits), starts=SolvedStarts())
    assert found.verdict == "complete"
    assert found.proof is not None
    assert are_far(found.R, found.T, 1.0).sum() >= 8


@pytest.mark.parametrize("digits", [4, 6])
def test_nearly_double_poses_far_away_are_found_from_ends_of_lost_paths(digits, monkeypatch):
    """Between nearly regular hexagons poses far away are pairs of which e hardly differs."""
    instance = guided((DPL, DPL), (IN, UP), digits, REGULAR)
    monkeypatch.setattr(TrackedPaths, "track", None)
    monkeypatch.setattr(further, "poses_by_elimination", None)
    found = solve(instance, starts=SolvedStarts())
    assert found.verdict == "complete"
    assert found.proof is not None
    monkeypatch.setattr(_Equations, "_among_two", lambda *_: None)
    with pytest.raises(TypeError):
        solve(instance, starts=SolvedStarts())


def test_they_are_those_of_the_further_strategies(monkeypatch):
    instance = guided((DPL, DPL), (IN, UP), 3)
    known = solve(instance, starts=SolvedStarts())
    monkeypatch.setattr(SideSearch, "add_far", lambda *_: None)
    other = solve(instance, starts=SolvedStarts())
    for part in ("quaternions", "R", "T", "real"):
        np.testing.assert_array_equal(getattr(known, part), getattr(other, part))


def test_points_in_planes_lead_to_one_of_each_pair_of_conjugates():
    problem = Problem(guided((DPL, DPL), (IN, UP), 6))
    known = solve(problem.instance)
    (ends,) = added(far_in_planes, problem)
    e = ends.points[0, 0, :, :4]
    e = e / np.linalg.norm(e, axis=1, keepdims=True)
    locator, sides = problem.locator, problem.sides[0]
    points = far_points(locator, sides, e, ends.planes)
    both = far_points(
        locator, sides, np.concatenate((e, e.conj())), np.concatenate((ends.planes, -ends.planes))
    )
    assert len(points) == len(both) == are_far(known.R, known.T, 1.0).sum() // 2
    for point in points:
        located = locator.locate_exactly(point, sides, 128)
        assert isinstance(located, Located)
        assert (located.T == known.T).all(axis=1).any()


@pytest.mark.parametrize("name", ["4PP 2PL", "4PP 2LP", "4PP PL LP"])
def test_planes_are_those_of_the_equations_of_proofs(name):
    rng = np.random.default_rng(4)
    turns = []
    for _ in range(8):
        instance, _ = random_instance(parse_type(name), rng)
        given = Arrangement.of(instance)
        _, (g, h, _) = coefficients_at(given)
        system = BallSystem(instance, 53)
        z = rng.normal(size=(3, 8)) + 1j * rng.normal(size=(3, 8))
        # The equations of paths are those of e.f = 0.
        e, f = z[:, :4], z[:, 4:]
        f -= ((e * f).sum(axis=1) / (e * e).sum(axis=1))[:, None] * e
        scaled = np.concatenate((e, f / system.scale), axis=1)
        for k, turn in enumerate(all_poses._turns(given).tolist()):
            if given.kinds[k] not in (DPL, DLP):
                continue
            row = system.statements[k]
            forms = heights(row.a, row.b, row.u, row.v)
            rows = arb_mat([[form.get(i, 0) for i in range(study.COUNT)] for form in forms])
            hessians = arb_mat(study.COUNT, 64, study.form_hessians().ravel().tolist())
            both = np.array([complex(x).real for x in acb_mat(rows * hessians).entries()]).reshape(
                2, 8, 8
            )
            A, B = np.einsum("ni,kij,nj->kn", scaled, both, scaled)
            for quadric, sign in ((g[0, k], turn), (h[0, k], -turn)):
                ratio = (A + 1j * sign * B) / evaluate(quadric[None], z)[..., 0]
                np.testing.assert_allclose(ratio, ratio[0], rtol=1e-8)
            turns.append(turn)
    assert set(turns) == {1, -1}


def test_few_solutions_at_infinity_are_taken_for_pairs_that_are_near_each_other(monkeypatch):
    """With two parallel guide rods paths lead to infinity."""
    calls = []
    among_two = _Equations._among_two

    def counted(*given):
        calls.append(among_two(*given))
        return calls[-1]

    monkeypatch.setattr(_Equations, "_among_two", counted)
    found = solve(guided((DPL, DPL), (IN, IN), 6), starts=SolvedStarts())
    assert found.verdict == "complete"
    assert len(found.R) == 128
    assert calls == [None, None]
    monkeypatch.setattr(gspcli.certification.poses.far_points, "_FAILURES", 100)
    calls.clear()
    solve(guided((DPL, DPL), (IN, IN), 6), starts=SolvedStarts())
    assert len(calls) > 2


# Real poses that cannot move, on sets of complex solutions that are infinite.


#: A ball in a seat at the origin, a ball in a groove along the x axis, a ball on the table: real
#: poses put B at (±40, 0, 0) and C at (0, ±30, 0).
SEAT = """
gsp: 1
units: {{length: mm, angle: deg}}
platform:
  A: {{point: [0, 0, 0]}}
  B: {{point: [40, 0, 0]}}
  C: {{point: [0, 30, 0]}}
base:
  O: {{point: [0, 0, 0]}}
  groove: {{line: {{point: [0, 0, 0], direction: [1, 0, 0]}}}}
  table: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
constraints:
  - {{distance: [A, O], value: 0}}
  - {{distance: [B, groove], value: 0}}
  - {{distance: [C, table], value: 0}}
  - {{distance: [B, O], value: {along}}}
  - {{distance: [C, O], value: 30}}
  - {{distance: [A, table], value: 0}}
"""
#: A shaft in a hole, two points and the direction of which are given, with a key that K = (8 cos t,
#: 8 sin t, 10) stands for: it is 6 - y from the wall.
SHAFT = """
gsp: 1
units: {{length: mm, angle: {unit}}}
platform:
  shaft: {{line: {{point: [0, 0, 0], direction: [0, 0, 2]}}}}
  O: {{point: [0, 0, 0]}}
  E: {{point: [0, 0, 50]}}
  K: {{point: [8, 0, 10]}}
base:
  hole: {{line: {{point: [0, 0, 0], direction: [0, 0, {direction}]}}}}
  end: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
  wall: {{plane: {{point: [0, 6, 0], normal: [0, 1, 0]}}}}
constraints:
  - {{angle: [shaft, hole], value: {angle}}}
  - {{distance: [O, hole], value: 0}}
  - {{distance: [O, end], value: 0}}
  - {{distance: [K, wall], value: {gap}}}
  - {{distance: [E, hole], value: 0}}
  - {{distance: [E, end], value: 50}}
"""


def lone(text: str) -> SolveResult:
    result = solve(loads(text))
    assert result.verdict == "infinite"
    assert result.proof is not None
    return result.lone


def turns(result: SolveResult) -> list[float]:
    """Return the sines of turns about the z axis, which all rotations must be."""
    np.testing.assert_allclose(result.R[:, 2, 2], 1, atol=1e-12)
    return sorted(result.R[:, 1, 0].real.tolist())


def test_ball_in_a_seat() -> None:
    found = lone(SEAT.format(along=40))
    expected = [np.diag([s, t, s * t]) for s in (1.0, -1.0) for t in (1.0, -1.0)]
    assert len(found.R) == len(expected)
    for R in expected:
        assert np.abs(found.R - R).max(axis=(1, 2)).min() < 1e-12
    np.testing.assert_allclose(found.T, 0, atol=1e-12)
    # They are what there is to look at.
    (modes, *_) = scene_of(solve(loads(SEAT.format(along=40)))).series
    assert len(modes) == len(expected)


@pytest.mark.parametrize(("unit", "angle", "direction"), [("deg", 0, 1), ("rad", "pi", -3)])
def test_shaft_in_a_hole(unit: str, angle: object, direction: int) -> None:
    found = lone(SHAFT.format(unit=unit, angle=angle, direction=direction, gap=3))
    # The key is 3 or 9 high, and it reaches up to 8 only.
    np.testing.assert_allclose(turns(found), [3 / 8, 3 / 8], atol=1e-12)


def test_sense_of_a_direction() -> None:
    found = lone(SHAFT.format(unit="deg", angle=180, direction=1, gap=3))
    # Turned over: E is as far below the end as it was above.
    np.testing.assert_allclose(found.R[:, 2, 2], -1, atol=1e-12)
    np.testing.assert_allclose(found.R[:, 1, 0], 3 / 8, atol=1e-12)


@pytest.mark.parametrize(("apart", "poses"), [(5, 0), (0, 2)])
def test_distance_of_parallel_lines(apart: int, poses: int) -> None:
    """Its equation holds at any distance; what is stated does not."""
    text = SHAFT.format(unit="deg", angle=0, direction=1, gap=3)
    other = loads(text.replace("[E, hole], value: 0", f"[shaft, hole], value: {apart}"))
    found = isolated_real_poses(other, lambda platform: solve(platform))
    assert found is not None
    assert len(found) == poses


@pytest.mark.parametrize("size", ["/100000000", "*100000000"])
def test_a_shaft_in_other_units(size: str) -> None:
    """An angle is no length: residuals of both are not compared with the same size."""
    text = SHAFT.format(unit="deg", angle=0, direction=1, gap=3)
    for number in ("50", "8", "10", "6", "3"):
        text = re.sub(rf"(?<=[ \[]){number}(?=[,\]}}])", f"{number}{size}", text)
    found = lone(text)
    np.testing.assert_allclose(turns(found), [3 / 8, 3 / 8], atol=1e-12)


def test_key_that_touches() -> None:
    found = lone(SHAFT.format(unit="deg", angle=0, direction=1, gap=2))
    np.testing.assert_allclose(turns(found), [1 / 2, 1 / 2, 1], atol=1e-7)


def test_planes_that_are_flush() -> None:
    text = """
gsp: 1
units: {length: mm, angle: deg}
platform:
  A: {point: [0, 0, 0]}
  B: {point: [40, 0, 0]}
  C: {point: [0, 30, 0]}
  F: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
  pin: {line: {point: [0, 0, 3], direction: [0, 0, 1]}}
base:
  P: {point: [10, 0, 0]}
  G: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
  Q: {point: [70, 20, 5]}
constraints:
  - {angle: [F, G], value: 180}
  - {distance: [A, G], value: 5, side: positive}
  - {distance: [pin, P], value: 0}
  - {distance: [B, Q], value: 50}
  - {distance: [C, G], value: 5, side: positive}
  - {distance: [B, G], value: 5, side: positive}
"""
    found = lone(text)
    assert len(found.R) == 2
    np.testing.assert_allclose(found.T - [10, 0, 5], 0, atol=1e-12)
    # B turns about (10, 0) at the distance 40: where it is 50 from (70, 20).
    B = found.R @ [40, 0, 0] + found.T
    np.testing.assert_allclose(np.linalg.norm(B - [70, 20, 5], axis=1), 50, atol=1e-9)
    assert not np.allclose(B[0], B[1])


def test_platforms_that_move_have_none() -> None:
    turning = SEAT.format(along=40).replace("[A, table], value: 0", "[B, table], value: 0")
    turning = turning.replace("[C, table]", "[A, table]")
    assert solve(loads(turning)).lone.R.shape == (0, 3, 3)


# Platforms in special positions: their poses, counts and verdicts.


# Platforms in special position: multiple poses, poses at infinity, and motions.


def test_example_6_8_has_64_real_poses():
    result = solved(*cylinders(6, 4, 5), *angles(60))
    assert result.expected == result.counts.found == result.counts.real == 64
    # Table 2 of the paper, with x and y as in equation (17).
    np.testing.assert_allclose(
        np.unique(np.round(np.abs(result.T.real), 9), axis=0),
        [[3 * np.sqrt(6) / 2, 3 * np.sqrt(10) / 2, np.sqrt(10) / 2]],
        atol=1e-9,
    )


def test_no_real_pose_is_an_answer():
    result = solved(*cylinders(6, 1, 1), *angles(60))
    assert result.verdict == "complete"
    assert result.counts.found == 64
    assert result.counts.real == 0


def test_right_angles():
    assert solved(*cylinders(6, 4, 5), *angles(90)).counts.found == 64


def test_equal_directions_are_an_eightfold_rotation():
    result = solved(*cylinders(6, 4, 5), *angles(0))
    assert result.counts.found == result.counts.real == result.counts.singular == 8
    assert result.multiplicity.tolist() == [8] * 8
    np.testing.assert_allclose(result.R, np.tile(np.eye(3), (8, 1, 1)), atol=1e-9)


def test_tangent_spheres_are_double_poses():
    result = solved(*spheres((at(0, 0, 0), 1), (at(2, 0, 0), 1), (at(1, 1, 0), 1)), *angles(60))
    assert result.expected == 16
    assert result.multiplicity.tolist() == [2] * 8
    assert result.verdict == "complete"
    np.testing.assert_allclose(result.T, np.tile([1, 0, 0], (8, 1)), atol=1e-9)


def test_almost_tangent_spheres_are_two_poses():
    """Radii that overlap by 1e-9 leave two poses 1e-4 apart, not one."""
    result = solved(
        *spheres((at(0, 0, 0), 1), (at(2, 0, 0), "1.00000001"), (at(1, 1, 0), 1)), *angles(60)
    )
    assert result.counts.found == 16
    assert result.counts.singular == 0


@pytest.mark.parametrize(
    ("centres", "radii"),
    [
        (((0, 0, 0), (0, 0, 0), (2, 0, 0)), (2, 3, 2)),
        (((0, 0, 0), (2, 0, 0), (4, 0, 0)), (2, 2, 2)),
    ],
    ids=["concentric", "collinear centres"],
)
def test_spheres_that_meet_only_at_infinity(centres, radii):
    result = solved(
        *spheres(*((at(*c), r) for c, r in zip(centres, radii, strict=True))), *angles(60)
    )
    assert result.verdict == "complete"
    assert result.counts.found == 0
    assert result.account.at_infinity == 16


def test_equal_spheres_are_infinite():
    result = solved(
        *spheres((at(1, 0, 0), 2), (at(1, 0, 0), 2)),
        ("DPH", P, Plane(ORIGIN, Z), 1, Side.POSITIVE),
        *angles(60),
    )
    assert result.verdict == "infinite"
    assert result.motions[0].dimension == 1


def test_coaxial_cylinders_are_infinite_or_empty():
    def pair(radius):
        return solved(
            ("DPL", P, Line(ORIGIN, Z), 2),
            ("DPL", P, Line(vector(0, 0, 3), vector(0, 0, -4)), radius),
            ("DPP", P, at(2, 0, 0), 2),
            *angles(60),
        )

    assert pair(1).verdict == "complete"
    assert pair(1).account.at_infinity == 64
    assert pair(2).verdict == "infinite"


def test_parallel_cylinders_lose_half_of_the_poses():
    result = solved(
        ("DPL", P, Line(ORIGIN, Z), 2),
        ("DPL", P, Line(vector(1, 0, 3), Z), 2),
        ("DPP", P, at(1, 1, 0), 2),
        *angles(60),
    )
    assert (result.counts.found, result.account.at_infinity) == (32, 32)


def test_parallel_planes_are_infinite_or_empty():
    def pair(height):
        return solved(
            ("DPH", P, Plane(ORIGIN, Z), 2, Side.POSITIVE),
            ("DPH", P, Plane(vector(0, 0, height), Z), 2, Side.NEGATIVE),
            ("DPH", P, Plane(ORIGIN, X), 2, Side.POSITIVE),
            *angles(60),
        )

    assert pair(1).account.at_infinity == 8
    assert pair(4).verdict == "infinite"
    assert pair(4).motions[0].dimension == 1


def test_planes_through_one_direction():
    result = solved(
        ("DPH", P, Plane(ORIGIN, Z), 1, Side.POSITIVE),
        ("DPH", P, Plane(ORIGIN, X), 1, Side.POSITIVE),
        ("DPH", P, Plane(ORIGIN, vector(1, 0, 1)), 2, Side.POSITIVE),
        *angles(60),
    )
    assert result.verdict == "complete"
    assert result.account.at_infinity == 8


def test_a_distance_of_zero_to_a_plane_has_one_side():
    rows = [("DPH", P, Plane(ORIGIN, d), 0) for d in (X, Y, Z)]
    result = solved(*rows, *angles(60))
    assert result.expected == result.counts.found == result.counts.real == 8


def test_dependent_angles_let_the_platform_turn():
    equal = [("ALL", Line(ORIGIN, Z), Line(ORIGIN, Z), 60)] * 2
    result = solved(*cylinders(6, 4, 5), *equal, ("ALL", Line(ORIGIN, X), Line(ORIGIN, Y), 60))
    assert result.verdict == "infinite"
    motion = result.motions[0]
    assert motion.real
    assert motion.dimension == 1
    assert residuals(result.arrangement, motion.R, motion.T).max() < 1e-9
    assert np.abs(motion.R[-1] - motion.R[0]).max() > 0.3


def test_three_angles_with_one_line_of_the_base():
    """The direction of the base line in the platform is fixed; turning about it is free."""
    base = Line(ORIGIN, Z)
    rows = [("ALL", Line(ORIGIN, d), base, value) for d, value in ((X, 60), (Y, 60), (Z, 45))]
    result = solved(*cylinders(6, 4, 5), *rows)
    assert result.verdict == "infinite"
    assert result.motions[0].real


def test_contradictory_angles_have_no_pose():
    for second, third in ((50, 60), (60, 50)):
        rows = [("ALL", Line(ORIGIN, Z), Line(ORIGIN, Z), value) for value in (60, second)]
        result = solved(
            *cylinders(6, 4, 5), *rows, ("ALL", Line(ORIGIN, X), Line(ORIGIN, Y), third)
        )
        if second != 60:
            assert result.verdict == "complete"
            assert result.counts.found == 0


def test_two_angles_with_one_line_of_the_base_lose_half_of_the_rotations():
    rows = [("ALL", Line(ORIGIN, d), Line(ORIGIN, Z), value) for d, value in ((X, 60), (Y, 50))]
    result = solved(*cylinders(6, 4, 5), *rows, ("ALL", Line(ORIGIN, Z), Line(ORIGIN, X), 60))
    assert (result.counts.found, result.account.at_infinity) == (32, 32)


def test_parallel_lines_keep_their_distance_on_a_cylinder():
    result = solved(
        ("DLL", Line(vector(1, 0, 0), Z), Line(ORIGIN, Z), 1),
        ("DPH", P, Plane(ORIGIN, X), "0.5"),
        ("DPH", P, Plane(ORIGIN, Z), 2),
        ("ALL", Line(ORIGIN, Z), Line(ORIGIN, Z), 0),
        ("ALL", Line(ORIGIN, Y), Line(ORIGIN, Y), 50),
        ("ALL", Line(ORIGIN, Y), Line(ORIGIN, X), 40),
    )
    # The lines are parallel at every pose: what is counted is the distance of a point from a line.
    assert result.verdict == "complete"
    assert result.proof is not None
    assert result.counts.real > 0
    assert result.residuals[result.real].max() < 1e-10
    assert (result.multiplicity > 1).all()


def test_motions_through_infinite_sets_satisfy_the_constraints():
    result = solved(
        ("DPL", P, Line(ORIGIN, Z), 2),
        ("DPL", P, Line(vector(4, 0, 0), Z), 2),
        ("DPL", P, Line(vector(2, 2, 0), Z), 2),
        *angles(60),
    )
    assert result.verdict == "infinite"
    motion = result.motions[0]
    np.testing.assert_allclose(motion.T[:, :2], np.tile([2, 0], (len(motion.T), 1)), atol=1e-9)


def test_motion_with_lines_kept_parallel():
    """Three angles of zero with one direction: the platform turns about that direction."""
    up = Line(ORIGIN, Z)
    down = Line(ORIGIN, vector(0, 0, -1))
    result = solved(
        ("DPH", P, Plane(ORIGIN, X), 1),
        ("DPH", P, Plane(ORIGIN, Y), 1),
        ("DPH", P, Plane(ORIGIN, Z), 1),
        ("ALL", up, up, 0),
        ("ALL", up, down, 180),
        ("ALL", down, down, 0),
    )
    assert result.verdict == "infinite"
    motion = result.motions[0]
    assert motion.real
    np.testing.assert_allclose(motion.R[:, 2], np.tile([0, 0, 1], (len(motion.R), 1)), atol=1e-9)


def test_a_line_that_coincides_with_another():
    """Distance and angle zero: the position along the line is left to the other distances."""
    result = solved(
        ("DLL", Line(ORIGIN, Z), Line(ORIGIN, Z), 0),
        ("DPH", P, Plane(ORIGIN, Z), 2, Side.POSITIVE),
        ("DPP", P, at(0, 0, 5), 3),
        ("ALL", Line(ORIGIN, Z), Line(ORIGIN, Z), 0),
        ("ALL", Line(ORIGIN, Y), Line(ORIGIN, Y), 50),
        ("ALL", Line(ORIGIN, X), Line(ORIGIN, Z), 90),
    )
    # Curves of complex solutions, with real poses on them that cannot move.
    assert result.verdict == "infinite"
    real = result.lone.T
    assert len(real) > 0
    np.testing.assert_allclose(real, np.tile([0, 0, 2], (len(real), 1)), atol=1e-9)


@pytest.mark.parametrize("kind", ["DPP", "DPL", "DLP", "DPH", "DHP", "DLL"])
def test_distances_of_zero_are_reported_without_a_warning(kind):
    """Their measures have no derivative. Warnings are errors in these tests."""
    shapes = {"P": at(1, 0, 1), "L": Line(vector(1, 0, 1), Y), "H": Plane(vector(1, 0, 1), X)}
    result = solved(
        (kind, shapes[kind[1]], {**shapes, "L": Line(ORIGIN, Z)}[kind[2]], 0),
        ("DPP", at(0, 1, 0), at(0, 2, 1), 2),
        ("DPL", at(0, 0, 1), Line(vector(1, 0, 1), vector(0, 1, 1)), 2),
        *angles(60),
    )
    assert result.verdict == "complete"
    document = result.to_json(everything=True)
    assert len(document["solutions"]) == result.counts.found > result.expected / 2


def test_nearly_equal_spheres_in_more_than_enough_places_still_add_up():
    # Nearly congruent bodies: at some rotations two spheres and a plane are not made out.
    first, second = (
        (3060.000000119, -180.000000216, 4249.999999762),
        (3059.999999193, -179.999999694, 4249.999999953),
    )
    third = (-6180.000000623, 8400.00000013, 9670.000000456)
    minus = [tuple(-x for x in point) for point in (first, second)]
    result = solved(
        ("DPP", at(*first), at(*minus[0]), 15094.570666745),
        ("DPP", at(*second), at(*minus[1]), 15094.570666715),
        (
            "DPH",
            at(*third),
            Plane(vector(6179.999999934, -8400.000000182, -9669.999999036), vector(-7, -6, 6)),
            9024.54545548,
            Side.NEGATIVE,
        ),
        ("ALL", Line(ORIGIN, vector(-7, -6, -6)), Line(ORIGIN, vector(6, 9, -2)), 155.796652974),
        ("ALL", Line(ORIGIN, vector(-6, 9, 2)), Line(ORIGIN, vector(42, -108, 27)), 90),
        ("ALL", Line(ORIGIN, vector(-6, 2, -9)), Line(ORIGIN, vector(-11, -10, 2)), 55.539341925),
    )
    assert (result.verdict, result.counts.found) == ("complete", 16)


# Lines of a DLL that are parallel at every pose: a plate on a table between round posts.


VALUES_OF_SPECIAL = [0, 0, 0, 1.5, 2, 1]


def _spec(*changes: tuple[str, str]) -> Instance:
    text = PLATE_ON_POSTS
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    unused = {"face"} if "[face" not in text else {"F3"}
    kept = [line for line in text.splitlines() if line.split(":")[0].strip() not in unused]
    return loads("\n".join(kept))


@cache
def _planar_counts() -> tuple[int, int]:
    """Count the poses of the plate in its plane: turned, or turned over; complex and real."""
    c, s, x, y = sp.symbols("c s x y")
    holes, posts, radii = [(1, 0), (-1, 1), (0, -2)], [(2, 1), (-2, 2), (1, -3)], ["3/2", 2, 1]
    total = real = 0
    for face in (1, -1):
        equations = [c**2 + s**2 - 1] + [
            (c * a - face * s * b + x - p) ** 2
            + (s * a + face * c * b + y - q) ** 2
            - sp.Rational(r) ** 2
            for (a, b), (p, q), r in zip(holes, posts, radii, strict=True)
        ]
        last = sp.Poly(sp.groebner(equations, x, y, c, s, order="lex").exprs[-1], s)
        total += last.degree()
        real += last.count_roots()
    return total, real


def test_all_poses_are_found_and_proved() -> None:
    result = solve(_spec())
    assert (len(result.R), int(result.real.sum())) == _planar_counts() == (10, 2)
    assert result.verdict == "complete"
    assert result.proof is not None
    assert result.exact_count == 10
    assert result.certified.all()
    assert result.residuals[result.real].max() < 1e-12


@pytest.mark.parametrize(
    ("changes", "poses", "with_multiplicity", "real"),
    [
        pytest.param([("[H3, P3], value: 1", "[H3, P3], value: 0")], 10, 10, 0, id="concentric"),
        # A face on a table is a double solution of the angle's equation.
        pytest.param(
            [("distance: [F3, table], value: 0", "angle: [face, table], value: 180")], 4, 8, 2,
            id="faces",
        ),
        # Of eight choices of sides two leave the plate parallel to the table.
        pytest.param(
            [(f"F{k}: {{point: [{xy}, 0]", f"F{k}: {{point: [{xy}, 1]")
             for k, xy in ((1, "3, 0"), (2, "-1, 2"), (3, "-2, -1"))]
            + [("table], value: 0", "table], value: 1")], 20, 20, 4, id="feet",
        ),
        pytest.param(
            [("H3: {line: {point: [0, -2, 0], direction: [0, 0, 1]",
              "H3: {line: {point: [0, -2, 0], direction: [1, 0, 1]")], 24, 24, 4, id="one skew",
        ),
    ],
)  # fmt: skip
def test_variants(
    changes: list[tuple[str, str]], poses: int, with_multiplicity: int, real: int
) -> None:
    result = solve(_spec(*changes))
    assert result.verdict == "complete"
    assert result.proof is not None
    assert (len(result.R), result.account.found) == (poses, with_multiplicity)
    assert int(result.real.sum()) == real
    assert result.residuals[result.real].max(initial=0) < 1e-9


LONG_FOOT = [
    ("F1: {point: [3, 0, 0]", "F1: {point: [3, 0, 1]"),
    ("[F1, table], value: 0", "[F1, table], value: 1, side: positive"),
]
ONE_SKEW = ("H3: {line: {point: [0, -2, 0], direction: [0, 0, 1]",
            "H3: {line: {point: [0, -2, 0], direction: [1, 0, 1]")  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "poses", "real"),
    [
        # Turned over the plate is tilted, and its lines are not parallel: there it has no pose.
        pytest.param([], 4, 2, id="upright"),
        # By Gröbner bases 12 upright, where two lines are parallel, and 16 turned over.
        pytest.param([ONE_SKEW], 28, 20, id="on both faces"),
    ],
)
def test_lines_parallel_at_some_poses_only(
    changes: list[tuple[str, str]], poses: int, real: int
) -> None:
    result = solve(_spec(*LONG_FOOT, *changes))
    assert result.verdict == "complete"
    assert result.proof is not None
    assert 0 < result.proof.error < 1e-9
    assert result.exact_count == len(result.R) == poses
    assert result.certified.all()
    assert int(result.real.sum()) == real
    assert result.residuals[result.real].max() < 1e-12


@pytest.mark.parametrize("skew", [False, True])
def test_motions_are_proved_where_lines_are_parallel_and_where_not(skew: bool) -> None:
    # Four feet, so that one is too many, and two posts.
    changes = [
        ("H1:", "F4: {point: [5, 5, 0]}\n  H1:"),
        ("distance: [H3, P3], value: 1", "distance: [F4, table], value: 0"),
        ("  H3: {line: {point: [0, -2, 0], direction: [0, 0, 1]}}\n", ""),
        ("  P3: {line: {point: [1, -3, 0], direction: [0, 0, 1]}}\n", ""),
    ]
    if skew:
        changes += [
            (f"H{k}: {{line: {{point: [{p}, 0], direction: [0, 0, 1]",
             f"H{k}: {{line: {{point: [{p}, 0], direction: [1, {k}, 2]")
            for k, p in ((1, "1, 0"), (2, "-1, 1"))
        ]  # fmt: skip
    result = solve(_spec(*changes))
    assert result.verdict == "infinite"
    assert result.proof is not None
    assert 0 < result.proof.error < 1e-9
    assert result.motions
    assert {motion.dimension for motion in result.motions} == {1}


@pytest.mark.parametrize("length", ["1", "sqrt(2)", "sind(41.37)", "1000000"])
def test_both_sides_are_the_plate_on_both_faces(length: str) -> None:
    # Of a foot on either side of the table one leaves the plate upright, and one turned over.
    result = solve(
        _spec(
            ("F1: {point: [3, 0, 0]", f"F1: {{point: [3, 0, {length}]"),
            ("[F1, table], value: 0", f"[F1, table], value: {length}, side: both"),
        )
    )
    assert result.verdict == "complete"
    assert result.proof is not None
    assert (len(result.R), int(result.real.sum())) == _planar_counts()


def test_one_pose_too_few_or_too_many_is_never_complete(monkeypatch: pytest.MonkeyPatch) -> None:
    from gspcli.solver import by_count

    count = by_count.exact_count(_spec(*LONG_FOOT))
    assert count is not None
    (side,) = count.sides
    for wrong in (3, 5):
        parts = tuple(replace(p, solutions=wrong, distinct=wrong) if p.distinct else p
                      for p in side.parts)  # fmt: skip
        other = replace(side, solutions=wrong, distinct=wrong, parts=parts)
        said = replace(count, solutions=wrong, distinct=wrong, sides=(other,))
        monkeypatch.setattr(
            by_count, "exact_count", _told(count.primes, said, by_count.exact_count)
        )
        result = solve(_spec(*LONG_FOOT))
        assert result.verdict == "incomplete"
        assert not result.certified.any()
        monkeypatch.undo()


def _told(
    primes: tuple[int, ...], said: ExactCount, count: Callable[..., ExactCount | None]
) -> Callable[..., ExactCount | None]:
    """Return a count that says something else of one platform."""

    def told(*arguments: Any, **options: Any) -> ExactCount | None:
        found = count(*arguments, **options)
        return said if found is not None and found.primes == primes else found

    return told


def test_the_count_is_that_of_points_for_lines() -> None:
    count, same = exact_count(_spec()), with_points_for_lines(_spec())
    assert count is not None
    assert same is not None
    other = exact_count(same)
    assert other is not None
    assert (count.finite, count.solutions, count.distinct) == (True, 10, 10)
    assert (other.solutions, other.distinct) == (10, 10)
    assert count.sides[0].parallel == (3, 4, 5)
    assert 0 < count.error < 1e-9


def test_lines_that_are_not_parallel_stay_lines() -> None:
    skew = [(f"H{k}: {{line: {{point: [{p}, 0], direction: [0, 0, 1]",
             f"H{k}: {{line: {{point: [{p}, 0], direction: [1, {k}, 3]")
            for k, p in ((1, "1, 0"), (2, "-1, 1"), (3, "0, -2"))]  # fmt: skip
    assert with_points_for_lines(_spec(*skew)) is None


def test_poses_are_certified_refined_and_refused() -> None:
    instance = _spec()
    result = solve(instance)
    certificates = certify(instance, result.R, result.T)
    assert certificates.distinct == 10
    assert certificates.real == 2
    assert refine(instance, certificates[0], 40).T[2].lstrip("-").strip("0.") == ""
    wrong = result.T.copy()
    wrong[:, 0] += 1e-3
    assert certify(instance, result.R, wrong).certified == 0


def test_the_plate_is_followed_on_the_table() -> None:
    rows = np.array([VALUES_OF_SPECIAL, [0, 0, 0, 1.6, 2.1, 1.05]])
    result = track(_spec(), rows)
    assert not result.events
    assert result.certified
    # Points are followed, lines are what the file says.
    assert result.instance.type == _spec().type
    assert result.followed.type != result.instance.type
    assert (result.conditions < 100).all()
    end = solve(_spec(("value: 3/2", "value: 1.6"), ("value: 2}", "value: 2.1}"),
                      ("[H3, P3], value: 1", "[H3, P3], value: 1.05")))  # fmt: skip
    there = {tuple(row) for row in end.T[end.real].real.round(9).tolist()}
    assert {tuple(row) for row in result.T[:, -1].round(9).tolist()} == there


def test_no_clearance_is_claimed_where_distances_jump() -> None:
    instance = _spec()
    result = solve(instance)
    R, T = result.R[result.real].real, result.T[result.real].real
    assert clearances(Machine.of(instance), R, T)[0].tolist() == [0, 0]


# Where the lines of a DLL are parallel its equation holds at every distance: no pose.


SPEC = """
gsp: 1
units: {{length: m, angle: deg}}
platform:
  L: {{line: {{point: [0, 0, 0], direction: [0, 0, 1]}}}}
  P1: {{point: [0.3, 0.2, 0.1]}}
  P2: {{point: [-0.3, 0.4, 0.5]}}
  P3: {{point: [0.1, -0.6, 0.3]}}
  P4: {{point: [0.5, 0.6, -0.3]}}
base:
  l: {{line: {{point: [0.25, 0, 0], direction: [0, 0, 1]}}}}
  p1: {{point: [1, 0, 0]}}
  p2: {{point: [0, 1.2, 0.1]}}
  p3: {{point: [-0.8, 0.1, 0.4]}}
  p4: {{point: [-0.8, -0.9, 0.4]}}
constraints:
  - {{distance: [L, l], value: {distance}}}
  - {{angle: [L, l], value: {angle}}}
  - {{distance: [P1, p1], value: sqrt(0.7*0.7 + 0.2*0.2 + 0.1*0.1)}}
  - {{distance: [P2, p2], value: sqrt(0.3*0.3 + 0.8*0.8 + 0.4*0.4)}}
  - {{distance: [P3, p3], value: sqrt(0.9*0.9 + 0.7*0.7 + 0.1*0.1)}}
  - {{distance: [P4, p4], value: sqrt(1.3*1.3 + 1.5*1.5 + 0.7*0.7)}}
"""


def _solved(distance: str, angle: str) -> SolveResult:
    return solve(loads(SPEC.format(distance=distance, angle=angle)))


def _accounted(result: SolveResult) -> int:
    return int(result.multiplicity.sum()) + result.account.expected - result.account.found


def test_parallel_lines_at_the_distance_asked_for_are_a_pose() -> None:
    result = _solved("0.25", "0")
    assert result.verdict == "complete"
    # The identity is the pose that the values were taken from; its parallel lines are right.
    at_identity = [np.allclose(s.R, np.eye(3), atol=1e-4) for s in result.real_solutions]
    assert sum(at_identity) == 1
    assert result.account.spurious > 0
    assert _accounted(result) == result.expected


def test_parallel_lines_at_another_distance_are_none() -> None:
    result = _solved("0.3", "0")
    assert result.verdict == "complete"
    # The others are complex directions whose difference is isotropic: not parallel, angle zero.
    assert not result.real_solutions
    assert result.account.spurious > 0
    assert _accounted(result) == result.expected


def test_lines_that_are_not_parallel_are_left_alone() -> None:
    result = _solved("0.25", "20")
    assert result.account.spurious == 0
    assert _accounted(result) == result.expected


def test_nearly_parallel_lines_are_a_pose() -> None:
    """A regular end is never spurious: the lines are 1e-6 from parallel and the pose is simple."""
    rng = np.random.default_rng(3)
    instance, (R, T) = random_instance(parse_type("5PP DLL"), rng)
    tilted = instance.constraints[5]
    # The line of the platform is turned to be almost parallel to that of the base at the pose.
    along = R.T @ (tilted.base.unit + 1e-6 * np.cross(tilted.base.unit, [1.0, 2.0, 3.0]))
    line = Line(tilted.platform.position, vector(*map(float, along)))
    arrangement = Arrangement.of(
        replace(instance, constraints=(*instance.constraints[:5], replace(tilted, platform=line)))
    )
    values = np.abs(measured(arrangement, R, T))
    moved = replace(
        instance,
        constraints=tuple(
            replace(c, platform=line if i == 5 else c.platform, value=Number.of(float(values[i])))
            for i, c in enumerate(instance.constraints)
        ),
    )
    result = solve(moved)
    assert result.account.spurious == 0
    distance = min(np.abs(s.R - R).max() + np.abs(s.T - T).max() for s in result.real_solutions)
    assert distance < 1e-6


# Certificates where lines are parallel at some poses only: a plate on posts with a longer foot.


POSTS = PLATE_ON_POSTS.replace("F1: {point: [3, 0, 0]}", "F1: {point: [3, 0, 1]}").replace(
    "{distance: [F1, table], value: 0}", "{distance: [F1, table], value: 1}"
)


@pytest.fixture(scope="module")
def plate() -> Instance:
    return loads(POSTS)


@pytest.fixture(scope="module")
def found(plate: Instance) -> SolveResult:
    return solve(plate)


def test_all_poses_are_certified(plate: Instance, found: SolveResult) -> None:
    alone = certify_alone(plate, found.R, found.T)
    assert any(item.outcome is Outcome.NOT_ISOLATED for item in alone)
    proved = certify_poses(plate, found.R, found.T)
    assert proved.distinct == len(found.R)
    assert proved.real == found.counts.real


def test_no_other_pose_is(plate: Instance, found: SolveResult) -> None:
    moved = certify_poses(plate, found.R, found.T + 1e-3)
    assert moved.certified == 0
    other = loads(POSTS.replace("value: 3/2", "value: 1.501"))
    assert certify_poses(other, found.R, found.T).certified == 0


def test_duplicates_are_told(plate: Instance, found: SolveResult) -> None:
    proved = certify_poses(plate, found.R[[0, 1, 0]], found.T[[0, 1, 0]])
    assert [item.same_as for item in proved] == [None, None, 0]
    assert proved.distinct == 2


def test_refined_digits_are_those_of_the_pose(plate: Instance, found: SolveResult) -> None:
    shaken = certify_poses(plate, found.R, found.T + 1e-9)
    assert shaken.certified == len(found.R)
    for item in shaken:
        # A bound: the error of the solution at 64 bits is part of it.
        assert 1e-9 <= item.deviation * shaken.least_length * (1 + 1e-6) < 1e-7


# Three angles that leave a rotation free: the platform moves, or nothing is left for it.


def free_angles(name: str) -> tuple[tuple[Any, ...], ...]:
    """Angles that leave a rotation free."""
    x, y, z = (Line(ORIGIN, d) for d in (X, Y, Z))
    back, diagonal = Line(ORIGIN, vector(-1, 0, 0)), Line(ORIGIN, vector(1, 1, 0))
    rows = {
        "one axis twice": ((x, x, 60), (x, x, 60), (z, z, 60)),
        "one axis and its opposite": ((x, x, 60), (back, x, 120), (z, z, 60)),
        "one axis three times": ((x, x, 60), (x, x, 60), (x, x, 60)),
        "one line of the base": ((x, z, 60), (y, z, 60), (z, z, 45)),
        "coplanar lines and one of the base": ((x, z, 60), (y, z, 60), (diagonal, z, 45)),
        "right angles with one line": ((x, x, 90), (y, x, 90), (z, y, 90)),
    }
    return tuple(("ALL", *row) for row in rows[name])


SURFACES = {
    "spheres": tuple(
        ("DPP", at(*y), at(*x), 2)
        for y, x in (((0, 0, 0), (0, 0, 0)), ((1, 0, 0), (1, 1, 0)), ((0, 1, 0), (0, 1, 1)))
    ),
    "cylinders": cylinders(6, 4, 5),
    "planes": tuple(("DPH", P, Plane(ORIGIN, d), 1) for d in (X, Y, Z)),
}


@pytest.mark.parametrize("surfaces", SURFACES)
@pytest.mark.parametrize(
    "name",
    [
        "one axis twice",
        "one axis and its opposite",
        "one axis three times",
        "one line of the base",
        "coplanar lines and one of the base",
        "right angles with one line",
    ],
)
def test_a_free_rotation_is_a_motion(name, surfaces):
    result = solved(*SURFACES[surfaces], *free_angles(name))
    assert result.verdict == "infinite"
    # That there are infinitely many is proved by the count: of so special a set paths may be lost.
    assert result.proof is not None
    assert result.account.lost < 8
    motion = result.motions[0]
    assert motion.real
    assert residuals(result.arrangement, motion.R, motion.T).max() < 1e-9


def test_a_free_rotation_without_any_translation_has_no_pose():
    """Two concentric spheres: path tracking confirms what sample rotations only suggest."""
    result = solved(
        *spheres((at(0, 0, 0), 1), (at(0, 0, 0), 2), (at(1, 0, 0), 1)),
        *free_angles("one axis twice"),
    )
    assert result.verdict == "complete"
    assert (result.counts.found, result.account.at_infinity) == (0, 16)


# Constraints that are the same leave motions, which are listed and proved; others do not.


TEXT = """
gsp: 1
units: {{length: m, angle: deg}}
platform: {{{ys}, Z: {{point: [1, 0.2, 0]}}}}
base: {{{xs}, {other}}}
constraints:
{rows}
  - {{distance: [Z, W], value: 2}}
"""
#: A file names equal points apart: a distance of two named points is there once.
YS = ", ".join(f"Y{k}: {{point: [0.1, -0.4, 0.3]}}" for k in range(5))
XS = ", ".join(f"X{k}: {{point: [1.2, 0.3, -0.7]}}" for k in range(5))
OTHERS = {
    "DPP": "W: {point: [0, 1, 2]}",
    "DPH": "W: {plane: {point: [0, 1, 2], normal: [1, 2, 2]}}",
    "DPL": "W: {line: {point: [0, 1, 2], direction: [1, 2, 2]}}",
}


def _platform(kind: str, *values: str) -> Instance:
    rows = (f"  - {{distance: [Y{k}, X{k}], value: {value}}}" for k, value in enumerate(values))
    return loads(TEXT.format(ys=YS, xs=XS, other=OTHERS[kind], rows="\n".join(rows)))


@pytest.mark.parametrize("kind", OTHERS)
def test_five_equal_constraints_leave_a_real_motion(kind: str) -> None:
    instance = _platform(kind, *5 * ["2.25"])
    found = solve(instance)
    assert found.verdict == "infinite"
    assert found.proof is not None
    assert found.proof.error == 0
    motion = next(motion for motion in found.motions if motion.real)
    assert motion.dimension == 4
    sizes = relative_residuals(Arrangement.of(instance), motion.R, motion.T)
    assert np.abs(sizes).max() < 1e-9


def test_other_values_between_the_same_points_are_no_motion() -> None:
    """Five distances of the same two points of which one differs: there is no pose."""
    assert _repeated(_platform("DPP", *4 * ["2.25"], "2.26")) is None


def test_six_different_constraints_are_left_to_counts() -> None:
    assert _repeated(_platform("DPP", "2.1", "2.2", "2.3", "2.4", "2.5")) is None


def _repeated(instance: Instance) -> PoseSet | None:
    problem = Problem(instance)
    return poses_of_repeated(problem, Search(problem))


# Nearly singular poses at T = 0, where the frames of most machines coincide: none is lost.


#: Nearly singular at R = 1, T = 0, which certifies; 36 of the 40 poses are not real.
_SPEC = """
gsp: 1
units: {length: m, angle: deg}
platform:
  Y1: {point: [-2, -1, -3]}
  Y2: {point: [2, 0, 0]}
  Y3: {point: [-2, -3, -3]}
  Y4: {point: [-3, 0, 1]}
  Y5: {point: [-1, 3, 3]}
  Y6: {point: [-3, -2, 1]}
base:
  X1: {point: [4, 1, 0]}
  X2: {point: [-2, -3, 0]}
  X3: {point: [-1, -4, 0]}
  X4: {point: [0, -1, -2]}
  X5: {point: [0, 0, 1]}
  X6: {point: [-3, -2.262242, 2]}
constraints:
  - {distance: [Y1, X1], value: 7}
  - {distance: [Y2, X2], value: 5}
  - {distance: [Y3, X3], value: sqrt(11)}
  - {distance: [Y4, X4], value: sqrt(19)}
  - {distance: [Y5, X5], value: sqrt(14)}
  - {distance: [Y6, X6], value: sqrt(1.068770866564)}
"""


def test_a_nearly_singular_pose_at_the_origin_is_found() -> None:
    result = solve(loads(_SPEC))
    assert result.verdict == "complete"
    assert result.counts.certified == 40
    assert result.counts.real == 4
    at_rest = np.abs(result.T[result.real]).max(axis=1) == 0
    assert at_rest.sum() >= 1
    turned = np.abs(result.R[result.real][at_rest] - np.eye(3)).max(axis=(1, 2))
    assert turned.max() < 1e-6


@pytest.mark.parametrize("shift", ["1e-4", "1e-6", "-3e-7", "1e-8", "1e-10"])
def test_none_is_lost_wherever_the_last_leg_begins(shift: str) -> None:
    """Its foot is moved, its length is still that at R = 1, T = 0: exactly, in decimals."""
    foot = Decimal("-2.262242") + Decimal(shift)
    square = 1 + (foot + 2) ** 2
    spec = _SPEC.replace("-2.262242", f"{foot:f}").replace("1.068770866564", f"{square:f}")
    result = solve(loads(spec))
    assert (result.verdict, result.counts.certified) == ("complete", 40)
    assert (np.abs(result.T[result.real]).max(axis=1) == 0).any()
