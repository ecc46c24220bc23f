"""The rigid-motion varieties: their equations hold, their degrees are those recorded."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path
from random import Random

import pytest
import sympy
from sympy import Matrix

from gspcli.catalogue.bounds import varieties
from gspcli.resources import data_json
from gspcli.symbolic.exact_motions import (
    hilbert_function,
    monomials,
    random_motion,
    rank,
    residues,
    sampled_hilbert_function,
)
from tools.equations.constraint_equations import (
    EXPRESSIONS,
    LAZARD,
    MOTIONS,
    SYMBOLS,
    SYSTEMS,
    system,
)
from tools.equations.motions import equations, motion_blocks, motion_variables

ROOT = Path(__file__).parents[3]
CHECK = [sys.executable, "-m", "tools.data.varieties", "--check"]
NAMES = [coordinates.name for coordinates in SYSTEMS]


def symbolic_blocks() -> dict[str, Matrix]:
    """Return the blocks at the rotation of any quaternion (1, a, b, c) and any translation."""
    a, b, c = sympy.symbols("a b c")
    rows = [
        [1 + a**2 - b**2 - c**2, 2 * (a * b - c), 2 * (a * c + b)],
        [2 * (a * b + c), 1 - a**2 + b**2 - c**2, 2 * (b * c - a)],
        [2 * (a * c - b), 2 * (b * c + a), 1 - a**2 - b**2 + c**2],
    ]
    rotation = Matrix(rows) / (1 + a**2 + b**2 + c**2)
    return motion_blocks(rotation, Matrix(sympy.symbols("x y z")))


def test_every_expression_of_a_block_is_an_identity_on_the_motions() -> None:
    blocks = symbolic_blocks()
    for block, ways in EXPRESSIONS.items():
        for other, way in ways.items():
            difference = way(blocks["R"], blocks[other]) - blocks[block]
            assert difference.applyfunc(sympy.cancel).is_zero_matrix, (block, other)


def test_mourrains_minors_are_the_entries_of_the_moment_block() -> None:
    r, t = SYMBOLS["R"], SYMBOLS["T"]
    moment = motion_blocks(r, t)["TxR"]
    for k in range(3):
        for i, j, row in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            # The paper's (i,j|k,4) = r_ik t_j − r_jk t_i, equation (4).
            minor = r[i, k] * t[j] - r[j, k] * t[i]
            assert sympy.expand(moment[row, k] + minor) == 0


@pytest.mark.parametrize("name", NAMES)
def test_equations_vanish_at_exact_motions(name: str) -> None:
    coordinates = system(name)
    values = motion_variables(random_motion(Random(3)))
    blocks = {
        symbol: entry.subs(values)
        for block in coordinates.blocks
        for symbol, entry in zip(SYMBOLS[block], MOTIONS.expressions[block], strict=True)
    }
    assert all(equation.subs(blocks) == 0 for equation in equations(coordinates))
    # One wrong coordinate violates them, but T or U alone is free.
    dependent = SYMBOLS["R"] if name in ("R,T", "R,U") else coordinates.symbols
    for symbol in dependent:
        wrong = blocks | {symbol: blocks[symbol] + 1}
        assert any(equation.subs(wrong) != 0 for equation in equations(coordinates)), symbol


def test_coordinates_determine_exactly_the_blocks_they_can() -> None:
    assert set(system("R").expressions) == {"R"}
    assert LAZARD.degrees == {"R": 1, "T": 1, "U": 1, "rho": 2, "TxR": 2}


@pytest.mark.parametrize("name", NAMES)
def test_hilbert_function_at_random_motions_is_the_recorded_one(name: str) -> None:
    variety = varieties()[name]
    # The two smallest up to the degree where the series has ended: their degree is confirmed.
    highest = 3 if variety.ambient_dimension <= 12 else 2
    for degree in range(highest + 1):
        expected = hilbert_function(variety.hilbert_numerator, variety.dimension, degree)
        points = expected + 6
        assert sampled_hilbert_function(name, degree, points) == expected


def test_records_are_consistent() -> None:
    assert list(varieties()) == NAMES
    for coordinates in SYSTEMS:
        variety = varieties()[coordinates.name]
        assert variety.dimension == (3 if coordinates.name == "R" else 6)
        assert sum(variety.hilbert_numerator) == variety.degree
        assert variety.equations == len(equations(coordinates))
        assert variety.ambient_dimension == len(coordinates.symbols)


def test_degrees_of_the_paper_and_of_the_large_mourrain_variety() -> None:
    degrees = {name: variety.degree for name, variety in varieties().items()}
    assert degrees["R,T,U"] == 20  # Section 3: Lazard
    assert degrees["R,T,U,rho"] == 40  # Section 3: Mourrain's 16 coordinates
    assert degrees["R,T,U,rho,TxR"] != 40  # not as Section 3 says about the 25 coordinates


@pytest.mark.parametrize(
    ("name", "key"), [("varieties.json", "varieties"), ("constraints.json", "constraints")]
)
def test_manifest_has_the_digest_of_the_content(name: str, key: str) -> None:
    record = data_json(name)
    text = json.dumps(record[key], sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    assert record["manifest"]["sha256"] == hashlib.sha256(text.encode()).hexdigest()


@pytest.mark.skipif(shutil.which("Singular") is None, reason="Singular is not installed")
def test_singular_confirms_the_record() -> None:
    run = subprocess.run(CHECK, capture_output=True, text=True, check=False, cwd=ROOT)
    assert run.returncode == 0, run.stderr
    assert "confirmed: dimension and degree of 10 varieties" in run.stdout


def test_without_singular_the_tool_says_so() -> None:
    run = subprocess.run(
        CHECK, cwd=ROOT, capture_output=True, text=True, check=False, env={"PATH": "/nonexistent"}
    )
    assert run.returncode == 4
    assert "Singular is not installed" in run.stderr
    assert "nothing was computed" in run.stderr


def test_rank_and_monomials_on_a_small_example() -> None:
    # The points (0, 0), (1, 1), (2, 4), (3, 9), (4, 16) lie on a parabola.
    points = residues([(x, x * x) for x in range(5)])
    assert monomials(points, 1).shape == (5, 3)
    assert monomials(points, 2).shape == (5, 6)
    assert rank(monomials(points, 1)) == 3
    assert rank(monomials(points, 2)) == 5
    assert rank(residues([(1, 2), (2, 4)])) == 1
