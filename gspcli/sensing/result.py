"""The result of `sensors`: how well each sensor distinguishes the modes of a platform."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli import __version__
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass
from gspcli.sensing.mirror import Mirror
from gspcli.sensing.sensor_kinds import GROUPS, Sensor
from gspcli.sensing.separations import BestPair, Separations, told_alike

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
SCHEMA = "gsp.sensors/1"


@dataclass(frozen=True, eq=False)
class SensorResult:
    """How well one additional sensor distinguishes the real modes of a platform.

    Attributes
    ----------
    instance
        The platform.
    drawn
        The origin of the n sets of values: ``given``, ``rows``, ``within``, ``ranges``, ``poses``,
        ``cranks``, ``drives`` or ``motors``.
    values
        The sets of readings, shape (n, 6), in the units of the instance.
    seed
        The source of randomness; None if nothing is random.
    sensors
        The s sensors.
    sigmas
        Their standard deviations, in the units of the instance, shape (s,).
    close
        Two modes are close if no point of the platform is farther apart than this, in the unit of
        length; no leg distinguishes them.
    need
        The difference in standard deviations that suffices.
    known_side
        Whether only modes on the side of home count.
    separations
        The differences for each sensor at each set.
    mirror
        The planes of both bodies if every mode is proved to have a mirror image, else None.
    blind
        Which sensors are proved to have the same reading at a mode and its mirror image; shape
        (s,).
    pair
        The best pair of sensors, if no sensor suffices for all sets; else None.
    """

    instance: Instance
    drawn: str
    values: Array
    seed: int | None
    sensors: tuple[Sensor, ...]
    sigmas: Array
    close: float
    need: float
    known_side: bool
    separations: Separations
    mirror: Mirror | None
    blind: NDArray[np.bool_]
    pair: BestPair | None

    def __post_init__(self) -> None:
        arrays = [self.values, self.sigmas, self.blind, *vars(self.separations).values()]
        for array in arrays if self.pair is None else [*arrays, self.pair.least]:
            array.setflags(write=False)

    def __repr__(self) -> str:
        name = self.instance.name or self.instance.type.id
        told = int(self.told.sum())
        sets = f"{told} set{'s' * (told != 1)} of values with several modes"
        if self.best is None:
            return f"<SensorResult of {name}: {sets}>"
        best, share = self.sensors[self.best], self.shares[self.best]
        return f"<SensorResult of {name}: {best} tells them apart in {share:.0%} of {sets}>"

    @cached_property
    def told(self) -> NDArray[np.bool_]:
        """Which sets have more than one mode, all of them known, shape (n,)."""
        return self.separations.complete & (self.separations.modes > 1)

    @cached_property
    def shares(self) -> Array:
        """The part of these sets for which each sensor suffices, shape (s,); NaN without a set."""
        return self._share(self.separations.least)

    def _share(self, least: Array) -> Array:
        if not self.told.any():
            return np.full(least.shape[:-1], np.nan)
        return np.asarray((least[..., self.told] >= self.need).mean(axis=-1))

    def quantile(self, part: float) -> Array:
        """Return a quantile over these sets of each sensor's worst difference, shape (s,)."""
        if not self.told.any():
            return np.full(len(self.sensors), np.nan)
        return np.asarray(np.quantile(self.separations.least[:, self.told], part, axis=1))

    @cached_property
    def order(self) -> list[int]:
        """The indices of the sensors, the best first: by the part of sets, then by difference."""
        if not self.told.any():
            return list(range(len(self.sensors)))
        surety = np.minimum(self.separations.least[:, self.told], 10 * self.need).mean(axis=1)
        surest, typical = told_alike(surety), told_alike(self.quantile(0.5))
        return [int(k) for k in np.lexsort((-typical, -surest, -self.shares))]

    @property
    def best(self) -> int | None:
        """The index of the best sensor; None if no set has two modes."""
        return self.order[0] if self.told.any() and self.sensors else None

    @property
    def suffices(self) -> bool:
        """Whether one sensor suffices for all sets, or no set has two modes."""
        return not self.told.any() or bool((self.shares == 1).any())

    @cached_property
    def hopeless(self) -> NDArray[np.bool_]:
        """The sets at which two modes are close and no sensor distinguishes them, shape (n,)."""
        near = (self.separations.closest < self.need) & (self.separations.distance < self.close)
        return self.told & near

    def in_group(self, group: str) -> list[int]:
        """Return the indices of the sensors of a group (`GROUPS`), the best first."""
        return [k for k in self.order if self.sensors[k].group == group]

    def any_of(self, group: str) -> float:
        """Return the part of the sets for which a sensor of a group suffices; NaN without a set."""
        return float(self._share(self.separations.least[self.in_group(group)].max(axis=0)))

    @property
    def groups(self) -> tuple[str, ...]:
        """The groups of the sensors."""
        there = {sensor.group for sensor in self.sensors}
        return tuple(group for group in GROUPS if group in there)

    def rows(self) -> list[dict[str, Any]]:
        """Return the numbers of each sensor, the best first."""
        low, middle = self.quantile(0.05), self.quantile(0.5)
        least = self.separations.least
        rows = []
        for k in self.order:
            at = int(told_alike(np.where(self.told, least[k], np.inf)).argmin())
            known = bool(self.told.any())
            first, second = self.separations.worst[k, at].tolist()
            rows.append(
                {
                    "sensor": str(self.sensors[k]),
                    "group": self.sensors[k].group,
                    "sigma": float(self.sigmas[k]),
                    "least": float(least[k, at]) if known else None,
                    "set": at + 1 if known else None,
                    "first": first if known else None,
                    "second": second if known else None,
                    "low": float(low[k]) if known else None,
                    "median": float(middle[k]) if known else None,
                    "share": float(self.shares[k]) if known else None,
                    "blind": bool(self.blind[k]),
                }
            )
        return rows

    def to_frame(self) -> pd.DataFrame:
        """Return the sensors as a table, the best first (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_json(self) -> dict[str, Any]:
        """Return the result as plain data of schema ``gsp.sensors/1``."""
        modes = self.separations.modes[self.separations.complete].tolist()
        return {
            "schema": SCHEMA,
            **self.instance.to_json(),
            "drawn": self.drawn,
            "sets": len(self.values),
            "complete": int(self.separations.complete.sum()),
            "told": int(self.told.sum()),
            "modes": {"least": min(modes), "most": max(modes)} if modes else None,
            "need": self.need,
            "known_side": self.known_side,
            "mirror": self.mirror is not None,
            "suffices": self.suffices,
            "sensors": self.rows(),
            "groups": [
                {
                    "group": group,
                    "sensors": len(self.in_group(group)),
                    "best": str(self.sensors[self.in_group(group)[0]]),
                    "any": self.any_of(group) if self.told.any() else None,
                }
                for group in self.groups
            ],
            "pair": self._pair_json(),
            "closest": self.closest_json(),
            "seed": self.seed,
            "version": __version__,
        }

    def _pair_json(self) -> dict[str, Any] | None:
        if self.pair is None:
            return None
        told = self.pair.least[self.told]
        return {
            "sensors": [str(self.sensors[k]) for k in self.pair.sensors],
            "least": float(told.min()),
            "share": float((told >= self.need).mean()),
        }

    def closest_json(self) -> dict[str, Any] | None:
        """Return the pair of modes that the sensors distinguish worst; None without a set."""
        if not self.told.any():
            return None
        found = self.separations
        among = self.hopeless if self.hopeless.any() else self.told
        at = int(told_alike(np.where(among, found.closest, np.inf)).argmin())
        return {
            "set": at + 1,
            "modes": found.closest_modes[at].tolist(),
            "least": float(found.closest[at]),
            "translation": float(found.distance[at]),
            "turn": float(found.turn[at]) / self.instance.units.angle.in_radians,
            "hopeless": int(self.hopeless.sum()),
        }
