"""Poses proved one by one, from the equations in the entries of the motion.

Where approximate poses come from does not matter: `real_poses` takes those of the program that is
judged, and believes nothing of them. Let F be the `square_system` of an instance with its numbers
as balls, x a point, w weights of its coordinates, Y a matrix, and D the polydisc of the z with
``|z_k - x_k| <= r w_k``. If

* ``|Y F(x)|_k <= r w_k / 2`` and
* ``sum_j |I - Y F'(D)|_kj w_j <= w_k / 2`` for each k,

then ``z -> z - Y F(z)`` maps D into itself and is a contraction: there is exactly one solution in
D, and it is simple. The equations are real: what is alone in the polydisc of its conjugate is real.
If a count says that disjoint polydiscs have all solutions, those are all real ones; if it says that
one is missing, that is its own conjugate, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, repeat

import flint
from flint import acb, acb_mat, arb

from gspcli.catalogue.kinds import DLL
from gspcli.certification.poses.certificates import Certificate, certify, refine
from gspcli.errors import IncompleteError
from gspcli.geometry.instance import Instance
from gspcli.solver import solve
from tools.oracle.matrix_ideal import Polynomial, Ring, parallel, square_system
from tools.oracle.rational_numbers import Balls

#: Decimals of the approximations that are tried one after the other.
DIGITS = (60, 240)
#: Bits for each of their decimals.
_BITS = 8
_MOST_STEPS = 12


@dataclass(frozen=True)
class Disc:
    """A polydisc with exactly one solution in it, which is simple.

    Attributes
    ----------
    centre, radii
        Of the coordinates of `square_system`.
    """

    centre: tuple[acb, ...]
    radii: tuple[arb, ...]

    @property
    def conjugate(self) -> Disc:
        """That of the conjugate solution."""
        return Disc(tuple(x.conjugate() for x in self.centre), self.radii)

    @property
    def real(self) -> bool:
        """Whether the solution is proved real: its conjugate is in the disc, too."""
        return all(x.imag == 0 for x in self.centre)

    def is_apart(self, other: Disc) -> bool:
        """Whether the two are proved to be disjoint."""
        pairs = zip(self.centre, self.radii, other.centre, other.radii, strict=True)
        return any(abs(x - y) > r + s for x, r, y, s in pairs)


class SquareSystem:
    """The `square_system` of an instance in balls of the current precision.

    Parameters
    ----------
    instance
        The platform, whose numbers are taken exactly.
    bits
        The precision.
    """

    def __init__(self, instance: Instance, bits: int) -> None:
        self.bits = bits
        field = Balls(instance)
        ideal = square_system(instance, field)
        self._index = {name: k for k, name in enumerate(ideal.names)}
        self._equations = [self._terms(p) for p in ideal.polynomials]
        ring = Ring(0)
        self._at_parallel = [
            [self._terms(p) for p in parallel(row, field, ring)]
            for row in instance.constraints
            if row.kind is DLL
        ]

    def _terms(self, polynomial: Polynomial) -> list[tuple[arb, tuple[int, ...]]]:
        return [
            (arb(value), tuple(self._index[name] for name in monomial))
            for monomial, value in polynomial.items()
        ]

    def disc(self, R: Sequence[acb], T: Sequence[acb]) -> Disc | None:
        """Return a disc about the pose near an approximate one, if it is proved to have one.

        Parameters
        ----------
        R, T
            Nine entries by rows and three coordinates.
        """
        x = self._refined(self._completed([*R, *T]))
        if x is None:
            return None
        weights = [(abs(z) + 1).mid() for z in x]
        radii = [w * arb(2) ** (-self.bits // 3) for w in weights]
        if all(abs(z.imag) < r / 4 for z, r in zip(x, radii, strict=True)):
            x = [acb(z.real) for z in x]
        values, jacobian = self._at(x)
        inverse = _inverse(jacobian)
        if inverse is None:
            return None
        shifts = [abs(value) for value in (inverse * values).entries()]
        everywhere = [acb(arb(z.real, r), arb(z.imag, r)) for z, r in zip(x, radii, strict=True)]
        defect = acb_mat(len(x), len(x), 1) - inverse * self._at(everywhere)[1]
        for k, (shift, r) in enumerate(zip(shifts, radii, strict=True)):
            spread = sum((abs(defect[k, j]) * s for j, s in enumerate(radii)), arb(0))
            if not (2 * shift < r and 2 * spread < r):
                return None
        if not self._is_as_stated(everywhere):
            return None
        return Disc(tuple(x), tuple(radii))

    def _completed(self, known: Sequence[acb]) -> list[acb]:
        """Return the whole point of a pose: each other coordinate by its own equation."""
        point = [*known, *[acb(0)] * (len(self._index) - len(known))]
        for k in range(len(known), len(point)):
            terms = next(e for e in self._equations if any(places == (k,) for _, places in e))
            factor = next(value for value, places in terms if places == (k,))
            point[k] = (-self._value(terms, point) / factor).mid()
        return point

    def _refined(self, x: list[acb]) -> list[acb] | None:
        """Return where Newton's method leads to, None if it does not settle."""
        for _ in range(_MOST_STEPS):
            values, jacobian = self._at(x)
            inverse = _inverse(jacobian)
            if inverse is None:
                return None
            step = (inverse * values).entries()
            x = [(a - d).mid() for a, d in zip(x, step, strict=True)]
            settled = arb(2) ** (-self.bits // 2)
            if all(abs(d) < settled * (abs(a) + 1) for a, d in zip(x, step, strict=True)):
                return x
        return None

    def _is_as_stated(self, point: Sequence[acb]) -> bool:
        """Whether all solutions in a disc are rotations, and no lines of a DLL parallel."""
        a, b, c, d, e, f, g, h, i = point[:9]
        determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
        # It is 1 or -1.
        return determinant.real > 0 and all(
            any(not self._value(terms, point).contains(0) for terms in vanishing)
            for vanishing in self._at_parallel
        )

    @staticmethod
    def _value(terms: list[tuple[arb, tuple[int, ...]]], point: Sequence[acb]) -> acb:
        total = acb(0)
        for value, places in terms:
            term = acb(value)
            for k in places:
                term *= point[k]
            total += term
        return total

    def _at(self, point: Sequence[acb]) -> tuple[acb_mat, acb_mat]:
        """Return the values, one column, and the Jacobian at a point."""
        size = len(point)
        values = acb_mat(size, 1, [self._value(terms, point) for terms in self._equations])
        jacobian = acb_mat(size, size)
        for row, terms in enumerate(self._equations):
            for value, places in terms:
                if len(places) == 1:
                    jacobian[row, places[0]] += value
                elif places:
                    i, j = places
                    jacobian[row, i] += value * point[j]
                    jacobian[row, j] += value * point[i]
        return values, jacobian


def real_poses(instance: Instance, distinct: int) -> int | None:
    """Return the number of real poses, None if that cannot be proved.

    Parameters
    ----------
    instance
        A platform with finitely many poses.
    distinct
        How many different ones there are over the complex numbers.
    """
    discs: list[Disc] = []
    waiting = _certificates(instance)
    for digits in DIGITS:
        with flint.ctx.workprec(_BITS * digits):
            system = SquareSystem(instance, _BITS * digits)
            found = [_disc(system, instance, item, digits) for item in waiting]
            for disc in found:
                if disc is not None:
                    _add(disc, discs)
        waiting = [item for item, disc in zip(waiting, found, strict=True) if disc is None]
        # A single pose without a disc, of any multiplicity, is its own conjugate.
        left = distinct - len(discs)
        if left in (0, 1):
            return sum(disc.real for disc in discs) + left
    return None


def _add(disc: Disc, discs: list[Disc]) -> None:
    """Add a disc and that of the conjugate solution if their solutions are proved to be new."""
    new = [disc] if disc.real else [disc, disc.conjugate]
    if len(new) == 2 and not new[0].is_apart(new[1]):
        return
    if all(one.is_apart(other) for one in new for other in discs):
        discs += new


def _certificates(instance: Instance) -> list[Certificate]:
    """Return what is certified of the poses that `gspcli.solve` finds."""
    found = solve(instance).solutions
    sides = [[_SIGNS[pose.sides.get(k, "")] for k in range(1, 7)] for pose in found]
    poses = [pose.R for pose in found], [pose.T for pose in found]
    return [item for item in certify(instance, *poses, sides=sides) if item.certified]


def _disc(
    system: SquareSystem, instance: Instance, certificate: Certificate, digits: int
) -> Disc | None:
    try:
        pose = refine(instance, certificate, digits)
    except IncompleteError:
        return None
    R_imag = None if pose.R_imag is None else chain(*pose.R_imag)
    return system.disc(_numbers(chain(*pose.R), R_imag), _numbers(pose.T, pose.T_imag))


def _numbers(real: Iterable[str], imaginary: Iterable[str] | None) -> list[acb]:
    parts = zip(real, imaginary or repeat("0"), strict=False)
    return [acb(arb(x), arb(y)).mid() for x, y in parts]


def _inverse(matrix: acb_mat) -> acb_mat | None:
    """Return an approximate inverse without error bounds, None if there is none."""
    identity = acb_mat(matrix.nrows(), matrix.nrows(), 1)
    try:
        return matrix.solve(identity, algorithm="approx").mid()
    except ZeroDivisionError:
        return None


_SIGNS = {"positive": 1, "negative": -1, "": 0}
