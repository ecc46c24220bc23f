"""The 3850 types of generalized Stewart platform and the four classes (Proposition 2.2)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache, cached_property
from itertools import combinations_with_replacement
from math import comb

from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS, Kind, Primitive
from gspcli.errors import TypeNameError
from gspcli.records import dataclass

#: A platform has six constraints (a rigid body has six degrees of freedom) ...
CONSTRAINTS = 6
#: ... of which at most three are angles (Definition 2.1: three fix the orientation).
MAX_ANGLES = 3


@dataclass(frozen=True, order=True)
class PlatformClass:
    """One of the classes 3D3A, 4D2A, 5D1A and 6D (Section 2)."""

    #: How many distance and how many angle constraints a platform of the class has.
    distances: int
    angles: int

    @property
    def id(self) -> str:
        """The name of the class in the paper, such as ``3D3A``."""
        return f"{self.distances}D" + (f"{self.angles}A" if self.angles else "")

    @property
    def distance_choices(self) -> int:
        """The number of multisets of distance kinds: the paper's d_j (Proposition 2.2)."""
        return comb(self.distances + len(DISTANCE_KINDS) - 1, self.distances)

    @property
    def angle_choices(self) -> int:
        """The number of multisets of angle kinds: the paper's a_i (Proposition 2.2)."""
        return comb(self.angles + len(ANGLE_KINDS) - 1, self.angles)

    @property
    def size(self) -> int:
        """The number of types in the class by the formula of Proposition 2.2."""
        return self.distance_choices * self.angle_choices

    def __str__(self) -> str:
        return self.id


#: The classes in the order of the paper.
CLASSES: tuple[PlatformClass, ...] = tuple(
    PlatformClass(CONSTRAINTS - angles, angles) for angles in range(MAX_ANGLES, -1, -1)
)


@dataclass(frozen=True)
class Family:
    """The types of one class that share their distance constraints, with angles left open.

    Attributes
    ----------
    platform_class
        The class.
    distances
        The distance kinds in canonical order.
    """

    platform_class: PlatformClass
    distances: tuple[Kind, ...]

    @property
    def id(self) -> str:
        """The name, such as ``3D3A PL PL LP``."""
        return " ".join([self.platform_class.id, *(kind.short for kind in self.distances)])

    @property
    def types(self) -> tuple[GspType, ...]:
        """The types of the family in catalogue order."""
        angles = combinations_with_replacement(ANGLE_KINDS, self.platform_class.angles)
        return tuple(GspType(self.distances + chosen) for chosen in angles)

    def to_json(self) -> dict[str, int | str | None]:
        """Return the identity of the family as plain data; a family has no number."""
        return {"id": None, "number": None, "class": self.platform_class.id}

    def __str__(self) -> str:
        return self.id


@dataclass(frozen=True)
class GspType:
    """A type of generalized Stewart platform: a multiset of six constraint kinds.

    Attributes
    ----------
    kinds
        The six kinds in canonical order (`GspType.of` sorts them).
    """

    kinds: tuple[Kind, ...]

    @classmethod
    def of(cls, kinds: Iterable[Kind]) -> GspType:
        """Return the type with the given kinds, in any order.

        Raises
        ------
        TypeNameError
            If there are not six constraints or more than three are angles.
        """
        ordered = tuple(sorted(kinds))
        angles = sum(not kind.is_distance for kind in ordered)
        if len(ordered) != CONSTRAINTS:
            raise TypeNameError(f"a platform has six constraints, not {len(ordered)}")
        if angles > MAX_ANGLES:
            raise TypeNameError(
                f"{angles} angle constraints, at most three are possible: "
                "three fix the orientation (Definition 2.1)"
            )
        return cls(ordered)

    @cached_property
    def id(self) -> str:
        """The full name, such as ``DPL DPL DLP ALL ALH AHH``."""
        return " ".join(kind.name for kind in self.kinds)

    @cached_property
    def distances(self) -> tuple[Kind, ...]:
        """The distance kinds."""
        return tuple(kind for kind in self.kinds if kind.is_distance)

    @cached_property
    def angles(self) -> tuple[Kind, ...]:
        """The angle kinds."""
        return tuple(kind for kind in self.kinds if not kind.is_distance)

    @property
    def platform_class(self) -> PlatformClass:
        """The class of the type."""
        return PlatformClass(len(self.distances), len(self.angles))

    @property
    def family(self) -> Family:
        """The family of the type: its class and distances."""
        return Family(self.platform_class, self.distances)

    @property
    def number(self) -> int:
        """The stable number of the type, from 1 to 3850."""
        own = self.platform_class
        before = sum(other.size for other in CLASSES[: CLASSES.index(own)])
        distances = _position(self.distances, DISTANCE_KINDS)
        return before + distances * own.angle_choices + _position(self.angles, ANGLE_KINDS) + 1

    @property
    def mirrored(self) -> GspType:
        """The type with platform and base exchanged."""
        return GspType(tuple(sorted(kind.mirrored for kind in self.kinds)))

    def count(self, *kinds: Kind) -> int:
        """Return the number of constraints of the given kinds."""
        return sum(kind in kinds for kind in self.kinds)

    @property
    def primitives(self) -> tuple[tuple[Primitive, Primitive], ...]:
        """The six pairs (platform primitive, base primitive)."""
        return tuple((kind.platform, kind.base) for kind in self.kinds)

    def to_json(self) -> dict[str, int | str | None]:
        """Return the identity of the type as plain data."""
        return {"id": self.id, "number": self.number, "class": self.platform_class.id}

    def __str__(self) -> str:
        return self.id


def families(platform_class: PlatformClass) -> Iterator[Family]:
    """Yield the families of a class in catalogue order."""
    for distances in combinations_with_replacement(DISTANCE_KINDS, platform_class.distances):
        yield Family(platform_class, distances)


@cache
def all_types() -> tuple[GspType, ...]:
    """Return every type in catalogue order: by class, distances, angles."""
    return tuple(
        gsp_type
        for platform_class in CLASSES
        for family in families(platform_class)
        for gsp_type in family.types
    )


def _position(chosen: tuple[Kind, ...], kinds: tuple[Kind, ...]) -> int:
    """Return the position of a multiset of kinds in lexicographic order, from 0."""
    position, first = 0, 0
    for left, kind in zip(range(len(chosen) - 1, -1, -1), chosen, strict=True):
        here = kinds.index(kind)
        # Multisets with an earlier kind here, and then any kinds that do not precede it.
        position += sum(comb(len(kinds) - k - 1 + left, left) for k in range(first, here))
        first = here
    return position


def type_by_number(number: int) -> GspType:
    """Return the type with a stable number.

    Raises
    ------
    TypeNameError
        If the number is not between 1 and 3850.
    """
    types = all_types()
    if not 1 <= number <= len(types):
        raise TypeNameError(f"type number {number}: the types are numbered 1 to {len(types)}")
    return types[number - 1]
