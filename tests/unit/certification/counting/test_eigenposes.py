"""Poses by eigenvectors: as many as counted, and they meet the constraints as stated."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from flint import acb, ctx

from gspcli.catalogue.names import parse_type
from gspcli.certification.counting import count_exactly, geometry_count, poses_by_elimination
from gspcli.certification.counting.modular_platform import NotCountedError
from gspcli.geometry.instance import AngleUnit, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_directory
from gspcli.spec import load

BITS = 512
DEGREES = Units("m", AngleUnit.DEGREE)


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
        a, b = ([x.ball() for x in point.position] for point in (row.platform, row.base))
        d = row.value.ball()
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


def with_angle(degrees: str):
    """A platform with one angle, in degrees."""
    names = parse_type("DPP DPP DPP DPP DPH ALL")
    instance, _ = random_instance(names, np.random.default_rng(3))
    (k,) = (k for k, row in enumerate(instance.constraints) if not row.kind.is_distance)
    return replace(instance, units=DEGREES).with_values({k: Number.of(degrees)})


def test_angles_with_many_decimals_have_poses_by_elimination():
    """Their cosines have no image modulo a prime: the pivots are those of another angle."""
    near, exact = with_angle("71.25"), with_angle("71.25000000000001")
    assert geometry_count(exact) is not None
    with pytest.raises(NotCountedError):
        count_exactly(exact)
    poses = list(poses_by_elimination(exact, BITS))
    assert len(poses) == count_exactly(near).solutions
    assert max(map(orthogonality, poses)) < 1e-50
    row = next(row for row in exact.constraints if not row.kind.is_distance)
    angle = row.value.ball() * Number("pi", ()).ball() / 180
    u, v = ([x.ball() for x in part.vector] for part in (row.platform, row.base))
    size = (sum(x * x for x in u) * sum(x * x for x in v)).sqrt()
    for pose in poses:
        found = sum(v[i] * pose.R[i][j] * u[j] for i in range(3) for j in range(3)) / size
        assert abs(found - angle.cos()) < 1e-60


def test_a_number_of_no_ring_has_no_poses_by_elimination():
    """Pi beside an angle in radians: whether they are independent is not known."""
    instance = with_angle("1")
    first = instance.constraints[0].platform.position
    point = replace(instance.constraints[0].platform, position=(Number("pi", ()), *first[1:]))
    rows = (replace(instance.constraints[0], platform=point), *instance.constraints[1:])
    radians = replace(instance, constraints=rows, units=replace(DEGREES, angle=AngleUnit.RADIAN))
    assert list(poses_by_elimination(radians, BITS)) == []
