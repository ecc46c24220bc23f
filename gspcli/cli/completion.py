"""Completion of words in a shell, by the metavars of arguments and options.

click has the scripts for bash, zsh and fish (docs/install.md says how to switch them on). While
the shell completes, every parameter gets the completion that belongs to its metavar; commands need
no code for it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import permutations

import click
from click.shell_completion import CompletionItem

_FILES = ("DATA", "FILE", "LOG", "POSES", "RESULT", "ROWS", "SPEC", "VALUES")
#: Several words between commas; one of columns may have a minus.
_LISTS = ("COLUMNS", "KINDS", "WHAT")
#: Words of which capitals mean something else than small letters.
_EXACT = ("AXES", "FORM")


def add_completion(command: click.Command) -> None:
    """Let the words of a command be completed; groups pass it on to their commands."""
    if isinstance(command, click.Group):
        for child in command.commands.values():
            add_completion(child)
    for parameter in command.params:
        if isinstance(parameter.type, click.types.StringParamType):
            parameter.type = _Completed(_words_of(parameter))


def _words_of(parameter: click.Parameter) -> list[str]:
    """Return the words of a metavar: SPEC of ``SPEC...``, TYPE and SPEC of ``TYPE|SPEC``."""
    name = parameter.metavar or parameter.human_readable_name
    return re.findall(r"[A-Z]{2,}", name.upper())


class _Completed(click.types.StringParamType):
    """A text that the shell can complete."""

    def __init__(self, metavars: Iterable[str]) -> None:
        self._metavars = metavars

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return what the word can become; files first, as the scripts of click need it."""
        del ctx, param
        files, items = [], []
        for metavar in self._metavars:
            if metavar in _FILES and not (metavar == "SPEC" and incomplete.startswith("@")):
                files = [CompletionItem(incomplete, type="file")]
                continue
            done = (re.match(r"(.*,)?-?", incomplete) or "")[0] if metavar in _LISTS else ""
            begun = incomplete[len(done) :]
            items += [
                CompletionItem(done + word)
                for word in _words(metavar)
                if word.startswith(begun)
                or (metavar not in _EXACT and word.lower().startswith(begun.lower()))
            ]
        return files + items


def _words(metavar: str) -> Iterable[str]:
    from gspcli.catalogue.kinds import KINDS
    from gspcli.catalogue.listing import COLUMNS_BY_KEY
    from gspcli.catalogue.names import ALIASES
    from gspcli.catalogue.types import CLASSES
    from gspcli.resources import instance_files

    if metavar == "WHAT":
        from gspcli.motion.files.requirements import QUANTITIES

        return QUANTITIES
    kinds, classes = [kind.name for kind in KINDS], [one.id for one in CLASSES]
    axes = ["".join(order) for letters in ("XYZ", "xyz") for order in permutations(letters)]
    words: dict[str, Iterable[str]] = {
        "AXES": axes,
        "CLASS": classes,
        "COLUMNS": COLUMNS_BY_KEY,
        "FORM": ["quaternion", "matrix", "rotvec", *axes],
        "KIND": kinds,
        "KINDS": dict.fromkeys(["A", "D", *kinds, *(kind.short for kind in KINDS)]),
        "NAME": instance_files(),
        "SPEC": [f"@{name}" for name in instance_files()],
        "TYPE": [*kinds, *classes, *ALIASES],
    }
    return words.get(metavar, ())
