"""Reading of a file to an `Instance`, or to all mistakes in the file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import BinaryIO, TextIO

from gspcli.errors import ArgumentError, Mistake, SpecError
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.records import dataclass
from gspcli.resources import shipped_file
from gspcli.spec.document import LARGEST_SPEC, Mapping, Scalar, Value, content_of, decode
from gspcli.spec.form_of_instance import INSTANCE
from gspcli.spec.instance_checks import FileChecker
from gspcli.spec.meaning import out_of_proportion
from gspcli.wording import named

#: A function of an angle in radians, with a plain number that is not zero.
_OF_RADIANS = re.compile(r"\b(sin|cos|tan)\(\s*[-+]?\s*((?=[\d.]*[1-9])[\d.]+)\s*\)")


@dataclass(frozen=True)
class Reading:
    """The content of a file."""

    #: The instance.
    instance: Instance
    _reader: FileChecker

    @cached_property
    def warnings(self) -> tuple[Mistake, ...]:
        """Remarks about unusual content: unused primitives, values with more equations."""
        found = [*self.doubts, *self._reader.warnings(self.instance)]
        return tuple(sorted(found, key=_place))

    @cached_property
    def doubts(self) -> tuple[Mistake, ...]:
        """The warnings about numbers that probably describe another platform than intended.

        They are functions of plain numbers, which are radians, in a file of degrees, and lengths
        out of all proportion.
        """
        root = self._reader.root
        found = []
        if self.instance.units.angle is AngleUnit.DEGREE:
            found += [
                Mistake(text.location, text.path, _radians_message(match))
                for text in _scalars(root)
                if (match := _OF_RADIANS.search(text))
            ]
        if message := out_of_proportion(self.instance):
            found.append(Mistake(root.location, "", message))
        return tuple(found)


def read(
    source: str | Path | TextIO | BinaryIO, *, name: str | None = None, any_number: bool = False
) -> Reading:
    """Read an instance file, with warnings about unusual content.

    Parameters
    ----------
    source
        A path, ``-`` for standard input, or an open file.
    name
        The name of the source in error messages; by default its path.
    any_number
        Whether there may be fewer or more constraints than six (`gspcli.freedoms`).

    Raises
    ------
    SpecError
        With all mistakes in the file, or because it cannot be read.
    ArgumentError
        If the source is neither a path nor an open file.
    """
    content: str | bytes
    if isinstance(source, str | Path):
        name = name or ("standard input" if str(source) == "-" else str(source))
        try:
            content = content_of(source, LARGEST_SPEC)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            message = f"{named(name)}: cannot be read: {reason}"
            raise SpecError([Mistake(None, "", message)]) from error
    else:
        if not hasattr(source, "read"):
            message = f"found a {type(source).__name__}, expected a path or an open file"
            raise ArgumentError(message, "source")
        name = name or str(getattr(source, "name", "input"))
        try:
            content = source.read()
        except UnicodeDecodeError as error:
            message = f"{name}: found {error.reason}, expected text in UTF-8"
            raise SpecError([Mistake(None, "", message)]) from error
        except OSError as error:
            message = f"{name}: cannot be read: {error.strerror or error}"
            raise SpecError([Mistake(None, "", message)]) from error
    text = decode(content, name) if isinstance(content, bytes) else content
    return read_text(text, name=name, any_number=any_number)


def read_text(text: str, *, name: str = "instance", any_number: bool = False) -> Reading:
    """Read the text of an instance file; as `read`."""
    if not isinstance(text, str):
        message = f"found a {type(text).__name__}, expected the text of an instance file"
        raise ArgumentError(message, "text")
    from gspcli.spec.yaml_reader import parse

    mistakes: list[Mistake] = []
    return _reading(parse(text, name, mistakes), mistakes, any_number=any_number)


def _reading(root: Value, mistakes: list[Mistake], *, any_number: bool) -> Reading:
    """Return the content of a document.

    Raises
    ------
    SpecError
        With all mistakes in it, and the earlier ones.
    """
    if not isinstance(root, Mapping):
        message = "found no keys, expected an instance: gsp, units, platform, base, constraints"
        raise SpecError([*mistakes, Mistake(root.location, "", message)])
    model = INSTANCE.read(root, mistakes)
    reader = FileChecker(root, model, mistakes, any_number=any_number)
    instance = reader.instance()
    if instance is None or mistakes:
        raise SpecError(sorted(mistakes, key=_place))
    return Reading(instance, reader)


def load(source: str | Path | TextIO | BinaryIO, *, name: str | None = None) -> Instance:
    """Return the instance in a file; as `read`, without the warnings."""
    return read(source, name=name).instance


def loads(text: str, *, name: str = "instance") -> Instance:
    """Return the instance in the text of a file; as `read`, without the warnings."""
    return read_text(text, name=name).instance


def _scalars(value: Value) -> Iterator[Scalar]:
    """Yield all texts of a document that are values."""
    if isinstance(value, Scalar):
        yield value
    else:
        for part in value.values() if isinstance(value, Mapping) else value:
            yield from _scalars(part)


def _radians_message(match: re.Match[str]) -> str:
    name, number = match[1], match[2]
    return f"{match[0]} is of {number} radians: for degrees write {name}d({number})"


def _place(mistake: Mistake) -> tuple[int, int]:
    location = mistake.location
    return (location.line, location.column) if location else (0, 0)


def example(name: str) -> Instance:
    """Return an instance that is part of gsp: an example, or a real machine.

    Parameters
    ----------
    name
        A name in the list of `gsp example`, with or without the ``@`` of the command line.

    Raises
    ------
    GspError
        If there is no instance with that name.

    Examples
    --------
    >>> example("rubin-m2").type.number
    3389
    """
    return load(shipped_file(name.removeprefix("@")))
