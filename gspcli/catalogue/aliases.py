"""Usual names of hexapods, such as 6-3, by the number of points that their legs share."""

from __future__ import annotations

import re

from gspcli.records import dataclass

#: The type of all of them: six distances of points.
_TYPE = "6DPP"


@dataclass(frozen=True)
class Alias:
    """A name that does not consist of kinds.

    Attributes
    ----------
    name
        The usual spelling.
    type_name
        The type, in a spelling that `parse_name` reads.
    pattern
        The legs that share a point, in the notation of `parse_sharing`; empty if none do.
    meaning
        The description.
    """

    name: str
    type_name: str
    pattern: str
    meaning: str


#: By their names: how many points the base has, then how many the platform.
ALIASES = {
    alias.name: alias
    for alias in (
        Alias("hexapod", _TYPE, "", "six legs with joints of their own"),
        Alias("6-6", _TYPE, "", "six legs with joints of their own"),
        Alias(
            "6-3",
            _TYPE,
            "P1-p1 P1-p2 P2-p3 P2-p4 P3-p5 P3-p6",
            "six joints of the base, and legs that meet in pairs at three points of the platform",
        ),
        Alias(
            "3-6",
            _TYPE,
            "P1-p1 P2-p1 P3-p2 P4-p2 P5-p3 P6-p3",
            "legs that meet in pairs at three points of the base, and six joints of the platform",
        ),
        Alias(
            "3-3",
            _TYPE,
            "P1-p1 P1-p2 P2-p2 P2-p3 P3-p3 P3-p1",
            "the octahedron: three points of the base and three of the platform, two legs at each",
        ),
    )
}


def find_alias(text: str) -> Alias | None:
    """Return the alias with a name, in either case and with any dash; None if there is none."""
    return ALIASES.get(re.sub("[–—]", "-", text.strip().lower()))
