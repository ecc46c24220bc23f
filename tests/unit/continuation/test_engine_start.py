"""Stored start systems: their counts, that they are solved, and that monodromy finds them again."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from gspcli.continuation.start import distinct, intersection_number, path_count, start_system
from gspcli.continuation.systems import Structure
from gspcli.resources import data_json, data_path
from tools.data.monodromy import solve_generic, trace_defects
from tools.data.start_systems import canonical_monomials


def test_there_are_119_spaces():
    spaces = canonical_monomials()
    assert len(spaces) == len(set(spaces)) == 119


def test_manifest_describes_the_files():
    manifest = data_json("start-systems", "manifest.json")
    assert list(manifest["counts"]) == canonical_monomials()
    assert manifest["solutions"] == sum(manifest["counts"].values())
    size = 0
    for name, expected in manifest["sha256"].items():
        content = data_path("start-systems", name).read_bytes()
        assert hashlib.sha256(content).hexdigest() == expected
        size += len(content)
    assert size < 1_000_000


@pytest.mark.parametrize(
    ("spaces", "known"),
    [
        # 6-6 platforms (Ronga and Vust 1995); Lazard's variety; three planes leave three quadrics.
        ("ssssss", 40),
        ("pppqqq", 20),
        ("pppppp", 8),
        # Table 3 of the paper, divided by 2 for each PL, LP: PPP, SSS.
        ("aaappp", 8),
        ("aaasss", 16),
    ],
)
def test_known_counts(spaces, known):
    assert intersection_number(spaces) == known


def test_counts_are_symmetric_under_the_swap():
    assert intersection_number("aqqqps") == intersection_number("apppqs")
    with pytest.raises(ValueError, match="at most three"):
        intersection_number("aaaass")


@pytest.mark.parametrize("spaces", canonical_monomials())
def test_stored_points_solve_the_stored_systems(spaces):
    start = start_system(Structure(spaces))
    # Stored in single precision.
    assert np.abs(start.system.values(start.points)).max() < 1e-6
    assert distinct(start.points)


@pytest.mark.parametrize(
    ("spaces", "products"),
    [("pppppp", (1,) * 6), ("aqqqqs", (0, 1, 1, 0, 1, 0)), ("plllss", (1, 0, 1, 1, 0, 0))],
)
def test_derived_start_systems(spaces, products):
    structure = Structure(spaces, tuple(map(bool, products))).canonical()
    start = start_system(structure)
    assert len(start.points) == path_count(structure)
    assert distinct(start.points)
    assert np.abs(start.system.values(start.points)).max() < 1e-6
    assert not start.system.coefficients.tau.any()


@pytest.mark.parametrize("spaces", ["ssssss", "aaappp", "ppqqll", "aaplls", "plllll"])
def test_monodromy_from_another_seed_agrees(spaces):
    solved = solve_generic(spaces, np.random.default_rng(2003))
    assert len(solved.points) == intersection_number(spaces)


def test_trace_test_notices_a_missing_solution():
    rng = np.random.default_rng(6)
    for spaces in ("ssssss", "aaappp", "llllll"):
        solved = solve_generic(spaces, rng)
        complete = trace_defects(spaces, solved.quadrics, solved.points, rng)
        missing = trace_defects(spaces, solved.quadrics, solved.points[:-1], rng)
        assert complete.max() < 1e-9
        assert missing.max() > 1e-6
