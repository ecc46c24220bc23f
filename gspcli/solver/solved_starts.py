"""What is kept of solved platforms: from where paths to the next one are short, and counts."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Any

import numpy as np

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.numbers import Number
from gspcli.solver.pose_set import PoseSet

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.continuation.systems import Structure

#: So many of each sort are kept, those used last.
_KEPT = 64
_UNITS = Units("unit", AngleUnit.DEGREE)


class _Last(OrderedDict[Any, Any]):
    """The entries used last."""

    def fetch(self, key: Any) -> Any:
        if key in self:
            self.move_to_end(key)
        return self.get(key)

    def keep(self, key: Any, entry: Any) -> Any:
        self[key] = entry
        if len(self) > _KEPT:
            self.popitem(last=False)
        return entry


class SolvedStarts:
    """Platforms that were solved. Nothing but time depends on them."""

    def __init__(self) -> None:
        self._platforms, self._counts, self._met = _Last(), _Last(), _Last()

    def clear(self) -> None:
        """Forget everything."""
        for part in (self._platforms, self._counts, self._met):
            part.clear()

    def is_second(self, structure: Structure) -> bool:
        """Return whether a platform of a structure was solved before."""
        return bool(self._met.fetch(structure)) or not self._met.keep(structure, True)

    def keep(self, arrangement: Arrangement, poses: PoseSet) -> None:
        """Keep all poses of a platform of a special geometry: its start is made from them."""
        if self._platforms.fetch(key := _key(arrangement)) is None:
            self._platforms.keep(key, (arrangement, poses))

    def platform(self, arrangement: Arrangement) -> tuple[Arrangement, PoseSet] | None:
        """Return the solved platform of a geometry, as well as doubles tell."""
        return self._platforms.fetch(_key(arrangement)) if self._platforms else None

    def count(self, instance: Instance, seed: int, limit: float | None) -> ExactCount | None:
        """Return the count of an instance's geometry; None if it is not known."""
        rows = tuple((row.kind, row.platform, row.base, row.side) for row in instance.constraints)
        key = rows, seed, limit
        if key in self._counts:
            return self._counts.fetch(key)
        from gspcli.certification.counting import geometry_count

        given = tuple(
            Constraint(kind=kind, platform=platform, base=base, value=Number.of(1), side=side)
            for kind, platform, base, side in rows
        )
        return self._counts.keep(
            key, geometry_count(Instance(given, _UNITS), seed=seed, limit=limit)
        )


def _key(given: Arrangement) -> tuple[Any, ...]:
    parts = (given.y, given.x, given.u, given.v, given.sides)
    return (given.kinds, *(np.asarray(part).tobytes() for part in parts))


#: Those of the process.
STARTS = SolvedStarts()
