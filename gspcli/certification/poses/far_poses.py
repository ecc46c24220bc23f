"""Poses far away, proved for other values of a geometry from poses that are known, without paths.

A platform that is special up to the rounding eps of its numbers has poses eps^-2 lengths away, with
N of size eps^4. A value occurs in its equation only as a multiple of N, so these poses hardly
depend on the values. In local coordinates at a known pose (native/far_poses.hpp) the equations for
other values have coefficients of order one for any N. There doubles suffice for proofs that need
hundreds of bits in the frames of the platform. The coefficients are computed in balls from the
equations of `ball_system`. The theorem is that of `isolation`, and proved poses are rounded
correctly.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain
from typing import NamedTuple

import numpy as np
from flint import acb, acb_mat, arb, ctx, fmpq, fmpq_mat
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DHP, DLP, DPH, DPL, DPP
from gspcli.certification.equations.ball_system import OpenEquation
from gspcli.certification.equations.local_frames import OWN
from gspcli.certification.numbers.doubled import ERROR, Doubled, two_sum
from gspcli.certification.numbers.rounding import TINY
from gspcli.certification.poses.isolation import all_different
from gspcli.certification.poses.locator import Located, Locator
from gspcli.certification.poses.many_values import ValueProofs, proved_bits
from gspcli.certification.poses.pose_arrays import Bits, PoseProofs
from gspcli.defaults import TOLERANCE
from gspcli.geometry import study
from gspcli.geometry.enclosures import above
from gspcli.geometry.quaternions import quaternion_product
from gspcli.records import dataclass

Complex = NDArray[np.complex128]

#: Bits in which coefficients are computed, each tried in turn, and how much they may err then.
_BITS, _KNOWN = (256, 512, 1024, 2048), 2.0**-120
#: What is lost where doubles underflow.
_LEAST = math.sqrt(TINY)
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
    return found, above(error)


Array = NDArray[np.float64]


class Values(NamedTuple):
    """Values of equations, lengths in a unit."""

    #: Rational numbers for each set of values, (b, 6).
    exact: list[list[fmpq]]
    #: How much they err, shape (b, 6).
    gaps: Array

    @classmethod
    def of(
        cls, proofs: ValueProofs, choice: Array, rows: Array | None, given: Array, unit: float
    ) -> Values:
        """Return sets of values.

        Parameters
        ----------
        proofs, choice, rows
            As for `FarPoses.beside`.
        given
            The values in the form of the kernel (`ValueProofs.values`), shape (b, 6, 6).
        unit
            The unit of length.
        """
        # Powers of two: exact.
        ratio = proofs.scale / unit
        factors = [ratio ** (2 * kind.is_distance - kind.has_sides) for kind in proofs.kinds]
        gaps = given[:, 4] * factors
        sets: list[Sequence[Fraction | None]]
        if rows is None:
            sets = [[row.value.fraction for row in proofs.instance.constraints]]
        else:
            sets = [[Fraction(x) for x in row] for row in rows.tolist()]
        exact = []
        for row, found in enumerate(sets):
            numbers = []
            for k, (kind, x) in enumerate(zip(proofs.kinds, found, strict=True)):
                if x is None or kind not in (DPP, DPH, DHP):
                    inexact = _rational(given[row, 0, k]) + _rational(given[row, 3, k])
                    numbers.append(inexact * _rational(factors[k]))
                    continue
                gaps[row, k] = 0.0
                height = fmpq(x.numerator, x.denominator) / _rational(unit)
                numbers.append(height**2 if kind is DPP else height * int(choice[k]))
            exact.append(numbers)
        return cls(exact, gaps)


class Shifts(NamedTuple):
    """Differences from the values of a platform, times a matrix."""

    #: The matrix, whose numbers are meant exactly, shape (6, 6).
    matrix: Array
    #: The values of the platform.
    own: Values
    #: Their unit of length.
    unit: float

    def of(self, proofs: ValueProofs, choice: Array, rows: Array | None, given: Array) -> Array:
        """Return the products for sets of values, as sums of two, and how much they err: (b, 3, 6).

        The parameters are those of `Values.of`.
        """
        values = Values.of(proofs, choice, rows, given, self.unit)
        differences = [
            [x - y for x, y in zip(each, self.own.exact[0], strict=True)] for each in values.exact
        ]
        turned = fmpq_mat([[_rational(x) for x in row] for row in self.matrix.T.tolist()])
        found = np.array([_doubled(x) for x in (fmpq_mat(differences) * turned).entries()]).reshape(
            -1, len(self.matrix), 3
        )
        gaps = (values.gaps + self.own.gaps) @ np.abs(self.matrix).T
        found[..., 2] += gaps
        return np.ascontiguousarray(np.moveaxis(found * (1.0, 1.0, above(1.0)), 2, 1))


def _rational(x: float) -> fmpq:
    return fmpq(*x.as_integer_ratio())


def _doubled(x: fmpq) -> tuple[float, float, float]:
    """Return a sum of two doubles next to a number, and how much it errs."""
    high, low, size = Doubled.of_ratio(int(x.p), int(x.q))
    return high, low, size * ERROR


#: Local coordinates of a pose.
LOCAL = 7
#: How far the values where paths begin are from real ones, in typical lengths, their squares, or
#: cosines.
_SPREAD = (0.2, 0.4)
#: Coordinates are chosen by solutions for this many sets of values, with this standard deviation as
#: a part of that; the shortest axis of those is at least such a part of the longest.
_SAMPLES, _SAMPLED = 24, 0.25
_THINNEST = 1e-3
#: Coordinates are chosen at most this many times. If solutions are lost, values differ by this part
#: of what they did, down to the third. The last suffices.
_STAGES, _NEARER, _LEAST_REACH, _NEARLY = 30, 0.25, 2.0**-60, 0.0625
#: Conjugates agree to this part of their largest entry.
_ALIKE = 1e-6
#: To poses not farther away than this many lengths paths lead.
_PATHS = 1e3
#: Poses not farther away than this many lengths are proved by the equations of near poses, too.
_NEAR = 1e5


@dataclass(frozen=True, eq=False)
class FarPoses:
    """Poses of a platform far away, from which the poses for other values are proved."""

    #: The numbers of each pose for the kernel (native/far_poses.hpp), as two doubles each, shape
    #: (2, n, 794), and 37 more for each product.
    numbers: Complex
    #: Bounds of their errors, shape (n,).
    errors: Array
    #: Of which poses these numbers are real, shape (n,). With a pose that is not real its conjugate
    #: is meant, too, unless it needs paths: two conjugates may lead to two real poses from complex
    #: values, and are both there.
    real: NDArray[np.uint8]
    #: The values in the form of the kernel (`ValueProofs.values`), shape (6, 6).
    values: Array
    #: The power of a length that each value is in its equation, shape (6,).
    powers: NDArray[np.int64]
    #: The unit of length.
    scale: float
    #: Complex values, as differences from `values`, from which paths lead to other values, (6,).
    origin: Complex
    #: The local coordinates there of the last k poses, which need paths, shape (k, 7).
    starts: Complex
    #: Bit r is 1 where equation r is a product.
    products: int
    #: Differences of values are multiplied by the matrix of these: equations that are nearly
    #: dependent are combined. None if they are not.
    shifts: Shifts | None

    @classmethod
    def of(
        cls,
        locator: Locator,
        proofs: ValueProofs,
        choice: Array,
        sides: tuple[int, ...],
        R: Complex,
        T: Complex,
        points: Mapping[bytes, Sequence[acb]],
        length: float,
        spread: Array | None = None,
        unit: float = 1.0,
    ) -> FarPoses | None:
        """Return the known poses of a platform; None if some are not accurate enough.

        Parameters
        ----------
        locator, proofs
            The equations of the platform.
        choice, sides
            The sides of its values, and the indices of its equations (`Problem`).
        R, T
            The poses, rounded correctly, shapes (n, 3, 3) and (n, 3).
        points
            Study points with more digits of some of them, by the bytes of their T.
        length
            The typical length.
        spread, unit
            By how much values differ from these, and the unit of length of that (`Balance.spread`).
            None if they differ by their own size.
        """
        chosen = _one_of_each_pair(R, T)
        if not chosen:
            return None
        products = sum(2 << k for k, kind in enumerate(proofs.kinds) if kind in (DPL, DLP))
        powers = np.array([2 * k.is_distance - k.has_sides for k in proofs.kinds])
        balance = None
        if spread is None:
            origin = _origin(powers, length / locator.scale)
        else:
            sizes = 2 * _factors(powers, unit / locator.scale)
            balance = np.linalg.inv(spread * sizes[:, None]).astype(np.float64)
            origin = _origin(np.zeros_like(powers), 1.0)
        made = _Made(locator, sides, origin, products, balance)
        found: dict[int, LocalCoordinates] = {}
        # The farthest first: these are less likely to have coordinates.
        for k in sorted(chosen, key=lambda k: -np.abs(T[k]).max()):
            each = made.coordinates(R[k], T[k], points.get(T[k].tobytes()))
            if each is None:
                return None
            found[k] = each
        known = [found[k] for k in chosen]
        # Poses that need paths are the last.
        known.sort(key=lambda each: each.is_bent)
        known += [each.conjugate for each in known if each.is_bent and not each.real]
        values = proofs.values(choice[None])[0]
        shifts = None
        if balance is not None:
            own = Values.of(proofs, choice, None, values, locator.scale)
            shifts = Shifts(balance, own, locator.scale)
        return cls(
            numbers=np.ascontiguousarray(np.stack([each.numbers for each in known], axis=1)),
            errors=np.array([each.error for each in known]),
            real=np.array([each.real for each in known], np.uint8),
            values=values[0],
            powers=powers,
            scale=locator.scale,
            origin=origin,
            starts=np.zeros((sum(each.is_bent for each in known), LOCAL), complex),
            products=products,
            shifts=shifts,
        )

    def about(self, values: Complex, known: Array, length: float) -> FarPoses | None:
        """Return the same with paths that begin at some complex values; None if one is lost.

        Parameters
        ----------
        values
            What the equations are linear in, in a unit of length, shape (6,).
        known
            The same of the platform whose poses these are, to which they were found.
        length
            The unit.
        """
        factors, own = _factors(self.powers, length / self.scale), self.values[0]
        if not np.allclose(known * factors, own, rtol=1e-9, atol=1e-9):
            return None
        origin = values * factors - own
        if self.shifts is not None:
            origin = self.shifts.matrix @ origin
        number = len(self.starts)
        starts, found = _kernel.follow_far(
            np.ascontiguousarray(self.numbers[:, len(self.real) - number :]),
            np.zeros_like(origin),
            origin,
            np.zeros_like(self.starts),
            products=self.products,
        )
        return replace(self, origin=origin, starts=starts) if found.all() else None

    def __len__(self) -> int:
        """Return the number of poses, conjugates included."""
        return len(self.real) + int(self._paired.sum())

    @property
    def _paired(self) -> NDArray[np.uint8]:
        """With which poses the conjugate is meant, shape (n,)."""
        paired = 1 - self.real
        paired[len(paired) - len(self.starts) :] = 0
        return paired

    def decide(
        self,
        values: Array,
        units: Array,
        scale: float,
        *,
        shifts: Array | None = None,
        jobs: int = 1,
    ) -> tuple[PoseProofs, Bits]:
        """Prove the poses for other values of the geometry; return also for which these are all.

        Parameters
        ----------
        values
            Values in the form of the kernel (`ValueProofs`), of one choice of sides, shape (b, 6,
            6).
        units
            The units of the last digits of translations, in `scale`, shape (b,).
        scale
            The unit of length of these values.
        shifts
            How they differ from those of the platform, times the matrix of `shifts`, if there is
            one, (b, 3, 6).
        jobs
            Threads.
        """
        R, T, quaternions, off, bits, complete = _kernel.decide_far(
            self.numbers,
            self.errors,
            self.real,
            self._paired,
            self.origin,
            self.starts,
            self._shifts(values, scale / self.scale) if shifts is None else shifts,
            units * (scale / self.scale),
            scale=self.scale,
            tolerance=TOLERANCE,
            products=self.products,
            jobs=jobs,
        )
        certified, real, rounded = proved_bits(bits)
        found = PoseProofs(
            R=R,
            T=T,
            quaternions=quaternions,
            certified=certified,
            real=real,
            multiplicity=certified.astype(np.int64),
            rounded=rounded,
            # In units of the other equations.
            deviation=off * max(self.scale / scale, 1.0),
        )
        return found, complete > 0

    def beside(
        self,
        near: PoseProofs,
        are_all: Bits,
        proofs: ValueProofs,
        choice: Array,
        rows: Array | None,
        *,
        jobs: int = 1,
    ) -> tuple[PoseProofs, Bits]:
        """Return near poses and the far ones for the same values, and for which these are all.

        Parameters
        ----------
        near, are_all, proofs
            The near poses, for which values all are proved and different, and by which equations.
        choice, rows
            The sign of each constraint, shape (6,), and the sets of values (b, 6), None for those
            of the instance.
        jobs
            Threads.
        """
        scale = proofs.scale
        values, units = proofs.values(choice[None], rows)[:, 0], proofs.units(rows)
        shifts = None if self.shifts is None else self.shifts.of(proofs, choice, rows, values)
        far, are_all_far = self.decide(values, units, scale, shifts=shifts, jobs=jobs)
        _prove_near(far, are_all_far, proofs, choice, rows, jobs)
        complete = are_all & are_all_far
        # Two poses are different if their error bounds do not overlap.
        with np.errstate(invalid="ignore"):
            least = (_largest(far.R, far.T / scale) - far.deviation).min(axis=1)
            largest = (_largest(near.R, near.T / scale) + near.deviation).max(axis=1, initial=0)
        for row in np.flatnonzero(complete & ~(above(largest) < least)).tolist():
            complete[row] = _are_apart(near, far, row, scale)
        return PoseProofs.together([near, far], axis=1), complete

    def _shifts(self, values: Array, ratio: float) -> Array:
        """Return the differences of values from those of the platform, (b, 3, 6)."""
        # The factors are powers of two and exact.
        factor = _factors(self.powers, ratio)
        high, low, gap = (values[:, k] * factor for k in (0, 3, 4))
        own, own_low, own_gap = (self.values[k] for k in (0, 3, 4))
        difference, rest = two_sum(high, np.broadcast_to(-own, high.shape))
        size = np.abs(high) + np.abs(own)
        gaps = above(gap + own_gap + ERROR * size)
        return np.ascontiguousarray(np.stack((difference, rest + (low - own_low), gaps), axis=1))


def _factors(powers: NDArray[np.int64], ratio: float) -> Array:
    """Return the factors of values in a unit that many times as large."""
    found: Array = ratio ** powers.astype(float)
    return found


def _origin(powers: NDArray[np.int64], length: float) -> Complex:
    """Return complex values in general position, as differences from real ones."""
    rng = np.random.default_rng(len(powers))
    turns = rng.choice([-1.0, 1.0], len(powers)) * rng.uniform(*_SPREAD, len(powers))
    return np.asarray(1j * turns * length ** powers.astype(float), np.complex128)


class _Made(NamedTuple):
    """How local coordinates are made."""

    #: locator, sides, products: As for `FarPoses`.
    locator: Locator
    sides: tuple[int, ...]
    #: Complex values in general position.
    origin: Complex
    products: int
    #: As for `FarPoses`.
    balance: Array | None

    @property
    def exact_balance(self) -> acb_mat | None:
        """The same matrix in balls."""
        return None if self.balance is None else acb_mat(self.balance.tolist())

    def coordinates(
        self, R: Complex, T: Complex, point: Sequence[acb] | None
    ) -> LocalCoordinates | None:
        """Return local coordinates at a pose; None if it is not known well enough.

        Where equations are bent, each coordinate is a multiple of others at most places. There they
        are replaced by those in which solutions for other values are of order one in all
        directions.
        """
        found = local_coordinates(self.locator, self.sides, R, T, point, self.exact_balance)
        if found is None:
            return None
        if not found.is_bent:
            # Not so far away a pose may take the place of a near one, to which paths lead.
            size = max(np.abs(R).max(), np.abs(T).max() / self.locator.scale)
            return found._replace(is_bent=bool(size < _PATHS))
        better = self._natural(found)
        return better and better._replace(is_bent=True)

    def _natural(self, given: LocalCoordinates) -> LocalCoordinates | None:
        """Return coordinates in which solutions for other values are of order one, or None.

        Where the first coordinates of these solutions differ by many powers of ten, doubles lose
        them on the way. Then coordinates are chosen for values that differ less, and again from
        there on.
        """
        known, matrix, last = given, np.eye(LOCAL, dtype=complex), _LEAST_REACH
        if self.balance is not None:
            # The first equation has no value.
            matrix[1:, 1:] = np.linalg.inv(self.balance)
            better = combined(self.locator, self.sides, given, matrix, self.exact_balance)
            known = better or given
        for _ in range(_STAGES):
            reach = 1.0
            while (
                found := _axes(known, self.origin, reach, self.products)
            ) is None and reach * _NEARER > last:
                reach *= _NEARER
            if found is None:
                break
            matrix = matrix @ found
            better = combined(self.locator, self.sides, given, matrix, self.exact_balance)
            if better is None or reach == 1:
                return better
            known, last = better, reach
        # Some values may have the pose at infinity, or near other ones.
        return known if last >= _NEARLY else None


def _axes(given: LocalCoordinates, origin: Complex, reach: float, products: int) -> Complex | None:
    """Return a matrix (7, 7): its products with vectors of order one are solutions for others.

    Values differ by that part of the origin.
    """
    numbers = np.ascontiguousarray(given.numbers[:, None])
    rng = np.random.default_rng(0)

    def followed(begin: Complex, end: Complex, at: Complex) -> Complex | None:
        ends = begin * reach, end * reach
        reached, found = _kernel.follow_far(numbers, *ends, at, products=products)
        return reached if found[0] else None

    start = followed(np.zeros_like(origin), origin, np.zeros((1, LOCAL), complex))
    if start is None:
        return None
    values = np.abs(origin) * rng.normal(0, _SAMPLED, (_SAMPLES, len(origin)))
    found = [followed(origin, each.astype(complex), start) for each in values]
    there = np.array([each[0] for each in found if each is not None])
    if len(there) < _SAMPLES // 2:
        return None
    # Some may be near values for which the pose is at infinity.
    there = there[np.abs(there).max(axis=1).argsort()[: _SAMPLES * 3 // 4]]
    square = there.T @ there.conj() / len(there)
    # Equations that are products are not added to others.
    alone = np.array([products >> r & 1 for r in range(LOCAL)], np.bool_)
    axes = np.diag(np.sqrt(square.diagonal()))
    rest = np.ix_(~alone, ~alone)
    sizes, axes[rest] = np.linalg.eigh(square[rest].real if given.real else square[rest])
    sizes = np.sqrt(np.maximum(sizes, 0))
    axes[rest] *= np.maximum(sizes, _THINNEST * sizes[-1])
    return axes


def _prove_near(
    far: PoseProofs,
    complete: Bits,
    proofs: ValueProofs,
    choice: Array,
    rows: Array | None,
    jobs: int,
) -> None:
    """Prove poses that have come nearer by the near equations; complete sets are noted.

    Two complex ones may have become real: that is not proved by complex local coordinates.
    """
    with np.errstate(invalid="ignore"):
        wanted = ~far.certified & (np.abs(far.T) < _NEAR * proofs.scale).all(axis=2)
    index = np.flatnonzero(wanted.any(axis=1))
    if not len(index):
        return
    with np.errstate(invalid="ignore"):
        shifts = np.concatenate((np.zeros_like(far.T[..., :1]), far.T), axis=-1)
        moved = quaternion_product(shifts, far.quaternions) / 2
    points = np.concatenate((far.quaternions, moved), axis=-1).astype(np.complex128, copy=False)
    points = np.where(wanted[..., None], points, np.nan)[index, None]
    part = None if rows is None else rows[index]
    better, _ = proofs.decide(choice[None], points, OWN, rows=part, jobs=jobs)
    row, place = np.nonzero(better.certified)
    far.put((index[row], place), better[row, place])
    for k in index[far.certified[index].all(axis=1)].tolist():
        complete[k] = all_different(far[k].entries(proofs.scale), far.deviation[k])


def _are_apart(near: PoseProofs, far: PoseProofs, row: int, scale: float) -> bool:
    """Whether all near poses for a set of values are proved to be none of the far ones."""
    flat = [x[row].entries(scale).view(np.float64) for x in (near, far)]
    gaps = np.abs(flat[0][:, None] - flat[1]).max(axis=2)
    off = near.deviation[row][:, None] + far.deviation[row]
    return bool((gaps > above(off)).all())


def _largest(R: Complex, T: Complex) -> Array:
    """Return the largest part of an entry of each pose, shape (b, n)."""
    turns, places = (np.abs(x.view(np.float64)).max(axis=-1) for x in (R, T))
    found: Array = np.maximum(turns.max(axis=-1), places)
    return found


def _one_of_each_pair(R: Complex, T: Complex) -> list[int] | None:
    """Return the real poses and one of each conjugate pair; None if a partner is missing."""
    entries = np.concatenate((R.reshape(-1, 9), T), axis=1)
    sizes = np.abs(entries).max(axis=1, initial=0)
    gaps = np.abs(entries[:, None].conj() - entries).max(axis=2, initial=0)
    own = np.arange(len(R))
    partners = gaps.argmin(axis=1) if len(R) else own
    are_mutual = partners[partners] == own
    are_near = gaps[own, partners] < _ALIKE * sizes
    is_real = ~entries.imag.any(axis=1)
    if not (are_mutual & are_near & ((partners == own) == is_real)).all():
        return None
    return np.flatnonzero(own <= partners).tolist()
