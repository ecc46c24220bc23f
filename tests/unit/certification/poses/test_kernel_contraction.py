"""The theorem of native/isolation.hpp on equations whose solutions are known: no claim is false.

The kernel takes any quadrics for N, e.f and the equations. Here each equation is in one coordinate
alone, so that all solutions are known. The kernel takes up to three steps of Newton's method: where
two roots are nearly one, each of them only halves the distance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.certification.numbers.rounding import COMPLEX, ISOLATED, REAL, ROUNDED

#: Nearly a double root: the roots are as far apart.
NEAR = 1e-3


class Decided(NamedTuple):
    """The verdicts of the kernel about points."""

    R: np.ndarray
    bits: np.ndarray
    deviation: np.ndarray
    complete: bool


def form(constant: float = 0, slope: float = 0, square: float = 0, k: int = 1) -> np.ndarray:
    """Return the Hessian matrix of constant + slope z + square z^2, z coordinate k by the first.

    If z is a coordinate of f, the square is f.f: quadrics have squares of f together.
    """
    matrix = np.diag([0.0] * 4 + [2.0 * square] * 4) if k > 3 else np.zeros((8, 8))
    matrix[0, 0], matrix[0, k], matrix[k, 0], matrix[k, k] = 2 * constant, slope, slope, 2 * square
    return matrix


NORM = np.diag([2.0] * 4 + [0.0] * 4)


def decide(
    rows: dict[int, list[np.ndarray]],
    points: list[complex],
    *,
    gap: float = 0.0,
    moduli: float = 1.0,
    value_bound: float = 0.0,
    tolerance: float = 1e9,
    coordinate: int = 1,
    others: dict[int, complex] | None = None,
) -> Decided:
    """Decide about points z of one coordinate; the others are zero, or given.

    Parameters
    ----------
    rows
        For equations 1 to 6 the main quadric and those whose squares are subtracted; of the others
        each makes one coordinate zero. The first of all, that of e.f, makes the last one zero.
    points
        Values of the coordinate.
    gap
        By how much each equation is unknown, as a multiple of N.
    moduli
        The moduli of the terms, as a multiple of those of the entries.
    value_bound
        That of the values, which enter the equations as a multiple of N.
    tolerance
        How far poses may be off.
    coordinate
        Its index: from 4 on it is one of f.
    others
        Those of the other coordinates that are not zero, by their indices.
    """
    quadrics = [NORM, form(slope=1, k=7)]
    table = np.full((6, 3), -1, np.int32)
    for r in range(6):
        for j, matrix in enumerate(rows.get(r, [form(slope=1, k=r + 1)])):
            table[r, j] = len(quadrics)
            quadrics.append(matrix)
    hessians = np.array(quadrics)
    bounds = np.abs(hessians) * moduli
    weights = np.zeros((4, 6))
    weights[1] = 1.0
    values = np.zeros((1, 6, 6))
    values[0, 1], values[0, 4] = value_bound, gap
    turned = np.full(6, -1, np.int32)
    study = np.zeros((1, len(points), 8), complex)
    study[0, :, 0], study[0, :, coordinate] = 1, points
    for k, other in (others or {}).items():
        study[0, :, k] = other
    R, _, _, deviation, bits, complete = _kernel.decide(
        hessians,
        np.zeros_like(hessians),
        bounds,
        table,
        weights,
        turned,
        values,
        np.ones(1),
        study,
        unit=1.0,
        origins=np.zeros((2, 3)),
        scale=1.0,
        tolerance=tolerance,
    )
    return Decided(R[0], bits[0], deviation[0], bool(complete[0]))


def rotation(z: complex) -> np.ndarray:
    """Return the rotation of the quaternion (1, z, 0, 0)."""
    n = 1 + z * z
    c, s = (1 - z * z) / n, 2 * z / n
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def test_simple_roots_are_proved_and_told_apart() -> None:
    found = decide({0: [form(-0.01, 0, 1)]}, [0.11, -0.09])
    assert (found.bits == ISOLATED | REAL | ROUNDED).all()
    assert found.complete
    np.testing.assert_allclose(found.R, [rotation(0.1), rotation(-0.1)], atol=1e-15)
    pair = decide({0: [form(0.01, 0, 1)]}, [0.11j, -0.09j])
    assert (pair.bits == ISOLATED | COMPLEX | ROUNDED).all()
    assert not decide({0: [form(-0.01, 0, 1)]}, [0.11, 0.09]).complete


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("scale", [1.0, 1e-2])
def test_next_to_two_roots_none_is_isolated(sign: int, scale: float) -> None:
    """Newton's step is half as long as the distance: a quarter of that is the most for a proof."""
    near = NEAR * scale
    starts = [scale * x for x in (0.02, 0.05, 0.1, 0.02j, 0.1j)]
    found = decide({0: [form(-sign * near**2, 0, 1)]}, starts)
    assert not (found.bits & ISOLATED).any()


def test_next_to_two_roots_of_a_product_none_is_isolated() -> None:
    """N A = B^2 with A = e z_0^2 and B = z_0 z: the second derivatives are those of the square."""
    found = decide({0: [form(NEAR**2), form(slope=1)]}, [0.02, 0.05, 0.1])
    assert not (found.bits & ISOLATED).any()


def test_next_to_two_roots_of_a_quartic_none_is_isolated() -> None:
    """N A = B^2 with A = e z_0^2 and B = z^2 is z^4 = e N: four roots about zero."""
    found = decide({0: [form(1e-12), form(square=1)]}, [0.01, 0.05])
    assert not (found.bits & ISOLATED).any()


def test_next_to_two_roots_of_f_none_is_isolated() -> None:
    """The equation f.f = e N in one coordinate of f."""
    given = {4: [form(-(NEAR**2), 0, 1, k=5)]}
    found = decide(given, [0.02, 0.05, 0.1], coordinate=5)
    assert not (found.bits & ISOLATED).any()
    assert decide(given, [NEAR + 1e-5], coordinate=5).bits[0] & ISOLATED


def test_next_to_two_roots_of_e_and_f_together_none_is_isolated() -> None:
    """z f = e N and f = c z; another coordinate of f is c, and so is the unit of f."""
    for size in (1.0, 2.0**20):
        both = form(-(NEAR**2) * size)
        both[1, 5] = both[5, 1] = 1
        alike = form(slope=size) - form(slope=1, k=5)
        given = {0: [both], 4: [alike], 5: [form(-size, 1, k=6)]}
        for z in (0.02, 0.05, 0.1):
            found = decide(given, [z], others={5: size * z, 6: size})
            assert not found.bits[0] & ISOLATED
        near = NEAR * (1 + 1e-5)
        assert decide(given, [near], others={5: size * near, 6: size}).bits[0] & ISOLATED


def test_curvature_away_from_the_point_counts() -> None:
    """Newton's method goes from 0 to s and back, and second derivatives vanish at 0.

    N A = B^2 with A = -s + z + s z^2 and B = c z^2 is s = z + z^3 - K z^4. All four roots are
    nearer to 0 than 2 s, so that none is alone there.
    """
    s = 0.01
    quartic = (1 + 2 * s**2) / (3 * s**3)
    assert np.abs(np.roots([-quartic, 1, 0, 1, -s])).max() < 2 * s
    found = decide({0: [form(-s, 1, s), form(square=np.sqrt(quartic + s))]}, [s])
    assert not found.bits.any()


def test_what_is_known_within_a_gap_is_proved_within_it() -> None:
    """The constant of the equation is known within the gap: so is the root, at least."""
    for gap in (1e-9, 1e-5, 1e-3):
        found = decide({0: [form(-0.01, 0, 1)]}, [0.1], gap=gap)
        assert found.bits[0] & ISOLATED
        assert not found.bits[0] & ROUNDED
        for moved in (-0.99 * gap, 0.99 * gap):
            # z^2 (1 - g) = 0.01 + g: a multiple g of N is added.
            root = np.sqrt((0.01 + moved) / (1 - moved))
            assert np.abs(found.R[0] - rotation(root)).max() <= found.deviation[0]


def test_a_gap_that_hides_two_roots_hides_their_reality() -> None:
    found = decide({0: [form(-0.01, 0, 1)]}, [0.1], gap=0.02)
    assert not found.bits.any()
    # The root is real for all numbers in the gap, or for none: else nothing is said.
    for constant, gap in ((-1e-4, 0.9e-4), (-1e-4, 1.1e-4), (1e-4, 1.1e-4)):
        z = np.sqrt(complex(-constant))
        bits = int(decide({0: [form(constant, 0, 1)]}, [z], gap=gap).bits[0])
        if bits & REAL:
            assert constant + gap < 0
        if bits & COMPLEX:
            assert constant - gap > 0


def test_errors_of_the_entries_are_errors_of_the_proof() -> None:
    """Entries are sums of terms whose moduli may be much larger than the entries."""
    assert decide({0: [form(-0.01, 0, 1)]}, [0.1], moduli=1e3).bits[0] & ISOLATED
    assert not decide({0: [form(-0.01, 0, 1)]}, [0.1], moduli=1e16).bits.any()
    # A derivative of one may be zero if it is a sum of terms of 2^48.
    assert decide({}, [0.0], moduli=2.0**40).bits[0] & ISOLATED
    assert not decide({}, [0.0], moduli=2.0**48).bits.any()
    # Values of 32 digits of so large terms are not known to all digits of a double.
    rough = decide({0: [form(-0.01, 0, 1)]}, [0.1], moduli=2.0**41)
    assert rough.bits[0] & ISOLATED
    assert not rough.bits[0] & ROUNDED
    assert decide({0: [form(-0.01, 0, 1)]}, [0.1], value_bound=1e3).bits[0] & ISOLATED
    assert not decide({0: [form(-0.01, 0, 1)]}, [0.1], value_bound=1e16).bits.any()


def test_poses_that_are_known_less_well_than_is_tolerated_are_not_proved() -> None:
    given = {0: [form(-0.01, 0, 1)]}
    assert decide(given, [0.1], gap=1e-5, tolerance=1e-2).bits.all()
    assert not decide(given, [0.1], gap=1e-5, tolerance=1e-9).bits.any()


def test_reality_is_not_claimed_beyond_the_theorem() -> None:
    """Where the conjugate of the solution may lie outside the ball, nothing is proved."""
    steps = np.geomspace(0.02, 2, 60)
    points = (-0.25 + steps[:, None] + 1j * steps).ravel()
    bits = decide({0: [form(0, 1, 2)]}, points.tolist()).bits
    assert ((bits == 0) | (bits & ISOLATED)).all()
    assert not (bits & COMPLEX).any()
    assert (bits & REAL).sum() > 1000
    undecided = points[bits == ISOLATED]
    assert len(undecided) > 40
    assert not decide({0: [form(0, 1, 2)]}, undecided[:1].tolist()).complete


def test_a_point_as_high_as_its_error_may_be_that_of_a_real_solution() -> None:
    """The equation z = 0: the error of a point is its height."""
    found = decide({}, [0.12j, 0.1j, 0.06j, 0.01j, -0.001j])
    assert not (found.bits & COMPLEX).any()
    assert (found.bits & REAL).all()


def test_a_point_far_from_a_real_root_is_not_called_complex() -> None:
    """The equations z + c z^2 = 0: all roots are real, but a step from afar ends beside them."""
    rng = np.random.default_rng(0)
    for bend in np.geomspace(0.01, 4, 40):
        points = rng.uniform(-1, 1, (200, 2)) @ [1, 1j]
        found = decide({0: [form(0, 1, bend)]}, points[np.abs(points) < 1].tolist())
        assert not (found.bits & COMPLEX).any()
