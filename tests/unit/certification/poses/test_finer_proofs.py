"""Proofs with 64 digits: the same poses as in balls, and no false claim about made-up equations."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np
import pytest
from flint import ctx

from gspcli import _kernel
from gspcli.certification.equations import study
from gspcli.certification.equations.frames import StudyFrames
from gspcli.certification.numbers.rounding import COMPLEX, ISOLATED, REAL, ROUNDED
from gspcli.certification.poses.finer_proofs import FinerProofs
from gspcli.certification.poses.locator import Located, Locator
from gspcli.solver import solve
from gspcli.solver.starts.solved_starts import SolvedStarts
from tools.special.realistic import machines

#: What the kernel allows for: the errors of coefficients as a part of their bounds.
ERROR = 2.0**-190


class Decided(NamedTuple):
    """What the kernel decides about points."""

    R: np.ndarray
    T: np.ndarray
    bits: np.ndarray
    deviation: np.ndarray
    reached: np.ndarray


def row(constant: float = 0, slope: float = 0, square: float = 0, k: int = 1) -> np.ndarray:
    """Return the coefficients of constant e_0^2 + slope e_0 z + square z^2, z coordinate k."""
    found = np.zeros(27)
    found[0], found[k if k < 4 else 6 + k] = constant, slope
    if k < 4:
        found[4 * k - k * (k - 1) // 2] = square
    return found


NORM = sum(row(square=1, k=k) for k in (1, 2, 3)) + row(1)


def decide(
    rows: dict[int, list[np.ndarray]],
    points: list[complex],
    *,
    more: float = 0.0,
    k: int = 1,
    last: float = 0.0,
    build: str = "",
) -> Decided:
    """Decide about values of coordinate k by the first; the others are zero.

    Parameters
    ----------
    rows
        For equations 1 to 6 the main quadric and those whose squares are subtracted; of the others
        each makes one coordinate zero. The first of all, that of e.f, makes the last one `last`.
    points
        Values of the coordinate.
    more
        By how much more than its modulus the constant of each main quadric of rows is bounded.
    """
    quadrics = [NORM, row(-last, 1, k=7)]
    bounds = [np.abs(x) for x in quadrics]
    table = np.full((6, 3), -1, np.int32)
    for r in range(6):
        for j, given in enumerate(rows.get(r, [row(slope=1, k=r + 1)])):
            table[r, j] = len(quadrics)
            quadrics.append(given)
            bounds.append(np.abs(given) + more * (np.arange(27) == 0) * (r in rows and not j))
    coefficients = np.zeros((4, len(quadrics), 27))
    coefficients[0] = quadrics
    study_points = np.zeros((1, len(points), 8), complex)
    study_points[0, :, 0], study_points[0, :, 7], study_points[0, :, k] = 1, last, points
    R, T, _, deviation, bits, reached = _kernel.decide_finer(
        coefficients,
        np.array(bounds),
        table,
        study_points,
        unit=1.0,
        origins=np.zeros((2, 3)),
        scale=1.0,
        tolerance=1e9,
        build=build,
    )
    return Decided(R, T, bits, deviation, reached)


def rotation(z: complex) -> np.ndarray:
    """Return the rotation of the quaternion (1, z, 0, 0)."""
    n = 1 + z * z
    c, s = (1 - z * z) / n, 2 * z / n
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


@pytest.mark.parametrize("build", ["", "portable"])
def test_simple_roots_are_proved_and_rounded(build: str) -> None:
    found = decide({0: [row(-0.01, 0, 1)]}, [0.11, -0.09], build=build)
    assert (found.bits == ISOLATED | REAL | ROUNDED).all()
    np.testing.assert_allclose(found.R, [rotation(0.1), rotation(-0.1)], atol=1e-15)
    pair = decide({0: [row(0.01, 0, 1)]}, [0.11j, -0.09j], build=build)
    assert (pair.bits == ISOLATED | COMPLEX | ROUNDED).all()
    np.testing.assert_allclose(pair.R, [rotation(0.1j), rotation(-0.1j)], atol=1e-15)


def test_a_root_has_sixty_digits() -> None:
    """z^2 = 1/4 + 1/16 = 5/16: twice the point is a square root of 5/4."""
    found = decide({0: [row(-0.3125, 0, 1)]}, [0.56])
    with ctx.workprec(400):
        z = Locator.exact_sum(found.reached[:, 0])[1]
        assert abs(16 * z * z - 5).abs_upper() < 2.0**-185


def test_what_errs_within_its_bounds_is_proved_within_them() -> None:
    """z^2 = n - 1, so that N = n = 2^-50: the constant is known up to `ERROR` times its bound."""
    n, z = 2.0**-50, 1j * np.sqrt(1 - 2.0**-50)
    for more in (2.0**86, 2.0**90):
        found = decide({0: [row(1 - n, 0, 1)]}, [z], more=more)
        assert found.bits[0] == ISOLATED | COMPLEX
        for moved in (-0.99, 0.99):
            changed = Fraction(n) - Fraction(moved * more * ERROR)
            exact = (2 - changed) / changed
            assert abs(Fraction(found.R[0, 1, 1].real) - exact) <= Fraction(found.deviation[0])
    assert decide({0: [row(1 - n, 0, 1)]}, [z]).bits[0] == ISOLATED | COMPLEX | ROUNDED


def test_double_roots_are_not_isolated() -> None:
    assert not decide({0: [row(0, 0, 1)]}, [1e-3, 1e-60, 0.0]).bits.any()
    assert not decide({0: [row(1e-300), row(square=1)]}, [1e-3, 1e-70]).bits.any()


def test_roots_that_are_nearer_than_double_precision_are_told_apart() -> None:
    """z^2 = 1e-60: two roots 2e-30 apart; from between them no claim about a third is made."""
    found = decide({0: [row(-1e-60, 0, 1)]}, [1.1e-30, -0.9e-30])
    assert (found.bits & (ISOLATED | REAL) == ISOLATED | REAL).all()
    np.testing.assert_allclose(found.reached[0, :, 1], [1e-30, -1e-30])


def test_curvature_of_squares_counts() -> None:
    """N A = B^2 with A = e z_0^2 and B = z_0 z: two roots, known up to more than their distance."""
    near = 1e-3
    bits = decide({0: [row(near**2), row(slope=1)]}, [near], more=3e-6 / ERROR).bits
    assert not bits.any()
    assert decide({0: [row(near**2), row(slope=1)]}, [near]).bits[0] & ISOLATED


def test_a_large_translation_is_rounded() -> None:
    """f is 2^40, and T twice as much."""
    large = 2.0**40
    found = decide({4: [row(-large, 1, k=5)]}, [large * (1 + 1e-6)], k=5)
    assert found.bits[0] == ISOLATED | REAL | ROUNDED
    assert found.T[0].tolist() == [2 * large, 0, 0]


def test_a_point_far_from_any_root_proves_nothing_false() -> None:
    found = decide({0: [row(-0.01, 0, 1)]}, [np.nan, 1e200, np.inf])
    for k in np.flatnonzero(found.bits & ISOLATED):
        assert min(np.abs(found.R[k] - rotation(z)).max() for z in (0.1, -0.1)) < 1e-12


@pytest.mark.parametrize("number", [0, 6, 11])
def test_poses_far_away_are_those_of_balls(number: int) -> None:
    """Up to 1e18 lengths away, with N down to 2^-52: R, T and quaternions to the last bit."""
    machine = next(machines(number + 1, rows=1, begin=number))
    result = solve(machine.instance, starts=SolvedStarts())
    frames = StudyFrames(length=2.0, platform=(0.5, 0.25, 0.0), base=(1.0, -0.5, 0.25))
    locator, sides = Locator(machine.instance, frames), (0,) * 6
    kernel = FinerProofs(locator, sides)
    far = [x for x in result.solutions if np.abs(x.T).max() > 1e4 * locator.scale]
    assert len(far) >= 8
    checked = 0
    for pose in far:
        located = _located(locator, sides, pose)
        if located is None:
            continue
        with ctx.workprec(1024):
            points, low = _in_parts(located, frames, locator.scale)
        found, reached = kernel.at(points, low, frames)
        if not found.rounded[0, 0]:
            assert np.abs(pose.T).max() > 1e16
            continue
        checked += 1
        assert found.R[0, 0].tobytes() == np.asarray(pose.R, complex).tobytes()
        assert found.T[0, 0].tobytes() == np.asarray(pose.T, complex).tobytes()
        assert not found.real[0, 0]
        with ctx.workprec(1024):
            point = Locator.exact_sum(reached[:, 0])
            patch = located.isolation.patch
            centre = [x * point[patch] for x in located.isolation.centre]
            gaps = [abs(a - b).abs_upper() for a, b in zip(centre, point, strict=True)]
            assert max(gaps) < 1e-25
    assert checked >= 6


def _located(locator, sides, pose):
    for bits in (64, 256):
        with ctx.workprec(1024):
            R, T = np.asarray(pose.R, complex), np.asarray(pose.T, complex)
        found = locator.near(R, T, sides, bits)
        if isinstance(found, Located):
            return found
    return None


def _in_parts(located, frames, scale):
    """Return a Study point in other frames as sums of two doubles."""
    centre = located.isolation.centre
    e, f = centre[:4], [x * scale for x in centre[4:]]
    base, platform = ([0, *map(float, x)] for x in (frames.base, frames.platform))
    ahead, behind = study.product(base, e), study.product(e, platform)
    moved = [(x - (a - b) / 2) / frames.length for x, a, b in zip(f, ahead, behind, strict=True)]
    high = [complex(x) for x in (*e, *moved)]
    low = [complex(x - y) for x, y in zip((*e, *moved), high, strict=True)]
    return np.array([high]), np.array([[low]])
