"""Chains of joints that realize the constraints (paper, Section 7).

A chain realizes a constraint when it leaves the platform all six freedoms, and when holding its
driven joint leaves exactly the motions that keep the constraint's value: five freedoms. Both
numbers are computed here from the screws of the joints (`gspcli.catalogue.realization`); the tests
compare the held chain with the gradient of the distance or angle. Idle freedoms move links of a
chain but not the platform.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from fractions import Fraction
from functools import cache, cached_property

from gspcli.catalogue.coincidence import Connection, coincident_types
from gspcli.catalogue.kinds import AHH, ALH, ALL, DLL, DPH, DPL, DPP, Kind, Primitive
from gspcli.catalogue.types import GspType
from gspcli.records import dataclass

#: A vector with three exact components.
Vector = tuple[Fraction, Fraction, Fraction]
#: A line in space: a point of it and its direction (of any length).
Line = tuple[Vector, Vector]
#: A velocity of a rigid body: angular velocity, then the velocity of the point at the origin.
Screw = tuple[Fraction, ...]


class JointKind(Enum):
    """A joint, by its letter in the paper."""

    REVOLUTE = "R"
    PRISMATIC = "P"
    CYLINDRICAL = "C"
    SPHERICAL = "S"
    PLANAR = "E"

    @property
    def letter(self) -> str:
        """The letter, such as ``R``."""
        return self.value

    @property
    def freedoms(self) -> int:
        """The freedoms of the motion that the joint allows."""
        return len(joint_screws(self, _SAMPLE_LINE))


class JointAxis(Enum):
    """The place of a joint of a chain.

    Attributes
    ----------
    PLATFORM, BASE
        At the primitive of that body: the point, the line, or a normal of the plane.
    LEG
        Along the driven direction: the shortest connection for a distance, the common
        perpendicular of the two directions for an angle.
    ACROSS, ACROSS_TOO
        Through the end of the leg at the base, perpendicular to the leg and to each other.
    """

    PLATFORM = "platform"
    BASE = "base"
    LEG = "leg"
    ACROSS = "across"
    ACROSS_TOO = "across-too"

    @property
    def mirrored(self) -> JointAxis:
        """The axis after platform and base are exchanged."""
        return {JointAxis.PLATFORM: JointAxis.BASE, JointAxis.BASE: JointAxis.PLATFORM}.get(
            self, self
        )


@dataclass(frozen=True)
class PlacedJoint:
    """A joint of a chain."""

    #: The joint; a driven one is revolute or prismatic.
    joint: JointKind
    #: Where it lies.
    axis: JointAxis
    #: Whether a motor moves it.
    driven: bool = False

    def __str__(self) -> str:
        return self.joint.letter + "*" * self.driven


@dataclass(frozen=True)
class Chain:
    """Joints in series, from the platform to the base."""

    #: The joints in order.
    joints: tuple[PlacedJoint, ...]

    @property
    def name(self) -> str:
        """The joints by their letters, the driven ones starred: ``S-P*-C``."""
        return "-".join(map(str, self.joints))

    @property
    def drawing(self) -> str:
        """The chain between the two bodies: ``platform ─S─P*─C─ base``."""
        return f"platform ─{'─'.join(map(str, self.joints))}─ base"

    @cached_property
    def freedoms(self) -> int:
        """The sum of the freedoms of the joints."""
        return sum(placed.joint.freedoms for placed in self.joints)

    @property
    def driven(self) -> int:
        """The number of driven joints."""
        return sum(placed.driven for placed in self.joints)

    @property
    def locked(self) -> Chain:
        """The chain with its driven joints held."""
        return Chain(tuple(placed for placed in self.joints if not placed.driven))

    @property
    def driven_outside(self) -> Chain:
        """The chain with its driven joints moved to the base, beyond all others."""
        return Chain(self.locked.joints + tuple(placed for placed in self.joints if placed.driven))

    @property
    def mirrored(self) -> Chain:
        """The chain with platform and base exchanged."""
        return Chain(
            tuple(PlacedJoint(p.joint, p.axis.mirrored, p.driven) for p in reversed(self.joints))
        )

    def screws(self, axes: Mapping[JointAxis, Line]) -> tuple[Screw, ...]:
        """Return the screws of all joints, in order, for axes in given places."""
        return tuple(
            screw
            for placed in self.joints
            for screw in joint_screws(placed.joint, axes[placed.axis])
        )


def chain(text: str) -> Chain:
    """Return a chain from its joints and axes, as ``S:platform P*:leg C:base``.

    >>> chain("S:platform P*:leg C:base").drawing
    'platform ─S─P*─C─ base'
    """
    words = (word.split(":") for word in text.split())
    return Chain(
        tuple(
            PlacedJoint(JointKind(name[0]), JointAxis(axis), name.endswith("*"))
            for name, axis in words
        )
    )


def joint_screws(joint: JointKind, line: Line) -> tuple[Screw, ...]:
    """Return independent screws of a joint whose axis, centre or normal is a line."""
    point, direction = line
    if joint is JointKind.SPHERICAL:
        return tuple(rotation((point, unit)) for unit in _UNITS)
    turn, slide = rotation(line), translation(direction)
    if joint is JointKind.REVOLUTE:
        return (turn,)
    if joint is JointKind.PRISMATIC:
        return (slide,)
    if joint is JointKind.CYLINDRICAL:
        return (turn, slide)
    # The plane is spanned by the products with two axes: without an axis whose component is not
    # zero.
    skipped = next(i for i in range(3) if direction[i])
    inside = [cross(direction, _UNITS[i]) for i in range(3) if i != skipped]
    return (turn, *map(translation, inside))


def rotation(line: Line) -> Screw:
    """Return the screw of a rotation about a line."""
    point, direction = line
    return (*direction, *cross(point, direction))


def translation(direction: Vector) -> Screw:
    """Return the screw of a translation."""
    return (*_ZERO, *direction)


def rank(screws: Sequence[Screw]) -> int:
    """Return the dimension of the space that screws span."""
    return len(screws) - len(dependencies(screws))


def dependencies(screws: Sequence[Screw]) -> list[tuple[Fraction, ...]]:
    """Return a basis of the linear combinations of screws that are zero, as coefficients."""
    count = len(screws)
    rows = [[*screw, *(Fraction(i == j) for j in range(count))] for i, screw in enumerate(screws)]
    for column in range(6):
        pivot = next((row for row in rows if row[column]), None)
        if pivot is not None:
            rows.remove(pivot)
            for row in rows:
                factor = row[column] / pivot[column]
                row[:] = [x - factor * y for x, y in zip(row, pivot, strict=True)]
    return [tuple(row[6:]) for row in rows]


def vector(*components: int) -> Vector:
    """Return a vector with integer components."""
    x, y, z = map(Fraction, components)
    return (x, y, z)


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Vector, b: Vector) -> Fraction:
    """Return the scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), start=Fraction(0))


def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def along(a: Vector, factor: Fraction, b: Vector) -> Vector:
    """Return a + factor b."""
    return (a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2])


_ZERO = vector(0, 0, 0)
_UNITS = (vector(1, 0, 0), vector(0, 1, 0), vector(0, 0, 1))
_SAMPLE_LINE: Line = (_ZERO, vector(0, 0, 1))


@dataclass(frozen=True)
class Realization:
    """A chain that realizes a constraint, or DLL and ALL between the same two lines."""

    #: The kinds of the constraints: one, or DLL and ALL.
    kinds: tuple[Kind, ...]
    #: The chain, one driven joint for each kind.
    chain: Chain
    #: The chain in words.
    description: str
    #: The figure of the paper that shows it, or 0.
    figure: int = 0

    @cached_property
    def freedoms(self) -> int:
        """The freedoms that the chain alone leaves the platform."""
        return rank(self.chain.screws(sample_axes(self.kinds[0])))

    @cached_property
    def held_freedoms(self) -> int:
        """The freedoms that remain when the driven joints are held."""
        return rank(self.chain.locked.screws(sample_axes(self.kinds[0])))

    @cached_property
    def idle_freedoms(self) -> int:
        """The freedoms of the joints that do not move the platform."""
        return self.chain.freedoms - self.freedoms

    @property
    def idle_motion(self) -> str:
        """The motion of a link between the joints with both bodies at rest, or empty."""
        axes = sample_axes(self.kinds[0])
        found = dependencies(self.chain.screws(axes))
        if not found:
            return ""
        (coefficients,) = found
        links = [
            Chain(self.chain.joints[:count]).screws(axes)
            for count in range(1, len(self.chain.joints))
        ]
        turning = any(
            sum(c * screw[i] for c, screw in zip(coefficients, to_the_link, strict=False))
            for to_the_link in links
            for i in range(3)
        )
        return "leg turns about its own axis" if turning else "leg slides along its own axis"


#: The chains of the paper's figures; those of DLP, DHP and AHL are their mirror images.
_FIGURES = {
    (DPP,): ("S:platform P*:leg S:base", "two spherical joints, a driven slide between them", 9),
    (DPL,): ("S:platform P*:leg C:base", "a spherical and a cylindrical joint, a driven slide", 7),
    (DPH,): ("S:platform P*:leg E:base", "a spherical and a planar joint, a driven slide", 5),
    (DLL,): (
        "C:platform R:leg P*:leg C:base",
        "two cylindrical joints; between them a revolute joint and a driven slide",
        10,
    ),
    (ALL,): (
        "C:platform P:leg R*:leg C:base",
        "two cylindrical joints; between them a slide and a driven revolute joint",
        11,
    ),
    (ALH,): ("C:platform R*:leg E:base", "a cylindrical and a planar joint, a driven hinge", 12),
    (AHH,): ("E:platform R*:leg E:base", "two planar joints, a driven hinge between them", 13),
    (DLL, ALL): (
        "C:platform R*:leg P*:leg C:base",
        "two cylindrical joints; between them a driven revolute joint and a driven slide",
        14,
    ),
}

#: The paper's figure of an outside driver.
_OUTSIDE_DRIVER = 8
_NOUNS = {Primitive.POINT: "point", Primitive.LINE: "line", Primitive.PLANE: "plane"}

_THREE_HINGES = (
    "R:platform R*:leg R:base P:leg P:across P:across-too",
    "three revolute joints, the middle one driven, on three slides: an angle has no place",
    0,
)
#: One other chain for each, without idle freedoms.
_ALTERNATIVES = {
    (DPP,): (
        "S:platform P*:leg R:across R:across-too",
        "a universal joint (two crossing revolute joints) at one end stops the leg from spinning",
        0,
    ),
    (DPL,): (
        "S:platform P*:leg P:base R:base",
        "the cylindrical joint as a revolute joint on a slide",
        0,
    ),
    (DPH,): (
        "S:platform P*:leg P:across P:across-too",
        "two slides in the plane instead of the planar joint",
        6,
    ),
    (DLL,): (
        "R:platform P:platform R:leg P*:leg P:base R:base",
        "each cylindrical joint as a revolute joint and a slide",
        0,
    ),
    (ALL,): _THREE_HINGES,
    (ALH,): _THREE_HINGES,
    (AHH,): _THREE_HINGES,
    (DLL, ALL): (
        "R:platform P:platform R*:leg P*:leg P:base R:base",
        "each cylindrical joint as a revolute joint and a slide",
        0,
    ),
}


@cache
def realization(*kinds: Kind) -> Realization:
    """Return the chain of the paper's figures for a kind, or for DLL and ALL in one.

    >>> from gspcli.catalogue.kinds import DLP
    >>> realization(DLP).chain.name
    'C-P*-S'
    """
    return _from(_FIGURES, kinds)


@cache
def alternative(*kinds: Kind) -> Realization:
    """Return another chain for the same constraints, without idle freedoms."""
    return _from(_ALTERNATIVES, kinds)


@cache
def outside(*kinds: Kind) -> Realization:
    """Return the chain of the paper's figures with outside drivers: Figure 8.

    The driven joints are between the base and its primitive, which they move; the value of the
    constraint is fixed by the chain. Where the driver is parallel to the leg the chain has the same
    screws as the chain with the driver inside. After a finite motion it has other screws: the
    kinematic problem is a different one.

    >>> from gspcli.catalogue.kinds import DPL
    >>> outside(DPL).chain.name
    'S-C-P*'
    """
    inside = realization(*kinds)
    moved = "driven joint moves" if len(kinds) == 1 else "driven joints move"
    return Realization(
        kinds,
        inside.chain.driven_outside,
        f"the {moved} the base's {_NOUNS[kinds[0].base]}; the rest is rigid or free",
        _OUTSIDE_DRIVER if kinds == (DPL,) else 0,
    )


#: The ways to realize each constraint, by the names of `gsp realize --realization`.
REALIZATIONS: Mapping[str, Callable[..., Realization]] = {
    "figure": realization,
    "alternative": alternative,
    "outside": outside,
}


def _from(
    chains: Mapping[tuple[Kind, ...], tuple[str, str, int]], kinds: tuple[Kind, ...]
) -> Realization:
    if kinds in chains:
        text, words, figure = chains[kinds]
        return Realization(kinds, chain(text), words, figure)
    text, words, figure = chains[tuple(kind.mirrored for kind in kinds)]
    return Realization(kinds, chain(text).mirrored, words, figure)


#: A platform's and a base's primitive in general position: a point of each and its direction.
SAMPLE: tuple[Line, Line] = (
    (vector(2, -1, 3), vector(1, 4, -2)),
    (vector(-3, 5, 1), vector(3, 1, 2)),
)


def sample_axes(kind: Kind, primitives: tuple[Line, Line] = SAMPLE) -> dict[JointAxis, Line]:
    """Return the axes of a constraint's chain where its primitives are.

    Parameters
    ----------
    kind
        The kind of the constraint.
    primitives
        A point of the platform's and of the base's primitive, each with the direction of the
        line or the normal of the plane (without meaning for a point).
    """
    platform, base = primitives
    leg = _leg(kind, platform, base)
    across = cross(leg[1], vector(5, -2, 7))
    return {
        JointAxis.PLATFORM: platform,
        JointAxis.BASE: base,
        JointAxis.LEG: leg,
        JointAxis.ACROSS: (base[0], across),
        JointAxis.ACROSS_TOO: (base[0], cross(leg[1], across)),
    }


def _leg(kind: Kind, platform: Line, base: Line) -> Line:
    """Return the driven direction as a line: the screw of the constraint's gradient lies on it."""
    if Primitive.POINT not in (kind.platform, kind.base):
        (a, u), (b, v) = platform, base
        normal = cross(u, v)
        factor = dot(cross(minus(b, a), v), normal) / dot(normal, normal)
        return along(a, factor, u), normal
    if kind.platform is not Primitive.POINT:
        return _leg(kind.mirrored, base, platform)
    (a, _), (b, v) = platform, base
    apart = minus(b, a)
    if kind.base is Primitive.PLANE:
        return a, v
    if kind.base is Primitive.LINE:
        return a, along(apart, -dot(apart, v) / dot(v, v), v)
    return a, apart


#: The freedoms of a rigid body in space.
BODY_FREEDOMS = 6

_TOGETHER = {
    Primitive.POINT: "compound spherical joint: {} S with one centre",
    Primitive.LINE: "{} C on one shaft",
    Primitive.PLANE: "{} E on one plane",
}


@dataclass(frozen=True)
class MountedChain:
    """A chain of a mechanism."""

    #: The chain and what it realizes.
    realization: Realization
    #: The constraints that it realizes, by index from 0, one for each kind of `realization`.
    constraints: tuple[int, ...]
    #: The primitives at its ends.
    platform_name: str
    base_name: str


@dataclass(frozen=True)
class SharedPrimitive:
    """A primitive at which several chains end."""

    #: ``platform`` or ``base``.
    body: str
    #: The name of the primitive.
    name: str
    #: Its sort.
    primitive: Primitive
    #: The chains that end there, by index from 0.
    chains: tuple[int, ...]

    @property
    def joints(self) -> str:
        """The arrangement of the joints at the primitive."""
        return _TOGETHER[self.primitive].format(len(self.chains))


@dataclass(frozen=True)
class Mechanism:
    """A platform on chains of joints.

    Attributes
    ----------
    chains
        The chains, in the order of the first constraint of each.
    """

    chains: tuple[MountedChain, ...]

    @property
    def links(self) -> int:
        """The number of rigid bodies, n: platform, base, and those between joints."""
        return 2 + self.joints - len(self.chains)

    @property
    def joints(self) -> int:
        """The number of joints, g; joints that share a centre or axis count each."""
        return sum(len(mounted.realization.chain.joints) for mounted in self.chains)

    @property
    def joint_freedoms(self) -> int:
        """The sum of the freedoms of the joints."""
        return sum(mounted.realization.chain.freedoms for mounted in self.chains)

    @property
    def mobility(self) -> int:
        """The freedoms by the formula of Kutzbach and Grübler, idle ones included.

        The formula is a count and ignores constraints that depend on each other.
        """
        loops = self.joints - self.links + 1
        return self.joint_freedoms - BODY_FREEDOMS * loops

    @property
    def idle_freedoms(self) -> int:
        """The freedoms of links that do not move the platform."""
        return sum(mounted.realization.idle_freedoms for mounted in self.chains)

    @property
    def moving_freedoms(self) -> int:
        """The mobility less the idle freedoms: those of the platform."""
        return self.mobility - self.idle_freedoms

    @property
    def driven(self) -> int:
        """The number of driven joints."""
        return sum(mounted.realization.chain.driven for mounted in self.chains)

    @property
    def sum_shown(self) -> str:
        """The formula of Kutzbach and Grübler with its numbers."""
        formula = f"6 ({self.links} - {self.joints} - 1) + {self.joint_freedoms} = {self.mobility}"
        moving = f"{self.mobility} - {self.idle_freedoms} idle = {self.moving_freedoms}"
        return f"M = 6 (n - g - 1) + Σf = {formula}; {moving}"

    @property
    def shared(self) -> tuple[SharedPrimitive, ...]:
        """The primitives at which several chains end, those of the platform first."""
        ends: dict[tuple[str, str], list[int]] = {}
        sorts: dict[tuple[str, str], Primitive] = {}
        for body in ("platform", "base"):
            for index, mounted in enumerate(self.chains):
                name = getattr(mounted, f"{body}_name")
                if name:
                    ends.setdefault((body, name), []).append(index)
                    sorts[body, name] = getattr(mounted.realization.kinds[0], body)
        return tuple(
            SharedPrimitive(body, name, sorts[body, name], tuple(chains))
            for (body, name), chains in ends.items()
            if len(chains) > 1
        )


def mechanism(
    connections: Sequence[Connection], chosen: Callable[..., Realization] = realization
) -> Mechanism:
    """Return the mechanism for constraints between named primitives.

    Parameters
    ----------
    connections
        The constraints.
    chosen
        The chain for the kinds of one or two constraints: one of `REALIZATIONS`.

    >>> from gspcli.catalogue.coincidence import parse_sharing
    >>> figure_14 = parse_sharing("L1-l3 L1^l3 L2-l4 L2^l4 L1^l4 L2-l3")
    >>> [mounted.realization.chain.name for mounted in mechanism(figure_14.bonds).chains]
    ['C-R-P*-C', 'C-R*-P*-C', 'C-R*-P*-C', 'C-P-R*-C']
    """
    groups: list[list[int]] = []
    open_groups: dict[tuple[str, str], list[int]] = {}
    for index, connection in enumerate(connections):
        pair = (connection.platform_name, connection.base_name)
        waiting = open_groups.get(pair)
        if waiting and {connections[waiting[0]].kind, connection.kind} == {DLL, ALL}:
            waiting.append(index)
            del open_groups[pair]
            continue
        groups.append([index])
        if all(pair) and connection.kind in (DLL, ALL):
            open_groups[pair] = groups[-1]
    return Mechanism(
        tuple(
            _mounted(connections, sorted(group, key=lambda i: connections[i].kind), chosen)
            for group in groups
        )
    )


def mechanism_of_type(gsp_type: GspType) -> Mechanism:
    """Return the mechanism of a type whose primitives are all distinct."""
    return mechanism(next(coincident_types(gsp_type)).bonds)


def _mounted(
    connections: Sequence[Connection], group: list[int], chosen: Callable[..., Realization]
) -> MountedChain:
    first = connections[group[0]]
    return MountedChain(
        chosen(*(connections[index].kind for index in group)),
        tuple(group),
        first.platform_name,
        first.base_name,
    )
