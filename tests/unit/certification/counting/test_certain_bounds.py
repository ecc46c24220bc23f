"""Bounds of the number of poses that do not rest on a random prime."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq

from gspcli.certification.counting import certain_bounds
from gspcli.certification.counting.certain_bounds import certain_bound
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.resources import data_directory
from gspcli.solver import solve
from gspcli.solver.results.proof import Grade
from gspcli.spec import load


def _example(name: str) -> Instance:
    return load(data_directory() / "examples" / f"{name}.yaml")


def _rational(instance: Instance) -> Instance:
    """Return an instance with values of few decimals."""
    values = {
        k: Number.of(Fraction(round(row.value.value, 3)).limit_denominator(1000))
        for k, row in enumerate(instance.constraints)
    }
    return instance.with_values(values)


def test_congruent_bodies_have_24_poses_for_certain() -> None:
    """Of the 40 of the type 16 are at infinity, 18 functionals say so in degree 3 or 4."""
    instance = _rational(_example("congruent-platform"))
    assert certain_bound(instance) == 24
    usual, proved = solve(instance), solve(instance, prove=True)
    assert usual.proof is not None
    assert proved.proof is not None
    assert usual.proof.grade is Grade.PRIME
    assert proved.proof.grade is Grade.CERTAIN
    assert len(usual.R) == len(proved.R) == 24


def test_equations_that_contradict_each_other_have_no_solution_for_certain(load_tool) -> None:
    made = load_tool("special.platforms")
    wanted = "bodies/similar-hexagons/3-places"
    [platform] = [one for one in made.platforms(["bodies"]) if one.id == wanted]
    assert certain_bound(platform.instance) == 0


@pytest.mark.parametrize("name", ["point-on-line", "planar-hexagons", "congruent-equal-legs"])
def test_what_the_argument_is_not_for_has_no_bound(name: str, monkeypatch) -> None:
    """Lines, irrational numbers, infinitely many poses."""
    monkeypatch.setattr(certain_bounds, "_DEGREES", (3,))
    assert certain_bound(_example(name)) is None


def test_functionals_that_do_not_vanish_over_the_rational_numbers_prove_nothing(
    monkeypatch,
) -> None:
    instance = _rational(_example("congruent-platform"))
    given = certain_bounds._fractions

    def spoilt(residues, modulus):
        found = given(residues, modulus)
        return found and [found[0] + fmpq(1), *found[1:]]

    monkeypatch.setattr(certain_bounds, "_fractions", spoilt)
    monkeypatch.setattr(certain_bounds, "_DEGREES", (3,))
    assert certain_bound(instance) is None


def test_the_relations_vanish_on_motions() -> None:
    forms, functions = certain_bounds.motion_forms(), certain_bounds._FUNCTIONS
    e, f = (np.random.default_rng(k).integers(-9, 9, 4) for k in (1, 2))
    # With e.f = 0, in integers.
    f = f * int(e @ e) - e * int(e @ f)
    point = np.concatenate((e, f)).astype(object)
    values = [int(point @ forms[k].astype(object) @ point) for k in functions]
    relations = certain_bounds._relations()
    assert len(relations) == 37
    for relation in relations:
        assert sum(c * values[i] * values[j] for (i, j), c in relation.items()) == 0


def test_a_platform_with_more_poses_than_the_bound_stays_as_it_was(monkeypatch) -> None:
    instance = _rational(_example("congruent-platform"))
    for bound in (23, 25, None):
        monkeypatch.setattr("gspcli.solver.special.by_count.certain_bound", lambda *_, n=bound: n)
        result = solve(instance, prove=True)
        assert result.proof is not None
        assert result.proof.grade is Grade.PRIME
