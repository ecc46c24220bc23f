"""What is kept of solved platforms: starts from which paths to others are short, and counts.

Nothing but time depends on it: a pose is proved wherever the path to it began, and is returned
correctly rounded (`gspcli.certification.numbers.correct_rounding`).
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from enum import Enum
from threading import Lock
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.certification.poses.locator import StudyPoints
    from gspcli.continuation.systems import Structure
    from gspcli.solver.poses import PoseSet


_Entry = TypeVar("_Entry")

#: This many of each sort are kept, those used last.
_KEPT = 64
#: After this many platforms of a sort one is solved from which paths to others are short. It takes
#: as long as three to ten of them save (`make bench`, rows "6-6, one", "planar 6-6").
OFTEN = 5
_UNITS = Units("unit", AngleUnit.DEGREE)


class Sort(Enum):
    """What is kept."""

    MET = "sorts of platforms, how often they were solved"
    START = "solved platforms with complex values"
    PLATFORM = "solved platforms of special geometries"
    SAME = "starts of special geometries, made from those"
    GEOMETRY = "solved systems of a geometry with complex values"
    SPREAD = "differences of values of geometries"
    COUNT = "exact counts of geometries"


class SolvedPlatform(NamedTuple):
    """A solved platform of a special geometry."""

    instance: Instance
    arrangement: Arrangement
    poses: PoseSet
    geometry_count: ExactCount | None
    """The count of the geometry, if it is known."""
    points: StudyPoints = MappingProxyType({})
    """Study points with more digits of poses that were located in balls, by the bytes of T."""

    def has_geometry_of(self, instance: Instance) -> bool:
        """Whether an instance differs in its values only, exactly, or in cones and cranks."""
        ours, theirs = self.instance, instance
        return [(a.kind, a.side) for a in ours.constraints] == [
            (b.kind, b.side) for b in theirs.constraints
        ] and all(
            (a.position, getattr(a, "vector", None)) == (b.position, getattr(b, "vector", None))
            for a, b in zip(ours.primitives, theirs.primitives, strict=True)
        )


class SolvedStarts:
    """Platforms that were solved.

    `gspcli.solve` and its neighbours take one of their own; without it those of the process are
    used (`STARTS`).
    """

    def __init__(self) -> None:
        self._kept: dict[Sort, OrderedDict[Hashable, object]] = {
            sort: OrderedDict() for sort in Sort
        }
        self._lock = Lock()

    def __repr__(self) -> str:
        # It is a default that `help` shows: how many are kept changes (`sizes`).
        return "<SolvedStarts>"

    @property
    def sizes(self) -> dict[Sort, int]:
        """How many of each sort are kept."""
        return {sort: len(entries) for sort, entries in self._kept.items()}

    def clear(self) -> None:
        """Forget everything."""
        with self._lock:
            for entries in self._kept.values():
                entries.clear()

    def fetch(self, sort: Sort, key: Hashable) -> object | None:
        """Return what is kept; None if nothing is."""
        with self._lock:
            entries = self._kept[sort]
            if key in entries:
                entries.move_to_end(key)
            return entries.get(key)

    def keep(self, sort: Sort, key: Hashable, entry: _Entry) -> _Entry:
        """Keep an entry, and return it."""
        with self._lock:
            entries = self._kept[sort]
            entries[key] = entry
            entries.move_to_end(key)
            if len(entries) > _KEPT:
                entries.popitem(last=False)
        return entry

    def kept(self, sort: Sort, key: Hashable, make: Callable[[], _Entry]) -> _Entry:
        """Return what is kept, made if nothing is."""
        with self._lock:
            known = key in self._kept[sort]
        if known:
            return cast(_Entry, self.fetch(sort, key))
        return self.keep(sort, key, make())

    def is_frequent(self, sort: Structure) -> bool:
        """Return whether `OFTEN` platforms were solved before, and count this one.

        They have the same structure of equations.
        """
        met = cast(int, self.fetch(Sort.MET, sort) or 0)
        self.keep(Sort.MET, sort, met + 1)
        return met >= OFTEN

    def keep_platform(self, solved: SolvedPlatform) -> None:
        """Keep all poses of a platform of a special geometry: its start is made from them."""
        self.kept(Sort.PLATFORM, geometry_key(solved.arrangement), lambda: solved)

    def platform(self, arrangement: Arrangement) -> SolvedPlatform | None:
        """Return the solved platform of a geometry that is equal in double precision."""
        if not self._kept[Sort.PLATFORM]:
            return None
        found = self.fetch(Sort.PLATFORM, geometry_key(arrangement))
        return cast("SolvedPlatform | None", found)

    def count(
        self, instance: Instance, values: NDArray[np.float64], seed: int, limit: float | None
    ) -> ExactCount | None:
        """Return the count of an instance's geometry; None if it is not known.

        Both sides of a plane at distance zero are the same equation, so that one of them is
        counted: at which distances that is so the values say, shape (6,).
        """
        rows = tuple(
            Constraint(
                kind=row.kind,
                platform=row.platform,
                base=row.base,
                value=Number.of(1),
                side=Side.POSITIVE if row.kind.has_sides and value == 0 else row.side,
            )
            for row, value in zip(instance.constraints, values.tolist(), strict=True)
        )

        def counted() -> ExactCount | None:
            from gspcli.certification.counting import geometry_count

            return geometry_count(Instance(rows, _UNITS), seed=seed, limit=limit)

        return self.kept(Sort.COUNT, (rows, seed, limit), counted)


def geometry_key(given: Arrangement) -> Hashable:
    """Return a key that platforms of one geometry and sides share, in double precision."""
    parts = (given.y, given.x, given.u, given.v, given.sides)
    return (given.kinds, *(np.asarray(part).tobytes() for part in parts))


#: Those of the process.
STARTS = SolvedStarts()
