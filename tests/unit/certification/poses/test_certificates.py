from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import acb, arb, ctx, fmpq

from gspcli.catalogue.kinds import DISTANCE_KINDS
from gspcli.catalogue.names import parse_type
from gspcli.certification import Certificate, Certificates, Outcome, certify
from gspcli.certification.equations.ball_system import BallSystem, pose_of_point
from gspcli.certification.poses.isolation import Isolation, refine_point
from gspcli.errors import GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.measurement import residuals, sides_of
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import vector
from gspcli.geometry.quaternions import pose_from_study
from gspcli.geometry.random_instances import random_instance

SHIFT = np.array([1, -1, 1])
TYPES = [
    *(" ".join([kind.name] * 6) for kind in DISTANCE_KINDS),
    "DPP DPL DLP DPH DHP DLL",
    "DPP DPL DLL ALL ALH AHH",
    "DLP DHP DLL ALL AHL AHL",
    "DPH DPH DPH DPH AHH ALH",
]


@pytest.mark.parametrize("names", TYPES)
@pytest.mark.parametrize("sided", [True, False])
def test_a_known_solution_is_certified_and_contained(
    names: str, sided: bool, known: Callable
) -> None:
    platform = known(names, 11, sided=sided)
    R, T = platform.floats
    result = certify(platform.instance, [R], [T])
    certificate = result[0]
    assert certificate.outcome is Outcome.CERTIFIED
    assert certificate.real is True
    assert result.distinct == result.real == 1
    # The solution itself, which is known exactly, is in the proved enclosure.
    with ctx.workprec(certificate.precision):
        pose = pose_of_point(certificate.isolation.point)
        exact = [fmpq(x.numerator, x.denominator) for row in platform.R for x in row]
        exact += [fmpq(x.numerator, x.denominator) / int(result.scale) for x in platform.T]
        for entry, value in zip(pose.entries, exact, strict=True):
            assert entry.overlaps(acb(arb(value)))
            assert entry.rad() < 1e-12
    # Sides and residual agree with floating-point geometry.
    arrangement = Arrangement.of(platform.instance)
    assert certificate.residual_bound == pytest.approx(
        residuals(arrangement, R, T).max(), abs=1e-13 * result.scale
    )
    signs = {None: 0, Side.POSITIVE: 1, Side.NEGATIVE: -1}
    assert [signs[side] for side in certificate.sides] == list(sides_of(arrangement, R, T))


@pytest.mark.parametrize("names", TYPES)
@pytest.mark.parametrize("size", [1e-4, 1e-2, 1.0])
def test_a_perturbed_solution_fails(names: str, size: float, known: Callable) -> None:
    platform = known(names, 12)
    R, T = platform.floats
    turned = R @ _small_turn(size)
    result = certify(platform.instance, [R, turned], [T + size * SHIFT, T])
    assert result.certified == result.distinct == 0
    assert all(item.outcome in (Outcome.REFUTED, Outcome.TOO_FAR) for item in result)


def test_a_wider_tolerance_accepts_rough_poses(known: Callable) -> None:
    platform = known("DPP DPL DLP DPH DHP DLL", 12)
    R, T = platform.floats
    rough = T + 1e-4 * SHIFT
    assert certify(platform.instance, [R], [rough])[0].outcome is Outcome.REFUTED
    certificate = certify(platform.instance, [R], [rough], tolerance=1e-3)[0]
    assert certificate.certified
    assert 1e-6 < certificate.deviation < 1e-3


def _small_turn(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def test_a_matrix_that_is_no_rotation_fails(known: Callable) -> None:
    platform = known("DPP DPP DPP DPP DPP DPP", 3)
    R, T = platform.floats
    wrong = [-R, 1.001 * R, R[[1, 0, 2]], np.zeros((3, 3)), np.full((3, 3), np.nan)]
    result = certify(platform.instance, wrong, [T] * 5)
    assert result.certified == 0
    assert result[4].outcome is Outcome.NOT_A_NUMBER


def test_dietmaiers_platform_has_forty_real_poses(
    dietmaier: Instance, forty: tuple[np.ndarray, np.ndarray]
) -> None:
    R, T = forty
    result = certify(dietmaier, R, T)
    assert len(result) == result.certified == result.distinct == result.real == 40
    assert max(item.residual_bound for item in result) < 1e-14
    assert max(item.error for item in result) < 1e-10


def test_duplicates_count_once(dietmaier: Instance, forty: tuple[np.ndarray, np.ndarray]) -> None:
    R, T = forty
    shuffled = np.random.default_rng(5).permutation(40)
    result = certify(
        dietmaier, np.concatenate((R, R[shuffled])), np.concatenate((T, T[shuffled] + 1e-9))
    )
    assert (result.certified, result.distinct, result.real) == (80, 40, 40)
    assert [item.same_as for item in result] == [None] * 40 + [int(k) for k in shuffled]


def test_a_double_root_is_never_certified(tangent: Callable) -> None:
    result = certify(tangent(Fraction(1)), [np.eye(3)] * 2, [[1, 0, 0], [1, 0, 1e-9]])
    assert [item.outcome for item in result] == [Outcome.NOT_ISOLATED] * 2
    assert result.distinct == 0


@pytest.mark.parametrize("exponent", [6, 12, 20, 30])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_close_pair_is_told_real_or_not_real(exponent: int, sign: int, tangent: Callable) -> None:
    """The third coordinates of the pair are +-sqrt(sign 2 10^-exponent), nearly."""
    instance = tangent(1 + sign * Fraction(1, 10**exponent))
    z = np.sqrt(complex(sign * 2 * 10.0**-exponent))
    result = certify(instance, [np.eye(3)] * 2, [[1, 0, z], [1, 0, -z]])
    assert result.certified == result.distinct == 2
    assert [item.real for item in result] == [sign > 0] * 2
    if exponent >= 20:
        assert result[0].precision > 64
    # Each has a ball that the other is not in.
    assert result[0].uniqueness < abs(z) / result.scale
    # Nothing in between is taken for a solution.
    between = certify(instance, [np.eye(3)], [[1, 0, 0]])
    assert between.certified == 0


def test_a_limit_of_precision_leaves_a_close_pair_open(tangent: Callable) -> None:
    instance = tangent(1 - Fraction(1, 10**30))
    z = 1.4142135623730951e-15j
    result = certify(instance, [np.eye(3)] * 2, [[1, 0, z], [1, 0, -z]], max_precision=64)
    assert result.distinct == 0
    assert all(item.real is None for item in result)


def complex_solutions(instance: Instance, starts: int, seed: int) -> list[list[complex]]:
    """Return Study points of complex solutions, by Newton's method from random ones."""
    source = np.random.default_rng(seed)
    found = []
    with ctx.workprec(128):
        system = BallSystem(instance, 128)
        for _ in range(starts):
            point = source.standard_normal(8) + 1j * source.standard_normal(8)
            point[0] = 1
            centre = [acb(x) for x in point.tolist()]
            result = refine_point(
                system, centre, 0, system.sides_near(centre, pose_of_point(centre), (0,) * 6)[0]
            )
            if isinstance(result, Isolation):
                # The proof may succeed before Newton's method has converged.
                result = refine_point(system, result.centre, 0, result.sides)
                assert isinstance(result, Isolation)
                found.append([complex(x) for x in result.centre])
    return found


@pytest.mark.parametrize("names", ["DPP DPP DPP DPP DPP DPP", "DPL DLP DLL DPP DHP ALH"])
def test_complex_solutions_are_real_or_come_in_pairs(names: str, known: Callable) -> None:
    instance = known(names, 21, sided=False).instance
    points = np.array(complex_solutions(instance, 60, 1))
    R, T = pose_from_study(points[:, :4], points[:, 4:] * BallSystem(instance, 64).scale)
    result = certify(instance, R, T)
    assert result.certified == len(points) > 10
    assert {item.real for item in result} <= {True, False}
    assert all((item.residual_bound is None) == (not item.real) for item in result)

    first = [k for k, item in enumerate(result) if item.same_as is None]
    assert result.distinct == len(first)
    R, T = R[first], T[first]
    both = certify(instance, np.concatenate((R, R.conj())), np.concatenate((T, T.conj())))
    assert both.certified == 2 * len(first)
    assert not any(item.unresolved for item in both)
    # A solution is the same as its own conjugate exactly if it is real.
    for k, item in enumerate(both[: len(first)]):
        assert item.real == (both[len(first) + k].same_as == k)


def test_a_real_solution_listed_with_a_small_imaginary_part_is_real(known: Callable) -> None:
    platform = known("DPP DPL DLP DPH DHP DLL", 12)
    R, T = platform.floats
    assert certify(platform.instance, [R], [T + 1e-9j])[0].real is True


def test_the_precision_of_others_is_left_alone(known: Callable) -> None:
    before = ctx.prec
    platform = known("DPP DPL DLP DPH DHP DLL", 12)
    R, T = platform.floats
    certify(platform.instance, [R], [T])
    assert ctx.prec == before


def test_an_instance_with_a_number_that_does_not_exist_is_refused(known: Callable) -> None:
    platform = known("DPP DPP DPP DPP DPP ALL", 2)
    impossible = Number("acos", (Number.of(2),))
    R, T = platform.floats
    wrong = platform.instance.with_values({5: impossible})
    with pytest.raises(GspError, match=r"^constraints\[5\]\.value: found acos\(2\), which is no"):
        certify(wrong, [R], [T])
    with ctx.workprec(64):
        assert not BallSystem(wrong, 64).is_finite


def test_lines_that_meet_are_certified(known: Callable) -> None:
    platform = known("DLL DPP DPL DLP DPP DPP", 8)
    row = platform.instance.constraints[0]
    a = [number.fraction for number in row.platform.position]
    image = [
        sum((x * y for x, y in zip(turned, a, strict=True)), Fraction(0)) + t
        for turned, t in zip(platform.R, platform.T, strict=True)
    ]
    meeting = replace(row, base=replace(row.base, position=vector(*image)), value=Number.of(0))
    rows = (meeting, *platform.instance.constraints[1:])
    R, T = platform.floats
    result = certify(replace(platform.instance, constraints=rows), [R], [T])
    assert result.real == 1
    assert result[0].residual_bound < 1e-13


def test_only_solutions_proved_different_are_counted() -> None:
    first = Certificate(Outcome.CERTIFIED, 64, real=True, unresolved=(1,))
    second = Certificate(Outcome.CERTIFIED, 64, real=True, unresolved=(0,))
    copy = Certificate(Outcome.CERTIFIED, 64, real=True, same_as=2)
    other = Certificate(Outcome.CERTIFIED, 64, real=False)
    nothing = Certificate(Outcome.REFUTED, 64)
    result = Certificates((first, second, other, copy, nothing), 1.0, 1.0)
    assert (result.certified, result.distinct, result.real) == (4, 2, 1)


def test_no_candidates_are_no_solutions(known: Callable) -> None:
    instance = known("DPP DPP DPP DPP DPP ALL", 2).instance
    result = certify(instance, np.empty((0, 3, 3)), np.empty((0, 3)))
    assert len(result) == result.distinct == 0


@pytest.mark.parametrize(
    ("R", "T", "message"),
    [
        (np.ones((2, 3)), np.ones((2, 3)), "R: found shape (2, 3), expected (n, 3, 3)"),
        (np.ones((2, 3, 3)), np.ones((2, 4)), "T: found shape (2, 4), expected (n, 3)"),
        (np.ones((2, 3, 3)), np.ones((3, 3)), "T: found 3 translations for 2 rotations"),
        ([["a"]], np.ones(3), "R: found something that is no array of numbers"),
    ],
)
def test_wrong_arguments_are_named(R, T, message):
    instance, _ = random_instance(parse_type("6PP"), np.random.default_rng(0))
    with pytest.raises(GspError) as caught:
        certify(instance, R, T)
    assert str(caught.value).startswith(message)


def parallel_at_home(value: int) -> Instance:
    """Return a platform at home whose first two lines are parallel there, sqrt(5) apart."""
    from gspcli.catalogue.kinds import DLL, DPP
    from gspcli.geometry.instance import AngleUnit, Constraint, Units
    from gspcli.geometry.primitives import Line, Point

    axis = vector(0, 0, 1)
    lines = Constraint(
        DLL, Line(vector(0, 0, 0), axis), Line(vector(1, 2, 0), axis), Number.of(value)
    )
    joints = [(1, 0, 0), (0, 1, 1), (-1, 2, 0), (2, -1, 1), (-1, -1, 3)]
    legs = [(2, 1, -3), (-1, 4, 2), (3, -2, 1), (-2, 1, 4), (1, 3, -2)]
    points = [
        Constraint(
            DPP,
            Point(vector(*y)),
            Point(vector(*(a + b for a, b in zip(y, leg, strict=True)))),
            Number("sqrt", (Number.of(sum(b * b for b in leg)),)),
        )
        for y, leg in zip(joints, legs, strict=True)
    ]
    return Instance((lines, *points), Units("m", AngleUnit.DEGREE))


def test_parallel_lines_are_measured_as_stated() -> None:
    """The equation of a DLL of distance zero holds there, simply; the distance does not."""
    instance = parallel_at_home(0)
    system = BallSystem(instance, 64)
    with ctx.workprec(64):
        home = [acb(1), *[acb(0)] * 7]
        assert isinstance(refine_point(system, home, 0, (0,) * 6), Isolation)
    assert certify(instance, [np.eye(3)], [np.zeros(3)])[0].outcome is Outcome.NOT_AS_STATED


def test_a_start_is_kept_where_newtons_method_leaves_it(known: Callable) -> None:
    """A pose that is not excluded, though the solution found is elsewhere, is not refuted."""
    platform = known("DPP DPP DPP DPP DPP DPP", 11)
    R, T = platform.floats
    far = certify(platform.instance, [R], [T + 1e-9], tolerance=1e-12, max_precision=64)[0]
    assert far.outcome in (Outcome.TOO_FAR, Outcome.REFUTED)
    assert certify(platform.instance, [R], [T + 1e-9])[0].certified
