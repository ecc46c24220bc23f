"""Whole platforms made of chains of joints: freedoms by Kutzbach and Grübler (paper, Section 7).

Each constraint gets a chain; DLL and ALL between the same two lines get one chain with two driven
joints, as in the paper's Figure 14. Other constraints that share a primitive have joints of their
own, with a common centre, axis or plane.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from gspcli.catalogue.coincidence import Connection, coincident_types
from gspcli.catalogue.kinds import ALL, DLL, Primitive
from gspcli.catalogue.realization import Realization, realization
from gspcli.catalogue.types import GspType
from gspcli.records import dataclass

#: The freedoms of a rigid body in space.
BODY_FREEDOMS = 6

_TOGETHER = {
    Primitive.POINT: "compound spherical joint: {} S with one centre",
    Primitive.LINE: "{} C on one shaft",
    Primitive.PLANE: "{} E on one plane",
}


@dataclass(frozen=True)
class MountedChain:
    """A chain of a mechanism.

    Attributes
    ----------
    realization
        The chain and what it realizes.
    constraints
        The constraints that it realizes, by index from 0, one for each kind of `realization`.
    platform_name, base_name
        The primitives at its ends.
    """

    realization: Realization
    constraints: tuple[int, ...]
    platform_name: str
    base_name: str


@dataclass(frozen=True)
class SharedPrimitive:
    """A primitive at which several chains end.

    Attributes
    ----------
    body
        ``platform`` or ``base``.
    name
        The name of the primitive.
    primitive
        Its sort.
    chains
        The chains that end there, by index from 0.
    """

    body: str
    name: str
    primitive: Primitive
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
