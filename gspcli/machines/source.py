"""Files of machines as text of limited size, with the places of mistakes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import Location, Mistake, SpecError
from gspcli.spec.document import content_of
from gspcli.wording import named, shown

Array = NDArray[np.float64]

#: Bytes of a file that is read.
LARGEST = 1 << 23
#: Lengths, angles and masses are smaller.
LARGEST_NUMBER = 1e15
_DECIMAL = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")


class SourceLine:
    """A line of a file, for errors.

    Parameters
    ----------
    file
        The name of the file.
    line, column
        From 1.
    what
        The part of the file that a message is about, such as ``joint 'slide_1'``.
    """

    def __init__(self, file: str, line: int = 1, column: int = 1, what: str = "") -> None:
        self.location = Location(file, line, column)
        self.what = what

    def error(self, message: str) -> SpecError:
        """Return an error with this place."""
        return SpecError([Mistake(self.location, self.what, message)])

    def number(self, text: str) -> float:
        """Return a decimal number.

        Raises
        ------
        SpecError
            If it is no number, or too large.
        """
        if not _DECIMAL.fullmatch(text.strip()):
            raise self.error(f"found {shown(text)}, expected a number")
        value = float(text)
        if not abs(value) < LARGEST_NUMBER:
            raise self.error(f"found {shown(text)}, expected a number below {LARGEST_NUMBER:g}")
        return value

    def numbers(self, text: str, count: int) -> Array:
        """Return the given number of numbers, which are separated by blanks.

        Raises
        ------
        SpecError
            If there are more or fewer.
        """
        words = text.split()
        if len(words) != count:
            raise self.error(f"found {shown(text)}, expected {count} numbers")
        return np.array([self.number(word) for word in words])

    def limit(self, text: str | None, otherwise: float) -> float:
        """Return an end of a range, `otherwise` if it is not given; of 1e15 on it is infinite."""
        if text is None or not text.strip():
            return otherwise
        word = text.strip().lower()
        if word.lstrip("+-") in ("inf", "infinity"):
            return -math.inf if word.startswith("-") else math.inf
        if not _DECIMAL.fullmatch(word):
            raise self.error(f"found {shown(text)}, expected a number")
        value = float(word)
        return value if abs(value) < LARGEST_NUMBER else math.copysign(math.inf, value)


def text_of(path: Path) -> str:
    """Return the text of a file.

    Raises
    ------
    OSError
        If it cannot be read.
    SpecError
        If it is too large, or no text.
    """
    place = SourceLine(str(path))
    try:
        content = content_of(path, LARGEST)
    except ValueError as error:
        raise place.error(str(error)) from None
    for encoding in ("utf-16", "utf-32") if content[:2] in (b"\xff\xfe", b"\xfe\xff") else ():
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in content:
            raise place.error(f"{named(path.name)} is no text") from None
        # Comments in the encoding of Western Europe are common, and every byte is a letter there.
        return content.decode("latin-1")


# XML as a tree whose elements have their line numbers. No other file is opened.
#
# Documents cannot define entities: a DOCTYPE may name a file, which is not read, and may hold no
# definitions of its own.


#: Elements of a document, and how deep they are nested, at most.
MOST_ELEMENTS, DEEPEST = 100_000, 100


class MarkupElement(SourceLine):
    """An element.

    Attributes
    ----------
    tag
        Its name.
    attributes
        Their texts by their names.
    text
        What stands before its first child.
    children
        The elements in it.
    """

    def __init__(
        self, tag: str, attributes: dict[str, str], file: str = "", at: tuple[int, int] = (1, 1)
    ) -> None:
        name = attributes.get("name", "")
        super().__init__(file, *at, f"<{tag}>{f' {shown(name)}' if name else ''}")
        self.tag, self.attributes = tag, attributes
        self.text = ""
        self.children: list[MarkupElement] = []

    def get(self, name: str, otherwise: str = "") -> str:
        """Return an attribute."""
        return self.attributes.get(name, otherwise)

    def needed(self, name: str) -> str:
        """Return an attribute that must be there.

        Raises
        ------
        SpecError
            If it is not.
        """
        if name not in self.attributes:
            raise self.error(f"found no attribute {name}, expected one")
        return self.attributes[name]

    def all(self, tag: str) -> list[MarkupElement]:
        """Return the children of a name."""
        return [child for child in self.children if child.tag == tag]

    def first(self, path: str) -> MarkupElement | None:
        """Return the first child of a name, or of a path such as ``limit/lower``."""
        found: MarkupElement | None = self
        for tag in path.split("/"):
            found = next((c for c in found.children if c.tag == tag), None) if found else None
        return found

    def child(self, tag: str) -> MarkupElement:
        """Return the first child of a name, which must be there.

        Raises
        ------
        SpecError
            If it is not.
        """
        found = self.first(tag)
        if found is None:
            raise self.error(f"found no <{tag}>, expected one")
        return found

    def said(self, path: str) -> str | None:
        """Return the text of `first`, without blanks around it; None if there is none."""
        found = self.first(path)
        return None if found is None else found.text.strip()

    def everywhere(self, *tags: str) -> Iterator[MarkupElement]:
        """Yield the elements of some names, in it and below, or all of them."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            if not tags or element.tag in tags:
                yield element
            waiting.extend(reversed(element.children))

    def decimal(self, path: str, otherwise: float = 0.0) -> float:
        """Return the text of `first` as a number."""
        found = self.first(path)
        return otherwise if found is None else found.number(found.text)

    def attribute_numbers(self, name: str, otherwise: tuple[float, ...]) -> Array:
        """Return the numbers of an attribute, as many as there are in `otherwise`."""
        if name not in self.attributes:
            return np.array(otherwise)
        return self.numbers(self.attributes[name], len(otherwise))


def parse(text: str, file: str) -> MarkupElement:
    """Return the root of a document.

    Raises
    ------
    SpecError
        If it is not well-formed, too large, or defines entities.
    """
    return _Tree(text.strip(), file, text[: len(text) - len(text.lstrip())].count("\n")).root()


class _Tree:
    def __init__(self, text: str, file: str, above: int) -> None:
        self.text, self.file, self.above = text, file, above
        self.open: list[MarkupElement] = []
        self.count = 0
        self.top: MarkupElement | None = None
        self.parser = parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._data
        parser.StartDoctypeDeclHandler = self._doctype
        parser.EntityDeclHandler = self._entity

    def root(self) -> MarkupElement:
        try:
            self.parser.Parse(self.text, True)
        except expat.ExpatError as error:
            place = SourceLine(self.file, error.lineno + self.above, error.offset + 1)
            said = expat.ErrorString(error.code) or "unknown"
            raise place.error(f"no well-formed XML: {said}") from None
        except (UnicodeError, ValueError) as error:
            raise SourceLine(self.file).error(f"no well-formed XML: {error}") from None
        assert self.top is not None
        return self.top

    def _at(self) -> tuple[int, int]:
        return self.parser.CurrentLineNumber + self.above, self.parser.CurrentColumnNumber + 1

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = MarkupElement(tag, attributes, self.file, self._at())
        self.count += 1
        if self.count > MOST_ELEMENTS or len(self.open) >= DEEPEST:
            limit = f"{MOST_ELEMENTS} elements, {DEEPEST} levels deep"
            raise element.error(f"found more, expected at most {limit}")
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.top = element
        self.open.append(element)

    def _end(self, tag: str) -> None:
        del tag
        self.open.pop()

    def _data(self, text: str) -> None:
        if self.open and not self.open[-1].children:
            self.open[-1].text += text

    def _doctype(self, name: str, system: str | None, public: str | None, inner: int) -> None:
        del name, system, public
        if inner:
            raise SourceLine(self.file, *self._at()).error(_NO_ENTITIES)

    def _entity(self, *_: object) -> None:
        raise SourceLine(self.file, *self._at()).error(_NO_ENTITIES)


_NO_ENTITIES = "found definitions in a DOCTYPE, expected none: entities are not read"


def written(root: MarkupElement) -> str:
    """Return an element as XML, attributes and children only."""
    attributes = "".join(f" {name}={quoteattr(x)}" for name, x in root.attributes.items())
    inner = "".join(map(written, root.children))
    return f"<{root.tag}{attributes}>{inner}</{root.tag}>"
