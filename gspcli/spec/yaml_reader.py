"""Any YAML text as values with their places in the file, and the mistakes in it.

PyYAML's parser in Python gives better messages and places than the one in C.
"""

from __future__ import annotations

from collections.abc import Iterator

import yaml
from yaml.error import MarkedYAMLError, YAMLError
from yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
)
from yaml.reader import ReaderError

from gspcli.errors import Location, Mistake, SpecError
from gspcli.spec.document import (
    MAX_BYTES,
    MAX_DEPTH,
    NULLS,
    Mapping,
    Missing,
    Scalar,
    Sequence,
    Value,
    locate,
)
from gspcli.wording import shown

_HINTS = {
    "'\\t' that cannot start": "indent with blanks, not with tabs",
    "mapping values are not allowed": "check the indentation, and quote texts with a :",
    "<block end>": "check the indentation, the blank after each :, and quotation marks",
    "',' or": "check the brackets and commas here and in the line above",
    "could not find expected ':'": "write a : and a blank after a key",
    "end of stream": "a quotation mark is not closed",
    "<stream end>": "a bracket is not closed",
    "cannot start any token": "put the text between quotation marks",
}


def parse(text: str, file: str, mistakes: list[Mistake]) -> Value:
    """Return the located content of a YAML text with one document.

    Mistakes that do not stop the reading are added to `mistakes`.

    Raises
    ------
    SpecError
        With all mistakes so far, if the text is not YAML, too large or has no content.
    """
    if len(text) > MAX_BYTES:
        message = f"found {len(text)} characters, expected an instance of at most {MAX_BYTES}"
        raise SpecError([Mistake(Location(file, 1, 1), "", message)])
    builder = _Builder(text.removeprefix("\ufeff"), file, mistakes)
    try:
        return builder.document()
    except ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        column = error.position - text.rfind("\n", 0, error.position)
        message = f"found the character U+{ord(text[error.position]):04X}, expected printable text"
        raise SpecError([*mistakes, Mistake(Location(file, line, column), "", message)]) from error
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        location = Location(file, mark.line + 1, mark.column + 1) if mark else None
        mistake = " ".join(str(error.problem or error.context).split())
        hint = next((f": {hint}" for key, hint in _HINTS.items() if key in mistake), "")
        message = f"not valid YAML: {mistake}{hint}"
        raise SpecError([*mistakes, Mistake(location, "", message)]) from error
    except (YAMLError, ValueError, OverflowError) as error:
        # PyYAML lets an escape such as "\UFFFFFFFF" fail inside `chr`, without its place.
        message = (
            "not valid YAML: found a backslash escape after this place that denotes no character"
        )
        raise SpecError([*mistakes, Mistake(builder.place, "", message)]) from error


class _Builder:
    """Builds located values from the events of the YAML parser."""

    def __init__(self, text: str, file: str, mistakes: list[Mistake]) -> None:
        self.events: Iterator[Event] = yaml.parse(text, Loader=yaml.SafeLoader)
        self.file = file
        self.place = Location(file, 1, 1)
        self.mistakes = mistakes

    def _location(self, event: Event) -> Location:
        self.place = Location(self.file, event.start_mark.line + 1, event.start_mark.column + 1)
        return self.place

    def _note(self, location: Location, path: str, message: str) -> None:
        self.mistakes.append(Mistake(location, path, message))

    def document(self) -> Value:
        next(self.events)
        event = next(self.events)
        if not isinstance(event, DocumentStartEvent):
            self._note(Location(self.file, 1, 1), "", "found nothing, expected an instance")
            raise SpecError(self.mistakes)
        root = self._value(next(self.events), "", 0)
        next(self.events)
        end = next(self.events)
        if not isinstance(end, StreamEndEvent):
            self._note(self._location(end), "", "found a second document, expected one a file")
        return root

    def _value(self, event: Event, path: str, depth: int) -> Value:
        location = self._location(event)
        if depth > MAX_DEPTH:
            self._note(location, path, f"found more than {MAX_DEPTH} levels of nesting")
            raise SpecError(self.mistakes)
        if isinstance(event, AliasEvent):
            message = "found an alias (*), expected the value itself: aliases are not supported"
            self._note(location, path, message)
            return locate(Missing(), location, path)
        assert isinstance(event, ScalarEvent | SequenceStartEvent | MappingStartEvent)
        if event.tag is not None:
            self._note(location, path, f"found the tag {shown(str(event.tag))}, expected none")
        if isinstance(event, ScalarEvent):
            plain = event.implicit[0]
            text = "" if plain and event.value in NULLS else event.value
            return locate(Scalar(text), location, path)
        if isinstance(event, SequenceStartEvent):
            return locate(self._sequence(path, depth), location, path)
        return locate(self._mapping(path, depth), location, path)

    def _sequence(self, path: str, depth: int) -> Sequence:
        sequence = Sequence()
        while not isinstance(event := next(self.events), SequenceEndEvent):
            sequence.append(self._value(event, f"{path}[{len(sequence) + 1}]", depth + 1))
        return sequence

    def _mapping(self, path: str, depth: int) -> Mapping:
        mapping = Mapping()
        places: dict[str, Location] = {}
        while not isinstance(event := next(self.events), MappingEndEvent):
            key = self._value(event, path, depth + 1)
            name = key if isinstance(key, Scalar) else Scalar()
            inner = f"{path}.{name}" if path else str(name)
            if not name.isprintable() or len(name) > 60:
                inner = f"{path}[…]"
            value = self._value(next(self.events), inner, depth + 1)
            if value == "":
                # The parser gives an absent value the place of the next token.
                value.location = key.location
            if isinstance(key, Missing):
                continue
            if not name:
                self._note(key.location, path, "found no plain word as a key, expected one")
            elif name in mapping:
                first = places[name]
                message = f"found {shown(name)} twice, first in line {first.line}"
                self._note(key.location, inner, message)
            else:
                places[name] = key.location
                mapping[locate(name, key.location, inner)] = value
        return mapping
