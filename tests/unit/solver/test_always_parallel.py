"""Lines of a DLL that are parallel at every pose: a plate on a table between round posts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp

from gspcli.certification import certify, refine
from gspcli.certification.counting import ExactCount, exact_count, with_points_for_lines
from gspcli.geometry.instance import Instance
from gspcli.motion.following.trajectories import track
from gspcli.motion.singularities.clearances import clearances
from gspcli.solver import solve
from gspcli.spec import loads
from tests.support.posts import PLATE_ON_POSTS

VALUES = [0, 0, 0, 1.5, 2, 1]


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
    from gspcli.solver.special import by_count

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
    rows = np.array([VALUES, [0, 0, 0, 1.6, 2.1, 1.05]])
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
    assert clearances(instance, R, T).tolist() == [0, 0]
