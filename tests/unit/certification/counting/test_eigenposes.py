"""Poses by eigenvectors: as many as counted, and they meet the constraints as stated."""

from dataclasses import replace
from itertools import islice

import pytest
from flint import acb, ctx

from gspcli.certification.counting import count_exactly, poses_by_elimination
from gspcli.certification.numbers.balls import ball
from gspcli.geometry.numbers import Number
from gspcli.resources import data_directory
from gspcli.spec import load

BITS = 512


@pytest.fixture(autouse=True)
def precision():
    before = ctx.prec
    ctx.prec = BITS
    yield
    ctx.prec = before


def example(name: str):
    return load(data_directory() / "examples" / f"{name}.yaml")


def rounded(instance, digits: int):
    """The instance with its points rounded."""

    def at(point):
        return replace(
            point, position=tuple(Number.of(f"{x.value:.{digits}f}") for x in point.position)
        )

    rows = (
        replace(row, platform=at(row.platform), base=at(row.base)) for row in instance.constraints
    )
    return replace(instance, constraints=tuple(rows))


def orthogonality(pose) -> float:
    """How far R^T R is from the identity, relative to the squares of R."""
    R = pose.R
    size = max(abs(x) ** 2 for row in R for x in row)
    errors = [
        abs(sum((R[i][k] * R[j][k] for k in range(3)), acb(-(i == j))))
        for i in range(3)
        for j in range(3)
    ]
    return float((max(errors) / size).upper())


def leg_error(instance, pose) -> float:
    """The largest relative error of a squared leg."""
    worst = 0.0
    for row in instance.constraints:
        a, b = ([ball(x) for x in point.position] for point in (row.platform, row.base))
        d = ball(row.value)
        leg = [
            sum((x * y for x, y in zip(r, a, strict=True)), t - z)
            for r, t, z in zip(pose.R, pose.T, b, strict=True)
        ]
        size = sum((abs(x) ** 2 for x in leg), abs(d * d))
        worst = max(worst, float((abs(sum((x * x for x in leg), -d * d)) / size).upper()))
    return worst


@pytest.mark.parametrize(
    ("name", "real"),
    [("dietmaier", 40), ("planar-hexagons", 8), ("congruent-platform", 4), ("platform-6-4", 6)],
)
def test_all_poses_of_hexapods(name, real):
    instance = example(name)
    poses = list(poses_by_elimination(instance, BITS))
    assert len(poses) == count_exactly(instance).solutions
    assert max(map(orthogonality, poses)) < 1e-50
    assert max(leg_error(instance, pose) for pose in poses) < 1e-50
    assert sum(all(x.imag.is_zero() for x in pose.T) for pose in poses) == real


@pytest.mark.parametrize(
    "name",
    ["example-6.8", "six-planes", "fixture-3-2-1", "surfaces-pps", "figure-2", "surfaces-ppp"],
)
def test_all_poses_of_other_platforms(name):
    instance = example(name)
    poses = list(poses_by_elimination(instance, BITS))
    assert len(poses) == count_exactly(instance).solutions
    assert max(map(orthogonality, poses)) < 1e-50


def test_poses_nearly_at_infinity_are_found_as_well_as_near_ones():
    instance = rounded(example("planar-hexagons"), 9)
    poses = list(poses_by_elimination(instance, BITS))
    assert len(poses) == 36
    far = [max(abs(x) for x in pose.T) > 1e20 for pose in poses]
    assert sum(far) == 8
    assert max(leg_error(instance, pose) for pose in poses) < 1e-30


def test_poses_nearly_at_infinity_come_first():
    instance = rounded(example("planar-hexagons"), 9)
    first = list(islice(poses_by_elimination(instance, BITS, near=28), 8))
    assert all(max(abs(x) for x in pose.T) > 1e20 for pose in first)
    assert len({str(pose.T) for pose in first}) == 8
    assert max(leg_error(instance, pose) for pose in first) < 1e-30


def test_infinite_sets_have_no_list():
    assert list(poses_by_elimination(example("griffis-duffy"), BITS)) == []


def test_the_precision_of_the_caller_stays():
    for _ in poses_by_elimination(example("six-planes"), 128, near=6):
        assert ctx.prec == BITS
    assert ctx.prec == BITS
