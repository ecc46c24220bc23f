"""Platforms near simpler ones: a large sphere is nearly a plane, a far point a direction.

| constraint | with | is nearly |
|---|---|---|
| DPP | its base point far away | DPH |
| DPP | its platform point far away | DHP |
| DPH | its point far away | an angle |
| DHP | its point far away | an angle |

Each simple real solution of the simpler platform gives one of the other platform, if this is near
enough (implicit function theorem). So a type can have as many real solutions as its simpler types;
if its generic count is the same, all can be real.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from gspcli.catalogue.kinds import ALL, DHP, DPH, DPP, Kind
from gspcli.reality.platforms import Array, Platforms
from gspcli.records import dataclass

_SIMPLER = {DPP: (DPH, DHP), DPH: (ALL,), DHP: (ALL,)}
#: With more angles a type has infinitely many poses.
_MOST_ANGLES = 3


@dataclass(frozen=True)
class Limit:
    """A type, one of its constraints, and a simpler kind that this constraint may become.

    Attributes
    ----------
    kinds
        The kinds of the type.
    index, simpler
        The index of the constraint, and its simpler kind.
    """

    kinds: tuple[Kind, ...]
    index: int
    simpler: Kind

    @property
    def remaining(self) -> tuple[Kind, ...]:
        """The kinds of the simpler type."""
        return (*self.kinds[: self.index], self.simpler, *self.kinds[self.index + 1 :])

    def lifted(self, known: Platforms, there: Array, back: Array, reach: float) -> Platforms:
        """Return a reduced platform of the type near a simpler one.

        Parameters
        ----------
        known
            One reduced platform of the simpler type, without leading axes.
        there, back
            The place of the platform's origin in one of its real solutions, in the axes of the
            base; and that of the base's origin in the axes of the platform.
        reach
            The distance of the far point.
        """
        i, kind = self.index, self.kinds[self.index]
        y, x, u, v, values = (
            part.copy() for part in (known.y, known.x, known.u, known.v, known.values)
        )
        if kind is DPP:
            if self.simpler is DPH:
                x[i] += reach * v[i]
            else:
                y[i] += reach * u[i]
            values[i], u[i], v[i] = reach, 0.0, 0.0
        elif kind is DPH:
            y[i], x[i] = reach * u[i], there + reach * values[i] * v[i]
            values[i], u[i] = 0.0, 0.0
        else:
            x[i], y[i] = reach * v[i], back + reach * values[i] * u[i]
            values[i], v[i] = 0.0, 0.0
        return replace(known, kinds=self.kinds, y=y, x=x, u=u, v=v, values=values)


def limits(kinds: tuple[Kind, ...]) -> Iterator[Limit]:
    """Yield the ways to make one constraint of a type simpler, each kind once."""
    angles = sum(not kind.is_distance for kind in kinds)
    for index, kind in enumerate(kinds):
        for simpler in _SIMPLER.get(kind, ()):
            if kinds.index(kind) == index and (simpler.is_distance or angles < _MOST_ANGLES):
                yield Limit(kinds, index, simpler)
