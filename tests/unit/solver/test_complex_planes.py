"""Poses far away of platforms with points and lines, from points in planes."""

from __future__ import annotations

import numpy as np
import pytest
from flint import acb_mat, arb_mat

import gspcli.certification.poses.far_points
from gspcli.catalogue.kinds import DLP, DPL, DPP
from gspcli.catalogue.names import parse_type
from gspcli.certification.equations.ball_system import BallSystem, heights
from gspcli.certification.poses.far_points import _Equations, far_points
from gspcli.certification.poses.locator import Located
from gspcli.continuation.quadrics import evaluate
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.geometry import study
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Point
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import all_poses, further, solve
from gspcli.solver.all_poses import far_in_planes
from gspcli.solver.poses import are_far
from gspcli.solver.problem import Problem
from gspcli.solver.side_search import SideSearch
from gspcli.solver.solved_starts import SolvedStarts
from gspcli.solver.study_systems import coefficients_at
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
