"""The number of common points of general quadrics of six spaces, from intersection theory.

Y is the smooth projective variety of the (e, f, g) with e.f = 0, e != 0 and (f, g) != 0, up to
(e, f, g) ~ (r e, r t f, t g). The motions are its open part g N != 0. Blow up Y along B_t, and
then along the strict transforms of B_p and B_q; these centres are products of projective lines.
On the result the spaces a, p, q, l and the differences of two members of s have no base points.
So the numbers are products of divisor classes. Proof: docs/counts.md, Theorem 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product
from math import comb, prod

from gspcli.catalogue.kinds import Kind
from gspcli.catalogue.types import CONSTRAINTS

#: The spaces of quadrics in Study coordinates, in their canonical order.
LETTERS = "apqls"
DIMENSION = 6
#: Where `data/counts` records them.
NUMBERS_FILE = "intersection-numbers.csv"
#: Degrees of h^k x^(6-k) on Y: coefficients of t^(3-k) in 1 / ((1 - t)^4 (1 - 2t)).
_POWERS = tuple(sum(comb(i + 3, 3) * 2 ** (3 - k - i) for i in range(4 - k)) for k in range(7))

#: A divisor class: coefficients of h, x and the exceptional divisors over B_t, B_p and B_q.
Divisor = tuple[int, int, int, int, int]
#: Of e, of the differences of members of s, and of the members of each space.
_DIFFERENCE: Divisor = (0, 1, -1, 0, 0)
_CLASSES: dict[str, Divisor] = {
    "a": (2, 0, 0, 0, 0),
    "p": (0, 1, -1, -1, 0),
    "q": (0, 1, -1, 0, -1),
    "l": (0, 1, 0, 0, 0),
    "s": (-2, 2, -1, -1, -1),
}

#: A class on a product of lines: coefficients by the set of lines, as bits, whose classes of
#: points are multiplied.
_OnLines = Mapping[int, int]
_A, _B, _C = {1: 1}, {2: 1}, {4: 1}


def _sum(*terms: tuple[int, _OnLines]) -> dict[int, int]:
    total: dict[int, int] = {}
    for factor, term in terms:
        for lines, coefficient in term.items():
            total[lines] = total.get(lines, 0) + factor * coefficient
    return total


def _times(one: _OnLines, other: _OnLines) -> dict[int, int]:
    return _sum(*[(c, {i | j: d}) for i, c in one.items() for j, d in other.items() if not i & j])


def _power(base: _OnLines, exponent: int) -> dict[int, int]:
    result = {0: 1}
    for _ in range(exponent):
        result = _times(result, base)
    return result


@dataclass(frozen=True)
class _Centre:
    """The centre of a blow-up, a product of lines; restrictions of h, x and earlier divisors."""

    lines: int
    h: _OnLines
    x: _OnLines
    earlier: _OnLines

    @property
    def codimension(self) -> int:
        return DIMENSION - self.lines

    def segre(self) -> dict[int, int]:
        """Return the inverse of the Chern class of the normal bundle.

        In K-theory the tangent bundle of Y is 4 O(h) + 4 O(x-h) + O(x-2h) - O(x) - 2, that of a
        line 2 O(1) - 1, and blowing up earlier within the centre twists the difference.
        """
        h, x = self.h, self.x
        bundles = [
            (4, h),
            (4, _sum((1, x), (-1, h))),
            (1, _sum((1, x), (-2, h))),
            (-1, x),
            (self.lines - 2, {}),
            *[(-2, {1 << line: 1}) for line in range(self.lines)],
        ]
        result = {0: 1}
        for rank, bundle in bundles:
            first = _sum((1, bundle), (-1, self.earlier))
            result = _times(
                result, _sum(*[(_choose(-rank, k), _power(first, k)) for k in range(4)])
            )
        return result

    def degree(self, h: int, x: int, earlier: int, own: int) -> int:
        """Return the degree of a monomial in h, x, the earlier divisor and, at least once, its own.

        Their exponents add up to 6.
        """
        segre = {
            lines: c
            for lines, c in self.segre().items()
            if lines.bit_count() == own - self.codimension
        }
        factors = (_power(self.h, h), _power(self.x, x), _power(self.earlier, earlier))
        for factor in factors:
            segre = _times(segre, factor)
        sign = -1 if own % 2 == 0 else 1
        return sign * segre.get((1 << self.lines) - 1, 0)


def _choose(n: int, k: int) -> int:
    """Return the binomial coefficient, also for negative n."""
    return comb(n, k) if n >= 0 else (-1) ** k * comb(k - n - 1, k)


#: e = a b^T and f = e; e = a b^T and f = c b^T; e = a b^T and f = a c^T.
_H = _sum((1, _A), (1, _B))
_CENTRE_T = _Centre(2, _H, _sum((2, _A), (2, _B)), {})
_CENTRE_P = _Centre(3, _H, _sum((1, _A), (2, _B), (1, _C)), _sum((1, _A), (1, _C)))
_CENTRE_Q = _Centre(3, _H, _sum((2, _A), (1, _B), (1, _C)), _sum((1, _B), (1, _C)))


@cache
def _degree(h: int, x: int, t: int, p: int, q: int) -> int:
    """Return the degree of a monomial of six divisors."""
    if p and q:
        return 0
    if p:
        return _CENTRE_P.degree(h, x, t, p)
    if q:
        return _CENTRE_Q.degree(h, x, t, q)
    return _CENTRE_T.degree(h, x, 0, t) if t else _POWERS[h]


@cache
def intersection_number(spaces: str) -> int:
    """Return the number of common points, with N not zero, of general members of six spaces.

    Parameters
    ----------
    spaces
        Six letters of ``apqls``, in any order.

    Raises
    ------
    ValueError
        If there are not six, or a letter is unknown.

    >>> intersection_number("ssssss"), intersection_number("pppqqq"), intersection_number("llllll")
    (40, 20, 64)
    """
    if len(spaces) != DIMENSION or not set(spaces) <= set(_CLASSES):
        message = f"spaces must be six letters of {''.join(_CLASSES)!r}, not {spaces!r}"
        raise ValueError(message)
    spheres = spaces.count("s")
    divisors = [_CLASSES[letter] for letter in spaces if letter != "s"]
    # One member of s, and its differences from the others.
    divisors += [_CLASSES["s"]] * (spheres > 0) + [_DIFFERENCE] * (spheres - 1)
    total = 0
    for chosen in product(*[[i for i in range(5) if d[i]] for d in divisors]):
        factor = prod(d[i] for d, i in zip(divisors, chosen, strict=True))
        h, x, t, p, q = map(chosen.count, range(5))
        total += factor * _degree(h, x, t, p, q)
    return total


def letters(distances: tuple[Kind, ...]) -> str:
    """Return the spaces of the six quadrics or products, in canonical order.

    >>> from gspcli.catalogue.kinds import DLL, DLP, DPL, DPP
    >>> letters((DPP, DPL, DLP, DLL))
    'aapqls'
    """
    chosen = "".join(sorted((kind.space for kind in distances), key=LETTERS.index))
    return "a" * (CONSTRAINTS - len(distances)) + chosen


def law(distances: tuple[Kind, ...]) -> int:
    """Return the one-sided count by its proof: a factor 2 for each product of quadrics.

    >>> from gspcli.catalogue.kinds import DLP, DPL
    >>> law((DPL, DPL, DLP))
    64
    """
    products = sum(kind.is_product for kind in distances)
    return int(2**products * intersection_number(letters(distances)))
