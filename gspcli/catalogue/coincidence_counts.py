"""The number of patterns of shared primitives, without a list of them (Burnside's lemma).

The patterns are those of `gspcli.catalogue.coincidence`; the way is independent of it. Let g
permute the primitives of each sort of the platform, and h those of the base. For every r let F_r be
the number of slots (pairs of primitives) for a kind that g^r and h^r fix together. It is the
product of the number of primitives that g^r fixes and the number of those that h^r fixes. The
multisets of slots that (g, h) leaves fixed have the generating function M(x) = exp(sum F_r x^r /
r). The *sets* have M(x) / M(x^2), since 1 + x^l = (1 - x^2l) / (1 - x^l) for each cycle. Hence the
sets of m slots for a kind are the sum, over a partition lambda of a and a partition nu of b with a
+ 2b = m, of

    (1 / z(lambda)) ((-1)^length(nu) / z(nu)) product of F_r over the parts r of lambda and nu,

where z is the order of the centralizer of a permutation of that cycle type. Now take the mean over
all g and h, with at least as many primitives of each sort as edges. Let some parts r be given, and
take the product over them of the number of primitives of one sort that g^r fixes. By Burnside's
lemma the mean of this product over g is the number of partitions of a set into blocks that a
permutation with cycles of these lengths does not change. So the number of patterns of a type is a
sum over cycle types, one for each kind, of a weight times one factor `invariant_partitions` for
each sort on each body.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cache
from itertools import combinations, product
from math import factorial, gcd, prod

from gspcli.catalogue.kinds import KINDS, Kind
from gspcli.catalogue.types import GspType

#: The lengths of the cycles of a permutation, the longest first.
CycleType = tuple[int, ...]


def count_coincident(gsp_type: GspType) -> int:
    """Return the number of patterns of shared primitives of a type, all distinct included.

    >>> from gspcli.catalogue.kinds import DPP
    >>> count_coincident(GspType.of([DPP] * 6))
    90
    """
    return _count(_multiplicities(gsp_type))


def count_up_to_swap(gsp_type: GspType) -> Fraction:
    """Return the share of a type in the number of patterns up to exchanging platform and base.

    Summed over a set of types that holds the mirror image of each of its types, the shares give the
    number of classes. A type that is its own mirror image has its own number of classes.

    >>> from gspcli.catalogue.kinds import DPP
    >>> print(count_up_to_swap(GspType.of([DPP] * 6)))
    50
    """
    return Fraction(count_coincident(gsp_type) + count_self_mirrored(gsp_type), 2)


def count_self_mirrored(gsp_type: GspType) -> int:
    """Return the number of patterns that do not change if platform and base are exchanged.

    Let t exchange the bodies and rename; its square g renames the platform. For odd r, t^r fixes as
    many slots for a kind such as DPP as g^r fixes primitives; for even r, the square of those
    that g^(r/2) fixes. The slots for two mirrored kinds such as DPL and DLP change places, so a
    set of the one determines a set of the other. The mean is taken over g as before.
    """
    return _count_self_mirrored(_multiplicities(gsp_type))


def invariant_partitions(cycle_type: CycleType) -> int:
    """Return the number of partitions of a set into blocks that a permutation does not change.

    The permutation moves blocks around in rings. A ring of d blocks holds whole cycles, each of a
    length that d divides, and each cycle but one can start at any of the d blocks.

    >>> invariant_partitions((1, 1, 1)), invariant_partitions((2, 1)), invariant_partitions((3,))
    (5, 3, 2)
    """
    return _invariant_partitions(tuple(sorted(cycle_type, reverse=True)))


@cache
def _invariant_partitions(cycle_type: CycleType) -> int:
    if not cycle_type:
        return 1
    first, *others = cycle_type
    total = 0
    for size in range(len(others) + 1):
        for chosen in combinations(range(len(others)), size):
            divisor = gcd(first, *(others[i] for i in chosen))
            rings = sum(d**size for d in range(1, divisor + 1) if divisor % d == 0)
            rest = tuple(length for i, length in enumerate(others) if i not in chosen)
            total += rings * _invariant_partitions(rest)
    return total


def _multiplicities(gsp_type: GspType) -> tuple[tuple[Kind, int], ...]:
    return tuple((kind, gsp_type.count(kind)) for kind in KINDS if kind in gsp_type.kinds)


def _partitions(total: int, largest: int | None = None) -> Iterator[CycleType]:
    if total == 0:
        yield ()
    for part in range(min(total, largest or total), 0, -1):
        for rest in _partitions(total - part, part):
            yield (part, *rest)


def _centralizer(cycle_type: CycleType) -> int:
    lengths = Counter(cycle_type)
    return prod(length**times * factorial(times) for length, times in lengths.items())


@cache
def _weights(edges: int) -> tuple[tuple[CycleType, Fraction], ...]:
    """Return the cycle types, with weights, that count the sets of slots for one kind."""
    weights: defaultdict[CycleType, Fraction] = defaultdict(Fraction)
    for doubled in range(edges // 2 + 1):
        for nu, lam in product(_partitions(doubled), _partitions(edges - 2 * doubled)):
            cycle_type = tuple(sorted(lam + nu, reverse=True))
            sign = (-1) ** len(nu)
            weights[cycle_type] += Fraction(sign, _centralizer(lam) * _centralizer(nu))
    return tuple((cycle_type, weight) for cycle_type, weight in weights.items() if weight)


@cache
def _count(multiplicities: tuple[tuple[Kind, int], ...]) -> int:
    kinds = [kind for kind, _ in multiplicities]
    total = Fraction(0)
    for choice in product(*(_weights(times) for _, times in multiplicities)):
        vertices: defaultdict[tuple[str, str], CycleType] = defaultdict(tuple)
        for kind, (cycle_type, _) in zip(kinds, choice, strict=True):
            vertices["platform", kind.short[0]] += cycle_type
            vertices["base", kind.short[1]] += cycle_type
        total += _term(choice, vertices.values())
    return int(total)


@cache
def _count_self_mirrored(multiplicities: tuple[tuple[Kind, int], ...]) -> int:
    times_of = dict(multiplicities)
    if any(times_of.get(kind.mirrored) != times for kind, times in multiplicities):
        return 0
    # One kind of each mirrored pair: its edges determine those of the other kind.
    kinds = [kind for kind, _ in multiplicities if not kind.mirrored < kind]
    total = Fraction(0)
    for choice in product(*(_weights(times_of[kind]) for kind in kinds)):
        vertices: defaultdict[str, CycleType] = defaultdict(tuple)
        for kind, (cycle_type, _) in zip(kinds, choice, strict=True):
            if kind.mirrored is kind:
                vertices[kind.short[0]] += _square(cycle_type)
            else:
                vertices[kind.short[0]] += cycle_type
                vertices[kind.short[1]] += cycle_type
        total += _term(choice, vertices.values())
    return int(total)


def _term(choice: Iterable[tuple[CycleType, Fraction]], vertices: Iterable[CycleType]) -> Fraction:
    weight = prod((weight for _, weight in choice), start=Fraction(1))
    return weight * prod(map(invariant_partitions, vertices))


def _square(cycle_type: CycleType) -> CycleType:
    """Return the cycle type of the square of a permutation."""
    halves = ((length,) if length % 2 else (length // 2,) * 2 for length in cycle_type)
    return tuple(length for half in halves for length in half)
