"""Which assembly modes belong together: groups joined by proved paths."""

from __future__ import annotations

from time import monotonic
from typing import Any

import numpy as np

from gspcli.defaults import PATH_SECONDS, SEED
from gspcli.geometry.instance import Instance
from gspcli.motion.paths.classes import PoseClass
from gspcli.motion.paths.ends import Modes, PathEnd
from gspcli.motion.paths.maps import Connections, PoseMap, ValueMap
from gspcli.motion.paths.planner import Planner
from gspcli.records import Tabular, dataclass
from gspcli.wording import counted


@dataclass(frozen=True, eq=False)
class ModeGroup:
    """One mode among the others.

    Attributes
    ----------
    mode
        Its number.
    signs
        The proved signs of det J and of its factors, such as ``+-``.
    group
        The smallest number of the modes that it is joined with by proved paths; None if the mode
        does not keep the limits.
    alone
        Whether it is proved that no path within the ranges leads to any other mode.
    left
        The first limit that the mode violates, in words; empty if it keeps all.
    """

    mode: int
    signs: str
    group: int | None
    alone: bool
    left: str


@dataclass(frozen=True, eq=False)
class ModeGroups(Tabular):
    """All modes of a platform in groups.

    Attributes
    ----------
    instance
        The platform.
    names
        What the signs are of, in words.
    modes
        The modes, in the order of `solve`.
    undecided
        Pairs of groups of which it is not known whether a path joins them.
    """

    instance: Instance
    names: tuple[str, ...]
    modes: tuple[ModeGroup, ...]
    undecided: tuple[tuple[int, int], ...]

    def __repr__(self) -> str:
        kinds = self.instance.name or self.instance.type.id
        modes = counted(len(self.modes), "mode")
        return f"<ModeGroups of {kinds}: {modes}, {counted(len(self.groups), 'group')}>"

    @property
    def groups(self) -> dict[int, list[int]]:
        """The numbers of the modes of each group, by the smallest of them."""
        found: dict[int, list[int]] = {}
        for one in self.modes:
            if one.group is not None:
                found.setdefault(one.group, []).append(one.mode)
        return found

    @property
    def complete(self) -> bool:
        """Whether all pairs of groups are proved to be apart."""
        return not self.undecided

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each mode, as plain data."""
        unknown = {group for pair in self.undecided for group in pair}
        return [
            {
                "mode": one.mode,
                "signs": one.signs,
                "group": one.group,
                "others": [k for k in self.groups.get(one.group or 0, []) if k != one.mode],
                "alone": one.alone,
                "apart": one.group is not None and one.group not in unknown,
                "left": one.left or None,
            }
            for one in self.modes
        ]

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.path/1``."""
        return {
            "schema": "gsp.path/1",
            **self.instance.to_json(),
            "complete": self.complete,
            "signs_of": list(self.names),
            "modes": self.rows(),
            "groups": list(self.groups.values()),
            "undecided": [list(pair) for pair in self.undecided],
        }


def mode_groups(
    instance: Instance, *, along: str | None = None, time: float = PATH_SECONDS, seed: int = SEED
) -> ModeGroups:
    """Return which assembly modes belong together, joined by proved paths.

    Parameters and errors are those of `gspcli.path`.

    Examples
    --------
    >>> import gspcli
    >>> gspcli.motion.mode_groups(gspcli.example("rubin-m2"))
    <ModeGroups of Rubin Observatory M2 hexapod: 2 modes, 2 groups>
    """
    planner = Planner(instance, along=along, seconds=time, seed=seed)
    deadline = monotonic() + time
    ends = Modes(planner.given).all()
    classes = [planner.classes.of(end.R, end.T) for end in ends]
    left = [planner.left(end) for end in ends]
    inside = [k for k, reason in enumerate(left) if not reason]
    alone = {k for k in inside if planner.fills_ranges(ends[k])}
    joined = Connections()
    for _ in ends:
        joined.add()
    open_ = [k for k in inside if k not in alone]
    _join(planner, ends, classes, open_, joined, deadline)
    group = {k: min(j for j in inside if joined.joined(j, k)) for k in inside}
    modes = tuple(
        ModeGroup(k + 1, classes[k].text, group[k] + 1 if k in group else None, k in alone, left[k])
        for k in range(len(ends))
    )
    firsts = sorted({group[k] for k in open_})
    undecided = tuple(
        (i + 1, j + 1)
        for a, i in enumerate(firsts)
        for j in firsts[a + 1 :]
        if not _groups_differ(classes, group, i, j)
    )
    names = tuple(planner.classes.name(k) for k in range(len(planner.classes.factors) + 1))
    return ModeGroups(planner.given, names, modes, undecided)


def _groups_differ(classes: list[PoseClass], group: dict[int, int], i: int, j: int) -> bool:
    """Whether any mode of a group is proved to be of another class than one of another group."""
    first, second = ([k for k, g in group.items() if g == one] for one in (i, j))
    return any(classes[a].differs(classes[b]) is not None for a in first for b in second)


def _join(
    planner: Planner,
    ends: list[PathEnd],
    classes: list[PoseClass],
    open_: list[int],
    joined: Connections,
    deadline: float,
) -> None:
    """Join modes on a map of poses, or on a map of values for each choice of sides of planes."""
    machine = planner.machine
    ranged = not machine.moves and bool(open_) and planner.values(ends[open_[0]]).ranged
    sides: dict[bytes, list[int]] = {}
    for k in open_:
        sides.setdefault(np.sign(ends[k].values).tobytes(), []).append(k)
    if planner.along != "poses" and ranged:
        for members in sides.values():
            found = planner.value_map([ends[k] for k in members])
            _grow(found, _tried_pairs(classes, members), deadline)
            _take(found, members, joined)
        return
    if len(open_) < 2:
        return
    poses = planner.pose_map([ends[k] for k in open_])
    # Random poses change what must stay. Modes differ in last digits of their orientation.
    grows = not (machine.shared or planner.stays)
    _grow(poses, _tried_pairs(classes, open_), deadline if grows else 0.0)
    _take(poses, open_, joined)


def _grow(found: PoseMap | ValueMap, tried: list[tuple[int, int]], deadline: float) -> None:
    """Let a map grow until all pairs are joined, or until a deadline."""
    found.join_given()
    while monotonic() < deadline and not all(found.connections.joined(i, j) for i, j in tried):
        found.grow()


def _take(found: PoseMap | ValueMap, members: list[int], joined: Connections) -> None:
    """Join the modes that a map joins."""
    for i, a in enumerate(members):
        for j in range(i):
            if found.connections.joined(i, j):
                joined.join(a, members[j])


def _tried_pairs(classes: list[PoseClass], members: list[int]) -> list[tuple[int, int]]:
    """Return the pairs of places in a list of modes that are not proved to be apart."""
    return [
        (i, j)
        for i, a in enumerate(members)
        for j, b in enumerate(members[:i])
        if classes[a].differs(classes[b]) is None
    ]
