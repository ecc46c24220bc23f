"""An instance modulo a random prime that is derived from it."""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import islice
from typing import Any

from flint import fmpz, nmod

from gspcli.catalogue.kinds import DLL, Kind
from gspcli.certification.counting.elements import (
    ONE,
    WHOLE,
    FieldElement,
    NoElementError,
    Sum,
    Term,
)
from gspcli.certification.counting.motion_equations import (
    Blocks,
    EvaluatedConstraint,
    MotionEquation,
    MotionEquations,
    choose,
    equations,
    evaluated,
    exact_constraints,
    parallel_lines,
)
from gspcli.certification.numbers.balls import dot
from gspcli.errors import IncompleteError
from gspcli.geometry.instance import Instance

#: Bits of the primes that prove counts, and of the primes that are tried before.
LARGE, SMALL = 61, 30
#: A larger order leaves too few primes to choose from at random.
_MAX_ORDER = 2**40
_MAX_SMALL_ORDER = 2**22
#: Each independent square root exists modulo half of the primes only.
_MAX_ROOTS = 14


class Randomness:
    """Integers derived from a text: equal texts give equal integers."""

    def __init__(self, text: str) -> None:
        self._key = text.encode()
        self._count = 0

    def below(self, limit: int) -> int:
        """Return an integer from 0 to ``limit - 1``, uniform up to 2^-64."""
        self._count += 1
        digest = hashlib.blake2b(self._key, digest_size=16, salt=self._count.to_bytes(8, "big"))
        return int.from_bytes(digest.digest(), "big") % limit


class Requirements:
    """The conditions on a prime under which some elements have images.

    Parameters
    ----------
    elements
        The exact numbers.

    Raises
    ------
    NoElementError
        If no such homomorphism is known.
    """

    def __init__(self, elements: Iterable[FieldElement]) -> None:
        self.terms: set[Term] = {ONE}
        self.denominators: set[int] = {1}
        for element in elements:
            for part in (element.numerator, element.denominator):
                if part is WHOLE:
                    continue
                self.terms |= part.keys()
                self.denominators |= {factor.denominator for factor in part.values()}
        self.transcendental = any(term.pi for term in self.terms)
        if self.transcendental and any(term.radians for term in self.terms):
            raise NoElementError("pi beside cosines of radians")
        if self.independent_roots > _MAX_ROOTS:
            raise NoElementError(f"{self.independent_roots} independent square roots")
        if self.order > _MAX_ORDER:
            raise NoElementError(f"angles whose cosines need roots of unity of order {self.order}")

    @cached_property
    def order(self) -> int:
        """The order N of the roots of unity: 1, or a multiple of 8."""
        order = math.lcm(*(term.turn.denominator for term in self.terms if term.turn))
        return 1 if order == 1 else math.lcm(order, 8)

    @property
    def has_small_primes(self) -> bool:
        """Whether there are enough primes of 30 bits."""
        return self.order << self.independent_roots <= _MAX_SMALL_ORDER

    @property
    def independent_roots(self) -> int:
        """The number of square roots that are not in the field of the roots of unity."""
        return sum(n not in self.order_primes for n in self.radicands)

    @cached_property
    def order_primes(self) -> tuple[int, ...]:
        """The primes that divide N."""
        return tuple(int(prime) for prime, _ in fmpz(self.order).factor())

    @cached_property
    def radian(self) -> Fraction:
        """The rational number whose multiples are all radians; 0 if there are none."""
        radians = [term.radians for term in self.terms if term.radians]
        if not radians:
            return Fraction(0)
        denominator = math.lcm(*(r.denominator for r in radians))
        return Fraction(math.gcd(*(int(r * denominator) for r in radians)), denominator)

    @cached_property
    def radicands(self) -> tuple[int, ...]:
        """Pairwise coprime numbers, primes of N or no squares, whose products give all roots."""
        base: list[int] = []
        for term in self.terms:
            if term.radicand != 1:
                _refine(base, term.radicand)
        for prime in self.order_primes:
            _refine(base, prime)
        roots = (math.isqrt(n) for n in base)
        # A square in the base is replaced by its root until it is not a square.
        result = []
        for n, root in zip(base, roots, strict=True):
            while root * root == n:
                n, root = root, math.isqrt(root)
            result.append(n)
        return tuple(sorted(result))


def _refine(base: list[int], n: int) -> None:
    """Add a number to pairwise coprime ones, so that all are products of powers of the base."""
    pending = [n]
    while pending:
        n = pending.pop()
        if n == 1:
            continue
        for k, other in enumerate(base):
            common = math.gcd(n, other)
            if common == 1:
                continue
            if common == n == other:
                break
            del base[k]
            pending += [common, n // common, other // common]
            break
        else:
            base.append(n)


class Homomorphism:
    """The images of exact numbers modulo a prime.

    Parameters
    ----------
    requirements
        The conditions of the numbers.
    prime
        A prime that meets them.
    randomness
        Chooses among the possible images.
    """

    def __init__(self, requirements: Requirements, prime: int, randomness: Randomness) -> None:
        self.prime = prime
        self._requirements = requirements
        self._inverses: dict[int, int] = {}
        self._root_of_unity = self._find_root_of_unity(randomness)
        self._circle = randomness.below(prime - 1) + 1
        self._pi = randomness.below(prime)
        self._roots: dict[int, nmod] = {}

    def rational(self, value: Fraction) -> nmod:
        """Return the image of a rational number."""
        denominator = value.denominator
        inverse = self._inverses.get(denominator)
        if inverse is None:
            inverse = self._inverses[denominator] = pow(denominator, -1, self.prime)
        return nmod(value.numerator * inverse % self.prime, self.prime)

    def __call__(self, element: FieldElement) -> nmod:
        """Return the image of an element.

        Raises
        ------
        ZeroDivisionError
            If the denominator is zero modulo the prime.
        """
        numerator = element.numerator
        if element.denominator is WHOLE and len(numerator) == 1:
            # Usual, and without hashes of terms.
            [(term, factor)] = numerator.items()
            if term is ONE:
                return self.rational(factor)
        if element.denominator is WHOLE:
            return self._sum(numerator)
        return self._sum(numerator) / self._sum(element.denominator)

    def _sum(self, terms: Sum) -> nmod:
        total = nmod(0, self.prime)
        for term, factor in terms.items():
            total += self.rational(factor) * self._term(term)
        return total

    def _term(self, term: Term) -> nmod:
        value = nmod(1, self.prime)
        rest = term.radicand
        for n in self._requirements.radicands if rest != 1 else ():
            while rest % n == 0:
                value, rest = value * self._root(n), rest // n
        if term.turn:
            value *= self._of_unity(term.turn)
        if term.radians:
            value *= self._power(self._circle, int(term.radians / self._requirements.radian))
        if term.pi:
            value *= self._power(self._pi, term.pi)
        return value

    def _of_unity(self, turn: Fraction) -> nmod:
        exponent = turn.numerator * (self._requirements.order // turn.denominator)
        return self._power(self._root_of_unity, exponent)

    def _power(self, base: int, exponent: int) -> nmod:
        return nmod(pow(base, exponent, self.prime), self.prime)

    def _find_root_of_unity(self, randomness: Randomness) -> int:
        """Return a primitive root of unity of the order that is needed."""
        order = self._requirements.order
        while True:
            root = pow(randomness.below(self.prime - 1) + 1, (self.prime - 1) // order, self.prime)
            if all(pow(root, order // q, self.prime) != 1 for q in self._requirements.order_primes):
                return root

    def _root(self, n: int) -> nmod:
        """Return the square root of a number of the base."""
        if n not in self._roots:
            self._roots[n] = self._new_root(n)
        return self._roots[n]

    def _new_root(self, n: int) -> nmod:
        if n not in self._requirements.order_primes:
            return nmod(int(nmod(n, self.prime).sqrt()), self.prime)
        order = self._requirements.order
        power = nmod(self._root_of_unity, self.prime)
        if n == 2:
            eighth = power ** (order // 8)
            return eighth + 1 / eighth
        # Gauss: the sum is sqrt(n), or i sqrt(n) for n = 3 mod 4.
        step = power ** (order // n)
        total, current = nmod(0, self.prime), nmod(1, self.prime)
        for a in range(1, n):
            current *= step
            total += current if pow(a, (n - 1) // 2, n) == 1 else -current
        return total if n % 4 == 1 else total / power ** (order // 4)


def homomorphisms(
    requirements: Requirements, text: str, bits: int = LARGE
) -> Iterator[Homomorphism]:
    """Yield homomorphisms to random primes with a number of bits, derived from a text."""
    randomness = Randomness(text)
    lowest = 2 ** (bits - 1)
    order, denominators = requirements.order, requirements.denominators
    used: set[int] = set()
    while True:
        step = order if order % 2 == 0 else 2 * order
        prime = lowest + randomness.below(lowest)
        prime += (1 - prime) % step
        if prime in used or not _suits(prime, requirements.radicands, requirements.order_primes):
            continue
        if prime >= 2 * lowest or any(d % prime == 0 for d in denominators):
            continue
        used.add(prime)
        yield Homomorphism(requirements, prime, randomness)


def _suits(prime: int, radicands: Sequence[int], order_primes: Sequence[int]) -> bool:
    return bool(fmpz(prime).is_prime()) and all(
        n in order_primes or pow(n, (prime - 1) // 2, prime) == 1 for n in radicands
    )


#: The most primes that are tried if one divides a denominator.
_ATTEMPTS = 5
#: With more DLL `ModularPlatform.has_lone_lines` is not decided.
_MOST_LINES = 3


class NotCountedError(IncompleteError):
    """The solutions of an instance could not be counted; the message gives the reason."""


class ModularPlatform:
    """The constraints of an instance modulo a prime.

    Parameters
    ----------
    instance
        The instance.
    seed
        The prime and everything random is derived from it and the instance.
    values_free
        Whether the values are random instead of those of the instance.
    index
        Another index gives another prime.
    bits
        Bits of the prime: `LARGE` or, where `Requirements.has_small_primes`, `SMALL`.

    Raises
    ------
    NotCountedError
        If the numbers have no homomorphism to a prime field that is known to be one.
    """

    def __init__(
        self,
        instance: Instance,
        seed: int,
        *,
        values_free: bool = False,
        index: int = 0,
        bits: int = LARGE,
    ) -> None:
        try:
            #: The constraints with exact numbers.
            self.exact = exact_constraints(instance, values_free=values_free)
            #: The conditions on primes.
            self.requirements = Requirements(x for row in self.exact for x in row.numbers)
        except NoElementError as error:
            raise NotCountedError(
                f"the solutions cannot be counted exactly: no exact arithmetic for {error}"
            ) from None
        text = f"{seed} {index} {bits} {values_free} {_identity(instance)}"
        self.bits = bits
        #: Choices of sides: for each constraint 1 or -1.
        self.choices = tuple(itertools.product(*(row.sides for row in self.exact)))
        #: The coordinates that suit the constraints.
        self.blocks = choose(self.kinds)
        #: The source of further random numbers.
        self.randomness = Randomness(f"{text} forms")
        #: The prime, and the constraints modulo it.
        self.prime, self.rows = self._images(homomorphisms(self.requirements, text, bits))
        if values_free:
            self.rows = [
                replace(row, value=nmod(self.randomness.below(self.prime), self.prime))
                for row in self.rows
            ]

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The kinds of the constraints."""
        return tuple(row.kind for row in self.exact)

    def equations(self, signs: Sequence[int]) -> MotionEquations:
        """Return the equations modulo the prime for a choice of sides."""
        return equations(on_sides(self.rows, signs))

    def parallel_lines(self) -> list[tuple[MotionEquation, MotionEquation]]:
        """Return for each DLL the conditions for parallel lines, and for their distance."""
        in_base = Blocks.TRANSLATION in self.blocks
        return [
            parallel_lines(
                row,
                [nmod(self.randomness.below(self.prime), self.prime) for _ in range(3)],
                in_base=in_base,
            )
            for row in self.rows
            if row.kind is DLL
        ]

    @property
    def has_lone_lines(self) -> bool:
        """Whether no two pairs of lines of a DLL can be parallel, or anti-parallel, together.

        They can be only if the lines of both bodies enclose the same angle. Numbers that differ
        modulo a prime are different.
        """
        rows = [row for row in self.rows if row.kind is DLL]
        return len(rows) <= _MOST_LINES and not any(
            _cosine_squared(one.u, other.u) == _cosine_squared(one.v, other.v)
            for one, other in itertools.combinations(rows, 2)
        )

    def _images(self, candidates: Iterator[Homomorphism]) -> tuple[int, list[EvaluatedConstraint]]:
        for homomorphism in islice(candidates, _ATTEMPTS):
            try:
                return homomorphism.prime, [evaluated(row, homomorphism) for row in self.exact]
            except ZeroDivisionError:
                continue
        raise NotCountedError(
            "the solutions cannot be counted exactly: a number is divided by zero"
        )


def _cosine_squared(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return the square of the cosine of the angle of two directions."""
    return dot(a, b) ** 2 / (dot(a, a) * dot(b, b))


def on_sides(
    rows: Sequence[EvaluatedConstraint], signs: Sequence[int]
) -> list[EvaluatedConstraint]:
    """Return constraints on one choice of sides."""
    return [row.on_side(sign) for row, sign in zip(rows, signs, strict=True)]


def _identity(instance: Instance) -> str:
    """Return a text that contains all numbers of an instance."""
    parts = [instance.units.angle.value]
    for row in instance.constraints:
        parts += [row.kind.name, row.side.value, str(row.value)]
        for geometry in (row.platform, row.base):
            for name in ("position", "direction", "normal"):
                parts += map(str, getattr(geometry, name, ()))
    return " ".join(parts)
