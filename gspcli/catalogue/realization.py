"""Chains of joints that realize the constraints (paper, Section 7).

A chain realizes a constraint when it leaves the platform all six freedoms, and when holding its
driven joint leaves exactly the motions that keep the constraint's value: five freedoms. Both
numbers are computed here from the screws of the joints (`gspcli.catalogue.joints`); the tests
compare the held chain with the gradient of the distance or angle. Idle freedoms move links of a
chain but not the platform.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, cached_property

from gspcli.catalogue.joints import (
    Chain,
    JointAxis,
    Line,
    along,
    chain,
    cross,
    dependencies,
    dot,
    minus,
    rank,
    vector,
)
from gspcli.catalogue.kinds import AHH, ALH, ALL, DLL, DPH, DPL, DPP, Kind, Primitive
from gspcli.records import dataclass


@dataclass(frozen=True)
class Realization:
    """A chain that realizes a constraint, or DLL and ALL between the same two lines.

    Attributes
    ----------
    kinds
        The kinds of the constraints: one, or DLL and ALL.
    chain
        The chain, one driven joint for each kind.
    description
        The chain in words.
    figure
        The figure of the paper that shows it, or 0.
    """

    kinds: tuple[Kind, ...]
    chain: Chain
    description: str
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
