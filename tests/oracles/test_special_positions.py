"""Platforms in special position against counts by Gröbner bases and theorems."""

from __future__ import annotations

import csv
import hashlib
import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from gspcli import dumps, load
from gspcli.catalogue.coincidence import parse_sharing
from gspcli.catalogue.kinds import DLL, DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import jacobian, measured, residuals
from gspcli.geometry.quaternions import Field, normalized, rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import SolveResult, solve
from tests.support.oracle.poses_by_paths import solve_by_tracking

DATA = Path(__file__).parents[2] / "data"
EXAMPLES = DATA / "examples"
EXPECTED = json.loads((EXAMPLES / "expected.json").read_text(encoding="utf-8"))["examples"]
SHARED_JOINTS = Path(__file__).parent / "records" / "coincident-platforms.csv"


def accounted(instance: Instance) -> SolveResult:
    """Solve, and check that every path and every pose is what the result says."""
    result = solve(instance)
    assert int(result.multiplicity.sum()) == result.account.found
    assert result.account.lost == 0
    size = 1 + np.abs(result.R).max((1, 2)) + np.abs(result.T).max(1) / result.arrangement.length
    # The distance of a complex point from a line that it lies on is the root of a sum of squares
    # that cancel: half of the digits.
    zero = result.arrangement.targets == 0
    relative = np.where(zero & ~result.real[:, None], result.residuals**2, result.residuals)
    simple = result.multiplicity == 1
    assert ((relative.max(axis=1) / size**2)[simple] < 1e-9).all()
    return result


@cache
def example(name: str) -> SolveResult:
    return accounted(load(EXAMPLES / f"{name}.yaml"))


def test_every_example_has_a_recorded_count():
    assert set(EXPECTED) == {path.stem for path in EXAMPLES.glob("*.yaml")}


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_examples_have_the_counts_of_groebner_bases(name):
    recorded = EXPECTED[name]
    content = (EXAMPLES / f"{name}.yaml").read_bytes()
    assert recorded["sha256"] == hashlib.sha256(content).hexdigest()
    result = example(name)
    if recorded["dimension"] == 0:
        assert result.verdict == "complete"
        assert int(result.multiplicity.sum()) == recorded["complex"]
        assert result.counts.found == recorded["distinct"]
        assert result.counts.real == recorded["real"]
    else:
        assert result.verdict == "infinite"
        assert max(motion.dimension for motion in result.motions) == recorded["dimension"]


with SHARED_JOINTS.open(encoding="utf-8", newline="") as file:
    PLATFORMS = list(csv.DictReader(file))
SEED = json.loads(SHARED_JOINTS.with_suffix(".manifest.json").read_text(encoding="utf-8"))["seed"]


def shared_joints(row: dict[str, str]) -> Instance:
    rng = np.random.default_rng([SEED, int(row["id"].partition(".")[2]), int(row["planar"])])
    bonds = parse_sharing(row["pattern"]).bonds
    instance, _ = random_instance(bonds, rng, planar=row["planar"] == "1")
    assert hashlib.sha256(dumps(instance).encode()).hexdigest() == row["instance_sha256"]
    return instance


@pytest.mark.parametrize("planar", ["0", "1"], ids=["spatial", "planar"])
def test_platforms_with_shared_joints_have_the_counts_of_groebner_bases(planar):
    """All ways in which six legs can share joints and still fix the platform."""
    rows = [row for row in PLATFORMS if row["planar"] == planar]
    assert len(rows) == 59
    for row in rows:
        result = accounted(shared_joints(row))
        found = {
            "dimension": "1" if result.motions else "0",
            "complex": str(result.multiplicity.sum()),
            "distinct": str(result.counts.found),
        }
        assert found == {key: row[key] for key in found}, row["pattern"]


def test_octahedral_platform_has_16_poses_in_mirror_pairs():
    """P. Nanua, K. Waldron, V. Murthy 1990: a polynomial of degree 8 in a square."""
    result = example("octahedral-3-3")
    assert result.counts.found == 16
    mirror = np.diag([1.0, 1.0, -1.0])
    # The base is in the plane z = 0, and the platform's own mirror image is itself.
    images = mirror @ result.R @ mirror
    for image in images:
        assert np.abs(result.R - image).max(axis=(1, 2)).min() < 1e-8


def test_planar_platforms_are_symmetric_to_their_base():
    result = example("planar-6-6")
    mirror = np.array([1.0, 1.0, -1.0])
    for T in result.T:
        assert np.abs(result.T - mirror * T).max(axis=1).min() < 1e-8 * (1 + np.abs(T).max())


@pytest.mark.parametrize(
    ("name", "dimension"),
    [
        # The platform moves parallel to itself, every joint on a sphere about its base joint.
        ("congruent-equal-legs", 2),
        # Architecturally singular: the Jacobian matrix has rank below six in every pose.
        ("similar-hexagons", 1),
        ("griffis-duffy", 1),
        # R. Bricard 1897, octahedra of the first kind.
        ("bricard-octahedron", 1),
    ],
)
def test_self_motions_are_found_and_keep_the_constraints(name, dimension):
    result = example(name)
    assert result.verdict == "infinite"
    real = [motion for motion in result.motions if motion.real]
    assert max(motion.dimension for motion in real) == dimension
    for motion in real[:3]:
        assert residuals(result.arrangement, motion.R, motion.T).max() < 1e-8
        steps = np.abs(np.diff(motion.R, axis=0)).max(axis=(1, 2))
        shifts = np.abs(np.diff(motion.T, axis=0)).max(axis=1)
        assert np.maximum(steps, shifts).max() > 1e-4


@pytest.mark.parametrize("name", ["similar-hexagons", "griffis-duffy"])
def test_architecturally_singular_platforms_are_singular_in_random_poses(name):
    arrangement = Arrangement.of(load(EXAMPLES / f"{name}.yaml"))
    rng = np.random.default_rng(1)
    R, T = rotation_from_quaternion(rng.normal(size=(20, 4))), rng.normal(size=(20, 3))
    singular_values = np.linalg.svd(jacobian(arrangement, R, T))[1]
    assert (singular_values[:, -1] < 1e-12).all()


def test_a_singular_pose_is_a_double_solution():
    result = example("singular-pose")
    (double,) = np.flatnonzero(result.multiplicity == 2)
    assert result.real[double]
    np.testing.assert_allclose(result.R[double], np.eye(3), atol=1e-6)
    np.testing.assert_allclose(result.T[double], 0, atol=1e-6)


def test_no_real_pose_is_an_answer():
    """The triangle inequality excludes real poses, not complex ones."""
    result = example("no-real-pose")
    assert result.verdict == "complete"
    assert (result.counts.found, result.counts.real) == (40, 0)


def test_dietmaier_has_40_real_poses():
    """P. Dietmaier 1998."""
    result = example("dietmaier")
    assert result.counts.found == result.counts.real == 40


def nearly_parallel(angle: float) -> tuple[Arrangement, Field, Field]:
    """Return five DPP and a DLL, and a pose in which its lines meet at an angle (radians)."""
    rng = np.random.default_rng(3)
    y, x = rng.uniform(-1, 1, (2, 6, 3))
    R, T = rotation_from_quaternion(rng.normal(size=4)), rng.uniform(-1, 1, 3)
    u, v = np.zeros((2, 6, 3))
    v[5] = normalized(rng.normal(size=3))
    across = normalized(np.cross(v[5], [1.0, 2.0, 3.0]))
    u[5] = (np.cos(angle) * v[5] + np.sin(angle) * across) @ R
    arrangement = Arrangement(
        kinds=(DPP,) * 5 + (DLL,),
        y=y,
        x=x,
        u=u,
        v=v,
        values=np.zeros(6),
        sides=np.zeros(6, dtype=np.int64),
        in_radians=1.0,
    )
    return arrangement.with_values(np.abs(measured(arrangement, R, T))), R, T


@pytest.mark.parametrize("angle", [1e-2, 1e-4, 1e-5])
def test_nearly_parallel_lines_are_a_pose(angle):
    arrangement, R, T = nearly_parallel(angle)
    poses = solve_by_tracking(arrangement, seed=1)
    distances = np.abs(poses.R - R).max(axis=(1, 2)) + np.abs(poses.T - T).max(axis=1)
    assert len(poses.R) == poses.account.found == poses.account.expected
    # The gradient of the equation is as small as the sine.
    assert distances.min() < 1e-13 / angle + 1e-12


@pytest.mark.parametrize("angle", [1e-6, 1e-7])
def test_poses_too_near_to_parallel_lines_are_not_passed_over(angle):
    """The two poses look like one end of two paths: lost, not spurious."""
    arrangement, *_ = nearly_parallel(angle)
    poses = solve_by_tracking(arrangement, seed=1)
    assert len(poses.R) + poses.account.lost == poses.account.expected
