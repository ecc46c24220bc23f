from __future__ import annotations

import flint
import numpy as np
import pytest
from flint import arb, arb_mat

import gspcli
from gspcli.catalogue.types import type_by_number
from gspcli.certification.branches.curves import (
    Arc,
    CurveSystem,
    at_time,
    corrected,
    tangent,
    towards,
)
from gspcli.certification.branches.taylor import MovingSystem
from gspcli.geometry.coordinates import choose
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import MovingPlatform
from gspcli.motion.following.branch_follower import at_values
from gspcli.resources import data_path

NOW = [*[arb(0)] * 8, arb(1)]
#: Two modes meet and vanish on the way.
VALUES = np.array([[2.53, 2.08, 0.93, 1.97, 1.46, 1.73], [2.6, 2.0, 1.0, 1.9, 1.46, 1.73]])


@pytest.fixture(autouse=True)
def _precision():
    with flint.ctx.workprec(160):
        yield


@pytest.mark.parametrize("number", [1, 411, 1035, 3316, 3850, "t-top-head"])
def test_polynomials_along_a_line_are_those_of_the_equations(number):
    names = ["crank.B1", "crank.B4"] if isinstance(number, str) else []
    rng = np.random.default_rng(0 if names else number)
    instance = (
        gspcli.load(data_path("platforms", f"{number}.yaml"))
        if names
        else (random_instance(type_by_number(number), rng)[0])
    )
    values = [*(one.value.value for one in instance.constraints), *[0.3] * len(names)]
    rows = np.array([values, 1.1 * np.array(values)])
    system = MovingSystem(instance, choose(instance, names))
    equations = CurveSystem(system, (rows[0], rows[1]), rng.normal(size=8))
    x, v = ([arb(value) for value in rng.normal(size=9).tolist()] for _ in range(2))
    h = arb(2.0**-20)
    polynomial = equations.along(x, v, 3)
    ((values_there, rows_there),) = equations.along(
        [a + h * b for a, b in zip(x, v, strict=True)], v, 0
    )
    here = [sum((one[0][k] * h**p for p, one in enumerate(polynomial)), arb(0)) for k in range(8)]
    assert all(abs(a - b) < 2.0**-65 for a, b in zip(here, values_there, strict=True))
    difference = sum((one[1] * h**p for p, one in enumerate(polynomial)), -rows_there)
    assert all(abs(entry) < 2.0**-65 for entry in difference.entries())
    # The derivatives are those of the values: of the first by s.
    slope = (polynomial[0][1] * arb_mat(9, 1, v)).entries()
    assert all(a.overlaps(b) for a, b in zip(slope, polynomial[1][0], strict=True))


@pytest.fixture(scope="module")
def curve():
    """Equations, and the two poses at the first row that meet later, with all others."""
    platform = MovingPlatform(gspcli.load(data_path("examples", "platform-6-6.yaml")))
    modes = gspcli.solve(at_values(platform.instance, VALUES[0]))
    points = platform.points(modes.R[modes.real].real, modes.T[modes.real].real)
    with flint.ctx.workprec(160):
        equations = CurveSystem(platform.system, (VALUES[0], VALUES[1]), points[0])
        poses = []
        for point in points.tolist():
            scale = sum((a * b for a, b in zip(equations.patch, point, strict=True)), arb(0))
            poses.append(at_time(equations, [*(arb(x) / scale for x in point), arb(0)]))
    return equations, poses


def arc_from(equations, pose):
    v = tangent(equations, [x.mid() for x in pose], NOW)
    x = corrected(equations, pose, v)
    return Arc(equations, x, v, v)


def test_an_arc_contains_its_solutions_and_no_others(curve):
    equations, (pose, other) = curve
    arc = arc_from(equations, pose)
    assert arc.holds(arb(2.0**-8), [arb(0)] * 9)
    assert arc.contains(pose)
    assert not arc.contains(other)
    # Twice as wide as the box, a ball is not in it.
    assert not arc.contains([a + arb(0, 2 * w) for a, w in zip(pose, arc.widths, strict=True)])
    # As long as the whole curve: two solutions for some s, or none.
    assert not arc.holds(arb(2), [arb(0)] * 9)


def test_tangents_of_an_arc_contain_those_at_its_points(curve):
    equations, (pose, _) = curve
    arc = arc_from(equations, pose)
    assert arc.holds(arb(2.0**-6), [arb(0)] * 9)
    enclosed = arc.tangents()
    for part in (-0.9, 0.0, 0.5, 0.9):
        x = arc.on_curve(part)
        v = tangent(equations, [a.mid() for a in x], arc.gauge)
        along = sum((a * b for a, b in zip(arc.gauge, v, strict=True)), arb(0))
        assert all((b / along) in a for a, b in zip(enclosed, v, strict=True))


def test_time_increases_along_the_curve_up_to_the_fold_and_not_beyond(curve):
    equations, (pose, _) = curve
    times = [float(place[-1]) for place in towards(equations, pose, arb(1))]
    assert times == sorted(times)
    # The fold is at 0.71886.
    assert 0.5 < times[-1] < 0.718861
    limited = [float(place[-1]) for place in towards(equations, pose, arb(0.25))]
    assert limited[-2] < 0.25 <= limited[-1]


def test_where_there_is_no_solution_none_is_proved(curve):
    equations, _ = curve
    assert at_time(equations, [*[arb(k) for k in range(8)], arb(30)]) is None
