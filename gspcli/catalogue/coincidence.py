"""Platforms whose constraints share primitives, listed up to renaming.

The paper asks after Proposition 2.2 how many platforms there are when "the geometric primitives in
the base and platform could be the same". A *pattern* states which constraints share a primitive. It
is a bipartite multigraph. Its vertices are the primitives of the platform and those of the base,
each a point, line or plane; its six edges are the constraints, each of a kind. No vertex is
isolated, and a pair of primitives carries no kind twice (a pair of lines may carry DLL and ALL).
Two patterns are the same if renaming the primitives of the platform, and those of the base, turns
one into the other; platform and base are not exchanged.

The least word of a pattern over all orders of its edges is its canonical form. A prefix of a
least word is a least word, so `coincident_types` grows words edge by edge and drops every word
that is not least (orderly generation): each pattern appears once, and nothing is stored.
`gspcli.catalogue.coincidence` counts the same patterns without listing them.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cache
from itertools import combinations, count, product
from math import factorial, gcd, prod
from typing import Protocol

from gspcli.catalogue.kinds import KINDS, KINDS_BY_NAME, Kind
from gspcli.catalogue.names import find_alias
from gspcli.catalogue.types import CONSTRAINTS, GspType
from gspcli.errors import TypeNameError
from gspcli.records import dataclass
from gspcli.wording import shown

#: A vertex: the letter of its sort and its number among the primitives of that sort and body.
Vertex = tuple[str, int]
#: The numbers of the two ends of an edge; with the kind they name the edge.
Pair = tuple[int, int]

_MARKS = {"D": "-", "A": "^"}
_QUANTITIES = {mark: letter for letter, mark in _MARKS.items()}
_BOND = re.compile(r"([PLH])(\d+)([-^])([plh])(\d+)")


class Connection(Protocol):
    """A constraint between two named primitives: a `Bond`, or a constraint of an instance.

    Equal names on one body are one primitive; an empty name is a primitive of its own.
    """

    @property
    def kind(self) -> Kind:
        """The kind; it gives the sorts of both primitives."""

    @property
    def platform_name(self) -> str:
        """The name of the platform's primitive."""

    @property
    def base_name(self) -> str:
        """The name of the base's primitive."""


@dataclass(frozen=True)
class Bond:
    """A constraint between two numbered primitives."""

    #: The kind; it gives the sorts of both primitives.
    kind: Kind
    #: The number of the primitive among those of its sort on its body, from 1.
    platform: int
    base: int

    @property
    def platform_name(self) -> str:
        """The primitive of the platform, such as ``L1``."""
        return f"{self.kind.platform.value}{self.platform}"

    @property
    def base_name(self) -> str:
        """The primitive of the base, in small letters, such as ``p2``."""
        return f"{self.kind.base.value.lower()}{self.base}"

    def __str__(self) -> str:
        return f"{self.platform_name}{_MARKS[self.kind.quantity.value]}{self.base_name}"


@dataclass(frozen=True)
class Sharing:
    """A pattern: a type together with the primitives that its constraints share."""

    #: The type.
    type: GspType
    #: The place of the pattern in the list of its type, from 1: all primitives are distinct in the
    #: first.
    index: int
    #: The six constraints in canonical order with canonical numbers.
    bonds: tuple[Bond, ...]

    @property
    def id(self) -> str:
        """The stable id: the number of the type and the index, such as ``2659.7``."""
        return f"{self.type.number}.{self.index}"

    @property
    def notation(self) -> str:
        """The pattern in words that `parse_sharing` reads, such as ``P1-p1 P1-p2 L1^l1 …``.

        A capital is a primitive of the platform, a small letter one of the base; ``-`` is a
        distance and ``^`` an angle.
        """
        return " ".join(map(str, self.bonds))

    @property
    def platform_primitives(self) -> tuple[str, ...]:
        """The names of the distinct primitives of the platform, in order of appearance."""
        return tuple(dict.fromkeys(bond.platform_name for bond in self.bonds))

    @property
    def base_primitives(self) -> tuple[str, ...]:
        """The names of the distinct primitives of the base, in order of appearance."""
        return tuple(dict.fromkeys(bond.base_name for bond in self.bonds))

    @property
    def mirrored(self) -> str:
        """The notation of the pattern with platform and base exchanged."""
        swapped = (Bond(bond.kind.mirrored, bond.base, bond.platform) for bond in self.bonds)
        return " ".join(map(str, canonical_bonds(swapped)))

    def __str__(self) -> str:
        return self.notation


def coincident_types(gsp_type: GspType) -> Iterator[Sharing]:
    """Yield every pattern of a type, once each, from all primitives distinct to the most shared.

    >>> from gspcli.catalogue.names import parse_type
    >>> patterns = coincident_types(parse_type("6PP"))
    >>> print(next(patterns).notation)
    P1-p1 P2-p2 P3-p3 P4-p4 P5-p5 P6-p6
    >>> print(next(patterns).notation)
    P1-p1 P2-p1 P3-p2 P4-p3 P5-p4 P6-p5
    """
    numbers = count(1)
    for word in _least_words(gsp_type.kinds, ()):
        yield Sharing(gsp_type, next(numbers), _bonds(gsp_type.kinds, word))


def parse_sharing(text: str) -> Sharing:
    """Return the pattern that a notation such as ``P1-p1 P1-p2 …`` denotes.

    The constraints may stand in any order, and the primitives may have any numbers. Names of
    hexapods that say which legs share a joint (``3-3``) denote patterns, too.

    Raises
    ------
    TypeNameError
        If a word is no constraint, a pair carries a kind twice, or the six constraints are no type.
    """
    alias = find_alias(text)
    pattern = alias.pattern if alias else text.strip()
    given = [_parse_bond(word) for word in re.split(r"[\s,;]+", pattern)]
    gsp_type = GspType.of(bond.kind for bond in given)
    bonds = canonical_bonds(given)
    return next(pattern for pattern in coincident_types(gsp_type) if pattern.bonds == bonds)


def canonical_bonds(bonds: Iterable[Bond]) -> tuple[Bond, ...]:
    """Return the canonical form of a set of constraints between numbered primitives.

    Raises
    ------
    TypeNameError
        If a pair of primitives carries a kind twice.
    """
    ordered = sorted(bonds, key=lambda bond: bond.kind)
    for bond, times in Counter(ordered).items():
        if times > 1:
            raise TypeNameError(
                f"{bond} stands twice: a pair carries each kind of constraint at most once"
            )
    kinds = tuple(bond.kind for bond in ordered)
    return _bonds(kinds, _least_pairs(kinds, [(bond.platform, bond.base) for bond in ordered]))


def _parse_bond(word: str) -> Bond:
    match = _BOND.fullmatch(word)
    if match is None:
        raise TypeNameError(
            f"{shown(word)} is no constraint between named primitives: write P1-p2 for a distance, "
            "L1^h2 for an angle\na capital is a primitive of the platform, a small letter one "
            "of the base"
        )
    platform, i, mark, base, j = match.groups()
    kind = KINDS_BY_NAME.get(_QUANTITIES[mark] + platform + base.upper())
    if kind is None:
        what = {"-": "distance", "^": "angle"}[mark]
        raise TypeNameError(f"{shown(word)}: there is no {what} of {platform} and {base.upper()}")
    return Bond(kind, int(i), int(j))


def _bonds(kinds: Sequence[Kind], word: Iterable[Pair]) -> tuple[Bond, ...]:
    return tuple(Bond(kind, a, b) for kind, (a, b) in zip(kinds, word, strict=True))


def _least_words(kinds: Sequence[Kind], prefix: tuple[Pair, ...]) -> Iterator[tuple[Pair, ...]]:
    """Yield the least words that begin with a least word, the greatest first."""
    length = len(prefix)
    if length == len(kinds):
        yield prefix
        return
    kind = kinds[length]
    before = list(zip(kinds, prefix, strict=False))
    fresh_a = 1 + max((a for k, (a, _) in before if k.platform is kind.platform), default=0)
    fresh_b = 1 + max((b for k, (_, b) in before if k.base is kind.base), default=0)
    # A least word increases within each kind, so a pair never carries a kind twice. Of two edges of
    # one kind the second was not smaller when the first was taken; new labels only raise it.
    floor = prefix[-1] if length and kinds[length - 1] is kind else (0, 0)
    for a in range(fresh_a, 0, -1):
        for b in range(fresh_b, 0, -1):
            if (a, b) > floor:
                word = (*prefix, (a, b))
                if all(map(tuple.__eq__, word, _least_pairs(kinds[: length + 1], word))):
                    yield from _least_words(kinds, word)


def _least_pairs(kinds: Sequence[Kind], word: Sequence[Pair]) -> Iterator[Pair]:
    """Yield the least word that a reordering and renaming of an edge set gives, pair by pair.

    The edges may change places within a kind. Primitives are numbered as they appear, so an order
    of the edges fixes the names; all orders that are least so far are carried along.
    """
    ends: list[tuple[Vertex, Vertex]] = [
        ((kind.short[0], a), (kind.short[1], b)) for kind, (a, b) in zip(kinds, word, strict=True)
    ]
    # Used edges as bits, and the new numbers of the primitives of platform and base.
    orders: list[tuple[int, dict[Vertex, int], dict[Vertex, int]]] = [(0, {}, {})]
    used_a: Counter[str] = Counter()
    used_b: Counter[str] = Counter()
    for kind in kinds:
        sort_a, sort_b = kind.short[0], kind.short[1]
        fresh_a, fresh_b = used_a[sort_a] + 1, used_b[sort_b] + 1
        least: Pair = (fresh_a, fresh_b)
        ties: list[tuple[int, int, dict[Vertex, int], dict[Vertex, int]]] = []
        for used, names_a, names_b in orders:
            for edge, (a, b) in enumerate(ends):
                if kinds[edge] is kind and not used >> edge & 1:
                    pair = (names_a.get(a, fresh_a), names_b.get(b, fresh_b))
                    if pair < least:
                        least = pair
                        ties.clear()
                    if pair == least:
                        ties.append((edge, used, names_a, names_b))
        yield least
        used_a[sort_a] = max(used_a[sort_a], least[0])
        used_b[sort_b] = max(used_b[sort_b], least[1])
        orders = [
            (
                used | 1 << edge,
                names_a | {ends[edge][0]: least[0]},
                names_b | {ends[edge][1]: least[1]},
            )
            for edge, used, names_a, names_b in ties
        ]


# The number of patterns of shared primitives, without a list of them (Burnside's lemma).
#
# The patterns are those of `gspcli.catalogue.coincidence`; the way is independent of it. Let g
# permute the primitives of each sort of the platform, and h those of the base. For every r let F_r
# be the number of slots (pairs of primitives) for a kind that g^r and h^r fix together. It is the
# product of the number of primitives that g^r fixes and the number of those that h^r fixes. The
# multisets of slots that (g, h) leaves fixed have the generating function M(x) = exp(sum F_r x^r /
# r). The *sets* have M(x) / M(x^2), since 1 + x^l = (1 - x^2l) / (1 - x^l) for each cycle. Hence
# the sets of m slots for a kind are the sum, over a partition lambda of a and a partition nu of b
# with a + 2b = m, of
#
#     (1 / z(lambda)) ((-1)^length(nu) / z(nu)) product of F_r over the parts r of lambda and nu,
#
# where z is the order of the centralizer of a permutation of that cycle type. Now take the mean
# over all g and h, with at least as many primitives of each sort as edges. Let some parts r be
# given, and take the product over them of the number of primitives of one sort that g^r fixes. By
# Burnside's lemma the mean of this product over g is the number of partitions of a set into blocks
# that a permutation with cycles of these lengths does not change. So the number of patterns of a
# type is a sum over cycle types, one for each kind, of a weight times one factor
# `invariant_partitions` for each sort on each body.

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


# Patterns of shared primitives that can never fix the platform, with the proof by counting.
#
# Choose some primitives of either body, at their places in a pose. Consider the motions of the
# platform that keep all of them in place (a line may slide along itself, a plane in itself). Such a
# motion changes no value of a constraint that has an end among these primitives. If the motions
# have s freedoms, at most 6 - s of these constraints are independent. If there are more than 6 - s
# of them, the whole pattern is dependent in every pose, and its direct kinematics has no solution
# or infinitely many. An angle depends only on the direction of a line or plane.
#
# The converse is a computation, not part of this module: the tests find six independent gradients,
# in exact arithmetic, for patterns without such a part.

#: The part of a primitive that the constraints use: all of it, or the direction of a line or plane.
_POINT, _LINE, _PLANE, _DIRECTION = "P", "L", "H", "direction"


@dataclass(frozen=True)
class OverConstraint:
    """Constraints that cannot all be independent."""

    #: Primitives, or directions of primitives, that have an end of each of the constraints.
    primitives: tuple[str, ...]
    #: The freedoms of the motions that leave these primitives in place.
    freedoms: int
    #: The constraints, by index from 0; there are more than six less `freedoms`.
    constraints: tuple[int, ...]

    @property
    def reason(self) -> str:
        """The proof in a sentence."""
        fixed = " and ".join(self.primitives)
        plural = "s" * (self.freedoms != 1)
        return (
            f"motions that keep {fixed} in place have {self.freedoms} freedom{plural}, so at most "
            f"{CONSTRAINTS - self.freedoms} of these {len(self.constraints)} constraints "
            "are independent"
        )


def motion_freedoms(points: int, lines: int, planes: int, directions: int) -> int:
    """Return the freedoms of the motions that leave primitives in general position in place.

    In special positions the motions can only be more. `directions` counts primitives of which only
    the direction stays.

    >>> motion_freedoms(1, 0, 0, 0), motion_freedoms(0, 1, 0, 0), motion_freedoms(0, 0, 1, 0)
    (3, 2, 3)
    """
    different = lines + planes + directions
    if different >= 2:
        # No rotation keeps two directions; of the translations a line leaves one, a plane two.
        return max(0, 3 - 3 * points - 2 * lines - planes)
    if different == 1 and points == 0:
        return 1 + 3 - 2 * lines - planes
    if different == 1:
        # The rotation about the parallel through the point, if there is no line and no other point.
        return int(points == 1 and lines == 0)
    return {0: 6, 1: 3, 2: 1}.get(points, 0)


def over_constraint(connections: Iterable[Connection]) -> OverConstraint | None:
    """Return constraints that cannot all be independent, or None if counting shows none.

    >>> from gspcli.catalogue.coincidence import parse_sharing
    >>> print(over_constraint(parse_sharing("P1-p1 P1-p2 P1-p3 P2-p4 P3-p4 P4-p4").bonds).reason)
    motions that keep P1 and p4 in place have 1 freedom, so at most 5 of these 6 constraints are \
independent
    """
    return _search(_features(tuple(connections)), (), frozenset())


#: A primitive: body and name, the part that is used, and the constraints that end there.
_Feature = tuple[tuple[str, str], str, frozenset[int]]


def _features(connections: tuple[Connection, ...]) -> list[_Feature]:
    distances: defaultdict[tuple[str, str], set[int]] = defaultdict(set)
    angles: defaultdict[tuple[str, str], set[int]] = defaultdict(set)
    sorts = {}
    for index, connection in enumerate(connections):
        kind = connection.kind
        for body, name, sort in (
            ("platform", connection.platform_name, kind.platform.value),
            ("base", connection.base_name, kind.base.value),
        ):
            primitive = (body, name or f"that of constraint {index + 1}")
            sorts[primitive] = sort
            (distances if kind.is_distance else angles)[primitive].add(index)
    directions = [(primitive, _DIRECTION, frozenset(ends)) for primitive, ends in angles.items()]
    whole = [
        (primitive, sorts[primitive], frozenset(ends | angles.get(primitive, set())))
        for primitive, ends in distances.items()
    ]
    return directions + whole


def _search(
    candidates: list[_Feature], kept: tuple[_Feature, ...], covered: frozenset[int]
) -> OverConstraint | None:
    """Add one of the candidates in every way that still allows a motion."""
    for position, feature in enumerate(candidates):
        primitive, _, ends = feature
        if any(primitive == other for other, _, _ in kept):
            continue
        now = (*kept, feature)
        seen = [sort for _, sort, _ in now]
        freedoms = motion_freedoms(*map(seen.count, (_POINT, _LINE, _PLANE, _DIRECTION)))
        if freedoms == 0:
            continue
        reached = covered | ends
        if len(reached) > CONSTRAINTS - freedoms:
            names = tuple(
                f"the direction of {name}" if sort == _DIRECTION else name
                for (_, name), sort, _ in now
            )
            return OverConstraint(names, freedoms, tuple(sorted(reached)))
        if found := _search(candidates[position + 1 :], now, reached):
            return found
    return None
