"""Local coordinates at a pose far away, in which equations for other values are of order one.

What they are is said in native/far_poses.hpp. They are computed in balls from the equations of
`ball_system` and the exact numbers of the platform, and given as sums of two doubles.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from flint import acb, acb_mat, arb, ctx
from numpy.typing import NDArray

from gspcli.certification.equations import study
from gspcli.certification.equations.ball_system import OpenEquation
from gspcli.certification.numbers.rounding import OUTWARD
from gspcli.certification.poses.locator import Located, Locator

Complex = NDArray[np.complex128]

#: Bits in which coefficients are computed, each tried in turn, and how much they may err then.
_BITS, _KNOWN = (256, 512, 1024, 2048), 2.0**-120
#: What is lost where doubles underflow.
_LEAST = 2.0**-500
#: Coefficients may not be larger: their products are doubles.
_LARGEST = 2.0**400
#: Numbers of a pose without products; monomials of a form; numbers of each product besides.
_PLAIN, _FORM, _OF_PRODUCT = 794, 36, 37
_PAIRS = [(i, j) for i in range(7) for j in range(i, 7)]
#: Where the equations are bent by more Newton's method needs to begin nearby: squares of lengths
#: alone make it 8.
_BENT = 64.0


class LocalCoordinates(NamedTuple):
    """Those at one pose: see the attributes of `FarPoses`."""

    numbers: Complex
    error: float
    located: Located
    bits: int
    is_bent: bool
    """Whether paths are needed to solutions for other values."""

    @property
    def real(self) -> bool:
        """Whether the numbers are real."""
        return self.located.real

    @property
    def conjugate(self) -> LocalCoordinates:
        """Those at the conjugate pose."""
        return self._replace(numbers=self.numbers.conj() + 0.0)


def local_coordinates(
    locator: Locator,
    sides: tuple[int, ...],
    R: Complex,
    T: Complex,
    point: Sequence[acb] | None = None,
    balance: acb_mat | None = None,
) -> LocalCoordinates | None:
    """Return local coordinates at a pose; None if it is not known well enough.

    Parameters
    ----------
    locator, sides
        The equations, and the index of that of each constraint.
    R, T
        The pose, shapes (3, 3) and (3,), rounded.
    point
        Its Study point with more digits, if it is known: doubles do not suffice 1e30 lengths away.
    balance
        Products of values with this matrix (6, 6) are in their place, where no equation is a
        product.
    """
    for bits in _BITS:
        if point is None:
            located = locator.near(R, T, sides, bits)
        else:
            located = locator.locate_exactly(point, sides, bits)
        if not isinstance(located, Located):
            return None
        found = _in_bits(locator, sides, located, bits, None, balance)
        if found is not None:
            return found if _fits(found.numbers) else None
    return None


def combined(
    locator: Locator,
    sides: tuple[int, ...],
    given: LocalCoordinates,
    products: Complex,
    balance: acb_mat | None = None,
) -> LocalCoordinates | None:
    """Return other local coordinates at a pose; None if they are not accurate enough.

    Parameters
    ----------
    locator, sides
        As for `local_coordinates`.
    given
        The coordinates s at the pose.
    products
        A matrix (7, 7), real at a real pose: s is its product with the other ones. In the row and
        the column of an equation that is a product it has its diagonal only.
    balance
        As for `local_coordinates`.
    """
    located: object = given.located
    for bits in _BITS[_BITS.index(given.bits) :]:
        # Products of very different sizes need more bits than the pose.
        if bits > given.bits:
            located = locator.locate_exactly(given.located.isolation.centre, sides, bits)
        if not isinstance(located, Located):
            return None
        found = _in_bits(locator, sides, located, bits, products, balance)
        if found is not None:
            return found if _fits(found.numbers) else None
    return None


def _fits(numbers: Complex) -> bool:
    return bool(np.isfinite(numbers).all() and np.abs(numbers).max() < _LARGEST)


def _in_bits(
    locator: Locator,
    sides: tuple[int, ...],
    located: Located,
    bits: int,
    products: Complex | None,
    balance: acb_mat | None,
) -> LocalCoordinates | None:
    with ctx.workprec(bits):
        balls = _coefficients(locator, sides, located, products, balance)
        if balls is None:
            return None
        # Products have factors that are not real.
        doubles, error = _in_doubles(balls, real=located.real and len(balls) == _PLAIN)
    if not error < _KNOWN:
        return None
    numbers = np.array(doubles).view(np.complex128)[..., 0]
    first = numbers[: 7 * _FORM, 0].reshape(7, _FORM)
    second = numbers[_PLAIN:, 0].reshape(-1, _OF_PRODUCT)[:, :_FORM]
    is_bent = bool(np.abs(np.concatenate((first, second))[:, 8:]).max() > _BENT)
    return LocalCoordinates(numbers.T, max(error, _LEAST), located, bits, is_bent)


def _coefficients(
    locator: Locator,
    sides: tuple[int, ...],
    located: Located,
    products: Complex | None,
    balance: acb_mat | None,
) -> list[acb] | None:
    """Return balls of the numbers of one pose in the order of the kernel."""
    system, patch = locator.system(ctx.prec), located.isolation.patch
    equations = system.open_equations(sides)
    if equations is None:
        return None
    point = [acb(x.real) if located.real else x for x in located.isolation.centre]
    column = acb_mat(8, 1, point)
    norm = sum((x * x for x in point[:4]), acb(0))
    scaled = [_scaled(each, column, norm, real=located.real) for each in equations]
    gradients = acb_mat([_gradient(each, column, norm) for each in scaled])
    free = [k for k in range(8) if k != patch]
    try:
        inverse = acb_mat(7, 7, [gradients[i, k] for i in range(7) for k in free]).inv()
    except ZeroDivisionError:
        return None
    directions = acb_mat(8, 7)
    for i, k in enumerate(free):
        for j in range(7):
            # Any exact numbers will do.
            x = inverse[i, j].mid()
            directions[k, j] = acb(x.real) if located.real else x
    # What the equations are multiplied by.
    mixing = acb_mat(7, 7, [int(i == j) for i in range(7) for j in range(7)])
    if products is not None:
        across = acb_mat(7, 7, [acb(x) for x in products.ravel().tolist()])
        directions = acb_mat(8, 7, [x.mid() for x in (directions * across).entries()])
        try:
            inverse = across.inv()
        except ZeroDivisionError:
            # Its rows are of too different sizes for so many bits.
            return None
        alone = [len(each.factors) > 1 for each in scaled]
        for i in range(7):
            for j in range(7):
                # No multiples of products are added to others.
                mixing[i, j] = 0 if i != j and (alone[i] or alone[j]) else inverse[i, j].mid()
    forms = [_form(each.factors[0], column, directions, norm) for each in scaled]
    if products is not None:
        forms = (mixing * acb_mat(forms)).tolist()
    found: list[acb] = list(chain.from_iterable(forms))
    for hessian in _pose_forms():
        found += _form(hessian, column, directions, norm)
    # Not across the negative numbers, where there is no square root.
    root = norm.sqrt() if norm.real > 0 else (-norm).sqrt() * acb(0, 1)
    for k in range(4):
        found.append(point[k] / root)
        found += [directions[k, j] * root for j in range(7)]
    # The values are in all equations but the first.
    mixed = acb_mat(7, 6, [mixing[i, r] * scaled[r].factor for i in range(7) for r in range(1, 7)])
    found += (mixed if balance is None else mixed * balance.inv()).entries()
    for i, each in enumerate(scaled):
        for second in each.factors[1:]:
            found += [*_form(second, column, directions, norm), mixing[i, i] * each.constant]
    return found


class _Scaled(NamedTuple):
    """An equation times a factor: ``F - factor D N`` or ``P Q - (constant + factor D) N^2``."""

    factors: tuple[acb_mat, ...]
    factor: acb
    constant: acb


def _scaled(given: OpenEquation, column: acb_mat, norm: acb, *, real: bool) -> _Scaled:
    """Return an equation, a product over the size of its larger factor at a Study point."""
    if len(given.factors) == 1:
        return _Scaled(given.factors, acb(1), acb(0))
    a, b = sorted(given.factors, key=lambda x: -float(_value(x, column, norm).abs_upper()))
    # Any exact number will do; a real equation stays real.
    factor = (1 / _value(a, column, norm)).mid()
    factor = acb(abs(factor).mid()) if real else factor
    return _Scaled((a * factor, b), factor, given.constant * factor)


def _value(hessian: acb_mat, column: acb_mat, norm: acb) -> acb:
    """Return a quadratic form over N."""
    return (column.transpose() * hessian * column)[0, 0] / (2 * norm)


def _gradient(given: _Scaled, column: acb_mat, norm: acb) -> list[acb]:
    """Return the gradient of an equation, of a product over N."""
    slopes = [hessian * column for hessian in given.factors]
    if len(slopes) == 1:
        return slopes[0].entries()
    p, q = (_value(hessian, column, norm) for hessian in given.factors)
    found = slopes[0] * q + slopes[1] * p
    for k in range(4):
        found[k, 0] -= 4 * given.constant * column[k, 0]
    return found.entries()


def _form(hessian: acb_mat, column: acb_mat, directions: acb_mat, norm: acb) -> list[acb]:
    """Return the coefficients of a quadratic form over N, in local coordinates."""
    across = directions.transpose()
    slope = hessian * column
    second = across * (hessian * directions)
    value = (column.transpose() * slope)[0, 0] / (2 * norm)
    squares = (norm * second[i, j] for i, j in _PAIRS)
    halves = (x / 2 if i == j else x for x, (i, j) in zip(squares, _PAIRS, strict=True))
    return [value, *(across * slope).entries(), *halves]


def _pose_forms() -> Iterable[acb_mat]:
    """Yield the Hessian matrices of N, N R by rows and N T."""
    for k in (study.NORM, *chain(*study.ROTATION), *study.TRANSLATION):
        yield acb_mat(8, 8, [acb(x) for x in study.form_hessians()[k].ravel().tolist()])


def _in_doubles(numbers: Sequence[acb], *, real: bool) -> tuple[list[list[list[float]]], float]:
    """Return complex numbers as sums of two, each by its parts, and by how much they err."""
    found, error = [], 0.0
    for number in numbers:
        parts = []
        for ball in (number.real, arb(0) if real else number.imag):
            middle = ball.mid()
            high = float(middle)
            parts.append((high, float(middle - high)))
            error = max(error, float(ball.rad()))
        found.append([list(both) for both in zip(*parts, strict=True)])
    return found, error * OUTWARD
