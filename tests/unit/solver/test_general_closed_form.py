"""The closed form of one platform at once: as the one of many sets of values finds them."""

from fractions import Fraction
from itertools import islice

import numpy as np
import pytest

from benchmarks.cases import random_instances
from gspcli import load, solve, solve_values
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.numbers import Number
from gspcli.resources import data_path
from gspcli.solver.problem import Problem
from gspcli.solver.results.proof import CountKind
from gspcli.solver.strategies.closed_form import closed_form

TYPES = (
    "DPL DPL DLP 3ALL",
    "DLL DLP DPP 3ALL",
    "DPH DPL DPP ALL ALH AHH",
    "DPP DPP DPP 3AHH",
)


def refused(*_):
    message = "no paths are to be needed"
    raise AssertionError(message)


def exactly(values):
    return {i: Number.of(Fraction(x)) for i, x in enumerate(values.tolist())}


@pytest.mark.parametrize("type_text", TYPES)
def test_poses_accounts_and_proofs_are_those_of_many_sets_of_values(type_text, monkeypatch):
    monkeypatch.setattr(Problem, "tracked", property(refused))
    for given in islice(random_instances(type_text, 5), 4):
        values = np.array([row.value.value for row in given.constraints])
        instance = given.with_values(exactly(values))
        one = solve(instance).poses
        (many,) = solve_values(instance, values[None])
        many = many.in_order(Arrangement.of(instance).length)
        assert (one.account, one.proof) == (many.account, many.proof)
        assert len(one.R) == instance.expected
        for name in ("quaternions", "R", "T", "real", "signs"):
            np.testing.assert_array_equal(getattr(one, name), getattr(many, name))


def test_what_is_special_goes_the_careful_way():
    example = load(str(data_path("examples", "example-6.8.yaml")))
    special = example.with_values({5: Number.of("sqrt(52)")})  # cylinders touch
    assert list(closed_form(Problem(special))) == []
    found = solve(special)
    assert found.verdict == "complete"
    assert (found.multiplicity > 1).any()


def test_both_sides_of_planes_are_found_at_once(monkeypatch):
    monkeypatch.setattr(Problem, "tracked", property(refused))
    two_sided = next(random_instances("DPH DPL DPP 3ALL", 5, one_sided=False))
    found = solve(two_sided)
    assert found.verdict == "complete"
    assert found.proof.by is CountKind.TYPE
    assert found.certified.all()
