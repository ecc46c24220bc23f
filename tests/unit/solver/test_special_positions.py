"""Platforms in special position: multiple poses, poses at infinity, and motions."""

from __future__ import annotations

import numpy as np
import pytest
from positions import ORIGIN, P, X, Y, Z, angles, at, cylinders, solved, spheres

from gspcli.geometry.instance import Side
from gspcli.geometry.primitives import Line, Plane, vector
from gspcli.geometry.residuals import residuals


def test_example_6_8_has_64_real_poses():
    result = solved(*cylinders(6, 4, 5), *angles(60))
    assert result.expected == result.counts.found == result.counts.real == 64
    # Table 2 of the paper, with x and y as in equation (17).
    np.testing.assert_allclose(
        np.unique(np.round(np.abs(result.T.real), 9), axis=0),
        [[3 * np.sqrt(6) / 2, 3 * np.sqrt(10) / 2, np.sqrt(10) / 2]],
        atol=1e-9,
    )


def test_no_real_pose_is_an_answer():
    result = solved(*cylinders(6, 1, 1), *angles(60))
    assert result.verdict == "complete"
    assert result.counts.found == 64
    assert result.counts.real == 0


def test_right_angles():
    assert solved(*cylinders(6, 4, 5), *angles(90)).counts.found == 64


def test_equal_directions_are_an_eightfold_rotation():
    result = solved(*cylinders(6, 4, 5), *angles(0))
    assert result.counts.found == result.counts.real == result.counts.singular == 8
    assert result.multiplicity.tolist() == [8] * 8
    np.testing.assert_allclose(result.R, np.tile(np.eye(3), (8, 1, 1)), atol=1e-9)


def test_tangent_spheres_are_double_poses():
    result = solved(*spheres((at(0, 0, 0), 1), (at(2, 0, 0), 1), (at(1, 1, 0), 1)), *angles(60))
    assert result.expected == 16
    assert result.multiplicity.tolist() == [2] * 8
    assert result.verdict == "complete"
    np.testing.assert_allclose(result.T, np.tile([1, 0, 0], (8, 1)), atol=1e-9)


def test_almost_tangent_spheres_are_two_poses():
    """Radii that overlap by 1e-9 leave two poses 1e-4 apart, not one."""
    result = solved(
        *spheres((at(0, 0, 0), 1), (at(2, 0, 0), "1.00000001"), (at(1, 1, 0), 1)), *angles(60)
    )
    assert result.counts.found == 16
    assert result.counts.singular == 0


@pytest.mark.parametrize(
    ("centres", "radii"),
    [
        (((0, 0, 0), (0, 0, 0), (2, 0, 0)), (2, 3, 2)),
        (((0, 0, 0), (2, 0, 0), (4, 0, 0)), (2, 2, 2)),
    ],
    ids=["concentric", "collinear centres"],
)
def test_spheres_that_meet_only_at_infinity(centres, radii):
    result = solved(
        *spheres(*((at(*c), r) for c, r in zip(centres, radii, strict=True))), *angles(60)
    )
    assert result.verdict == "complete"
    assert result.counts.found == 0
    assert result.account.at_infinity == 16


def test_equal_spheres_are_infinite():
    result = solved(
        *spheres((at(1, 0, 0), 2), (at(1, 0, 0), 2)),
        ("DPH", P, Plane(ORIGIN, Z), 1, Side.POSITIVE),
        *angles(60),
    )
    assert result.verdict == "infinite"
    assert result.motions[0].dimension == 1


def test_coaxial_cylinders_are_infinite_or_empty():
    def pair(radius):
        return solved(
            ("DPL", P, Line(ORIGIN, Z), 2),
            ("DPL", P, Line(vector(0, 0, 3), vector(0, 0, -4)), radius),
            ("DPP", P, at(2, 0, 0), 2),
            *angles(60),
        )

    assert pair(1).verdict == "complete"
    assert pair(1).account.at_infinity == 64
    assert pair(2).verdict == "infinite"


def test_parallel_cylinders_lose_half_of_the_poses():
    result = solved(
        ("DPL", P, Line(ORIGIN, Z), 2),
        ("DPL", P, Line(vector(1, 0, 3), Z), 2),
        ("DPP", P, at(1, 1, 0), 2),
        *angles(60),
    )
    assert (result.counts.found, result.account.at_infinity) == (32, 32)


def test_parallel_planes_are_infinite_or_empty():
    def pair(height):
        return solved(
            ("DPH", P, Plane(ORIGIN, Z), 2, Side.POSITIVE),
            ("DPH", P, Plane(vector(0, 0, height), Z), 2, Side.NEGATIVE),
            ("DPH", P, Plane(ORIGIN, X), 2, Side.POSITIVE),
            *angles(60),
        )

    assert pair(1).account.at_infinity == 8
    assert pair(4).verdict == "infinite"
    assert pair(4).motions[0].dimension == 1


def test_planes_through_one_direction():
    result = solved(
        ("DPH", P, Plane(ORIGIN, Z), 1, Side.POSITIVE),
        ("DPH", P, Plane(ORIGIN, X), 1, Side.POSITIVE),
        ("DPH", P, Plane(ORIGIN, vector(1, 0, 1)), 2, Side.POSITIVE),
        *angles(60),
    )
    assert result.verdict == "complete"
    assert result.account.at_infinity == 8


def test_a_distance_of_zero_to_a_plane_has_one_side():
    rows = [("DPH", P, Plane(ORIGIN, d), 0) for d in (X, Y, Z)]
    result = solved(*rows, *angles(60))
    assert result.expected == result.counts.found == result.counts.real == 8


def test_dependent_angles_let_the_platform_turn():
    equal = [("ALL", Line(ORIGIN, Z), Line(ORIGIN, Z), 60)] * 2
    result = solved(*cylinders(6, 4, 5), *equal, ("ALL", Line(ORIGIN, X), Line(ORIGIN, Y), 60))
    assert result.verdict == "infinite"
    motion = result.motions[0]
    assert motion.real
    assert motion.dimension == 1
    assert residuals(result.arrangement, motion.R, motion.T).max() < 1e-9
    assert np.abs(motion.R[-1] - motion.R[0]).max() > 0.3


def test_three_angles_with_one_line_of_the_base():
    """The direction of the base line in the platform is fixed; turning about it is free."""
    base = Line(ORIGIN, Z)
    rows = [("ALL", Line(ORIGIN, d), base, value) for d, value in ((X, 60), (Y, 60), (Z, 45))]
    result = solved(*cylinders(6, 4, 5), *rows)
    assert result.verdict == "infinite"
    assert result.motions[0].real


def test_contradictory_angles_have_no_pose():
    for second, third in ((50, 60), (60, 50)):
        rows = [("ALL", Line(ORIGIN, Z), Line(ORIGIN, Z), value) for value in (60, second)]
        result = solved(
            *cylinders(6, 4, 5), *rows, ("ALL", Line(ORIGIN, X), Line(ORIGIN, Y), third)
        )
        if second != 60:
            assert result.verdict == "complete"
            assert result.counts.found == 0


def test_two_angles_with_one_line_of_the_base_lose_half_of_the_rotations():
    rows = [("ALL", Line(ORIGIN, d), Line(ORIGIN, Z), value) for d, value in ((X, 60), (Y, 50))]
    result = solved(*cylinders(6, 4, 5), *rows, ("ALL", Line(ORIGIN, Z), Line(ORIGIN, X), 60))
    assert (result.counts.found, result.account.at_infinity) == (32, 32)


def test_parallel_lines_keep_their_distance_on_a_cylinder():
    result = solved(
        ("DLL", Line(vector(1, 0, 0), Z), Line(ORIGIN, Z), 1),
        ("DPH", P, Plane(ORIGIN, X), "0.5"),
        ("DPH", P, Plane(ORIGIN, Z), 2),
        ("ALL", Line(ORIGIN, Z), Line(ORIGIN, Z), 0),
        ("ALL", Line(ORIGIN, Y), Line(ORIGIN, Y), 50),
        ("ALL", Line(ORIGIN, Y), Line(ORIGIN, X), 40),
    )
    # The lines are parallel at every pose: what is counted is the distance of a point from a line.
    assert result.verdict == "complete"
    assert result.proof is not None
    assert result.counts.real > 0
    assert result.residuals[result.real].max() < 1e-10
    assert (result.multiplicity > 1).all()


def test_motions_through_infinite_sets_satisfy_the_constraints():
    result = solved(
        ("DPL", P, Line(ORIGIN, Z), 2),
        ("DPL", P, Line(vector(4, 0, 0), Z), 2),
        ("DPL", P, Line(vector(2, 2, 0), Z), 2),
        *angles(60),
    )
    assert result.verdict == "infinite"
    motion = result.motions[0]
    np.testing.assert_allclose(motion.T[:, :2], np.tile([2, 0], (len(motion.T), 1)), atol=1e-9)


def test_motion_with_lines_kept_parallel():
    """Three angles of zero with one direction: the platform turns about that direction."""
    up = Line(ORIGIN, Z)
    down = Line(ORIGIN, vector(0, 0, -1))
    result = solved(
        ("DPH", P, Plane(ORIGIN, X), 1),
        ("DPH", P, Plane(ORIGIN, Y), 1),
        ("DPH", P, Plane(ORIGIN, Z), 1),
        ("ALL", up, up, 0),
        ("ALL", up, down, 180),
        ("ALL", down, down, 0),
    )
    assert result.verdict == "infinite"
    motion = result.motions[0]
    assert motion.real
    np.testing.assert_allclose(motion.R[:, 2], np.tile([0, 0, 1], (len(motion.R), 1)), atol=1e-9)


def test_a_line_that_coincides_with_another():
    """Distance and angle zero: the position along the line is left to the other distances."""
    result = solved(
        ("DLL", Line(ORIGIN, Z), Line(ORIGIN, Z), 0),
        ("DPH", P, Plane(ORIGIN, Z), 2, Side.POSITIVE),
        ("DPP", P, at(0, 0, 5), 3),
        ("ALL", Line(ORIGIN, Z), Line(ORIGIN, Z), 0),
        ("ALL", Line(ORIGIN, Y), Line(ORIGIN, Y), 50),
        ("ALL", Line(ORIGIN, X), Line(ORIGIN, Z), 90),
    )
    # Curves of complex solutions, with real poses on them that cannot move.
    assert result.verdict == "infinite"
    real = result.poses.lone.T
    assert len(real) > 0
    np.testing.assert_allclose(real, np.tile([0, 0, 2], (len(real), 1)), atol=1e-9)


@pytest.mark.parametrize("kind", ["DPP", "DPL", "DLP", "DPH", "DHP", "DLL"])
def test_distances_of_zero_are_reported_without_a_warning(kind):
    """Their measures have no derivative. Warnings are errors in these tests."""
    shapes = {"P": at(1, 0, 1), "L": Line(vector(1, 0, 1), Y), "H": Plane(vector(1, 0, 1), X)}
    result = solved(
        (kind, shapes[kind[1]], {**shapes, "L": Line(ORIGIN, Z)}[kind[2]], 0),
        ("DPP", at(0, 1, 0), at(0, 2, 1), 2),
        ("DPL", at(0, 0, 1), Line(vector(1, 0, 1), vector(0, 1, 1)), 2),
        *angles(60),
    )
    assert result.verdict == "complete"
    document = result.to_json(everything=True)
    assert len(document["solutions"]) == result.counts.found > result.expected / 2


def test_nearly_equal_spheres_in_more_than_enough_places_still_add_up():
    # Nearly congruent bodies: at some rotations two spheres and a plane are not made out.
    first, second = (
        (3060.000000119, -180.000000216, 4249.999999762),
        (3059.999999193, -179.999999694, 4249.999999953),
    )
    third = (-6180.000000623, 8400.00000013, 9670.000000456)
    minus = [tuple(-x for x in point) for point in (first, second)]
    result = solved(
        ("DPP", at(*first), at(*minus[0]), 15094.570666745),
        ("DPP", at(*second), at(*minus[1]), 15094.570666715),
        (
            "DPH",
            at(*third),
            Plane(vector(6179.999999934, -8400.000000182, -9669.999999036), vector(-7, -6, 6)),
            9024.54545548,
            Side.NEGATIVE,
        ),
        ("ALL", Line(ORIGIN, vector(-7, -6, -6)), Line(ORIGIN, vector(6, 9, -2)), 155.796652974),
        ("ALL", Line(ORIGIN, vector(-6, 9, 2)), Line(ORIGIN, vector(42, -108, 27)), 90),
        ("ALL", Line(ORIGIN, vector(-6, 2, -9)), Line(ORIGIN, vector(-11, -10, 2)), 55.539341925),
    )
    assert (result.verdict, result.counts.found) == ("complete", 16)
