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
`gspcli.catalogue.coincidence_counts` counts the same patterns without listing them.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import count
from typing import Protocol

from gspcli.catalogue.aliases import find_alias
from gspcli.catalogue.kinds import KINDS_BY_NAME, Kind
from gspcli.catalogue.types import GspType
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
    """A constraint between two numbered primitives.

    Attributes
    ----------
    kind
        The kind; it gives the sorts of both primitives.
    platform, base
        The number of the primitive among those of its sort on its body, from 1.
    """

    kind: Kind
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
    """A pattern: a type together with the primitives that its constraints share.

    Attributes
    ----------
    type
        The type.
    index
        The place of the pattern in the list of its type, from 1: all primitives are distinct in
        the first.
    bonds
        The six constraints in canonical order with canonical numbers.
    """

    type: GspType
    index: int
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
            message = f"{bond} stands twice: a pair carries each kind of constraint at most once"
            raise TypeNameError(message)
    kinds = tuple(bond.kind for bond in ordered)
    return _bonds(kinds, _least_pairs(kinds, [(bond.platform, bond.base) for bond in ordered]))


def _parse_bond(word: str) -> Bond:
    match = _BOND.fullmatch(word)
    if match is None:
        message = (
            f"{shown(word)} is no constraint between named primitives: write P1-p2 for a distance, "
            "L1^h2 for an angle\na capital is a primitive of the platform, a small letter one "
            "of the base"
        )
        raise TypeNameError(message)
    platform, i, mark, base, j = match.groups()
    kind = KINDS_BY_NAME.get(_QUANTITIES[mark] + platform + base.upper())
    if kind is None:
        what = {"-": "distance", "^": "angle"}[mark]
        message = f"{shown(word)}: there is no {what} of {platform} and {base.upper()}"
        raise TypeNameError(message)
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
