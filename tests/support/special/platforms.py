"""Special and nearly special platforms by name, with exact counts by other programs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from pathlib import Path
from random import Random
from typing import Any

import yaml

from gspcli import loads
from gspcli.geometry.instance import Instance

TABLE = Path(__file__).parents[2] / "oracles" / "special-platforms.yaml"


@dataclass(frozen=True)
class Platform:
    """A platform of the table: its group and what it is within, and the instance file."""

    id: str
    text: str

    @cached_property
    def instance(self) -> Instance:
        """The instance that the file states."""
        return loads(self.text, name=self.id)

    @property
    def group(self) -> str:
        """The first part of the id."""
        return self.id.partition("/")[0]


@cache
def _table() -> list[dict[str, Any]]:
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    return yaml.load(TABLE.read_text(encoding="utf-8"), loader)


def platforms(groups: Iterable[str] | None = None) -> Iterator[Platform]:
    """Yield all platforms, or those of some groups."""
    chosen = None if groups is None else set(groups)
    for entry in _table():
        platform = Platform(entry["id"], entry["file"])
        if chosen is None or platform.group in chosen:
            yield platform


def platform(name: str) -> Platform:
    """Return the platform with an id."""
    entry = next(entry for entry in _table() if entry["id"] == name)
    return Platform(name, entry["file"])


def recorded() -> dict[str, dict[str, str]]:
    """Return the counts by id, as text: ``finite`` is yes or no, what is not known is empty."""
    keys = ("count", "distinct", "spurious", "real")
    return {
        entry["id"]: {"finite": "yes" if counts["finite"] else "no"}
        | {key: str(counts.get(key, "")) for key in keys}
        for entry in _table()
        if (counts := entry.get("counts"))
    }


class Draws(Random):
    """Random numbers, always the same for the same name."""

    def decimal(self, size: int = 1, places: int = 3) -> Fraction:
        """Return a decimal between minus and plus a size."""
        return size * Fraction(self.randrange(-(10**places), 10**places + 1), 10**places)
