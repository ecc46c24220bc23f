"""How messages quote what a person wrote, what they suggest instead, and how they count."""

from __future__ import annotations

from collections.abc import Iterable

_LONGEST = 40


def shown(text: str) -> str:
    """Return a text between quotation marks, on one line, printable and not too long."""
    cut = text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"
    return "'" + "".join(c if c.isprintable() else ascii(c)[1:-1] for c in cut) + "'"


def listed(words: Iterable[str], last: str = "or") -> str:
    """Return words as an English list: ``a, b or c``."""
    *first, end = words
    return f"{', '.join(first)} {last} {end}" if first else end


def counted(count: int, noun: str) -> str:
    """Return ``1 part``, ``2 parts``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


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
