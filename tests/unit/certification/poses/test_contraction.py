"""The theorem of `isolation` on equations whose solutions are known: no claim is false.

Each test has equations in one free coordinate, and linear ones in the others. Their solutions are
roots of a polynomial, so that every claim can be compared with all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import pytest
from flint import acb, acb_mat, arb, ctx

from gspcli.certification.numbers.balls import largest
from gspcli.certification.poses.isolation import (
    REACH,
    Isolation,
    _Newton,
    _newton,
    _prove,
    refine_point,
)

SIDES = (0,) * 6


class MadeUp:
    """A polynomial in the first free coordinate; the others are zero."""

    precision = 128

    def __init__(self, coefficients: Sequence[complex]) -> None:
        self.polynomial = np.polynomial.Polynomial(coefficients)
        #: Its second derivative, with moduli for coefficients.
        self.bend = np.polynomial.Polynomial(np.abs(self.polynomial.deriv(2).coef))

    def at(self, point: Sequence[acb], sides: Sequence[int]) -> tuple[acb_mat, acb_mat]:
        x = point[1]
        value, slope = (
            sum((acb(c) * x**k for k, c in enumerate(p.coef.tolist())), acb(0))
            for p in (self.polynomial, self.polynomial.deriv())
        )
        rows = [[acb(k == i + 1) for k in range(8)] for i in range(7)]
        rows[0][1] = slope
        return acb_mat(7, 1, [value, *point[2:]]), acb_mat(rows)

    def curvatures(self, moduli: np.ndarray) -> np.ndarray:
        return np.array([self.bend(moduli[1]), *[0.0] * 6])

    def proved(self, x: complex, *, share: float = 1.0) -> Isolation | None:
        """Return what is proved at a point, with a share of the inverse."""
        with ctx.workprec(self.precision):
            centre = [acb(1), acb(x), *[acb(0)] * 6]
            newton = _newton(self, centre, 0, SIDES)
            if newton is None:
                return None
            poor = _Newton(
                newton.centre,
                newton.jacobian,
                newton.inverse * share,
                newton.step,
                (newton.length * share).upper(),
                newton.noise,
            )
            return _prove(self, poor, 0, SIDES)

    def is_right(self, found: Isolation, x: complex) -> bool:
        """Whether one root is within the error, and no other root in the uniqueness ball."""
        gaps = np.sort(np.abs(self.polynomial.roots() - x))
        error = float(found.error) * (1 + 1e-9)
        return gaps[0] <= error and (len(gaps) < 2 or gaps[1] > found.uniqueness * (1 - 1e-9))


#: How long Newton's step is, as a part of 1 / b: a quarter is the most that is proved.
PARTS = np.array([0.05, 0.2, 0.24, 0.26, 0.3, 0.4, 0.49, 0.51, 0.6, 0.75])
TURNS = np.exp(1j * np.linspace(0, np.pi, 7))


@pytest.mark.parametrize("x", [1e-3, 0.1, 0.1j, 0.1 + 0.1j])
def test_of_two_roots_no_claim_is_false(x: complex) -> None:
    proved = 0
    for part, turn in product(PARTS, TURNS):
        # z^2 = w with a step of the part of x.
        system = MadeUp([-(x**2) * (1 - 2 * part * turn), 0, 1])
        found = system.proved(x)
        assert (found is not None) == (part < 0.25)
        if found is not None:
            proved += 1
            assert system.is_right(found, x)
    assert proved


@pytest.mark.parametrize("share", [0.3, 0.6, 1.4])
def test_with_a_poor_inverse_no_claim_is_false(share: float) -> None:
    claims = 0
    for part, turn in product((0.0, 0.05, 0.1, 0.2, 0.3), TURNS):
        system = MadeUp([-0.01 * (1 - 2 * part * turn), 0, 1])
        found = system.proved(0.1, share=share)
        if found is not None:
            claims += 1
            assert system.is_right(found, 0.1)
    assert claims


@pytest.mark.parametrize("factor", [0.25, 1.0, 60.0, 100.0, 4000.0])
def test_curvature_that_grows_is_bounded_in_all_of_the_ball(factor: float) -> None:
    """The roots of z + k z^3 are 0 and at a distance of k^(-1/2): for 100 that is below `REACH`."""
    system = MadeUp([0, 1, 0, factor])
    found = system.proved(0.0)
    assert found is not None
    assert found.uniqueness <= REACH
    assert system.is_right(found, 0.0)


def test_rows_of_what_is_not_one_are_summed() -> None:
    """Of two equations that are the same there are infinitely many solutions."""

    class Twice(MadeUp):
        def at(self, point: Sequence[acb], sides: Sequence[int]) -> tuple[acb_mat, acb_mat]:
            rows = [[acb(k == i + 1) for k in range(8)] for i in range(7)]
            for i in (0, 1):
                rows[i][1:3] = [acb(0.5) * (-1) ** i, acb(-0.5) * (-1) ** i]
            column = acb_mat(8, 1, list(point))
            return acb_mat(rows) * column, acb_mat(rows)

    system = Twice([0, 1])
    with ctx.workprec(128):
        centre = [acb(1), *[acb(0)] * 7]
        values, rows = system.at(centre, SIDES)
        jacobian = acb_mat([row[1:] for row in rows.tolist()])
        newton = _Newton(centre, jacobian, acb_mat(7, 7, 1), [acb(0)] * 8, arb(0), arb(0))
        assert largest(values.entries()) == 0
        assert _prove(system, newton, 0, SIDES) is None


def test_a_double_root_is_never_isolated() -> None:
    with ctx.workprec(128):
        for x in (0.0, 1e-30, 1e-9, 1e-3, 0.1):
            system = MadeUp([0, 0, 1])
            centre = [acb(1), acb(x), *[acb(0)] * 6]
            assert not isinstance(refine_point(system, centre, 0, SIDES), Isolation)


def record(x: complex, error: float, uniqueness: float) -> Isolation:
    centre = (acb(1), acb(x), *(acb(0),) * 6)
    return Isolation(centre, 0, SIDES, arb(error), uniqueness, 64)


@pytest.mark.parametrize(
    ("x", "error", "inside"),
    [(0.09, 0, True), (0.11, 0, False), (0.19, 0, False), (0.05, 0.04, True), (0.09, 0.02, False)],
)
@pytest.mark.parametrize("turn", [1, -1, 1j])
def test_what_a_ball_contains_lies_within_its_radius(
    x: float, error: float, inside: bool, turn: complex
) -> None:
    """The whole of the other ball counts: its solution may be anywhere in it."""
    assert record(0, 0, 0.1).contains(record(x * turn, error, 0.2)) is inside


@pytest.mark.parametrize("imaginary", [0.03, 0.04, 0.06])
def test_a_solution_whose_conjugate_may_be_another_is_not_real(imaginary: float) -> None:
    """The conjugate of a solution within the error is as far as twice the height and the error."""
    assert record(imaginary * 1j, 0.07, 0.1).real is None


def test_only_what_is_off_the_real_numbers_by_more_than_its_error_is_not_real() -> None:
    assert record(0.01j, 0.011, 0.02).real is None
    assert record(0.01j, 0.009, 0.02).real is False
