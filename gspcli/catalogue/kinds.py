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
    """The quantity that a constraint measures."""

    DISTANCE = "D"
    ANGLE = "A"


class Law(Enum):
    """The polynomial of a constraint as a function of its value d (paper, Section 4).

    The polynomial of an angle is ``R u . v`` of the unit directions. The angle of two planes is
    that of one normal and the opposite of the other.
    """

    SQUARE = "d^2"
    SIGNED = "d"
    MOMENT = "d times the sine of the angle of the lines"
    COSINE = "cos d"
    SINE = "sin d"
    SUPPLEMENT = "-cos d"

    @property
    def is_cosine(self) -> bool:
        """Whether the angle is an arc cosine, up to the sign, or else an arc sine."""
        return self is not Law.SINE

    @property
    def sign(self) -> int:
        """The sign of cosine or sine."""
        return -1 if self is Law.SUPPLEMENT else 1


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of constraint, such as DPL: the distance of a platform point to a base line."""

    #: Distance or angle.
    quantity: Quantity
    #: The primitive on the moving platform and the one on the base.
    platform: Primitive
    base: Primitive
    #: Position in the canonical order of the kinds, from 0.
    order: int
    #: The polynomial as a function of the value.
    law: Law
    #: The space of quadrics in Study coordinates that contains its equation (docs/counts.md).
    space: str
    #: Whether the equation is a product of two such quadrics, not one.
    is_product: bool = False

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

    @cached_property
    def is_squared(self) -> bool:
        """Whether the equation is linear in the square of the value: distances without sides."""
        return self.is_distance and not self.has_sides

    @property
    def mirrored(self) -> Kind:
        """The kind with platform and base exchanged."""
        return KINDS_BY_NAME[self.quantity.value + self.base.value + self.platform.value]

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"Kind({self.name})"

    def __hash__(self) -> int:
        # Sets and dictionaries of kinds are frequent; the hash of the enums would take most of the
        # time.
        return self.order

    def __lt__(self, other: Kind) -> bool:
        return self.order < other.order

    def __reduce__(self) -> tuple[Callable[[str], Kind], tuple[str]]:
        # Kinds are compared by identity, also after they are sent to another process.
        return _kind, (self.name,)


def _kind(name: str) -> Kind:
    return KINDS_BY_NAME[name]


_ONE, _PRODUCT = False, True
#: All kinds in canonical order, distances first, each group in the order of the paper: law, space,
#: and whether the equation is a product.
_TABLE = {
    "DPP": (Law.SQUARE, "s", _ONE),
    "DPL": (Law.SQUARE, "p", _PRODUCT),
    "DLP": (Law.SQUARE, "q", _PRODUCT),
    "DPH": (Law.SIGNED, "p", _ONE),
    "DHP": (Law.SIGNED, "q", _ONE),
    "DLL": (Law.MOMENT, "l", _PRODUCT),
    "ALL": (Law.COSINE, "a", _ONE),
    "ALH": (Law.SINE, "a", _ONE),
    "AHL": (Law.SINE, "a", _ONE),
    "AHH": (Law.SUPPLEMENT, "a", _ONE),
}
KINDS: tuple[Kind, ...] = tuple(
    Kind(Quantity(name[0]), Primitive(name[1]), Primitive(name[2]), order, *facts)
    for order, (name, facts) in enumerate(_TABLE.items())
)
KINDS_BY_NAME: dict[str, Kind] = {kind.name: kind for kind in KINDS}
DISTANCE_KINDS: tuple[Kind, ...] = tuple(kind for kind in KINDS if kind.is_distance)
ANGLE_KINDS: tuple[Kind, ...] = tuple(kind for kind in KINDS if not kind.is_distance)

DPP, DPL, DLP, DPH, DHP, DLL, ALL, ALH, AHL, AHH = KINDS
