"""CuikSuite: worlds of two links with legs, rods and balls between them, numbers as written."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gspcli.machines.arithmetic import value_of
from gspcli.machines.frames import frame
from gspcli.machines.graph import Graph, Joint, NoPlatform, ball
from gspcli.machines.readers.legs import RowLeg, legs_graph
from gspcli.machines.source import SourceLine
from gspcli.records import dataclass
from gspcli.wording import counted, shown

Array = NDArray[np.float64]

#: A word, a symbol, or a comment; expressions between brackets are put together afterwards.
_TOKEN = re.compile(
    r"\s+|%[^\n]*|/\*.*?\*/|:=|[A-Za-z_]\w*|[0-9.]+(?:[eE][-+]?[0-9]+)?|.", re.DOTALL
)
#: Characters of an expression with its constants at most.
_LONGEST = 2000
_ATTRIBUTES = {"length", "range", "radius", "color", "hidden", "decoration"}
_READ = {"sph_sph", "sph_prs_sph", "spherical"}
_JOINTS = _READ | {"revolute", "prismatic", "universal", "fix", "free", "in_patch", "crevolute"}


@dataclass(frozen=True)
class _Token:
    text: str
    line: int


@dataclass(frozen=True, eq=False)
class _Entry:
    """A joint: its kind, its links, their first points, and what follows."""

    kind: str
    name: str
    links: tuple[str, str]
    points: tuple[list[str], list[str]]
    rest: dict[str, list[str]]
    line: int


def is_world(text: str) -> bool:
    """Return whether a text has the sections of a world."""
    return "[LINKS]" in text and "[JOINTS]" in text


def read(text: str, file: str, name: str) -> Graph:
    """Return the graph of a world.

    Parameters
    ----------
    text
        The file.
    file, name
        Its name, and what the machine is called.

    Raises
    ------
    SpecError
        With the line of what is wrong.
    NoPlatform
        If there are joints that are not read, or more links than two.
    """
    return _World(text, file).graph(name)


class _World:
    def __init__(self, text: str, file: str) -> None:
        self.file = file
        tokens, line = [], 1
        for match in _TOKEN.finditer(text):
            word = match[0]
            if not word.isspace() and word[0] != "%" and not word.startswith("/*"):
                tokens.append(_Token(word, line))
            line += word.count("\n")
        self.sections = self._sections(tokens)
        self.constants = self._constants()

    def _sections(self, tokens: list[_Token]) -> dict[str, list[_Token]]:
        sections: dict[str, list[_Token]] = {}
        current: list[_Token] = []
        position = 0
        while position < len(tokens):
            word = tokens[position].text
            names = [t.text for t in tokens[position + 1 : position + 4]]
            if word == "[" and "]" in names and names[0].isupper() and len(names[0]) > 2:
                end = names.index("]")
                current = sections.setdefault(" ".join(names[:end]), [])
                position += end + 2
                continue
            current.append(tokens[position])
            position += 1
        return sections

    def _constants(self) -> dict[str, str]:
        """Return the constants, each as an expression of numbers."""
        tokens = self.sections.get("CONSTANTS", [])
        places = [k for k, token in enumerate(tokens) if token.text == ":=" and k > 0]
        found: dict[str, str] = {}
        ends = [*(place - 1 for place in places[1:]), len(tokens)]
        for k, end in zip(places, ends, strict=False):
            found[tokens[k - 1].text] = self.full([t.text for t in tokens[k + 1 : end]], found)
        return found

    def full(self, words: list[str], constants: Mapping[str, str] | None = None) -> str:
        """Return an expression with constants replaced by what they are."""
        known = self.constants if constants is None else constants
        text = "".join(
            f"({known[word]})" if word in known and words[k + 1 : k + 2] != ["("] else word
            for k, word in enumerate(words)
        )
        if len(text) > _LONGEST:
            raise SourceLine(self.file).error(f"found an expression of {len(text)} characters")
        # A number needs no brackets, but as the argument of a function.
        return re.sub(r"(?<!\w)\((-?[0-9.]+)\)", r"\1", text).replace("--", "+")

    def value(self, words: list[str], line: int) -> float:
        try:
            return value_of(self.full(words), {})
        except ValueError as error:
            said = shown(" ".join(words))
            raise SourceLine(self.file, line).error(f"found {said}: {error}") from None

    def _entries(self) -> list[_Entry]:
        tokens = self.sections.get("JOINTS", [])
        starts = [
            k
            for k, token in enumerate(tokens)
            if token.text.lower() in _JOINTS and ":" in [t.text for t in tokens[k + 1 : k + 3]]
        ]
        found = []
        for start, end in zip(starts, [*starts[1:], len(tokens)], strict=True):
            found.append(self._entry(tokens[start:end]))
        return found

    def _entry(self, tokens: list[_Token]) -> _Entry:
        place = SourceLine(self.file, tokens[0].line)
        words = [token.text for token in tokens]
        colon = words.index(":")
        position = colon + 1
        links, points = [], []
        for _ in range(2):
            if position + 1 >= len(words) or words[position + 1] != "(":
                found = " ".join(words[position : position + 2])
                raise place.error(f"found {shown(found)}, expected a link and a point (x, y, z)")
            links.append(words[position])
            position, first = _bracket(words, position + 1, place)
            points.append(first)
            while words[position : position + 1] == ["("]:
                position, _ = _bracket(words, position, place)
        rest: dict[str, list[str]] = {}
        for k, word in enumerate(words[position:], position):
            if word in ("length", "range"):
                after = range(k + 1, len(words))
                stop = next((j for j in after if words[j] in _ATTRIBUTES), len(words))
                rest[word] = words[k + 1 : stop]
        name = "".join(words[1:colon])
        return _Entry(words[0].lower(), name, (links[0], links[1]), (points[0], points[1]), rest,
                      tokens[0].line)  # fmt: skip

    def graph(self, name: str) -> Graph:
        entries = self._entries()
        others = [entry.kind for entry in entries if entry.kind not in _READ]
        if others or not entries:
            kinds = ", ".join(f"{others.count(k)} {k}" for k in dict.fromkeys(others)) or "none"
            message = f"found the joints {kinds}, expected only sph_sph, sph_prs_sph and spherical"
            raise NoPlatform(message)
        first = entries[0].links
        pairs = {frozenset(entry.links) for entry in entries}
        if len(pairs) != 1 or first[0] == first[1]:
            message = f"found joints between {counted(len(pairs), 'pair')} of links, expected one"
            raise NoPlatform(message + " pair of two: the base and the platform")
        exact: dict[tuple[float, ...], tuple[str, ...]] = {}
        legs: list[RowLeg] = []
        balls: list[tuple[str, Array, Array]] = []
        for number, entry in enumerate(entries, 1):
            ends = entry.points if entry.links == first else entry.points[::-1]
            points = [self._point(words, entry.line, exact) for words in ends]
            if entry.kind == "spherical":
                balls.append((entry.name or f"ball {number}", points[0], points[1]))
            else:
                legs.append(self._leg(entry, number, points[0], points[1]))
        pose = frame(T=balls[0][1] - balls[0][2]) if balls else None
        joints = [
            Joint(said, "base", "platform", pose if pose is not None else frame(), (ball(x, said),))
            for said, x, _ in balls
        ]
        notes = ["CuikSuite states no unit of length: metres"]
        notes += ["CuikSuite states no pose: no home is written"] if pose is None else []
        return legs_graph(
            "CuikSuite", name, legs, pose, length="m", notes=notes, exact=exact, joints=joints
        )

    def _point(
        self, words: list[str], line: int, exact: dict[tuple[float, ...], tuple[str, ...]]
    ) -> Array:
        parts: list[list[str]] = [[]]
        depth = 0
        for word in words:
            depth += (word == "(") - (word == ")")
            if word == "," and depth == 0:
                parts.append([])
            else:
                parts[-1].append(word)
        if len(parts) != 3:
            raise SourceLine(self.file, line).error(
                f"found {counted(len(parts), 'coordinate')}, expected three"
            )
        point = np.array([self.value(part, line) for part in parts])
        exact[tuple(float(x) for x in point)] = tuple(self.full(part) for part in parts)
        return point

    def _leg(self, entry: _Entry, number: int, base: Array, platform: Array) -> RowLeg:
        name = entry.name or f"{entry.kind} {number}"
        length, low, high = None, 0.0, np.inf
        for key in ("range", "length"):
            words = entry.rest.get(key, [])
            if words[:1] == ["["] and "]" in words and "," in words:
                comma, end = words.index(","), words.index("]")
                low = self.value(words[1:comma], entry.line)
                high = self.value(words[comma + 1 : end], entry.line)
                length = (low + high) / 2
            elif words:
                length = self.value(words, entry.line)
        if length is None or length <= 0 or low > high:
            raise SourceLine(self.file, entry.line).error("found no length above 0, expected one")
        rod = entry.kind == "sph_sph"
        return RowLeg(name, base, platform, length, low, float(high), rod)


def _bracket(words: list[str], start: int, place: SourceLine) -> tuple[int, list[str]]:
    """Return where a bracket that begins somewhere ends, and what is in it."""
    depth = 0
    for k in range(start, len(words)):
        depth += (words[k] == "(") - (words[k] == ")")
        if depth == 0:
            return k + 1, words[start + 1 : k]
    raise place.error("found a bracket that is not closed")
