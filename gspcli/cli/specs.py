"""What words of a command line name: instance files with their values, types, deviations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gspcli.catalogue.names import parse_name
from gspcli.catalogue.types import Family, GspType
from gspcli.cli.render import Output
from gspcli.cli.streams import say
from gspcli.errors import GspError, Mistake, SpecError, TypeNameError
from gspcli.records import dataclass
from gspcli.resources import instance_files, shipped_file
from gspcli.wording import brief, named, nearest, shown

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

_YAML = (".yaml", ".yml")


#: The first character of the name of a shipped instance file where a SPEC is expected.
_SHIPPED = "@"


@dataclass(frozen=True)
class Changes:
    """Changes of the values of an instance, as texts ``I=V``."""

    #: New values.
    values: tuple[str, ...] = ()
    #: Numbers that are added to the values.
    differences: tuple[str, ...] = ()

    @property
    def given(self) -> bool:
        """Whether there are any."""
        return bool(self.values or self.differences)

    def of(self, instance: Instance) -> Instance:
        """Return the instance with these changes."""
        if not self.given:
            return instance
        from gspcli.spec import set_values

        return set_values(set_values(instance, self.values), self.differences, delta=True)


def is_file(word: str) -> bool:
    """Return whether a word on the command line means an instance file, shipped or not."""
    return word == "-" or word.startswith(_SHIPPED) or word.lower().endswith(_YAML)


def spec_source(word: str) -> str | Path:
    """Return where a SPEC is: a path, ``-`` for standard input, a shipped file for ``@NAME``."""
    if word.startswith(_SHIPPED):
        return shipped_file(word[1:])
    if word != "-" and (meant := _meant(word)):
        raise GspError(f"{named(word)}: there is no such file: did you mean {meant}?")
    return word


def _meant(word: str) -> str | None:
    """Return the probably meant name for one of a file that does not exist."""
    path = Path(word)
    try:
        if path.exists():
            return None
        beside = [one.name for one in path.parent.iterdir() if one.suffix.lower() in _YAML]
    except (OSError, ValueError):
        return None
    same = [name for name in beside if Path(name).stem == path.stem]
    near = same[0] if same else None
    if near is None and path.name == word:
        shipped = instance_files()
        stem = path.stem if path.suffix.lower() in _YAML else word
        if stem.lower() in shipped:
            return f"{_SHIPPED}{stem.lower()}"
    near = near or nearest(path.name, beside)
    return None if near is None else str(path.with_name(near))


def load_instance(word: str, changes: Changes | None = None) -> Instance:
    """Read the instance that a SPEC denotes, with other values; see `spec_source`.

    Standard error names probable mistakes (radians in a file of degrees, lengths out of all
    proportion), since the answer would be about another platform.
    """
    from gspcli.spec import read

    refuse_to_replace(word)
    reading = read(spec_source(word))
    if reading.doubts:
        say(brief("\n".join(f"warning: {problem}" for problem in reading.doubts), "warning"))
    return reading.instance if changes is None else changes.of(reading.instance)


def refuse_to_replace(word: str) -> None:
    """Raise if a command would write the file that it reads."""
    context = click.get_current_context(silent=True)
    output = None if context is None else context.params.get("output")
    if not isinstance(output, Output) or output.path is None or output.force or word == "-":
        return
    try:
        same = output.path.exists() and output.path.samefile(word)
    except (OSError, ValueError):
        return
    if same and output.path.is_file():
        raise GspError(
            f"-o {named(output.path)}: it is the file that is read: choose another, or --force"
        )


def read_type(words: Sequence[str]) -> GspType:
    """Return a type, for commands whose answer does not depend on the kinds of the angles.

    Of a family it is the first type: all its angles are ALL.
    """
    named = parse_name(words)
    return named.types[0] if isinstance(named, Family) else named


def read_names(words: Sequence[str]) -> list[GspType | Family]:
    """Return the types that the words of a command line name; of a file its type.

    All words together may be one name (``3D3A PL PL LP``), or each word is a name (``17 6PP
    platform.yaml``).
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


def standard_deviations(texts: Sequence[str]) -> dict[str, float]:
    """Return standard deviations, of ``--sigma WHAT=NUMBER``, by what is measured."""
    from gspcli.motion.files.number_tables import wrong_number

    found: dict[str, float] = {}
    mistakes = []
    for text in texts:
        name, equals, number = text.partition("=")
        message = ""
        if not equals:
            message = f"found {shown(text)}, expected WHAT=NUMBER, as value=0.001"
        elif name in found:
            message = f"found {name} twice"
        else:
            message = wrong_number(number)
        if message:
            mistakes.append(Mistake(None, "--sigma", message))
        else:
            found[name] = float(number)
    if mistakes:
        raise SpecError(mistakes)
    return found
