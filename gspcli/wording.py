"""How messages quote what a person wrote, what they suggest instead, and how they count."""

from __future__ import annotations

import re
from collections.abc import Iterable

#: Characters of what a person wrote that are repeated.
_ECHOED = 60
#: Characters of the name of a file, on all usual systems.
_LONGEST_NAME = 255
#: Lines of a message, and characters of one of its lines.
MOST_LINES, _MOST_CHARACTERS = 5, 600


def shown(text: str) -> str:
    """Return a text between quotation marks, on one line, printable and not too long."""
    return "'" + "".join(c if c.isprintable() else ascii(c)[1:-1] for c in shortened(text)) + "'"


def shortened(text: str) -> str:
    """Return a text that is not too long to be repeated."""
    return text if len(text) <= _ECHOED else text[: _ECHOED - 1] + "…"


def named(place: object) -> str:
    """Return the name of a file as messages say it: whole if there can be such a file."""
    text = str(place)
    return text if max(map(len, re.split(r"[/\\]", text))) <= _LONGEST_NAME else shortened(text)


def brief(message: str, noun: str = "line") -> str:
    """Return a message of at most five lines, which are not too long.

    Parameters
    ----------
    message
        The first lines of it are shown, and how many there are more.
    noun
        What each line is.
    """
    lines = message.split("\n")
    if len(lines) > MOST_LINES:
        first = lines[: MOST_LINES - 1]
        lines = [*first, f"… and {counted(len(lines) - len(first), f'more {noun}')}"]
    return "\n".join(map(_middle_left_out, lines))


def _middle_left_out(line: str) -> str:
    if len(line) <= _MOST_CHARACTERS:
        return line
    half = _MOST_CHARACTERS // 2
    return f"{line[: half - 1]} … {line[2 - half :]}"


def listed(words: Iterable[str], last: str = "or") -> str:
    """Return words as an English list: ``a, b or c``."""
    *first, end = words
    return f"{', '.join(first)} {last} {end}" if first else end


def counted(count: int, noun: str, several: str = "") -> str:
    """Return ``1 part``, ``2 parts``; `several` is the plural if it does not end with s."""
    return f"{count} {noun if count == 1 else several or f'{noun}s'}"


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return ``: did you mean …?`` for a misspelt word, or nothing."""
    near = nearest(word, known)
    return f": did you mean {near}?" if near else ""


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that is spelt most like a word, if one is near."""
    spellings: dict[str, str] = {}
    for candidate in known:
        spellings.setdefault(candidate.lower(), candidate)
    near = similar(word.lower(), spellings, 1)
    return spellings[near[0]] if near else None


def similar(word: str, known: Iterable[str], most: int, *, cutoff: float = 0.6) -> list[str]:
    """Return the known words that are spelt most like a word, the nearest first."""
    # Imported for mistakes only: they are rare, and start-up counts for every command.
    from difflib import get_close_matches

    return get_close_matches(word, list(known), n=most, cutoff=cutoff)
