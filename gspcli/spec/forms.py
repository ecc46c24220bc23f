"""What a section, list or word of an instance file can be: reads it, and gives its JSON Schema.

A wrong part does not hide the mistakes in others: each is noted with its place, and the part is
None if the form tolerates that, else so is what contains it.
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NamedTuple

from gspcli.errors import GspError, Mistake
from gspcli.geometry.numbers import Number, parse_number
from gspcli.spec.document import Mapping, Missing, Scalar, Sequence, Value, locate
from gspcli.wording import listed, nearest, shortened, shown, suggestion

FORMAT_VERSION = 1
MAX_TEXT = 1000
MAX_NAME = 60


def described(value: Value) -> str:
    """Return the content of the file in the words of an error message."""
    if isinstance(value, Mapping):
        if not value:
            return "an empty mapping"
        return f"a mapping with {shortened(listed(value, 'and'))}"
    if isinstance(value, Sequence):
        return f"a list of {len(value)}"
    return shown(value) if value else "nothing"


def complain(value: Value, expected: str) -> ValueError:
    """Return the error of an unexpected value."""
    return ValueError(f"found {described(value)}, expected {expected}")


def scalar(value: Value, expected: str) -> str:
    """Return a scalar that is not empty."""
    if not isinstance(value, Scalar) or not value:
        raise complain(value, expected)
    return str(value)


def text(value: Value) -> str:
    """Return a text for people."""
    given = scalar(value, "a text")
    if len(given) > MAX_TEXT:
        message = f"found {len(given)} characters, expected at most {MAX_TEXT}"
        raise ValueError(message)
    if not all(character.isprintable() or character in " \t\n" for character in given):
        raise complain(value, "a printable text")
    return given


def optional_text(value: Value) -> str | None:
    """Return a text for people, or None."""
    return None if value == "" else text(value)


def number(value: Value) -> Number:
    """Return an exact number."""
    return parse_number(scalar(value, "a number or an expression like sqrt(3)/2"))


def number_or_home(value: Value) -> Number | None:
    """Return an exact number, or None for the word ``home``."""
    return None if value == "home" else number(value)


def version(value: Value) -> int:
    """Return the version of the file format."""
    if value != str(FORMAT_VERSION):
        raise complain(value, f"{FORMAT_VERSION}, the version of the file format")
    return FORMAT_VERSION


def nonzero(components: list[Number]) -> list[Number]:
    """Return a vector that is not zero."""
    if all(x.fraction == 0 for x in components):
        message = "found the zero vector, expected a direction: any nonzero vector"
        raise ValueError(message)
    return components


def turning(components: list[Number]) -> list[Number]:
    """Return a quaternion that is not zero."""
    if all(x.fraction == 0 for x in components):
        message = "found zero, expected a quaternion [w, x, y, z]: any but zero"
        raise ValueError(message)
    return components


def axes(value: Value) -> str:
    """Return the order of the axes of three angles, which a maker's name may stand for."""
    from gspcli.geometry.euler import named_order

    try:
        return named_order(scalar(value, "an order of axes such as ZYX"))
    except GspError as error:
        raise ValueError(str(error)) from None


def name(value: Value) -> str:
    """Return the name of a primitive."""
    return scalar(value, "the name of a primitive")


def proper_name(key: str) -> bool:
    """Whether a primitive may have this name."""
    return len(key) <= MAX_NAME and not any(c.isspace() or not c.isprintable() for c in key)


#: What a part is that cannot be read; its mistake is noted already.
WRONG: Any = object()
Schema = dict[str, Any]


class Form:
    """What a value can be."""

    def _parse(self, value: Value, note: list[Mistake]) -> Any:
        """Return what a value means, or raise a `ValueError` about it."""
        raise NotImplementedError

    def read(self, value: Value, note: list[Mistake]) -> Any:
        """Return what a value means; `WRONG`, with its mistakes noted, if that is nothing."""
        if isinstance(value, Missing):
            return WRONG
        try:
            return self._parse(value, note)
        except ValueError as error:
            note.append(Mistake(value.location, value.path, str(error)))
            return WRONG

    def schema(self, sections: Schema) -> Schema:
        """Return the JSON Schema; `sections` takes those that have names."""
        raise NotImplementedError


class Word(Form):
    """A text, number or name, converted by a function."""

    def __init__(self, convert: Callable[[Value], Any], **schema: Any) -> None:
        self.convert, self._schema = convert, schema

    def _parse(self, value: Value, note: list[Mistake]) -> Any:
        del note
        return self.convert(value)

    def schema(self, sections: Schema) -> Schema:
        """As `Form.schema`."""
        del sections
        return self._schema


def choice(*words: str) -> Word:
    """Return the form of one of some words."""

    def convert(value: Value) -> str:
        if value not in words:
            near = suggestion(value, words) if isinstance(value, Scalar) else ""
            raise ValueError(f"found {described(value)}, expected {listed(words)}{near}")
        return str(value)

    return Word(convert, enum=[*words], type="string")


class List(Form):
    """A list; with `alone` one entry without brackets is a list, too."""

    def __init__(
        self,
        item: Form,
        expected: str = "",
        length: int | None = None,
        *,
        check: Callable[[Any], Any] = lambda entries: entries,
        tolerant: bool = False,
        alone: bool = False,
        least: int = 0,
        **schema: Any,
    ) -> None:
        self.item, self.expected, self.length, self.check = item, expected, length, check
        self.tolerant, self.alone, self.least, self._schema = tolerant, alone, least, schema

    def _parse(self, value: Value, note: list[Mistake]) -> Any:
        if self.alone and not isinstance(value, Sequence):
            value = locate(Sequence([value]), value.location, value.path)
        if not isinstance(value, Sequence):
            raise complain(value, self.expected)
        if self.length not in (None, len(value)):
            said = "1 entry" if len(value) == 1 else f"{len(value)} entries"
            raise ValueError(f"found {said}, expected {self.expected}")
        if len(value) < self.least:
            raise ValueError(f"found no point, expected {self.expected}")
        entries = [self.item.read(entry, note) for entry in value]
        if self.tolerant:
            return [None if entry is WRONG else entry for entry in entries]
        return WRONG if WRONG in entries else self.check(entries)

    def schema(self, sections: Schema) -> Schema:
        """As `Form.schema`."""
        ends = {"minItems": self.length or self.least, "maxItems": self.length}
        items = self.item.schema(sections)
        several = {"items": items, "type": "array", **self._schema}
        several |= {key: number for key, number in ends.items() if number}
        return {"anyOf": [items, several]} if self.alone else several


class Names(Form):
    """A mapping of names that are free to things of one form."""

    def __init__(self, item: Form) -> None:
        self.item = item

    def _parse(self, value: Value, note: list[Mistake]) -> Any:
        if not isinstance(value, Mapping):
            raise complain(value, "a mapping of names to primitives")
        entries = {}
        for name, entry in value.items():
            if not proper_name(name):
                told = f"at most {MAX_NAME} characters, no blanks"
                message = f"found the name {shown(name)}, expected {told}"
                note.append(Mistake(name.location, name.path, message))
            one = self.item.read(entry, note)
            entries[str(name)] = None if one is WRONG else one
        return entries

    def schema(self, sections: Schema) -> Schema:
        """As `Form.schema`."""
        return {
            "additionalProperties": self.item.schema(sections),
            "propertyNames": {"pattern": rf"^\S{{1,{MAX_NAME}}}$"},
            "type": "object",
        }


class Entry(NamedTuple):
    """What a key of a section means."""

    form: Form
    meaning: str = ""
    needed: bool = False
    more: Schema = {}  # noqa: RUF012


class Section(Form):
    """A mapping with known keys.

    Parameters
    ----------
    title, meaning
        What the schema calls it.
    one_of
        Keys of which exactly one must be given.
    needs
        Keys that need another key.
    excludes
        Pairs of keys of which at most one is given.
    tolerant
        Whether a wrong entry is None; else a wrong entry makes the section wrong.
    entries
        What its keys mean; `with_` is the key ``with``, and `partner` the attribute.
    """

    def __init__(
        self,
        title: str,
        meaning: str,
        one_of: tuple[str, ...] = (),
        needs: dict[str, str] | None = None,
        excludes: tuple[tuple[str, str], ...] = (),
        *,
        tolerant: bool = False,
        **entries: Any,
    ) -> None:
        self.title, self.meaning, self.one_of, self.excludes = title, meaning, one_of, excludes
        self.needs, self.tolerant = needs or {}, tolerant
        self.entries = {name.rstrip("_"): entry for name, entry in entries.items()}

    def _parse(self, value: Value, note: list[Mistake]) -> Any:
        if not isinstance(value, Mapping):
            keys = listed(self.one_of) if self.one_of else listed(self.entries, "and")
            raise complain(value, f"a mapping with {keys}")
        self._check_keys(value, note)
        found: dict[str, Any] = dict.fromkeys(self.entries)
        wrong = False
        for name, entry in self.entries.items():
            if (given := value.get(Scalar(name))) is not None:
                found[name] = entry.form.read(given, note)
            elif entry.needed:
                found[name] = WRONG
            if found[name] is WRONG:
                wrong, found[name] = True, None
        if wrong and not self.tolerant:
            return WRONG
        found["partner"] = found.get("with")
        return SimpleNamespace(**found)

    def _check_keys(self, section: Mapping, note: list[Mistake]) -> None:
        """Note unknown and missing keys, and those that exclude or need each other."""

        def say(place: Value, message: str) -> None:
            note.append(Mistake(place.location, place.path, message))

        known, misspelt = [*self.entries], set()
        for key in section:
            if key not in known:
                near = nearest(key, [name for name in known if name not in section])
                misspelt.add(near)
                hint = f": did you mean {near}?" if near else ""
                if key.isdecimal():
                    hint = ": write decimals with a point"
                say(key, f"found the unknown key {shown(key)}, expected {listed(known)}{hint}")
        unnamed = [
            name
            for name, entry in self.entries.items()
            if entry.needed and name not in section and name not in misspelt
        ]
        if unnamed:
            words = "key {} is" if len(unnamed) == 1 else "keys {} are"
            say(section, f"the {words.format(listed(unnamed, 'and'))} missing")
        given = [name for name in self.one_of if name in section]
        if len(given) > 1 or (self.one_of and not given and not misspelt & {*self.one_of}):
            what = listed(given, "and") if given else "none of them"
            say(section, f"found {what}, expected exactly one of {listed(self.one_of)}")
        for needy, other in self.needs.items():
            if needy in section and other not in section and (given or not self.one_of):
                message = f"found {needy} without {other}, expected both"
                if given:
                    message = f"found {needy} at a {given[0]}, expected it only at a {other}"
                say(section[Scalar(needy)], message)
        for one, other in self.excludes:
            if one in section and other in section:
                message = f"found {one} beside {other}, expected one of them"
                say(section[Scalar(one)], message)

    def schema(self, sections: Schema) -> Schema:
        """As `Form.schema`."""
        if self.title not in sections:
            sections[self.title] = {}
            sections[self.title] |= self.body(sections)
        return {"$ref": f"#/$defs/{self.title}"}

    def body(self, sections: Schema) -> Schema:
        """Return the schema itself, not a reference to it."""
        properties = {
            name: entry.form.schema(sections)
            | ({"description": entry.meaning} if entry.meaning else {})
            | entry.more
            for name, entry in self.entries.items()
        }
        refused = [{"required": list(pair)} for pair in self.excludes]
        keys = {
            "required": [name for name, entry in self.entries.items() if entry.needed],
            "oneOf": [{"required": [key]} for key in self.one_of],
            "dependentRequired": {key: [other] for key, other in self.needs.items()},
            "not": {"anyOf": refused} if len(refused) > 1 else refused[0] if refused else None,
        }
        return {
            "additionalProperties": False,
            "description": self.meaning,
            "properties": properties,
            "title": self.title,
            "type": "object",
            **{key: value for key, value in keys.items() if value},
        }
