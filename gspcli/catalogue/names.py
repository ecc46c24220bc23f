"""Names of kinds, types and families, read in every usual spelling."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NoReturn

from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS, KINDS, Kind
from gspcli.catalogue.types import (
    CLASSES,
    CONSTRAINTS,
    Family,
    GspType,
    PlatformClass,
    type_by_number,
)
from gspcli.errors import ArgumentError, TypeNameError
from gspcli.records import dataclass
from gspcli.wording import shown, similar

_CLASSES_BY_ID = {platform_class.id: platform_class for platform_class in CLASSES}
_SEPARATORS = re.compile(r"[\s,;+]+")
_NUMBER_DIGITS = 9
#: A count with a blank before its kind, as in 6 PP.
_APART = re.compile(r"(?<!\S)([1-6]) +(?=[A-Z]{2,3}(?!\S))")
_REPEATED = re.compile(r"(\d{1,3})[*x]?([A-Z]{2,3})|([A-Z]{2,3})[*^](\d{1,3})")


def parse_class(text: str) -> PlatformClass:
    """Return the class with a name such as ``3D3A``, in either case.

    Raises
    ------
    TypeNameError
        If there is no such class.
    """
    found = _CLASSES_BY_ID.get(_joined(text).strip().upper())
    if found is None:
        raise TypeNameError(
            f"unknown class {shown(text)}: the classes are {', '.join(_CLASSES_BY_ID)}"
        )
    return found


def parse_kind(text: str) -> Kind:
    """Return the one kind with a name such as ``DPL``, ``PL`` or ``dpl``.

    Raises
    ------
    TypeNameError
        If there is no such kind, or if the name fits two (``LL`` is DLL or ALL).
    """
    found = parse_kinds(text)
    if len(found) > 1:
        names = " or ".join(kind.name for kind in found)
        raise TypeNameError(f"{shown(text)} is {names}: give the leading letter")
    return found[0]


def parse_kinds(text: str) -> tuple[Kind, ...]:
    """Return the kinds that a name can mean: one, or for ``LL`` the distance and the angle.

    Raises
    ------
    TypeNameError
        If there is no such kind.
    """
    name = _joined(text).strip().upper()
    found = tuple(kind for kind in KINDS if name in (kind.name, kind.short))
    if not found:
        _unknown_kind(text)
    return found


def _unknown_kind(text: str) -> NoReturn:
    name = text.strip().upper()
    names = [kind.name for kind in KINDS]
    message = f"unknown constraint {shown(text)}"
    swapped = name[:-2] + name[-2:][::-1]
    if len(name) == 3 and name[0] in "DA" and all(letter in "PLH" for letter in name[1:]):
        what, kinds = ("distance", DISTANCE_KINDS) if name[0] == "D" else ("angle", ANGLE_KINDS)
        message += f": there is no {what} of this pair, only {_names(kinds)}"
    elif near := similar(name, [*names, *(n[1:] for n in names)], 3, cutoff=0.5):
        message += f": did you mean {' or '.join(dict.fromkeys(near))}?"
    elif swapped in names:
        message += f": did you mean {swapped}?"
    message += f"\nthe kinds are {' '.join(names)}"
    raise TypeNameError(message)


def _names(kinds: Sequence[Kind]) -> str:
    return " ".join(kind.name for kind in kinds)


def _joined(text: str | Sequence[str]) -> str:
    """Return a text, or several with blanks between."""
    try:
        return text if isinstance(text, str) else " ".join(text)
    except TypeError as error:
        raise ArgumentError(
            f"found a {type(text).__name__}, expected a text, such as 6PP or DPL"
        ) from error


def _words(text: str | Sequence[str]) -> list[str]:
    words: list[str] = []
    for word in _SEPARATORS.split(_APART.sub(r"\1", _joined(text).strip().upper())):
        repeated = _REPEATED.fullmatch(word)
        if repeated and word not in _CLASSES_BY_ID:
            count, name = (repeated[1], repeated[2]) if repeated[1] else (repeated[4], repeated[3])
            if int(count) > CONSTRAINTS:
                raise TypeNameError(f"{shown(word)}: a platform has six constraints")
            words += [name] * int(count)
        elif word:
            words.append(word)
    return words


def parse_name(text: str | Sequence[str]) -> GspType | Family:
    """Return the type or family that a name denotes.

    A name is one of these:

    - a stable number (``17``);
    - six kinds in any order, separated by blanks or commas (``DPL pl LP all alh AHH``); the first
      letter may be omitted if the kind is clear, and kinds may be repeated (``6PP``, ``PL^2``);
    - a family: a class with its distances (``3D3A PL PL LP``); a family without angles is a type;
    - a name in `ALIASES` (``hexapod``, ``6-3``).

    Raises
    ------
    TypeNameError
        Says what is wrong, which names are near and how to write a name.
    ArgumentError
        If the argument is neither a text nor several texts.
    """
    text = _joined(text)
    alias = find_alias(text)
    words = _words(text if alias is None else alias.type_name)
    if not words:
        raise TypeNameError(
            "no type given: write six kinds, a number, or a family as 3D3A PL PL LP"
        )
    number = words[0].lstrip("#")
    if len(words) == 1 and number.isdecimal():
        # Python refuses to read integers of thousands of digits.
        return type_by_number(int(number[:_NUMBER_DIGITS]))
    named = None
    if words[0][0].isdigit():
        named, words = parse_class(words[0]), words[1:]
    return _assemble(named, [parse_kinds(word) for word in words])


def _assemble(named: PlatformClass | None, choices: list[tuple[Kind, ...]]) -> GspType | Family:
    count = len(choices)
    if named is not None and count == named.distances != CONSTRAINTS:
        distances = tuple(sorted(kind for kinds in choices for kind in kinds if kind.is_distance))
        if len(distances) == count:
            return Family(named, distances)
    if count != CONSTRAINTS:
        message = f"{count} constraint{'s' * (count != 1)} given, a platform has six"
        if named is not None:
            message += f"; the family form of {named} names its {named.distances} distances"
        elif count < CONSTRAINTS:
            message += "\na family is named by its class and distances, as in 3D3A PL PL LP"
        raise TypeNameError(message)
    _reject_ambiguity(named, choices)
    if named is not None:
        choices = _resolve_by_class(named, choices)
    gsp_type = GspType.of(kinds[0] for kinds in choices)
    if named is not None and gsp_type.platform_class != named:
        raise TypeNameError(f"{gsp_type.id} is of class {gsp_type.platform_class}, not {named}")
    return gsp_type


def _reject_ambiguity(named: PlatformClass | None, choices: list[tuple[Kind, ...]]) -> None:
    if named is None and any(len(kinds) > 1 for kinds in choices):
        names = " or ".join(kind.name for kinds in choices if len(kinds) > 1 for kind in kinds[:2])
        raise TypeNameError(
            f"LL can be {' or '.join(dict.fromkeys(names.split(' or ')))}: "
            "give the leading letter, or the class first"
        )


def _resolve_by_class(
    named: PlatformClass, choices: list[tuple[Kind, ...]]
) -> list[tuple[Kind, ...]]:
    """Choose by the class which of the names ``LL`` are distances and which are angles."""
    missing = named.distances - sum(len(k) == 1 and k[0].is_distance for k in choices)
    resolved = []
    for kinds in choices:
        if len(kinds) > 1:
            wanted = missing > 0
            missing -= wanted
            resolved.append(tuple(kind for kind in kinds if kind.is_distance is wanted))
        else:
            resolved.append(kinds)
    return resolved


def parse_type(text: str | Sequence[str]) -> GspType:
    """Return the type that a name denotes, in any spelling that `parse_name` accepts.

    Raises
    ------
    TypeNameError
        Also if the name denotes a family with its angles left open.
    """
    found = parse_name(text)
    if isinstance(found, Family):
        raise TypeNameError(
            f"{found.id} is a family of {len(found.types)} types: add its "
            f"{found.platform_class.angles} angles ({_names(ANGLE_KINDS)})"
        )
    return found


def any_type(subject: GspType | Family | str | int) -> GspType:
    """Return a type as functions take it: itself, its name or its number.

    A family stands for its first type, all of whose angles are ALL, as for commands to which the
    kinds of the angles make no difference.

    Raises
    ------
    TypeNameError
        If a text is the name of neither.
    """
    found = any_subject(subject)
    return found.types[0] if isinstance(found, Family) else found


def any_subject(subject: GspType | Family | str | int) -> GspType | Family:
    """Return a type or family as functions take it: itself, its name or its number; as above."""
    if isinstance(subject, GspType | Family):
        return subject
    if not isinstance(subject, str | int):
        raise ArgumentError(
            f"found a {type(subject).__name__}, expected a type, its name or its number"
        )
    return parse_name(str(subject))


def parse_kind_set(text: str | Sequence[str]) -> frozenset[Kind]:
    """Return a set of kinds: names, ``A`` for all angles, ``D`` for all distances.

    A name that fits two kinds, ``LL``, means both.

    Raises
    ------
    TypeNameError
        If a name denotes no kind.
    """
    groups = {"A": ANGLE_KINDS, "D": DISTANCE_KINDS}
    return frozenset(
        kind
        for word in _words(text)
        for kind in (groups[word] if word in groups else parse_kinds(word))
    )


#: The type of all of them: six distances of points.
_TYPE = "6DPP"


@dataclass(frozen=True)
class Alias:
    """A name that does not consist of kinds."""

    #: The usual spelling.
    name: str
    #: The type, in a spelling that `parse_name` reads.
    type_name: str
    #: The legs that share a point, in the notation of `parse_sharing`; empty if none do.
    pattern: str
    #: The description.
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
