"""A reader of files in the ordinary form of YAML; a parser of YAML takes longer to load.

The ordinary form has mappings and lists by indentation, ``{...}`` and ``[...]`` over any number of
lines, comments, and scalars on one line: plain ones, or in quotation marks without escapes. A file
in braces as a whole, as JSON, has it, too.
`any_yaml` reads all other forms and files with mistakes. A file that is read here has the same
content there, with the same places.
"""

from __future__ import annotations

import re
from bisect import bisect_right

from gspcli.errors import Location
from gspcli.spec.document import (
    MAX_BYTES,
    MAX_DEPTH,
    NULLS,
    Mapping,
    Scalar,
    Sequence,
    Value,
    locate,
)

#: Blanks, ends of lines, comments.
_GAP = re.compile(r"(?:[ \n]+|(?<![^ \n])#[^\n]*)*")
_START = r"(?:[^-\s?:,\[\]{}#&*!|>'\"%@`]|-(?=[^-\s?:,\[\]{}#]))"
_QUOTED = r"\"([^\"\\\n]*)\"|'([^'\n]*)'(?!')|"
#: Scalars between brackets, and keys.
_INNER = re.compile(rf"{_QUOTED}({_START}[^\s?:,\[\]{{}}#]*(?: +[^\s?:,\[\]{{}}#]+)*)")
#: Scalars after a key or a dash, to the end of the line.
_OUTER = re.compile(rf"{_QUOTED}({_START}(?:[^\s:#]|:(?=\S)|(?<=\S)#| +(?=[^\s#]))*)")
_LONGEST_KEY = 60


def read_ordinary(text: str, file: str) -> Value | None:
    """Return the located content of a text, or None unless it has the ordinary form."""
    if len(text) > MAX_BYTES:
        return None
    text = text.removeprefix("\ufeff").replace("\r\n", "\n")
    if not text.replace("\n", "").isprintable():
        return None
    if "\n---" in text or "\n..." in text:
        return None
    try:
        return _Reader(text, file).document()
    except _UnusualError:
        return None


class _UnusualError(Exception):
    """A text that is not in the ordinary form."""


class _Reader:
    """Reads from one place of a text to the next.

    Attributes
    ----------
    at
        The place: how many characters are read.
    """

    def __init__(self, text: str, file: str) -> None:
        self.text, self.file, self.at = text, file, 0
        self.lines = [0, *(match.end() for match in re.finditer("\n", text))]

    def document(self) -> Value:
        """Return the content; it begins at the margin."""
        self._gap()
        if self._column():
            raise _UnusualError
        if self._next() == "{":
            content: Value = self._bracket("", 0)
            self._gap()
        else:
            content = self._mapping("", 0)
        if self.at < len(self.text):
            raise _UnusualError
        return content

    def _next(self) -> str:
        return self.text[self.at : self.at + 1]

    def _location(self) -> Location:
        line = bisect_right(self.lines, self.at)
        return Location(self.file, line, self.at - self.lines[line - 1] + 1)

    def _column(self) -> int:
        return self.at - self.text.rfind("\n", 0, self.at) - 1

    def _gap(self) -> bool:
        """Go on to the next token, and return whether it is in another line."""
        match = _GAP.match(self.text, self.at)
        assert match is not None
        self.at = match.end()
        return self.at == len(self.text) or "\n" in match[0]

    def _scalar(self, form: re.Pattern[str], path: str) -> Scalar:
        match = form.match(self.text, self.at)
        if match is None:
            raise _UnusualError
        plain = match[3]
        text = (match[1] or match[2] or "") if plain is None else plain
        scalar = locate(Scalar("" if text in NULLS and plain else text), self._location(), path)
        self.at = match.end()
        return scalar

    def _key(self, path: str, mapping: Mapping) -> Scalar:
        """Read a key and the colon after it."""
        key = self._scalar(_INNER, path)
        after = self.text[self.at : self.at + 2]
        if not 0 < len(key) <= _LONGEST_KEY or key in mapping or after not in (": ", ":\n", ":"):
            raise _UnusualError
        self.at += 1
        key.path = f"{path}.{key}" if path else str(key)
        return key

    def _dash(self) -> bool:
        return self.text[self.at : self.at + 2] in ("- ", "-\n")

    def _mapping(self, path: str, depth: int) -> Mapping:
        """Read the lines of a mapping, from its first key on."""
        _check(depth)
        mapping = locate(Mapping(), self._location(), path)
        margin = self._column()
        while True:
            key = self._key(path, mapping)
            if not self._gap():
                mapping[key] = self._inline(key.path, depth + 1)
            elif self._column() > margin or (self._column() == margin and self._dash()):
                mapping[key] = self._block(key.path, depth + 1)
            else:
                mapping[key] = locate(Scalar(), key.location, key.path)
            if mapping[key] == "":
                mapping[key].location = key.location
            if self._ended(margin) or self._dash():
                return mapping

    def _ended(self, margin: int) -> bool:
        """Whether the entries at a margin are all read."""
        if self.at == len(self.text):
            return True
        column = self._column()
        if column > margin:
            raise _UnusualError
        return column < margin

    def _block(self, path: str, depth: int) -> Value:
        return self._list(path, depth) if self._dash() else self._mapping(path, depth)

    def _list(self, path: str, depth: int) -> Sequence:
        """Read the lines of a list, from its first dash on."""
        _check(depth)
        sequence = locate(Sequence(), self._location(), path)
        margin = self._column()
        while True:
            self.at += 1
            inner = f"{path}[{len(sequence) + 1}]"
            if self._gap():
                raise _UnusualError
            sequence.append(self._item(inner, depth + 1))
            if self._ended(margin) or not self._dash():
                return sequence

    def _item(self, path: str, depth: int) -> Value:
        """Read the value after a dash."""
        match = _INNER.match(self.text, self.at)
        if match is not None and self.text[match.end() : match.end() + 1] == ":":
            return self._mapping(path, depth)
        return self._inline(path, depth)

    def _inline(self, path: str, depth: int) -> Value:
        """Read a value in the line of its key or dash."""
        value = (
            self._bracket(path, depth) if self._next() in ("[", "{") else self._outer(path, depth)
        )
        if not self._gap():
            raise _UnusualError
        return value

    def _outer(self, path: str, depth: int) -> Scalar:
        _check(depth)
        return self._scalar(_OUTER, path)

    def _bracket(self, path: str, depth: int) -> Sequence | Mapping:
        """Read from a bracket to the one that closes it."""
        _check(depth)
        location, begin = self._location(), self._next()
        close = "]" if begin == "[" else "}"
        sequence, mapping = Sequence(), Mapping()
        while True:
            self.at += 1
            self._gap()
            if begin == "[":
                sequence.append(self._inside(f"{path}[{len(sequence) + 1}]", depth + 1))
            else:
                key = self._key(path, mapping)
                self._gap()
                mapping[key] = self._inside(key.path, depth + 1)
                if mapping[key] == "":
                    mapping[key].location = key.location
            self._gap()
            if self._next() != ",":
                break
        if self._next() != close:
            raise _UnusualError
        self.at += 1
        if begin == "[":
            return locate(sequence, location, path)
        return locate(mapping, location, path)

    def _inside(self, path: str, depth: int) -> Value:
        """Read a value between brackets."""
        if self._next() in ("[", "{"):
            return self._bracket(path, depth)
        _check(depth)
        return self._scalar(_INNER, path)


def _check(depth: int) -> None:
    if depth > MAX_DEPTH:
        raise _UnusualError
