"""What is loaded when a person asks: helps, meanings of keys, completion of words in a shell.

click has the scripts for bash, zsh and fish (docs/install.md says how to switch them on). While the
shell completes, every parameter gets the completion that belongs to its metavar; commands need no
code for it.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import permutations

import click
from click.shell_completion import CompletionItem

from gspcli.cli.result import Field, Fields, Result

#: The options that many commands have, by the headings of helps; others come first.
_GROUPS = {
    "Poses": ("--pose", "--near", "--mode", "--euler", "--pivot", "--relative-to", "--rotation"),
    "Values and columns": (
        "--set", "--delta", "--relative", "--reading", "--sigma", "--ignore", "--columns",
    ),
    "Work": (
        "--jobs", "--scheduler", "--resume", "--seed", "--time", "--timeout", "--effort",
    ),
    "Output": (
        "--format", "--output", "--force", "--part", "--keys", "--digits", "--decimals",
        "--help",
    ),
}  # fmt: skip
#: Examples before the options; the others follow the text.
_FIRST_LINES = 12


def write_help(command: click.Command, ctx: click.Context, formatter: click.HelpFormatter) -> None:
    """Write the help of a command: examples first, then options in groups, then the text."""
    text, _, shown = inspect.cleandoc(command.help or "").partition("\b\nExamples:\n")
    first, _, rest = text.strip().partition("\n\n")
    command.format_usage(ctx, formatter)
    formatter.write_paragraph()
    with formatter.indentation():
        formatter.write_text(first)
    examples = [_wrapped(line, formatter.width) for line in shown.replace("\\\n", "").splitlines()]
    count = next(
        (k for k in range(len(examples), 1, -1) if sum(map(len, examples[:k])) <= _FIRST_LINES), 1
    )
    _write_examples(formatter, "Examples", examples[:count])
    _write_options(command, ctx, formatter)
    for paragraph in filter(None, rest.split("\n\n")):
        formatter.write_paragraph()
        with formatter.indentation():
            formatter.write_text(paragraph)
    _write_examples(formatter, "More examples", examples[count:])
    command.format_epilog(ctx, formatter)


def _write_options(
    command: click.Command, ctx: click.Context, formatter: click.HelpFormatter
) -> None:
    """Write the options under the headings of their groups."""
    groups: dict[str, list[tuple[str, str]]] = {"Options": [], **{name: [] for name in _GROUPS}}
    for parameter in command.get_params(ctx):
        record = parameter.get_help_record(ctx)
        if record and isinstance(parameter, click.Option):
            names = {*parameter.opts}
            heading = next((g for g, those in _GROUPS.items() if names & {*those}), "Options")
            if len(record[0]) > formatter.width - 4 and isinstance(parameter.type, click.Choice):
                words = ", ".join(map(str, parameter.type.choices))
                record = (f"{parameter.opts[-1]} NAME", f"{record[1]} NAME is {words}.")
            groups[heading].append(record)
    for heading, records in groups.items():
        if records:
            with formatter.section(heading):
                formatter.write_dl(records, col_max=24)


def _wrapped(line: str, width: int) -> list[str]:
    """Return a command line in lines that a shell takes as one."""
    first, *words = re.findall(r"""(?:"[^"]*"|'[^']*'|\S)+""", line)
    lines = [f"  {first}"]
    for word in words:
        if len(lines[-1]) + len(word) + 3 > width:
            lines[-1] += " \\"
            lines.append(f"    {word}")
        else:
            lines[-1] += f" {word}"
    return lines


def _write_examples(
    formatter: click.HelpFormatter, heading: str, examples: Sequence[Sequence[str]]
) -> None:
    if examples:
        formatter.write(f"\n{heading}:\n")
        formatter.write("".join(f"{line}\n" for lines in examples for line in lines))


_TYPES = {"whole": "integer", "text": "string", "list": "array"}


def type_in_json(one: Field) -> str:
    """Return the type of the key of a field in JSON."""
    names = [_TYPES.get(name, name) for name in one.type.rstrip("?").split("/")]
    return " or ".join(["null"] * one.type.endswith("?") + names)


def meanings(command: str) -> Iterator[Result]:
    """Yield tables of what the keys of JSON and the columns of CSV mean, for each form."""
    schema = {"key": "schema", "type": "string", "meaning": "name and version of this form"}
    for form, fields in Fields(command).forms.items():
        keys = [
            {"key": one.path, "type": type_in_json(one), "meaning": one.meaning}
            for one in fields
            if one.path
        ]
        meaning = Field("meaning", essential=True, fold=" ")
        columns = (Field("key", essential=True), Field("type", fold=" "), meaning)
        yield Result(columns, [schema, *keys], f"JSON {form}", part="keys")
        cells = {one.key: one.meaning for one in fields if one.is_column and "@" not in one.key}
        if cells:
            rows = [{"column": key, "meaning": said} for key, said in cells.items()]
            yield Result((Field("column", essential=True), meaning), rows, "CSV")


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
