"""Results: what they say, and how."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gspcli.catalogue.types import type_by_number
from gspcli.defaults import SEED
from gspcli.errors import GspError
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_path, instance_files
from gspcli.solver import solve
from gspcli.solver.poses import CountKind, Grade, Proof
from gspcli.solver.result import COLUMNS, ROTATIONS, rotation_columns
from gspcli.spec import load


@pytest.fixture(scope="module")
def result():
    instance, _ = random_instance(type_by_number(900), np.random.default_rng(4))
    return solve(instance)


def test_json_has_the_keys_of_the_schema(result):
    document = json.loads(json.dumps(result.to_json(everything=True), allow_nan=False))
    assert list(document) == [
        "schema",
        "name",
        "type",
        "units",
        "expected",
        "verdict",
        "proof",
        "geometry_count",
        "exact_count",
        "counts",
        "home",
        "solutions",
        "seed",
        "version",
    ]
    assert document["schema"] == "gsp.solve/1"
    assert document["type"]["number"] == 900
    assert document["seed"] == SEED
    assert len(document["solutions"]) == document["counts"]["found"]
    for solution in document["solutions"]:
        keys = {"number", "real", "certified", "multiplicity", "R", "T", "quaternion"}
        keys |= {"residual", "condition", "sides", "home"}
        if not solution["real"]:
            keys |= {"R_imag", "T_imag", "quaternion_imag"}
        assert set(solution) == keys


def test_json_has_real_poses_only_unless_asked(result):
    document = result.to_json()
    assert len(document["solutions"]) == document["counts"]["real"]
    assert all(solution["real"] for solution in document["solutions"])


@pytest.mark.parametrize("number", [900, 2500, 3850])
def test_quaternions_are_those_of_the_rotations(number):
    instance, _ = random_instance(type_by_number(number), np.random.default_rng(number))
    poses = solve(instance)
    assert poses.counts.real
    assert not poses.quaternions[poses.real].imag.any()
    sizes = np.abs(poses.R).max(axis=(1, 2))[:, None]
    np.testing.assert_allclose(
        poses.quaternions / sizes, quaternion_from_rotation(poses.R) / sizes, atol=1e-11
    )


def test_counts_add_up(result):
    counts = result.counts
    assert counts.found == counts.certified == result.expected
    assert counts.real == len(result.real_solutions)
    assert result.verdict == "complete"


def test_residuals_are_those_of_their_poses_in_any_order(result):
    order = np.arange(len(result.R))[::-1]
    assert result.real.any()
    assert not result.real.all()
    turned = result[order]
    np.testing.assert_array_equal(turned.residuals, result.residuals[order])


def test_certification_agrees_with_the_pairing_of_conjugates(result):
    candidate = solve(result.instance)
    np.testing.assert_array_equal(candidate.real, result.real)


def test_sides_are_named_by_constraint_number(result):
    sided = {i for i, c in enumerate(result.instance.constraints, 1) if c.kind.has_sides}
    for solution in result.solutions:
        assert set(solution.sides) == sided
        assert set(solution.sides.values()) <= {"positive", "negative"}


def test_frame_has_a_row_for_each_pose(result):
    frame = result.to_frame()
    assert len(frame) == result.counts.real
    assert frame.index.name == "number"
    assert frame.index.tolist() == [one.number for one in result.real_solutions]
    np.testing.assert_allclose(frame[["Tx", "Ty", "Tz"]], result.T[result.real].real)
    everything = result.to_frame(everything=True)
    assert len(everything) == result.counts.found
    assert everything["certified"].all()


def test_order_is_by_quaternion_then_translation(result):
    poses = [tuple(np.round(np.concatenate((s.quaternion, s.T)), 6)) for s in result.real_solutions]
    assert poses == sorted(poses)
    for solution in result.real_solutions:
        assert next(q for q in np.round(solution.quaternion, 9) if q) > 0


def test_a_result_is_one_line_and_prints_as_a_table():
    result = solve(load(data_path("examples", "example-6.8.yaml")))
    line = "64 real of 64 solutions, 64 certified, complete, proved"
    assert repr(result) == f"<SolveResult of Example 6.8: {line}>"
    assert repr(result.instance) == "<Instance 'Example 6.8': ALL ALL ALL DPL DPL DPL (unit, deg)>"
    table = str(result).splitlines()
    assert len(table) == 1 + 1 + 64 + 1
    assert table[1].split()[:7] == ["no.", "Tx", "[unit]", "Ty", "[unit]", "Tz", "[unit]"]
    assert table[-1] == line
    assert len({len(row) for row in table[1:-1]}) == 1
    assert repr(result.solutions[0]).startswith("<Solution: real, certified, residual ")


# Every column is said once, and the frame and the CSV have the same ones.


def test_the_frame_has_the_columns_in_their_order() -> None:
    result = solve(load(instance_files()["six-planes"]))
    frame = result.to_frame(everything=True)
    assert list(frame.columns) == [column.key for column in COLUMNS]
    for column in COLUMNS:
        assert len(column.read(result)) == len(result.R)


def test_angles_of_poses_that_are_not_real_are_no_numbers() -> None:
    result = solve(load(instance_files()["six-planes"]))
    for form in ("rotvec", "zxy"):
        for column in rotation_columns(form):
            np.testing.assert_array_equal(np.isfinite(column.read(result)), result.real)


@pytest.mark.parametrize("form", ["", "XYX", "xYz", "euler"])
def test_unknown_forms_are_told_the_known_ones(form: str) -> None:
    with pytest.raises(GspError, match="or one of " + ", ".join(ROTATIONS)):
        rotation_columns(form)


def test_a_count_for_every_prime_is_a_proof() -> None:
    assert Proof.modulo(CountKind.EXACT, 0.0) == Proof(CountKind.EXACT)
    assert Proof(CountKind.EXACT).to_json() == {
        "by": "exact count",
        "grade": "certain",
        "modulo_random_prime": False,
    }
    assert Proof(CountKind.TYPE).grade is Grade.CERTAIN
    assert Proof(CountKind.TYPE).words == "proved"
    assert not Proof(CountKind.TYPE).reservation


@pytest.mark.parametrize("error", [1e-15, 0.3])
def test_the_bound_of_a_random_prime_is_told(error: float) -> None:
    proof = Proof.modulo(CountKind.GEOMETRY, error)
    assert proof is not None
    assert proof.to_json() == {
        "by": "geometry count",
        "grade": "up to a random prime",
        "modulo_random_prime": error,
    }
    assert proof.grade is Grade.PRIME


@pytest.mark.parametrize(
    ("error", "bound"), [(1.23e-12, "10^11"), (9.9e-11, "10^10"), (1e-3, "10^3")]
)
def test_the_bound_that_is_printed_is_not_less_than_the_error(error: float, bound: str) -> None:
    proof = Proof(CountKind.GEOMETRY, error)
    assert proof.words == f"proved (wrong at most once in {bound})"
    assert proof.reservation.startswith(f"wrong at most once in {bound}, ")
    assert ("treat as certain" in proof.reservation) == (error < 1e-9)


def test_a_probability_of_at_most_one_proves_nothing() -> None:
    assert Proof.modulo(CountKind.EXACT, 1.0) is None
