"""Numbers with 64 digits, against those with 32, and poses that only they round."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import arb, ctx

from gspcli import solve_batch
from gspcli.catalogue.names import parse_type
from gspcli.certification.equations.frames import OWN
from gspcli.certification.poses.finer_numbers import FinerNumbers, coefficients_of
from gspcli.certification.poses.many_values import OF_POSES, ProvedPoses, ValueProofs
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import study_from_pose
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import solve
from gspcli.solver.many_poses import many_poses
from gspcli.solver.problem import Problem
from gspcli.solver.starts.solved_starts import SolvedStarts
from gspcli.solver.study_systems import side_choices
from tools.special.realistic import machines

TYPES = (
    "DPP DPP DPP DPL DLP DLL",
    "DPH DPH DHP DHP DPP DPP",
    "DPP DPL DPH DHP ALL ALH",
)
#: A coupling whose complex poses are a hundred lengths away.
COUPLING = 381


def proofs_of(name):
    instance, _ = random_instance(parse_type(name), np.random.default_rng(21), one_sided=True)
    return instance, ValueProofs(instance, None)


@pytest.mark.parametrize("name", TYPES)
def test_the_first_32_digits_are_those_of_the_kernel(name):
    _, proofs = proofs_of(name)
    finer = proofs._finer
    coefficients, weights = finer.equations
    hessians, lows, _, _, own_weights, _ = proofs.numbers
    places = [(i, j) for i in range(4) for j in range(i, 8) if i <= j]
    order = sorted(places, key=lambda x: (x[1] >= 4, x))
    for part, matrix in ((coefficients[0], hessians), (coefficients[1], lows)):
        half = np.array([0.5 if i == j else 1.0 for i, j in order] + [0.5])
        known = np.stack([matrix[:, i, j] for i, j in [*order, (4, 4)]], axis=1) * half
        size = np.abs(hessians).max()
        assert np.abs(part - known).max() <= 2.0**-50 * size
    both = coefficients[0] + coefficients[1]
    assert np.abs(both).max() > 0
    assert weights[0] == pytest.approx(own_weights[0], rel=1e-15)


@pytest.mark.parametrize("name", TYPES)
def test_values_are_those_of_the_kernel(name):
    instance, proofs = proofs_of(name)
    (choice,) = side_choices(Arrangement.of(instance))
    for rows in (None, Arrangement.of(instance).values[None]):
        own = ValueProofs(instance, rows).values(choice[None], rows)[0, 0]
        found = proofs._finer.values(choice, None if rows is None else rows[0])
        assert found[0] == pytest.approx(own[0], rel=1e-15)
        assert np.abs((found[0] - own[0]) + (found[1] - own[3])).max() <= 1e-28
        assert (found[4] <= 2.0**-180).all()


def test_a_number_with_many_bits_is_a_sum_of_four_doubles():
    instance, _ = proofs_of(TYPES[0])
    number = Number.of("1/3")
    other = instance.with_values({0: number})
    found = FinerNumbers(other, 1.0, [False] * 6, np.ones(27)).values(np.ones(6), None)
    with ctx.workprec(400):
        total = sum((arb(x) for x in found[:4, 0].tolist()), arb(0))
        assert abs(total - arb(1) / 9) < arb(found[4, 0])
        assert abs(total - arb(1) / 9) < arb(2) ** -200


def coupling(rows=8):
    return next(iter(machines(COUPLING + 1, rows=rows, begin=COUPLING)))


def test_rows_with_nearly_dependent_equations_are_solved_together():
    machine = coupling()
    starts = SolvedStarts()
    solve(machine.instance, starts=starts)
    (answers,) = many_poses(machine.instance, machine.rows, seed=1, jobs=1, starts=starts)
    assert not answers.alone
    batch = solve_batch(machine.instance, machine.rows, starts=starts)
    assert batch.complete.all()
    assert batch.proved.all()
    for k, row in enumerate(machine.rows[:3].tolist()):
        values = {i: Number.of(Fraction(x)) for i, x in enumerate(row)}
        alone = solve(machine.instance.with_values(values), starts=SolvedStarts())
        assert batch.number[k] == alone.counts.found == 4
        # Correct rounding: the same numbers.
        there = {tuple(x.T.tolist()): x.R.tolist() for x in alone.solutions}
        here = zip(batch.T[k].tolist(), batch.R[k].tolist(), strict=True)
        assert {tuple(T): R for T, R in here} == there


@pytest.mark.parametrize("name", TYPES)
def test_sets_of_values_that_share_lanes_are_as_each_alone(name):
    """They have different values, and some have fewer points than others."""
    instance, proofs = proofs_of(name)
    problem = Problem(instance, starts=SolvedStarts())
    own = problem.arrangement.values
    rows = own * (1 + 0.01 * np.random.default_rng(1).normal(size=(3, 6)))
    found = []
    for row in rows:
        values = {i: Number.of(Fraction(x)) for i, x in enumerate(row.tolist())}
        found.append(solve(instance.with_values(values), starts=SolvedStarts()).poses)
    width = 5
    R, T = (np.stack([getattr(x, part)[:width] for x in found]) for part in ("R", "T"))
    points = np.concatenate(study_from_pose(R, T), axis=-1)[:, None]
    points[1, 0, 2:] = np.nan
    (choice,) = side_choices(problem.arrangement)
    proofs = ValueProofs(instance, rows)
    wanted = np.isfinite(points[:, 0]).all(axis=-1)
    both = proofs.decide(choice[None], points, OWN, rows=rows)
    first = ProvedPoses(*(part.copy() for part in both))
    proofs.round(both, wanted, choice, points[:, 0], OWN, rows=rows)
    assert both.certified[wanted].all()
    for k in range(3):
        one = ProvedPoses(*(part[k : k + 1].copy() for part in first))
        given = wanted[k : k + 1], choice, points[k : k + 1, 0], OWN
        proofs.round(one, *given, rows=rows[k : k + 1])
        for part in OF_POSES:
            assert getattr(one, part)[0].tobytes() == getattr(both, part)[k].tobytes()
    for part in ("R", "T", "quaternions", "real"):
        assert getattr(first, part)[wanted].tobytes() == getattr(both, part)[wanted].tobytes()
        assert (both.deviation <= first.deviation)[wanted].all()


def test_a_number_that_is_zero_in_exact_numbers_only_is_zero():
    """Of a coupling whose coordinates are no doubles, the terms of some coefficients cancel."""
    machine = next(iter(machines(118, rows=1, begin=117)))
    proofs = ValueProofs(machine.instance, None)
    coefficients, _ = proofs._finer.equations
    moduli = coefficients_of(proofs.numbers[2])
    assert ((coefficients[0] == 0) & (moduli > 1)).any()
    # What errs by more than a part of its terms is not known.
    given = machine.instance, proofs.scale, [False] * 6
    assert FinerNumbers(*given, 2 * moduli).equations is not None
    assert FinerNumbers(*given, 2.0**-120 * moduli).equations is None


def test_poses_some_thousand_lengths_away_are_proved_at_once():
    """Newton's step is bounded by its length: its terms cancel where the inverse is large."""
    machine = next(iter(machines(162, rows=71, begin=161)))
    row = machine.rows[7 + 1]
    values = {i: Number.of(Fraction(x)) for i, x in enumerate(row.tolist())}
    instance = machine.instance.with_values(values)
    poses = solve(instance, starts=SolvedStarts()).poses
    assert np.abs(poses.R).max() > 2000
    points = np.concatenate(study_from_pose(poses.R, poses.T), axis=-1)[None, None]
    (choice,) = side_choices(Arrangement.of(instance))
    proofs = ValueProofs(instance, None)
    found = proofs.decide(choice[None], points, OWN, all_poses=True)
    assert found.complete.all()
    assert found.R[0].tobytes() == poses.R.tobytes()


def test_a_value_that_errs_is_not_rounded(monkeypatch):
    machine = coupling()
    proofs = ValueProofs(machine.instance, None)
    poses = solve(machine.instance, starts=SolvedStarts())
    R, T = (np.array([getattr(x, name) for x in poses.solutions], complex) for name in "RT")
    points = np.concatenate(study_from_pose(R, T), axis=-1)[None, None]
    (choice,) = side_choices(Arrangement.of(machine.instance))
    assert proofs.decide(choice[None], points, OWN).complete.all()
    known = FinerNumbers.values

    def doubtful(self, *given):
        found = known(self, *given)
        found[4] = 2.0**-70
        return found

    monkeypatch.setattr(FinerNumbers, "values", doubtful)
    assert not proofs.decide(choice[None], points, OWN).complete.any()


def test_all_digits_are_used(monkeypatch):
    """Without the parts that 32 digits have not, other solutions are found, and not rounded."""
    machine = coupling()
    (choice,) = side_choices(Arrangement.of(machine.instance))
    proofs = ValueProofs(machine.instance, None)
    poses = solve(machine.instance, starts=SolvedStarts())
    R, T = (np.array([getattr(x, name) for x in poses.solutions], complex) for name in "RT")
    points = np.concatenate(study_from_pose(R, T), axis=-1)[None, None]
    exact = proofs.decide(choice[None], points, OWN)
    assert exact.complete.all()
    # As if the numbers were known to a few digits.
    coefficients, weights = proofs._finer.equations
    first = np.where(np.arange(4)[:, None, None] == 0, coefficients, 0.0)
    proofs._finer.equations = (first, weights)
    found = proofs.decide(choice[None], points, OWN)
    assert exact.T.tobytes() != found.T.tobytes()
