"""The ten kinds of constraint: six distances and four angles (paper, Sections 2 and 4)."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from functools import cached_property

from gspcli.records import dataclass


class Primitive(Enum):
    """A geometric primitive, by the letter that the paper gives it."""

    POINT = "P"
    LINE = "L"
    PLANE = "H"


class Quantity(Enum):
    """What a constraint measures."""

    DISTANCE = "D"
    ANGLE = "A"


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of constraint, such as DPL: the distance of a platform point to a base line.

    Attributes
    ----------
    quantity
        Distance or angle.
    platform, base
        The primitive on the moving platform and the one on the base.
    order
        Position in the canonical order of the kinds, from 0.
    """

    quantity: Quantity
    platform: Primitive
    base: Primitive
    order: int

    @cached_property
    def name(self) -> str:
        """The full name, such as ``DPL``."""
        return self.quantity.value + self.short

    @cached_property
    def short(self) -> str:
        """The name without its leading letter, such as ``PL``."""
        return self.platform.value + self.base.value

    @cached_property
    def is_distance(self) -> bool:
        """Whether the constraint fixes a distance."""
        return self.quantity is Quantity.DISTANCE

    @cached_property
    def has_sides(self) -> bool:
        """Whether the distance has two sides to choose from: DPH and DHP (Theorem 5.4)."""
        return self.is_distance and Primitive.PLANE in (self.platform, self.base)

    @property
    def mirrored(self) -> Kind:
        """The kind with platform and base exchanged."""
        return KINDS_BY_NAME[self.quantity.value + self.base.value + self.platform.value]

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"Kind({self.name})"

    def __hash__(self) -> int:
        # Sets and dictionaries of kinds are everywhere; hashing the enums would dominate.
        return self.order

    def __lt__(self, other: Kind) -> bool:
        return self.order < other.order

    def __reduce__(self) -> tuple[Callable[[str], Kind], tuple[str]]:
        # Kinds are compared by identity, also after a way to another process.
        return _kind, (self.name,)


def _kind(name: str) -> Kind:
    return KINDS_BY_NAME[name]


def _kinds(names: str) -> tuple[Kind, ...]:
    return tuple(
        Kind(Quantity(name[0]), Primitive(name[1]), Primitive(name[2]), order)
        for order, name in enumerate(names.split())
    )


#: All kinds in canonical order: distances first, each group in the order of the paper.
KINDS: tuple[Kind, ...] = _kinds("DPP DPL DLP DPH DHP DLL ALL ALH AHL AHH")
KINDS_BY_NAME: dict[str, Kind] = {kind.name: kind for kind in KINDS}
DISTANCE_KINDS: tuple[Kind, ...] = tuple(kind for kind in KINDS if kind.is_distance)
ANGLE_KINDS: tuple[Kind, ...] = tuple(kind for kind in KINDS if not kind.is_distance)

DPP, DPL, DLP, DPH, DHP, DLL, ALL, ALH, AHL, AHH = KINDS
