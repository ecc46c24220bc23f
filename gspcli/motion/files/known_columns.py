"""Which columns of a table are known; the others are refused, unless they are left out by name.

A column with a misspelt heading would otherwise be dropped, and the numbers of the platform taken
in its place.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from gspcli.errors import Mistake, SpecError
from gspcli.motion.files.headings import WORDS, Heading
from gspcli.wording import nearest, shown, suggestion

#: What stands for any text in the name of a column that is left out.
_ANY = "*"
_NUMBERS = "123456"
#: What `gsp` writes beside poses and values: tables with these are read again without them.
BESIDE = frozenset(
    (
        *("number", "row", "mode", "real", "sides", "multiplicity", "residual", "certified"),
        *("condition", "home", "distance", "turn", "off", "fits", "status", "orientation"),
        *(
            "range",
            "cone",
            "clearance",
            "pose_clearance",
            "gap",
            "gap_between",
            "force",
            "moment",
            "stiffness",
        ),
        *("transmission", "torque", "torque_of"),
        *("power", "frequency", "error", "kinetic", "potential", "work"),
        *("shift", "limits", "way"),
        *(f"{name}{k}" for name in "fva" for k in _NUMBERS),
        *(f"{name}{axis}" for name in ("w", "v", "alpha", "a") for axis in "xyz"),
        *(f"t{axis}_imag" for axis in "xyz"),
        *(f"q{axis}_imag" for axis in "wxyz"),
        *(f"{turn}{axis}_{end}" for turn in ("", "r") for axis in "xyz" for end in ("low", "high")),
    )
)


def left_out(cells: Sequence[str], ignore: Collection[str], name: str) -> frozenset[int]:
    """Return the places of the columns that are left out because they are named.

    Parameters
    ----------
    cells
        The heading, as written.
    ignore
        Names of columns that are left out, as written in the heading or as `gsp` calls them. A name
        with ``*``, which stands for any text, leaves out unknown columns only.
    name
        How messages name the file.

    Raises
    ------
    SpecError
        If there is no such column.
    """
    if not ignore:
        return frozenset()
    meant = [Heading.of(cell).name for cell in cells]
    found: set[int] = set()
    for one in ignore:
        if _ANY in one:
            continue
        places = [k for k, cell in enumerate(cells) if cell == one]
        name_here = Heading.of(one).name.lower()
        places = places or [k for k, key in enumerate(meant) if key and key.lower() == name_here]
        if not places:
            message = f"{name} has no column {shown(one)}{suggestion(one, cells)}"
            raise SpecError([Mistake(None, "--ignore", message)])
        found.update(places)
    return frozenset(found)


def unknown(
    place: int,
    written: str,
    word: str,
    cells: Sequence[str],
    known: Collection[str],
    expected: str,
    ignore: Collection[str],
) -> str:
    """Return the message about an unknown column; empty if the column may be left out.

    That is so if a name with ``*`` in `ignore` is like it, if it has neither a name nor cells, or
    if it has no name, is the first one and counts the rows.

    Parameters
    ----------
    place
        Which column it is, from 0.
    written, word
        Its heading, and that without a unit.
    cells
        What is in it.
    known, expected
        The known names, and the text that lists them if none is spelt like this one.
    ignore
        Names of columns that are left out.
    """
    if any(_is_like(written, one) for one in ignore if _ANY in one):
        return ""
    hint = "(--ignore leaves it out)"
    if written:
        names = {*known, *(name for name in WORDS if Heading.of(name).name in known)}
        near = nearest(word, sorted(names))
        said = f": did you mean {near}?" if near else f", expected {expected}"
        return f"found the unknown column {shown(written)}{said} {hint}"
    stripped = [cell.strip() for cell in cells]
    counted = any(stripped == [str(k + first) for k in range(len(stripped))] for first in (0, 1))
    if not any(stripped) or (place == 0 and counted):
        return ""
    return f"found a column without a name, expected one {hint}"


def _is_like(written: str, pattern: str) -> bool:
    """Return whether a heading is like a name with stars."""
    parts = map(re.escape, pattern.split(_ANY))
    return re.fullmatch(".*".join(parts), written, re.IGNORECASE) is not None
