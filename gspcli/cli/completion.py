"""Completion of words in a shell, by the metavars of arguments and options.

click has the scripts for bash, zsh and fish (docs/install.md says how to switch them on). While
the shell completes, every parameter gets the completion that belongs to its metavar; commands need
no code for it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

import click
from click.shell_completion import CompletionItem

Completer = Callable[[str], list[CompletionItem]]


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

    def __init__(self, words: Iterable[str]) -> None:
        self._completers = [_COMPLETERS[word] for word in words if word in _COMPLETERS]

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return what the word can become; files first, as the scripts of click need it."""
        del ctx, param
        items = [item for completer in self._completers for item in completer(incomplete)]
        return sorted(items, key=lambda item: item.type == "plain")


def _file(incomplete: str) -> list[CompletionItem]:
    return [CompletionItem(incomplete, type="file")]


def _folder(incomplete: str) -> list[CompletionItem]:
    return [CompletionItem(incomplete, type="dir")]


def _spec(incomplete: str) -> list[CompletionItem]:
    if not incomplete.startswith("@"):
        return _file(incomplete)
    return [CompletionItem(f"@{item.value}", help=item.help) for item in _example(incomplete[1:])]


def _example(incomplete: str) -> list[CompletionItem]:
    from gspcli.resources import instance_files

    return _beginning(incomplete, instance_files())


def _class(incomplete: str) -> list[CompletionItem]:
    from gspcli.catalogue.types import CLASSES

    return _beginning(incomplete, [platform_class.id for platform_class in CLASSES])


def _kind(incomplete: str) -> list[CompletionItem]:
    from gspcli.catalogue.kinds import KINDS

    return _beginning(incomplete, [kind.name for kind in KINDS])


def _type(incomplete: str) -> list[CompletionItem]:
    from gspcli.catalogue.names import ALIASES

    return _kind(incomplete) + _class(incomplete) + _beginning(incomplete, ALIASES)


def _kinds(incomplete: str) -> list[CompletionItem]:
    from gspcli.catalogue.kinds import KINDS

    names = ["A", "D", *(kind.name for kind in KINDS), *(kind.short for kind in KINDS)]
    return _in_list(incomplete, dict.fromkeys(names))


def _columns(incomplete: str) -> list[CompletionItem]:
    from gspcli.catalogue.listing import COLUMNS_BY_KEY

    return _in_list(incomplete, COLUMNS_BY_KEY)


def _form(incomplete: str) -> list[CompletionItem]:
    from itertools import permutations

    axes = ["".join(order) for axes in ("XYZ", "xyz") for order in permutations(axes)]
    return _beginning(incomplete, ["quaternion", "matrix", "rotvec", *axes], exact=True)


def _axes(incomplete: str) -> list[CompletionItem]:
    return [item for item in _form(incomplete) if len(item.value) == 3]


def _requirements(incomplete: str) -> list[CompletionItem]:
    from gspcli.motion.files.requirements import QUANTITIES

    return _in_list(incomplete, QUANTITIES)


def _beginning(
    incomplete: str, words: Iterable[str], *, exact: bool = False
) -> list[CompletionItem]:
    """Return the words that begin so, in either case unless exactly."""
    if exact:
        return [CompletionItem(word) for word in words if word.startswith(incomplete)]
    start = incomplete.lower()
    return [CompletionItem(word) for word in words if word.lower().startswith(start)]


def _in_list(incomplete: str, words: Iterable[str]) -> list[CompletionItem]:
    """Complete the last of several words between commas; one of columns may have a minus."""
    done, last = re.fullmatch(r"((?:.*,)?-?)([^,]*)", incomplete).groups()  # type: ignore[union-attr]
    return [CompletionItem(done + item.value) for item in _beginning(last, words)]


#: By the words of metavars.
_COMPLETERS: dict[str, Completer] = {
    "AXES": _axes,
    "CLASS": _class,
    "COLUMNS": _columns,
    "FILE": _file,
    "FOLDER": _folder,
    "FORCES": _file,
    "FORM": _form,
    "KIND": _kind,
    "KINDS": _kinds,
    "NAME": _example,
    "POSES": _file,
    "RESULT": _file,
    "ROWS": _file,
    "SPEC": _spec,
    "TYPE": _type,
    "VALUES": _file,
    "WHAT": _requirements,
}
