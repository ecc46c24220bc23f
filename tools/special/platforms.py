"""All special platforms of the campaign by name, and the table of their exact counts."""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial

from gspcli import dumps, loads
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from tools.recording import ROOT
from tools.special import (
    extremes,
    fixtures,
    hexapods,
    lines_of_points,
    mixtures,
    small_differences,
    surfaces,
)
from tools.special.parts import Draws

TABLE = ROOT / "data" / "verification" / "special-platforms.csv"
GROUPS = {
    **hexapods.GROUPS,
    **fixtures.GROUPS,
    **surfaces.GROUPS,
    **mixtures.GROUPS,
    **extremes.GROUPS,
    **lines_of_points.GROUPS,
    **small_differences.GROUPS,
}


@dataclass(frozen=True)
class Platform:
    """A platform of the campaign.

    Attributes
    ----------
    id
        Its group, and what it is within.
    text
        The instance file.
    """

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

    @property
    def sha256(self) -> str:
        """Of the text, its first 16 digits."""
        return hashlib.sha256(self.text.encode()).hexdigest()[:16]


def _draws(group: str, name: str) -> Draws:
    return Draws(f"{SEED} {group} {name}")


def platforms(groups: Iterable[str] = tuple(GROUPS)) -> Iterator[Platform]:
    """Yield the platforms of all groups, or of some."""
    for group in groups:
        members = GROUPS[group]
        for name, instance in members(partial(_draws, group)):
            yield Platform(f"{group}/{name}", dumps(instance))


def recorded() -> dict[str, dict[str, str]]:
    """Return the rows of the table by id."""
    if not TABLE.is_file():
        return {}
    with TABLE.open(encoding="utf-8", newline="") as file:
        return {row["id"]: row for row in csv.DictReader(file)}
