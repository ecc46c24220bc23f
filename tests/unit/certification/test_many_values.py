"""Proofs for many sets of values at a time, against those of single platforms."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.catalogue.parsing import parse_type
from gspcli.certification import decide
from gspcli.certification.distinct import all_different, surely_different
from gspcli.certification.many_values import ValueProofs
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.solver.generate import random_instance
from gspcli.solver.study_systems import side_choices
from gspcli.solver.tracking import solve_by_tracking

TYPES = (
    "DPP DPP DPP DPP DPP DPP",
    "DPP DPP DPP DPL DLP DLL",
    "DPH DPH DHP DHP DPP DPP",
    "DPP DPL DPH DHP ALL ALH",
    "DPP DPP DPP DPP AHL AHH",
)


class Batch:
    """A few sets of values of a geometry with their poses."""

    def __init__(self, name: str) -> None:
        rng = np.random.default_rng(21)
        self.instance, _ = random_instance(parse_type(name), rng, one_sided=True)
        arrangement = Arrangement.of(self.instance)
        self.rows = arrangement.values * (1 + 0.05 * rng.normal(size=(3, 6)))
        self.choices = side_choices(arrangement)
        poses = [solve_by_tracking(arrangement.with_values(row), seed=22) for row in self.rows]
        self.quaternions, self.R, self.T, self.real = (
            np.array([getattr(part, name) for part in poses])
            for name in ("quaternions", "R", "T", "real")
        )
        self.proofs = ValueProofs(self.instance, self.rows)

    def platform(self, k: int) -> Instance:
        values = {i: Number.of(float(value)) for i, value in enumerate(self.rows[k])}
        return self.instance.with_values(values)

    def decide(self, rows=None, R=None, T=None):
        given = (self.rows if rows is None else rows, self.choices, self.quaternions)
        R, T = self.R if R is None else R, self.T if T is None else T
        return self.proofs.decide(*given, R, T)


@pytest.fixture(scope="module", params=TYPES)
def batch(request):
    return Batch(request.param)


def test_what_is_proved_is_what_is_proved_of_each_platform(batch):
    found = batch.decide()
    assert found.certified.mean() > 0.9
    assert found.different.all()
    for k in range(len(batch.rows)):
        single = decide(batch.platform(k), batch.R[k], batch.T[k])
        assert (single.certified | ~found.certified[k]).all()
        known = found.certified[k]
        np.testing.assert_array_equal(found.real[k, known], single.real[known])
        np.testing.assert_array_equal(found.real[k, known], batch.real[k, known])


def test_poses_of_other_values_are_not_certified(batch):
    for i in range(6):
        rows = batch.rows.copy()
        rows[:, i] *= 1.02
        # Newton's method finds other solutions; a few may be as near as the tolerance allows.
        assert batch.decide(rows=rows).certified.mean() < 0.01


def test_other_poses_are_not_certified(batch):
    size = np.abs(batch.T).max()
    assert not batch.decide(T=batch.T + 1e-3 * size).certified.any()
    assert not batch.decide(R=batch.R + 1e-4).certified.any()
    assert not batch.decide(T=np.full_like(batch.T, np.nan)).certified.any()


def test_the_other_side_of_a_plane_is_not_certified():
    batch = Batch("DPH DPH DHP DHP DPP DPP")
    batch.choices = -batch.choices
    assert not batch.decide().certified.any()


def test_poses_twice_are_not_different(batch):
    batch_of_two = [
        np.concatenate([part[:, :1], part], axis=1)
        for part in (batch.quaternions, batch.R, batch.T)
    ]
    found = batch.proofs.decide(batch.rows, batch.choices, *batch_of_two)
    assert not (found.different & found.certified[:, 0]).any()


@pytest.mark.parametrize("build", ["portable", "avx2", "avx512"])
def test_every_build_proves_the_same(build):
    order = ["portable", "avx2", "avx512"]
    if order.index(build) > order.index(_kernel.build()):
        pytest.skip(f"this processor cannot run {build}")
    batch = Batch("DPP DPP DPP DPL DLP DLL")
    given, real = _kernel.prove, []

    def other(*arguments, **options):
        real.append(build)
        return given(*arguments, **{**options, "build": build})

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_kernel, "prove", other)
        found = batch.decide()
    assert real
    np.testing.assert_array_equal(found.certified, batch.decide().certified)


def test_one_form_proves_no_more_than_comparing_all():
    rng = np.random.default_rng(23)
    entries = rng.normal(size=(4, 9, 12)) + 1j * rng.normal(size=(4, 9, 12))
    deviations = np.full((4, 9), 1e-9)
    entries[1, 7] = entries[1, 2]
    entries[2, 8] = entries[2, 0] + 1e-9
    deviations[3] = 10.0
    assert surely_different(entries, deviations).tolist() == [True, False, False, False]
    each = [all_different(*pair) for pair in zip(entries, deviations, strict=True)]
    assert each == [True, False, False, False]
    # What does not count is equal to nothing.
    deviations[1, 7] = deviations[2, 8] = np.inf
    assert surely_different(entries, deviations).tolist() == [True, True, True, False]
