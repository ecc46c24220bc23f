"""What a command was pointed at: types, families and instance files."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gspcli.catalogue.parsing import parse_name
from gspcli.catalogue.types import Family, GspType
from gspcli.errors import TypeNameError

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

_SUFFIXES = (".yaml", ".yml")


def is_file(word: str) -> bool:
    """Return whether a word on the command line means an instance file; ``-`` is stdin."""
    return word == "-" or word.lower().endswith(_SUFFIXES)


def load_instance(word: str) -> Instance:
    """Read an instance from a file or, for ``-``, from standard input.

    Raises
    ------
    SpecError
        With all mistakes of the file.
    """
    from gspcli.spec import load

    return load(sys.stdin, name="<stdin>") if word == "-" else load(Path(word))


def read_type(words: Sequence[str]) -> GspType:
    """Return a type, for work to which the kinds of the angles make no difference.

    Of a family it is the first type: all its angles are ALL.

    Raises
    ------
    TypeNameError
        If the words denote neither a type nor a family.
    """
    named = parse_name(words)
    return named.types[0] if isinstance(named, Family) else named


def read_names(words: Sequence[str]) -> list[GspType | Family]:
    """Return what the words of a command line name, file contents reduced to their types.

    Together they may spell one name (``3D3A PL PL LP``), or each of them one of its own
    (``17 6PP platform.yaml``).

    Raises
    ------
    TypeNameError
        If they do neither.
    """
    if any(map(is_file, words)):
        return [load_instance(word).type if is_file(word) else parse_name(word) for word in words]
    try:
        return [parse_name(words)]
    except TypeNameError:
        if len(words) == 1:
            raise
        try:
            return [parse_name(word) for word in words]
        except TypeNameError:
            pass
        raise
