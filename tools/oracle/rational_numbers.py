"""The numbers of an instance as fractions, exactly or rounded, and as balls."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import flint

from gspcli.catalogue.kinds import AHH
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Vector
from tools.oracle.number_parts import UnknownNumberError, direction, square_of, turn_of


class Rationals:
    """The numbers of an instance that has only rational ones; else as `homomorphisms.Homomorphism`.

    Methods raise `UnknownNumberError` where a number is irrational.
    """

    prime = 0

    def __init__(self, instance: Instance) -> None:
        self.unit = instance.units.angle

    def number(self, number: Number) -> Fraction:
        """Return a number."""
        if number.fraction is None:
            message = f"{number} is irrational"
            raise UnknownNumberError(message)
        return number.fraction

    def vector(self, exact: Vector) -> list[Fraction]:
        """Return a vector."""
        return [self.number(x) for x in exact]

    def norm(self, exact: Vector) -> Fraction:
        """Return the length of a direction."""
        return _rational_root(square_of(exact))

    def square(self, number: Number) -> Fraction:
        """Return the square of a number."""
        if number.operation == "sqrt":
            return self.number(number.arguments[0])
        return self.number(number) ** 2

    def scalar_product(self, constraint: Constraint) -> Fraction:
        """Return what an angle makes ``R u . v`` of directions of any length (Section 4)."""
        turn, radians, cosines = turn_of(constraint, self.unit)
        of_turn = _RATIONAL_COSINES.get(turn % 1)
        if radians or len(cosines) > 1 or (cosines and turn):
            of_turn = None
        if of_turn is None:
            message = f"the cosine of {constraint.value} is irrational"
            raise UnknownNumberError(message)
        cosine = cosines[0][0] if cosines else of_turn
        square = square_of(direction(constraint.platform)) * square_of(direction(constraint.base))
        norms = _rational_root(square) if cosine else Fraction(0)
        return (-1 if constraint.kind is AHH else 1) * cosine * norms


class Rounded(Rationals):
    """Rational numbers near those of an instance: irrational ones are rounded."""

    def __init__(self, instance: Instance, decimals: int) -> None:
        super().__init__(instance)
        self.decimals = decimals
        self._balls = Balls(instance)

    def _rounded(self, ball: flint.arb) -> Fraction:
        scaled = ball * flint.arb(10) ** self.decimals
        whole = scaled.mid().floor().unique_fmpz()
        assert whole is not None
        return Fraction(int(whole), 10**self.decimals)

    def _root(self, value: Fraction) -> Fraction:
        with flint.ctx.workdps(self.decimals + 30):
            return self._rounded(flint.arb(_rational(value)).sqrt())

    def number(self, number: Number) -> Fraction:
        """Return a number, rounded if it is irrational."""
        if number.fraction is not None:
            return number.fraction
        with flint.ctx.workdps(self.decimals + 30):
            return self._rounded(number.ball())

    def norm(self, exact: Vector) -> Fraction:
        """Return the length of a direction."""
        try:
            return super().norm(exact)
        except UnknownNumberError:
            return self._root(square_of(exact))

    def scalar_product(self, constraint: Constraint) -> Fraction:
        """Return what an angle makes ``R u . v`` of directions of any length (Section 4)."""
        try:
            return super().scalar_product(constraint)
        except UnknownNumberError:
            pass
        with flint.ctx.workdps(self.decimals + 30):
            return self._rounded(self._balls.scalar_product(constraint))


class Balls(Rationals):
    """Balls that contain the numbers of an instance, at the current precision."""

    def number(self, number: Number) -> flint.arb:  # type: ignore[override]
        """Return a number."""
        return number.ball()

    def norm(self, exact: Vector) -> flint.arb:  # type: ignore[override]
        """Return the length of a direction."""
        return sum((x.ball() ** 2 for x in exact), flint.arb(0)).sqrt()

    def scalar_product(self, constraint: Constraint) -> flint.arb:  # type: ignore[override]
        """Return what an angle makes ``R u . v`` of directions of any length (Section 4)."""
        turn, radians, cosines = turn_of(constraint, self.unit)
        angle = flint.arb(_rational(turn)) * 2 * flint.arb.pi() + flint.arb(_rational(radians))
        for cosine, sign in cosines:
            angle += sign * flint.arb(_rational(cosine)).acos()
        bodies = (constraint.platform, constraint.base)
        product = angle.cos() * self.norm(direction(bodies[0])) * self.norm(direction(bodies[1]))
        return -product if constraint.kind is AHH else product


def _rational(value: Fraction) -> flint.fmpq:
    return flint.fmpq(value.numerator, value.denominator)


_RATIONAL_COSINES = {
    Fraction(turn, 12): Fraction(cosine, 2)
    for turn, cosine in ((0, 2), (2, 1), (3, 0), (4, -1), (6, -2), (8, -1), (9, 0), (10, 1))
}


def _rational_root(value: Fraction) -> Fraction:
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    if root**2 != value:
        message = f"the square root of {value} is irrational"
        raise UnknownNumberError(message)
    return root
